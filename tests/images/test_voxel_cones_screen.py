"""voxel-cones where the picture shows what cones meet: closed forms, and what of direct light is reflected again."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from gpu_tools import scene_of
from test_voxel_cones_pictures import ALBEDO, FLOOR, PAINT, from_above, renderer, technique

from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight, DirectionalLight, PointLight
from octolux.scene.load import load_scene

WALL = quad([(-1, 0, -1), (1, 0, -1), (1, 1, -1), (-1, 1, -1)])
ALONG_FLOOR = DirectionalLight(direction=(0.0, 0.0, -1.0), illuminance=(5.0, 5.0, 5.0))
EYE, SEEN = (0.0, 0.5, -0.3), (0.0, 0.1, -1.0)
INTO_CORNER = Camera.look_at(EYE, SEEN, vertical_fov=1.2)


def from_wall(points: np.ndarray) -> np.ndarray:
    """Share of the wall's exitance that floor points (m, 3) receive: the integral of cos cos / (pi r^2), by squares
    whose edge, 1/400 m, is an eighth of the least distance here."""
    x, y = np.meshgrid((np.arange(800) + 0.5) / 400 - 1.0, (np.arange(400) + 0.5) / 400)
    found = []
    for px, _, pz in points:
        away = pz + 1.0
        square = (x - px) ** 2 + y**2 + away**2
        found.append((y * away / square**2).sum() / (pi * 400**2))
    return np.array(found)


def beside_the_wall(device, away=(0.0, 0.0, 0.0), **settings) -> np.ndarray:
    """Irradiance over the closed form, of floor pixels 0.02 to 0.1 m, at most three voxels, from the wall. away: where
    the scene's middle is."""
    meshes = [replace(mesh, positions=(mesh.positions + np.array(away)).astype(np.float32)) for mesh in (FLOOR, WALL)]
    scene = scene_of(meshes, [PAINT], lights=[ALONG_FLOOR])
    camera = Camera.look_at(np.add(EYE, away), np.add(SEEN, away), vertical_fov=1.2)
    picture = renderer(device, scene, size=(64, 48), **settings).render(camera)
    place, seen = picture.layers["position"] - np.array(away), picture.geometric_normal[..., 1] > 0.9
    near = seen & (np.abs(place[..., 0]) < 0.2) & (place[..., 2] < -0.9) & (place[..., 2] > -0.98)
    assert near.sum() > 20
    light = picture.layers["irradiance"][near] / (5.0 * np.array(ALBEDO))
    return light / from_wall(place[near])[:, None]


def test_beside_a_lit_wall(device):
    """Within what so many directions tell apart of a spot (simulator/voxels/directions.py), and the voxels that are
    read beyond the wall's edges; voxels alone cannot tell where in them the wall is."""
    assert np.abs(beside_the_wall(device, preset="finest") - 1.0).max() <= 0.03
    assert np.abs(beside_the_wall(device, preset="finest", screen=0.0) - 1.0).max() > 0.15


def test_far_from_the_origin(device):
    """At 2^13 m places are known within 2^-11 m: of the least distance from the wall that is a 40th, by which its share
    of the light may change."""
    far = beside_the_wall(device, (2.0**13, 0.0, -(2.0**13)), preset="finest")
    assert np.abs(far - 1.0).max() <= 0.03 + 2.0**-11 / 0.02


@pytest.mark.parametrize("preset", ["default", "full", "finest"])
def test_rooms_that_are_looked_into_through_their_ceilings(device, preset):
    """Of a low room's floor, all that it sees is near, and not seen by the camera: no cone leaves the room, within the
    bound of closed boxes. Corners, where voxels alone let so much out, are not looked at."""
    room = scene_of([box((-1.0, 0.0, -1.0), (1.0, 0.2, 1.0), inward=True)], [PAINT])
    made = renderer(device, room, preset)
    picture = made.render(from_above(3.0, 1.5))
    assert picture.mask.any() and (picture.geometric_normal[picture.mask][:, 1] > 0.9).any()
    visible = device.read_texture(technique(made).diffuse.visibility, np.float32, 1)[..., 0]
    assert visible[picture.mask].max() <= 0.05


LIGHTS = {
    "lamps": {"lights": [ALONG_FLOOR, PointLight(position=(0.2, 0.8, 0.3), intensity=(1.0, 2.0, 3.0))]},
    "area": {"lights": [AreaLight(corners=((-0.2, 0.9, -0.2), (0.2, 0.9, -0.2), (0.2, 0.9, 0.2), (-0.2, 0.9, 0.2)),
                                  radiance=(30.0, 20.0, 10.0))]},
    "sky": {"environment": Environment(radiance=(3.0, 2.0, 1.0))},
}  # fmt: skip


@pytest.mark.parametrize("light", LIGHTS)
def test_what_the_diffuse_lobe_reflects(device, light):
    """All that matte paint reflects, nothing that metal does, and of what is glazed the rest."""
    found = {}
    for name, material in {
        "paint": PAINT, "metal": replace(PAINT, metallic=1.0, specular=1.0), "glazed": replace(PAINT, specular=1.0)
    }.items():  # fmt: skip
        made = renderer(device, scene_of([FLOOR, WALL], [material], **LIGHTS[light]))
        made.frame_settings = replace(made.frame_settings, sky_lights=8, emitter_lights=4)
        picture = made.render(INTO_CORNER)
        part = device.read_texture(made.targets.direct_diffuse, np.float32, 4)[..., :3]
        found[name] = part, picture.layers["direct"]
    part, direct = found["paint"]
    assert direct.max() > 0.1
    np.testing.assert_allclose(part, direct, rtol=1e-6)
    assert not found["metal"][0].any() and found["metal"][1].max() > 0.1
    part, direct = found["glazed"]
    assert (part <= direct).all() and 0.5 * direct.mean() < part.mean() < direct.mean()


def test_direct_light_is_divided_only_for_the_screen(device):
    made = renderer(device, load_scene("cornell-box"), screen=0.0)
    made.render()
    assert made.targets.direct_diffuse is None and not technique(made).wide.bindings
