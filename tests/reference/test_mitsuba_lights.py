"""Lights as the exporter writes them: Mitsuba's direct light on a floor against the simulator's closed forms, so units,
directions and falloffs are right."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from estimators import assert_same_expectation
from gpu_tools import scene_of
from mitsuba_tools import Witness

from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import AreaLight, DirectionalLight, Light, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.simulator.camera import pixel_rays
from octolux.simulator.direct import lambert_radiance

ALBEDO = (0.2, 0.5, 0.8)
FLOOR = quad([(-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)])
VIEW = Camera.look_at((0.3, 0.8, 0.2), (0.3, 0.0, 0.0), up=(0, 0, -1), vertical_fov=1.6)
SIZE = (48, 32)
SUN = DirectionalLight(direction=(0.3, -2.0, -1.0), illuminance=(3.0, 2.0, 1.0))
LAMP = PointLight(position=(0.6, 0.8, 0.5), intensity=(5.0, 7.0, 9.0))
SPOT = SpotLight(position=(-0.2, 1.4, 0.4), direction=(0.3, -1.0, -0.2), intensity=(9.0, 4.0, 6.0), inner_angle=0.2,
                 outer_angle=0.6)  # fmt: skip
EVEN_SPOT = replace(SPOT, inner_angle=0.3, outer_angle=0.3)
WIDE_SPOT = replace(SPOT, inner_angle=0.0, outer_angle=1.5)
PANEL = AreaLight(
    corners=((-0.5, 1.0, 0.9), (-0.6, 1.0, 0.1), (0.2, 1.2, 0.0), (0.3, 1.2, 0.8)), radiance=(3.0, 2.0, 1.0)
)


def scene(*lights: Light):
    return scene_of([FLOOR], [Material(base_color=ALBEDO, specular=0.0)], lights=list(lights))


def floor_points(size: tuple[int, int], camera: Camera = VIEW) -> np.ndarray:
    """Where the rays of a picture's pixels meet the floor: (height, width, 3)."""
    origins, directions = pixel_rays(camera, *size)
    return origins - directions * (origins[..., 1:2] / directions[..., 1:2])


def closed_form(lights: list[Light], size: tuple[int, int] = SIZE, camera: Camera = VIEW) -> np.ndarray:
    points = floor_points(size, camera)
    up = np.broadcast_to([0.0, 1.0, 0.0], points.shape)
    return sum(lambert_radiance(light, points, up, ALBEDO) for light in lights)


@pytest.mark.parametrize("light", [SUN, LAMP], ids=["directional", "point"])
def test_directional_and_point_lights(light):
    """No chance is left in them. Two dozen roundings of float32: the ray, the point, the distance and its square, the
    cosine; a little more where they are in part subtractions."""
    expected = closed_form([light])
    assert np.abs(Witness(scene(light), VIEW, SIZE).at_centres() / expected - 1.0).max() < 24 * 2.0**-23


