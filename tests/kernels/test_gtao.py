"""Ambient occlusion on the device against its float64 version, on what the G-buffer holds."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import TESTS, front_camera, one_stage, scene_of, small_settings

import octolux
from octolux.frame.ambient_occlusion import MOST_SLICES, AmbientOcclusion
from octolux.gpu.bindings import uniform
from octolux.gpu.layout import Struct
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.default_camera import chosen_camera
from octolux.scene.errors import OctoluxError
from octolux.simulator.blending import moved_share
from octolux.simulator.gtao import Seen, ambient_visibility, filtered, taken

# WGSL's accuracy: acos within 6.8e-5, sine and cosine within 2^-11. Of whole arcs, which are at least 1 for each
# slice's weight, the open one of a side moves by no more than the first and by a half (two cosines, each a quarter) and
# pi / 2 (half the horizon times the sine) of the second.
SINE = 2.0**-11
ACCURACY = 2.0 * (6.8e-5 + (0.5 + 0.5 * np.pi) * SINE)
# The geometric normal is packed within this angle (test_gbuffer.py).
NORMAL_ERROR = 1.04e-3


def rendered(device, scene, camera: Camera, size: tuple[int, int] = (96, 54)) -> SimpleNamespace:
    """The frame, and what was seen in float64 as the passes read it."""
    settings = small_settings(sky_lights=0, emitter_lights=0)
    renderer = Renderer(scene, "none", size=size, exposure=0.0, device=device, frame_settings=settings)
    frames, shade = [], renderer.technique.shade
    renderer.technique.shade = lambda frame: (frames.append(frame), shade(frame))
    picture = renderer.render(camera)
    arrays = (picture.layers["depth"], picture.geometric_normal, picture.layers["normal"])
    seen = Seen(camera, *(a.astype(np.float64) for a in arrays))
    return SimpleNamespace(frame=frames[0], seen=seen, renderer=renderer, picture=picture)


def run(device, ao: AmbientOcclusion, frame, *radius: float, **resources) -> np.ndarray:
    with one_stage(device) as stage:
        texture = ao.run(stage, frame, *radius, **resources)
    return device.read_texture(texture, np.float32, 1)[..., 0]


@pytest.fixture(scope="module", params=["perspective", "orthographic", "normal maps"])
def room(request, device) -> SimpleNamespace:
    if request.param == "orthographic":
        camera = Camera.look_at((0.3, 1.5, 3.5), (0.0, 0.9, 0.0), orthographic_height=2.4)
        return rendered(device, octolux.load("cornell-box"), camera)
    scene = octolux.load("cornell-box" if request.param == "perspective" else "atrium")
    return rendered(device, scene, chosen_camera(scene, None, 96 / 54))


RADIUS = 0.3


@pytest.mark.parametrize(("slices", "steps", "falloff"), [(3, 6, 0.5), (1, 1, 0.0), (4, 3, 1.0)])
def test_as_the_simulator(device, room, slices, steps, falloff):
    """Where no sample lies so near to a pixel's edge or to the radius that the device may take another one: a slice's
    direction is known within SINE, its samples within that times their distance in pixels."""
    ao = AmbientOcclusion(device, slices, steps, falloff=falloff)
    run(device, ao, room.frame, RADIUS)
    found = device.read_texture(ao.raw, np.float32, 2)[..., 0]
    expected, margin = ambient_visibility(room.seen, RADIUS, slices, steps, falloff)
    far = RADIUS / np.linalg.norm(room.seen.pixel_extent()[0], axis=-1)
    sure = margin > SINE * np.maximum(far, 1.0)
    assert sure.mean() > 0.2
    assert expected[sure].min() < 0.8
    assert np.abs(found - expected)[sure].max() <= ACCURACY


@pytest.mark.parametrize("resolution", [1, 2])
def test_filter_as_the_simulator(device, room, resolution):
    """From the device's own raw picture, the filter's mean; and that picture has the noise that the simulator has."""
    ao = AmbientOcclusion(device, 2, 4, resolution)
    found = run(device, ao, room.frame, RADIUS)
    raw = device.read_texture(ao.raw, np.float32, 2)[..., 0].astype(np.float64)
    expected, margin = ambient_visibility(room.seen, RADIUS, 2, 4, resolution=resolution)
    at = np.ix_(*(taken(n, resolution) for n in expected.shape))
    far = RADIUS / np.linalg.norm(room.seen.pixel_extent()[0], axis=-1)
    sure = (margin > SINE * np.maximum(far, 1.0))[at]
    assert sure.mean() > 0.2
    assert np.abs(raw - expected[at])[sure].max() <= ACCURACY
    # Heights over the plane are known within 2^-20 of the depth (the normal's rounding and the position's), and count
    # in widths of a raw pixel; a weight's change moves the mean by at most as much for each of sixteen.
    wide = resolution * np.linalg.norm(room.seen.pixel_extent()[0], axis=-1)
    error = 16 * 2.0**-20 * room.seen.depth.max() / wide.min()
    assert np.abs(found - filtered(room.seen, raw, resolution)).max() <= error


@pytest.mark.parametrize("slant", [0.0, 45.0, 75.0, 87.0])
@pytest.mark.parametrize("kind", [{"vertical_fov": 1.0}, {"orthographic_height": 2.0}])
def test_open_plane(device, slant, kind):
    """The packed normal makes the plane rise by up to NORMAL_ERROR on a side, over the normal's length in the slice; of
    an arc that loses the square's half. SINE is that of the cosines in both the whole and the open arcs."""
    a = np.radians(slant)
    floor = quad([(-9, 0, 9), (9, 0, 9), (9, 0, -9), (-9, 0, -9)])
    camera = Camera.look_at((0.3, 2.0 * np.cos(a), 2.0 * np.sin(a) + 0.01), (0.0, 0.0, 0.0), **kind)
    made = rendered(device, scene_of([floor]), camera, (64, 36))
    facing = np.abs(np.sum(made.seen.rays()[1] * made.seen.geometric, axis=-1))
    facing = facing / np.linalg.norm(made.seen.rays()[1], axis=-1)
    seen = made.seen.depth > 0.0
    tolerance = SINE + NORMAL_ERROR**2 / (2.0 * np.maximum(facing, NORMAL_ERROR))
    for ao in (AmbientOcclusion(device), AmbientOcclusion(device, filtered=False), AmbientOcclusion(device, 2, 4, 2)):
        found = run(device, ao, made.frame, 0.4)
        assert np.all(np.abs(found - 1.0)[seen] <= tolerance[seen])
        assert np.all(found[~seen] == 1.0)


