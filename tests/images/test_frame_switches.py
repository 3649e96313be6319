"""Settings that all techniques share and that switch something: normal maps, the shadow maps' filter, falloff."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from gpu_tools import small_settings
from path_tracing import floor_scene

from octolux.frame.settings import FrameSettings
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.errors import OctoluxError
from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Image, Texture
from octolux.scene.scene import Scene

SMALL = {
    "none": {}, "uniform-lpv": {"n": 16, "iterations": 2}, "voxel-cones": {"depth": 6}, "path-tracer": {"samples": 2},
}
UNDER = Camera.look_at((0.0, 0.5, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=2.0)
SUN = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(pi,) * 3)
LAMP = PointLight(position=(0.0, 3.0, 0.0), intensity=(9.0 * pi,) * 3)


def renderer(device, scene: Scene, technique: str, size=(24, 24), **settings) -> Renderer:
    return Renderer(scene, technique, settings=SMALL[technique], size=size, exposure=0.0, default_light=False,
                    device=device, frame_settings=small_settings(**settings))  # fmt: skip


def same(a, b) -> bool:
    return all(np.array_equal(a.layers[name], b.layers[name]) for name in a.layers if name != "motion")


def relief() -> Scene:
    """The Cornell box with waves on all its surfaces."""
    column = 128 + 90 * np.sin(np.arange(32) / 32 * 4 * pi)
    pixels = np.broadcast_to(np.stack([column, 0 * column + 128, 0 * column + 220, 0 * column + 255], -1), (32, 32, 4))
    waves = Texture(Image(pixels.astype(np.uint8)))
    scene = load_scene("cornell-box")
    return replace(scene, materials=[replace(m, normal_texture=waves) for m in scene.materials])


def flat(scene: Scene) -> Scene:
    return replace(scene, materials=[replace(m, normal_texture=None) for m in scene.materials])


@pytest.mark.parametrize("technique", SMALL)
def test_without_normal_maps_materials_are_as_if_they_had_none(device, technique):
    """The same bits, also where they are switched off and on between frames."""
    made = renderer(device, relief(), technique)
    mapped = made.render()
    made.frame_settings = replace(made.frame_settings, normal_maps=False)
    off = made.render()
    assert same(off, renderer(device, flat(relief()), technique).render())
    assert np.abs(off.layers["normal"] - mapped.layers["normal"]).max() > 0.2
    assert not np.array_equal(off.layers["direct"], mapped.layers["direct"])
    made.frame_settings = replace(made.frame_settings, normal_maps=True)
    assert same(made.render(), mapped)


def test_normal_maps_that_are_off_take_no_memory(device):
    on, off = (renderer(device, relief(), "none", normal_maps=value) for value in (True, False))
    held = [set(made.gpu_scene.materials.textures.resources) for made in (on, off) if made.render()]
    assert held == [{"material_sampler", "linear_256"}, {"material_sampler"}]


@pytest.mark.parametrize("technique", [name for name in SMALL if name != "path-tracer"])
@pytest.mark.parametrize("change", [{"inverse_square": False}, {"shadow_filter": 1}], ids=str)
def test_a_switch_between_frames(device, technique, change):
    """Nothing that is kept from frame to frame is of before: there and back."""
    scene = load_scene("cornell-box")
    made = renderer(device, scene, technique)
    before = made.render()
    made.frame_settings = replace(made.frame_settings, **change)
    changed = made.render()
    assert same(changed, renderer(device, scene, technique, **change).render())
    assert not np.array_equal(changed.layers["direct"], before.layers["direct"])
    assert np.array_equal(changed.layers["indirect"], before.layers["indirect"]) == (
        technique == "none" or ("shadow_filter" in change and technique != "voxel-cones")
    )
    made.frame_settings = replace(made.frame_settings, inverse_square=True, shadow_filter=2)
    assert same(made.render(), before)


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["sun", "lamp"])
def test_one_texel_is_lit_or_not(device, light):
    """Below a plate over the floor's left half. One texel leaves steps; four are blended, and agree with it wherever
    all four say the same. Both put the edge to within a texel of where it is."""
    plate = quad([(-2, 1, 2), (0, 1, 2), (0, 1, -2), (-2, 1, -2)])
    scene = floor_scene(plate, lights=[light])
    one, four = (renderer(device, scene, "none", (64, 64), shadow_filter=n).render(UNDER) for n in (1, 2))
    unshadowed = renderer(device, floor_scene(lights=[light]), "none", (64, 64)).render(UNDER).layers["direct"]
    sharp, soft = ((p.layers["direct"] / unshadowed)[..., 0] for p in (one, four))
    assert set(np.unique(sharp)) == {0.0, 1.0}
    between = (soft > 0.0) & (soft < 1.0)
    assert between.sum() >= 64
    assert np.array_equal(sharp[~between], soft[~between])
    # The floor of 4 m in 64 texels of the sun's map; 6 m below the lamp, at 3 m, in 64 texels of one face of its.
    x, texel = one.layers["position"][..., 0], 4.0 / 64 if light is SUN else 6.0 / 64
    assert np.array_equal(sharp[np.abs(x) > texel], (x > 0)[np.abs(x) > texel])
    assert np.all(np.abs(x[between]) <= texel)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        ({"shadow_filter": 3}, "shadow_filter is 1 or 2 texels, not 3"),
        ({"shadow_filter": 0}, "shadow_filter"),
        ({"normal_maps": "no"}, "normal_maps is True or False, not 'no'"),
        ({"inverse_square": 2}, "inverse_square is True or False, not 2"),
    ],
    ids=str,
)
def test_wrong_values_are_said(wrong, says):
    with pytest.raises(OctoluxError, match=says):
        FrameSettings(**wrong)
    with pytest.raises(OctoluxError, match=says):
        replace(FrameSettings(), **wrong)
