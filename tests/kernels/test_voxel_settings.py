"""Settings of `voxel-cones`: what is refused, and what they change."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import scene_of
from voxel_tools import built, mesh_of, read

from octolux.scene.materials import Image, Material, Texture
from octolux.simulator.grid import Grid
from octolux.techniques.settings import SettingsError
from octolux.techniques.voxel_cones.cones.sharing import USUAL_SIZE, sharing
from octolux.techniques.voxel_cones.settings import VoxelConesSettings
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree


@pytest.mark.parametrize(
    ("bad", "message"),
    [
        ({"depth": 5}, r"'depth' is 6 to 9 \(levels\), not 5"),
        ({"depth": 10}, "not 10"),
        ({"depth": 7.5}, "not 7.5"),
        ({"texture_level": 5.0}, r"'texture_level' is -4.0 to 4.0 \(levels\), not 5.0"),
        ({"cones": 3}, r"'cones' is 4 to 16"),
        ({"bounces": 0}, r"'bounces' is 1 to 8"),
        ({"resolution": 3}, "'resolution' is one of 0, 1, 2, 4, not 3"),
        ({"box": "0 0 0 1 1"}, r"'box' is `scene`, or six numbers .* \(m\), not '0 0 0 1 1'"),
        ({"box": "0 0 0 1 0 1"}, "not '0 0 0 1 0 1'"),
        ({"box": "0 0 0 1 1 nan"}, "not '0 0 0 1 1 nan'"),
        ({"box": "0 0 0 1 1 1e9"}, "not '0 0 0 1 1 1e9'"),
        ({"attenuation": -0.1}, r"'attenuation' is 0.0 to 10.0 \(1/m\), not -0.1"),
        ({"ambient_distance": float("inf")}, r"'ambient_distance' is 0.0 to 1000.0 \(m\), not inf"),
        ({"sky": 1}, "'sky' is one of False, True, not 1"),
        ({"cover": "glass"}, "one of surfaces, medium, not 'glass'"),
        ({"dept": 8}, r"no setting 'dept'. Did you mean 'depth'\?"),
    ],
)
def test_bad_settings_are_refused(bad, message):
    with pytest.raises(SettingsError, match=message):
        VoxelConesSettings.make(**bad)


def test_the_mip_level_of_textures(device):
    """Stripes as wide as a voxel are seen at the level of voxels, and are grey from two levels up."""
    grid = Grid((0.0, 0.0, 0.0), 0.25, 32)
    pixels = np.zeros((256, 256, 4), np.uint8)
    pixels[:, np.arange(256) // 16 % 2 == 0, :3] = 255
    pixels[..., 3] = 255
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 0], [1, 1], [0, 1]], dtype=np.float64).reshape(2, 3, 2)
    corners = np.concatenate([2.0 + 4.0 * square, np.full((2, 3, 1), 1.1)], axis=2)
    scene = scene_of([mesh_of(corners, uvs=square)], [Material(base_color_texture=Texture(Image(pixels)))])
    off = ~np.eye(16, dtype=bool)
    for level, contrast in ((0.0, 1.0), (2.0, 0.0)):
        octree = VoxelOctree(device, 5, texture_level=level)
        albedo = read(built(device, scene, grid, octree)).albedo[4, 8:24, 8:24, 0]
        bright, dark = albedo[off & (np.arange(16) % 2 == 0)], albedo[off & (np.arange(16) % 2 == 1)]
        # Samples lie aside by 2^-10 voxels; the mip level and the voxel have 8 bits of about the square root.
        np.testing.assert_allclose(bright.mean() - dark.mean(), contrast, atol=2 * 2.0**-10 + 2 / 255)


@pytest.mark.parametrize(
    ("pixels", "given", "expected"),
    [
        ((1280, 720), (0, 0), (2, 4)), ((3840, 2160), (0, 0), (2, 4)), ((640, 360), (0, 0), (1, 4)),
        ((641, 360), (0, 0), (2, 4)), ((256, 144), (0, 0), (1, 2)), ((160, 90), (0, 0), (1, 1)),
        ((1280, 720), (1, 0), (1, 4)), ((256, 144), (1, 0), (1, 1)), ((256, 144), (0, 4), (1, 4)),
        ((256, 144), (4, 0), (4, 1)), ((256, 144), (2, 4), (2, 4)), ((1280, 720), (1, 1), (1, 1)),
    ],
)  # fmt: skip
def test_what_pixels_share(pixels, given, expected):
    """What is not said is as fine as cones allow that are no more than those of 1280 x 720."""
    found = sharing(*given, pixels)
    assert found == (*expected, 1)
    usual = sharing(*given, USUAL_SIZE)
    assert found == usual or found.sets(pixels) <= usual.sets(USUAL_SIZE)


@pytest.mark.parametrize(("samples", "among"), [(1, 1), (3, 1), (6, 2), (8, 4), (64, 4)])
def test_samples_divide_what_a_pixel_has(samples, among):
    """Four sets in these pixels: each is in the same number of samples."""
    assert sharing(0, 0, (256, 144), samples) == (1, 2, among)
    assert sharing(0, 0, USUAL_SIZE, samples) == (2, 4, 1)