@pytest.mark.parametrize("light", [SPOT, EVEN_SPOT, WIDE_SPOT], ids=["ramp", "even", "wide"])
def test_spot_lights(light):
    """The falloff is a picture of 512 x 512 texels, read bilinearly: off by at most h^2 / 8 of its second derivative in
    both directions, with h = 2 tan(outer) / 512. A ramp squared of slope s in the cosine c bends by 2 s^2 c'^2 and by
    2 s |c''|, where c = (1 + r^2)^-1/2 has |c'| <= 0.385 and |c''| <= 1. Left out are pixels whose corners lie on both
    sides of the rim, which is a step where the cone is even, and those nearer to the ramp's upper kink than a texel."""
    points = floor_points(SIZE)
    to_light = np.asarray(light.position) - points
    distance = np.linalg.norm(to_light, axis=-1)
    cosine = -(to_light @ np.asarray(light.direction)) / distance / np.linalg.norm(light.direction)
    step = np.abs(np.gradient(cosine, axis=0)) + np.abs(np.gradient(cosine, axis=1))
    texel = 2.0 * np.tan(light.outer_angle) / 512
    keep = np.abs(cosine - np.cos(light.outer_angle)) > step
    keep &= np.abs(cosine - np.cos(light.inner_angle)) > 0.385 * texel * np.sqrt(2.0)
    slope = 1.0 / max(np.cos(light.inner_angle) - np.cos(light.outer_angle), 1e-6)
    bend = 0.0 if light is EVEN_SPOT else 2.0 * slope**2 * 0.385**2 + 2.0 * slope
    tolerance = 2.0 * texel**2 / 8.0 * bend + 1e-5
    unattenuated = closed_form([PointLight(position=light.position, intensity=light.intensity)])
    difference = np.abs(Witness(scene(light), VIEW, SIZE).at_centres() - closed_form([light])) / unattenuated
    assert keep.mean() > 0.8
    assert difference[keep].max() < tolerance
    assert (closed_form([light])[keep] > 0).mean() > 0.1


def test_area_light():
    """Monte Carlo against Lambert's formula, averaged over each pixel by the midpoint rule: its error, 1/96 of a
    pixel's second derivative, is far below the noise."""
    fine = closed_form([PANEL], (SIZE[0] * 2, SIZE[1] * 2))
    expected = fine.reshape(SIZE[1], 2, SIZE[0], 2, 3).mean(axis=(1, 3))
    found = Witness(scene(PANEL), VIEW, SIZE).batches(512, paths="direct")
    assert_same_expectation(found, expected)


def test_area_light_is_one_sided():
    turned = replace(PANEL, corners=PANEL.corners[::-1])
    assert not Witness(scene(turned), VIEW, SIZE).batches(16, paths="direct").any()


def test_an_area_light_hides_nothing():
    """Neither the floor from a camera above it nor a lamp's light."""
    above = replace(LAMP, position=(-0.2, 2.0, 0.5))
    camera = Camera.look_at((-0.2, 2.5, 0.5), (-0.2, 0.0, 0.5), up=(0, 0, -1), vertical_fov=0.7)
    fine = closed_form([PANEL, above], (SIZE[0] * 2, SIZE[1] * 2), camera)
    expected = fine.reshape(SIZE[1], 2, SIZE[0], 2, 3).mean(axis=(1, 3))
    assert_same_expectation(Witness(scene(PANEL, above), camera, SIZE).batches(512, paths="direct"), expected)


@pytest.mark.parametrize("double_sided", [False, True])
def test_glowing_surface(double_sided):
    """A plate that stands on edge lights the floor before it, and behind it where it is double-sided."""
    corners = [(0.3, 0.0, 0.5), (0.3, 0.0, -0.5), (0.3, 0.4, -0.5), (0.3, 0.4, 0.5)]  # faces -x
    front = AreaLight(corners=tuple(corners), radiance=(3.0, 2.0, 1.0))
    lights = [front, replace(front, corners=tuple(corners[::-1]))] if double_sided else [front]
    glow = Material(base_color=(0.0, 0.0, 0.0), specular=0.0, emissive=front.radiance, double_sided=double_sided)
    plate = quad(corners, material=1)
    materials = [Material(base_color=ALBEDO, specular=0.0, double_sided=True), glow]
    witness = Witness(scene_of([FLOOR, plate], materials), VIEW, SIZE)
    expected = closed_form(lights, (SIZE[0] * 4, SIZE[1] * 4)).reshape(SIZE[1], 4, SIZE[0], 4, 3).mean(axis=(1, 3))
    beside = np.abs(floor_points(SIZE)[..., 0] - 0.3) > 0.1  # the plate itself is seen around the middle
    beside &= np.abs(witness.seen()["position"][..., 1]) < 1e-3
    assert_same_expectation(witness.batches(512, paths="direct"), expected, beside, block=4)
