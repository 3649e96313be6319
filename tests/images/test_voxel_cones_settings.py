"""Settings of voxel-cones that change what light does, as pictures."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from gpu_tools import scene_of
from test_voxel_cones_pictures import FLOOR, PAINT, PRESETS, from_above, renderer, technique

from octolux.picture import Picture
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.scene.scene import Scene

SUN = DirectionalLight(direction=(-1.0, 0.0, 0.0), illuminance=(5.0, 6.0, 7.0))


def floor_and_walls(*places: float) -> Scene:
    """A floor, dark from the sun, and lit walls 0.5 m high across it at x."""
    walls = [quad([(x, 0, 1), (x, 0, -1), (x, 0.5, -1), (x, 0.5, 1)]) for x in places]
    return scene_of([FLOOR, *walls], [PAINT], lights=[SUN])


def test_a_box_of_its_own(device):
    """Voxels are as small as it is, and what is outside is neither lit, but for what the filter's window of 8 pixels
    takes along, nor there: as if the scene ended at the box."""
    camera, given = from_above(2.0, 2.0), {"box": "-0.5 -0.1 -0.5 0.5 0.6 0.5", "size": (96, 96)}
    whole = renderer(device, floor_and_walls(-0.9), **given)
    lost = whole.render(camera).layers["irradiance"]
    assert np.isclose(technique(whole).octree.grid.cell_size, 1.0 / (2**6 - 3)) and not lost.any()
    made = renderer(device, floor_and_walls(-0.4, -0.9), **given)
    found = made.render(camera).layers["irradiance"]
    alone = renderer(device, floor_and_walls(-0.4), **given).render(camera)
    x = np.abs((np.arange(96) + 0.5) / 48.0 - 1.0)
    assert (found[40:56, x < 0.35].min(axis=-1) > 0.0).all() and not found[:, x > 0.53 + 8 / 48].any()
    np.testing.assert_array_equal(found, alone.layers["irradiance"])


SKY = Environment((3.0, 2.0, 1.0))


def under_sky(device, scene: Scene, camera=None, lights: int = 0, **settings) -> Picture:
    made = renderer(device, scene, **settings)
    made.frame_settings = replace(made.frame_settings, sky_lights=lights)
    return made.render(camera)


@pytest.mark.parametrize("material", [PAINT, Material(metallic=1.0, roughness=0.3)], ids=["paint", "white metal"])
@pytest.mark.parametrize("preset", PRESETS)
def test_a_plane_under_an_even_sky_seen_by_cones(device, preset, material):
    """pi times the sky's radiance arrives, within what is asked of cones; and it is in the picture once, as when it
    comes past shadow maps, which have no shadows here either."""
    scene, camera = scene_of([FLOOR], [material], environment=SKY), from_above(2.0, 1.0)
    by_cones = under_sky(device, scene, camera, 8, preset=preset, sky=True)
    by_maps = under_sky(device, scene, camera, 8, preset=preset)
    np.testing.assert_allclose(by_cones.layers["irradiance"], np.broadcast_to(pi * np.array(SKY.radiance), (24, 32, 3)),
                               rtol=0.03)  # fmt: skip
    assert not by_cones.layers["direct"].any() and not by_maps.layers["irradiance"].any()
    np.testing.assert_allclose(by_cones.radiance, by_maps.radiance, rtol=0.03)


def test_no_sky_reaches_into_a_closed_box(device):
    """Cones meet walls wherever they go, also from a hundredth of a voxel beside one; ambient visibility there is 0
    within 0.05."""
    room = box((-1, -1, -1), (1, 1, 1), inward=True)
    inside = Camera.look_at((0.0, 0.6, 0.9), (0.0, -0.6, -1.0), vertical_fov=1.2)
    picture = under_sky(device, scene_of([room], [PAINT], environment=SKY), inside, sky=True)
    assert picture.mask.all() and picture.layers["irradiance"].max() <= 0.05 * pi * max(SKY.radiance)


def test_the_sky_is_counted_once(device):
    """Of a wall's foot half of the sky is seen, whether cones or shadow maps say so; and the wall reflects it to the
    floor either way."""
    wall = quad([(-1, 0, -1), (1, 0, -1), (1, 1, -1), (-1, 1, -1)])
    scene, camera = scene_of([FLOOR, wall], [PAINT], environment=SKY), from_above(3.0, 2.0)
    by_cones, by_maps = (under_sky(device, scene, camera, 32, sky=sky, depth=7) for sky in (True, False))
    assert by_maps.layers["indirect"].any() and not by_cones.layers["direct"].any()
    seen = by_maps.mask
    np.testing.assert_allclose(by_cones.radiance[seen].mean(axis=0), by_maps.radiance[seen].mean(axis=0), rtol=0.05)


def test_lamps_shine_beside_a_sky_seen_by_cones(device):
    """Only the sky leaves the direct light."""
    lamp = PointLight(position=(0.2, 1.0, 0.3), intensity=(5.0, 6.0, 7.0))
    scene = scene_of([FLOOR], [PAINT], environment=SKY, lights=[lamp])
    lit = under_sky(device, scene, from_above(2.0, 1.0), 8, sky=True).layers["direct"]
    alone = under_sky(device, replace(scene, environment=Environment()), from_above(2.0, 1.0)).layers["direct"]
    assert alone.any()
    np.testing.assert_array_equal(lit, alone)


def test_air_takes_from_light(device):
    """Of a ceiling that is lit from below, 1 m over a floor and as wide as 2 m, each part is 1 to sqrt(3) m away from
    the middle; what bounces once more has the way twice again. Surfaces lit directly are as before."""
    ceiling = quad([(-1, 1, -1), (1, 1, -1), (1, 1, 1), (-1, 1, 1)])
    middle = quad([(-0.1, 0, 0.1), (0.1, 0, 0.1), (0.1, 0, -0.1), (-0.1, 0, -0.1)])
    sun = DirectionalLight(direction=(0.0, 1.0, 0.0), illuminance=(4.0, 4.0, 4.0))
    scene, camera, taken = scene_of([ceiling, middle], [PAINT], lights=[sun]), from_above(0.5, 0.1), 0.8
    clear, hazy = (renderer(device, scene, attenuation=a).render(camera).layers for a in (0.0, taken))
    ratio = hazy["irradiance"] / clear["irradiance"]
    assert np.exp(-np.sqrt(3.0) * taken) < ratio.min() and ratio.max() < np.exp(-0.97 * taken)  # a voxel is 1/30 m
    np.testing.assert_array_equal(hazy["direct"], clear["direct"])
    box = load_scene("cornell-box")
    once, more = (renderer(device, box, attenuation=0.3, bounces=n).render().layers["indirect"].mean() for n in (1, 4))
    free, all_free = (renderer(device, box, bounces=n).render().layers["indirect"].mean() for n in (1, 4))
    assert once < 0.9 * free and (more - once) < 0.8 * (all_free - free)


def test_ambient_visibility_ends_at_a_distance(device):
    """A wall 0.9 m away, 2 m wide and high, hides 1 / pi (atan(w / d) - d / s atan(w / s)) of the floor's sky, where s
    is from its upper edge to the floor's point, d from its lower one, and w half its width (form factor of an upright
    rectangle): within 2 m most of that, within 0.3 m nothing. Light comes from as far either way."""
    wall = quad([(-1, 0, -0.9), (1, 0, -0.9), (1, 2, -0.9), (-1, 2, -0.9)])
    scene, camera = scene_of([FLOOR, wall], [PAINT], lights=[SUN]), from_above(3.0, 0.2)
    seen = {}
    for distance in (0.0, 0.3, 2.0):
        made = renderer(device, scene, ambient_distance=distance)
        light = made.render(camera).layers["irradiance"]
        seen[distance] = made.technique.debug_views()["visibility"].mean()
    np.testing.assert_array_equal(light, renderer(device, scene).render(camera).layers["irradiance"])
    s = np.hypot(0.9, 2.0)
    hidden = (np.arctan(1.0 / 0.9) - 0.9 / s * np.arctan(1.0 / s)) / pi
    assert abs(1.0 - hidden - seen[0.0]) < 0.05 and seen[0.3] == 1.0
    assert seen[0.0] <= seen[2.0] < 1.0 - 0.7 * hidden


def test_small_pictures_share_less(device):
    """All directions at each of these few pixels, as `resolution` and `tile` of 1 say; and again what pixels share in a
    larger picture of the same technique."""
    scene, camera = floor_and_walls(-0.4), from_above(2.0, 2.0)
    found, finest, coarse = (
        renderer(device, scene, **given).render(camera).layers["irradiance"]
        for given in ({}, {"resolution": 1, "tile": 1}, {"resolution": 2, "tile": 4})
    )
    np.testing.assert_array_equal(found, finest)
    assert not np.array_equal(found, coarse)
    small, large = renderer(device, scene), renderer(device, scene, size=(644, 364))
    small.render(camera)
    large.technique = small.technique
    whole = large.render(camera).layers["irradiance"]
    given = renderer(device, scene, size=(644, 364), resolution=2, tile=4).render(camera)
    np.testing.assert_array_equal(whole, given.layers["irradiance"])
