"""Area lights and glowing surfaces: what stands for them brings their light."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest

import octolux
from octolux.frame.emitters import emitter_lights
from octolux.frame.frame import FrameSettings
from octolux.scene.builtin.round_shapes import sphere
from octolux.scene.builtin.shapes import quad
from octolux.scene.lights import AreaLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene

LAMP = AreaLight(corners=((-0.5, 2.0, -0.5), (0.5, 2.0, -0.5), (0.5, 2.0, 0.5), (-0.5, 2.0, 0.5)),
                 radiance=(10.0, 20.0, 30.0), name="lamp")  # fmt: skip


def lobes_flux(lights) -> np.ndarray:
    return sum(4.0 * pi * np.asarray(light.intensity) for light in lights)


@pytest.mark.parametrize("count", [1, 2, 3, 4, 9])
def test_an_area_light_keeps_its_flux_and_faces_one_way(count):
    lights = emitter_lights(Scene(lights=[LAMP]), count)
    assert len(lights) == count
    np.testing.assert_allclose(lobes_flux(lights), pi * np.array(LAMP.radiance) * 1.0, rtol=1e-12)
    for light in lights:
        np.testing.assert_allclose(light.axis, (0.0, -1.0, 0.0), atol=1e-12)
        assert light.beam == pytest.approx(1.0)
        assert light.position[1] == pytest.approx(2.0)
    areas = sum(light.square_radius * pi for light in lights)
    assert areas == pytest.approx(1.0)


def glowing_floor(double_sided: bool) -> Scene:
    mesh = quad([(-1.0, 0.0, 1.0), (1.0, 0.0, 1.0), (1.0, 0.0, -1.0), (-1.0, 0.0, -1.0)])
    material = Material(emissive=(3.0, 2.0, 1.0), base_color=(0.0,) * 3, double_sided=double_sided)
    return Scene(meshes=[mesh], instances=[Instance(0)], materials=[material])


@pytest.mark.parametrize("double_sided", [False, True])
def test_a_glowing_quadrilateral_shines_from_its_front_and_from_its_back_if_double_sided(double_sided):
    lights = emitter_lights(glowing_floor(double_sided), 4)
    sides = {round(light.axis[1]) for light in lights}
    assert sides == ({1, -1} if double_sided else {1})
    expected = pi * 4.0 * np.array([3.0, 2.0, 1.0]) * (2 if double_sided else 1)
    np.testing.assert_allclose(lobes_flux(lights), expected, rtol=1e-6)


def test_nothing_that_glows_gives_no_lights():
    dark = glowing_floor(False)
    dark.materials[0] = replace(dark.materials[0], emissive=(0.0, 0.0, 0.0))
    assert emitter_lights(dark, 4) == [] and emitter_lights(glowing_floor(False), 0) == []


def floor_below(lamp: AreaLight | None) -> Scene:
    mesh = quad([(-4.0, 0.0, 4.0), (4.0, 0.0, 4.0), (4.0, 0.0, -4.0), (-4.0, 0.0, -4.0)])
    return Scene(meshes=[mesh], instances=[Instance(0)], materials=[Material(specular=0.0)],
                 lights=[lamp] if lamp else [])  # fmt: skip


def seen_from_above(scene: Scene, device, count: int) -> np.ndarray:
    camera = octolux.Camera.look_at((0.0, 1.5, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=1.0)
    settings = FrameSettings(emitter_lights=count, shadow_resolution=64, rsm_resolution=32)
    renderer = octolux.Renderer(scene, "none", size=(9, 9), exposure=0.0, device=device, frame_settings=settings)
    return renderer.render(camera).radiance


def lambert_irradiance(lamp: AreaLight, point: np.ndarray, steps: int = 200) -> np.ndarray:
    """Midpoint rule over a 1 m square at y = 2, shining down on a floor."""
    x = (np.arange(steps) + 0.5) / steps - 0.5
    px, pz = np.meshgrid(x, x)
    square = (px - point[0]) ** 2 + (pz - point[2]) ** 2 + 4.0
    return np.asarray(lamp.radiance) * (4.0 / square**2).mean()


def test_direct_light_below_an_area_light_is_that_of_its_integral(device):
    """A patch of side s seen from d on its axis: a disk of its area errs by O((s/d)^4), here (0.5/2)^4 = 0.4 %."""
    middle = seen_from_above(floor_below(LAMP), device, 4)[4, 4]
    expected = lambert_irradiance(LAMP, np.zeros(3)) / pi
    np.testing.assert_allclose(middle, expected, rtol=0.01)


def test_a_glowing_ball_lights_all_around_and_does_not_shade_itself(device):
    """A ball of radiance L at height d: on the floor below, E = pi L r^2 / d^2; of that a white floor shows E / pi."""
    radius, glow = 0.2, 50.0
    scene = floor_below(None)
    scene.meshes.append(sphere(radius, material=1))
    raised = np.eye(4)
    raised[1, 3] = 2.0
    scene.instances.append(Instance(1, raised))
    scene.materials.append(Material(emissive=(glow,) * 3, base_color=(0.0,) * 3))
    light = emitter_lights(scene, 1)[0]
    assert light.beam == pytest.approx(0.0, abs=1e-3)
    middle = seen_from_above(scene, device, 1)[4, 4]
    # The ball has 14 rows: its area is less than the sphere's by some (pi / 14)^2 / 6 for each of two curvatures.
    np.testing.assert_allclose(middle, glow * radius**2 / 4.0, rtol=0.02)
