"""Camera rays and the packing of normals."""

from math import asin, pi, radians, sqrt

import numpy as np
import pytest

from octolux.scene.cameras import Camera
from octolux.simulator import camera


def test_rays_go_through_pixel_centres_with_row_0_at_the_top():
    origins, directions = camera.pixel_rays(Camera(transform=np.eye(4), vertical_fov=pi / 2), 4, 2)
    np.testing.assert_array_equal(origins, np.zeros((2, 4, 3)))
    on_plane = directions / -directions[..., 2:]
    np.testing.assert_allclose(on_plane[0, :, 0], [-1.5, -0.5, 0.5, 1.5])
    np.testing.assert_allclose(on_plane[:, 0, 1], [0.5, -0.5])


def test_rays_follow_the_camera():
    eye = Camera.look_at((1.0, 2.0, 3.0), (1.0, 2.0, -5.0), vertical_fov=radians(44))
    turned = Camera.look_at((1.0, 2.0, 3.0), (9.0, 2.0, 3.0), vertical_fov=radians(44))
    _, ahead = camera.pixel_rays(eye, 3, 3)
    origins, sideways = camera.pixel_rays(turned, 3, 3)
    np.testing.assert_allclose(ahead[1, 1], [0, 0, -1], atol=1e-15)
    np.testing.assert_allclose(sideways[..., 2], ahead[..., 0], atol=1e-15)
    np.testing.assert_allclose(sideways[..., 1], ahead[..., 1], atol=1e-15)
    np.testing.assert_array_equal(origins[2, 0], [1, 2, 3])


def test_orthographic_rays_are_parallel():
    eye = Camera.look_at((0.0, 0.0, 5.0), (0.0, 0.0, 0.0), orthographic_height=2.0)
    origins, directions = camera.pixel_rays(eye, 4, 2)
    np.testing.assert_allclose(directions, np.broadcast_to([0.0, 0, -1], (2, 4, 3)))
    np.testing.assert_allclose(origins[0], [[-1.5, 0.5, 5], [-0.5, 0.5, 5], [0.5, 0.5, 5], [1.5, 0.5, 5]])


def test_empty_pictures_are_refused():
    with pytest.raises(ValueError, match="0 x 4"):
        camera.pixel_rays(Camera(transform=np.eye(4)), 0, 4)


def test_octahedral_square_and_back():
    normals = np.random.default_rng(9).normal(size=(1000, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    square = camera.octahedral_encode(normals)
    assert np.abs(square).max() <= 1.0
    np.testing.assert_allclose(camera.octahedral_decode(square), normals, atol=1e-14)


def test_octahedral_places_of_the_axes():
    axes = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [0, -1, 0], [0, 0, -1]])
    np.testing.assert_allclose(
        camera.octahedral_encode(axes), [[1, 0], [0, 1], [0, 0], [-1, 0], [0, -1], [1, 1]], atol=1e-15
    )


def test_packed_normals_are_within_the_derived_angle():
    rng = np.random.default_rng(10)
    normals = np.concatenate(
        [rng.normal(size=(20000, 3)), rng.normal(size=(20000, 3)) * [1, 1, 1e-5], np.eye(3), -np.eye(3)]
    )
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    returned = camera.unpack_normals(camera.pack_normals(normals))
    angle = 2 * np.arcsin(0.5 * np.linalg.norm(returned - normals, axis=-1))
    assert angle.max() <= asin(sqrt(18) * 0.5 / camera.SNORM16)
    assert angle.max() > 0.0


def test_packing_is_bit_exact():
    values = [[0.0, 0.0], [1.0, -1.0], [0.5, -0.5], [2.0, -2.0], [1 / 32767, -1 / 32767]]
    words = [0x00000000, 0x80017FFF, 0xC0014000, 0x80017FFF, 0xFFFF0001]
    packed = camera.pack_snorm2x16(values)
    assert packed.dtype == np.uint32
    np.testing.assert_array_equal(packed, words)
    np.testing.assert_array_equal(camera.unpack_snorm2x16(0x80007FFF), [1.0, -1.0])


def test_packing_round_trips_every_integer():
    levels = np.arange(-32767, 32768)
    values = np.stack([levels, levels[::-1]], axis=-1) / 32767
    np.testing.assert_array_equal(camera.unpack_snorm2x16(camera.pack_snorm2x16(values)), values)