def test_radii_from_the_room(device):
    """Another file says at each place how far is looked: within two radii by shares that change there, as the simulator
    with one and with the other, one giving way to the other."""
    scene = octolux.load("cornell-box")
    made = rendered(device, scene, chosen_camera(scene, None, 96 / 54))
    given = Struct("Given", near="f32", border="f32")
    ao = AmbientOcclusion(
        device, 2, 4, filtered=False, radius_file=str(TESTS / "kernels" / "ao_radius.wgsl"),
        bindings=[uniform("given", given)], structs=[given], times=2.5, per_metre=2.0,
    )  # fmt: skip
    found = run(device, ao, made.frame, given=device.uniform("given", given.pack(near=0.2, border=0.1)))
    share = np.clip(0.5 - 2.0 * (made.seen.positions()[..., 0] - 0.1), 0.0, 1.0)
    sure, both = made.seen.depth > 0.0, []
    for radius, used in ((0.2, share > 0.0), (0.5, share < 1.0)):
        visible, margin = ambient_visibility(made.seen, radius, 2, 4, noise=False)
        far = radius / np.linalg.norm(made.seen.pixel_extent()[0], axis=-1)
        sure &= (margin > SINE * np.maximum(far, 1.0)) | ~used
        both.append(visible)
    for kind in (share == 1.0, (share > 0.0) & (share < 1.0), share == 0.0):
        assert (kind & sure).sum() > 200

    def between(off: float, share_off: float) -> np.ndarray:
        near, far = (np.clip(b + off, 0.0, 1.0) for b in both)
        moved = np.clip(share + share_off, 0.0, 1.0)
        return far + moved_share(near, far, moved) * (near - far)

    # More of either is more between them; shares change by 2 a metre, and places are right to a 20th of a millimetre.
    low, high = (np.min([between(a, b) for b in (-1e-4, 1e-4)], axis=0) for a in (-ACCURACY, ACCURACY))
    high = np.maximum(high, np.max([between(ACCURACY, b) for b in (-1e-4, 1e-4)], axis=0))
    assert np.all((low - 1e-6 <= found) & (found <= high + 1e-6) | ~sure)
    assert np.median((high - low)[sure]) < 0.01 and np.abs(both[0] - both[1])[sure].max() > 0.1


@pytest.mark.parametrize("radius", [1e-6, 1e6])
def test_any_radius(device, room, radius):
    """A radius within a pixel holds no other one: nothing is hidden. One beyond the scene still gives shares."""
    for ao in (AmbientOcclusion(device, 2, 4), AmbientOcclusion(device, 2, 4, filtered=False)):
        found = run(device, ao, room.frame, radius)
        assert np.all((found >= 0.0) & (found <= 1.0))
        assert radius > 1.0 or np.abs(found - 1.0).max() <= ACCURACY


def test_follows_the_size(device):
    """Textures are made for the picture's size, also where it is odd, and kept."""
    floor = quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    ao = AmbientOcclusion(device, 1, 1, 2)
    for size in [(33, 17), (64, 36)]:
        made = rendered(device, scene_of([floor]), front_camera(), size)
        assert run(device, ao, made.frame, 0.5).shape == size[::-1]
        kept = ao.visibility
        run(device, ao, made.frame, 0.5)
        assert ao.visibility is kept


@pytest.mark.parametrize(
    ("given", "words"),
    [({"slices": 0}, "slices"), ({"slices": MOST_SLICES + 1}, "slices"), ({"steps": 99}, "steps"),
     ({"resolution": 3}, "resolution"), ({"resolution": 2, "filtered": False}, "filtered"), ({"falloff": 1.5}, "share"),
     ({"falloff": float("nan")}, "share")],
)  # fmt: skip
def test_bad_numbers(device, given, words):
    with pytest.raises(OctoluxError, match=words):
        AmbientOcclusion(device, **given)


@pytest.mark.parametrize("radius", [None, 0.0, -1.0, float("nan"), float("inf")])
def test_bad_radius(device, radius):
    made = rendered(device, scene_of([quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])]), front_camera(), (8, 8))
    with pytest.raises(OctoluxError, match="radius"):
        run(device, AmbientOcclusion(device, 1, 1), made.frame, radius)
