"""Lamps without the inverse square bring everywhere what they do at 1 m, whoever asks: against closed forms and the
simulator."""

from __future__ import annotations

from dataclasses import replace
from math import asinh, atan, pi, sqrt

import numpy as np
import pytest
from fog_tools import BOX, HAZE, PLACES, expected, relative, wall
from fog_tools import LAMP as FOG_LAMP
from fog_tools import SPOT as FOG_SPOT
from fog_tools import render as render_fog
from gpu_tools import scene_of, small_settings
from path_tracing import ABOVE, WHITE, assert_mean, floor_scene

from octolux.frame.structs import VPL
from octolux.gpu.records import read_records
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight, DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.simulator import direct, fog
from octolux.simulator import rsm as reference
from octolux.simulator.camera import unpack_normals
from octolux.simulator.lpv.propagation import total_flux
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

UP, ALBEDO = np.array([0.0, 1.0, 0.0]), np.array(WHITE.base_color)
LIGHTS = {
    "point": PointLight(position=(0.4, 2.2, -0.3), intensity=(1.0, 2.0, 4.0)),
    "spot": SpotLight(position=(0.2, 2.8, 0.1), direction=(-0.1, -1.0, 0.1), intensity=(9.0, 6.0, 3.0),
                      inner_angle=0.15, outer_angle=0.5),
    "directional": DirectionalLight(direction=(0.3, -1.0, 0.2), illuminance=(3.0, 2.0, 1.0)),
}  # fmt: skip
DIRECT = {"none": {}, "path-tracer": {"samples": 2, "pixel": "centre", "paths": "direct"}}
LOW, HIGH = np.array([-1.0, -0.5, -1.5]), np.array([1.0, 1.5, 0.9])
LAMP = PointLight(position=(0.3, 0.6, -0.4), intensity=(10.0, 20.0, 30.0))


def renderer(device, scene, technique="none", settings=None, inverse_square=False) -> Renderer:
    return Renderer(
        scene, technique, settings=settings or {}, size=(16, 16), exposure=0.0, default_light=False, device=device,
        frame_settings=small_settings(inverse_square=inverse_square),
    )  # fmt: skip


@pytest.mark.parametrize("technique", DIRECT)
@pytest.mark.parametrize("kind", LIGHTS)
def test_direct_light_on_a_floor(device, technique, kind):
    """Rasterised and traced: float32 arithmetic, and the slope of a spot's ramp, 1 / 0.111."""
    made = renderer(device, floor_scene(lights=[LIGHTS[kind]]), technique, DIRECT[technique])
    picture = made.render(ABOVE)
    position = picture.layers["position"].astype(np.float64)
    wanted = ALBEDO / pi * direct.irradiance(LIGHTS[kind], position, UP, inverse_square=False)
    np.testing.assert_allclose(picture.layers["direct"], wanted, rtol=1e-4, atol=1e-4 * wanted.max())


@pytest.mark.parametrize("technique", DIRECT)
def test_a_lamp_straight_above_brings_as_many_lux_from_any_height(device, technique):
    """I cd are I lx, albedo / pi of it nits; beside that, as the cosine."""
    made = renderer(device, floor_scene(), technique, DIRECT[technique])
    for height in (2.0, 20.0):
        made.scene.lights = [PointLight(position=(0.0, height, 0.0), intensity=(3.0, 5.0, 7.0))]
        picture = made.render(ABOVE)
        place = picture.layers["position"].astype(np.float64)
        cosine = height / np.linalg.norm(place - [0.0, height, 0.0], axis=-1, keepdims=True)
        found = picture.layers["direct"] / cosine
        np.testing.assert_allclose(found, np.broadcast_to(ALBEDO / pi * [3.0, 5.0, 7.0], found.shape), rtol=1e-4)


class Watched(NoTechnique):
    """A technique that only looks at the VPLs."""

    needs = frozenset({"rsm"})

    def update(self, frame) -> None:
        self.frame = frame


def vpls_of(device, scene, inverse_square=False) -> tuple[np.ndarray, np.ndarray]:
    """VPL [layer][row][column], and what the renderer takes for a bound of each light's flux, (lights, 3)."""
    made = renderer(device, scene, inverse_square=inverse_square)
    made.frame_settings = replace(made.frame_settings, rsm_resolution=64)
    made.technique = Watched(device, Settings())
    made.render(ABOVE)
    frame = made.technique.frame
    found = read_records(device, frame.vpls, VPL, sum(count for _, count in frame.vpl_ranges))
    return found.reshape(-1, 64, 64), frame.lights.total_flux


def room(lights) -> object:
    lambert = Material(base_color=(0.8, 0.5, 0.1), specular=0.0)
    return scene_of([box(LOW, HIGH, inward=True)], [lambert], lights=lights)


def wall_flux(height: float, x: tuple[float, float], y: tuple[float, float]) -> float:
    """Flux on a rectangle `height` below a lamp of 1 cd without falloff: the integral of the cosine, h / r, over it.
    That of 1 / r between 0 and (x, y) is x asinh(y / |x, h|) + y asinh(x / |y, h|) - h atan(x y / (h r))."""

    def corner(a: float, b: float) -> float:
        r = sqrt(a * a + b * b + height * height)
        return a * asinh(b / sqrt(a * a + height**2)) + b * asinh(a / sqrt(b * b + height**2)) - height * atan(
            a * b / (height * r)
        )

    return height * (corner(x[1], y[1]) - corner(x[0], y[1]) - corner(x[1], y[0]) + corner(x[0], y[0]))


def box_flux(light: PointLight) -> np.ndarray:
    low, high = LOW - light.position, HIGH - light.position
    spans = [(low[axis], high[axis]) for axis in range(3)]
    whole = 0.0
    for axis in range(3):
        others = [spans[k] for k in range(3) if k != axis]
        whole += wall_flux(-low[axis], *others) + wall_flux(high[axis], *others)
    return whole * np.array(light.intensity)


def test_flux_on_walls_by_quadrature():
    """The closed form itself, by the midpoint rule."""
    x, y = ((np.arange(400) + 0.5) / 400 * (b - a) + a for a, b in ((-0.5, 1.5), (0.2, 1.0)))
    cosine = 0.7 / np.sqrt(x[:, None] ** 2 + y[None, :] ** 2 + 0.7**2)
    assert wall_flux(0.7, (-0.5, 1.5), (0.2, 1.0)) == pytest.approx(cosine.mean() * 2.0 * 0.8, rel=1e-5)


def test_vpls_receive_by_area(device):
    """Each what the simulator says of the texel that it lies in; together what the walls receive in closed form. The
    shader's solid angle errs with the square of the texel's angle; a texel on an edge goes whole to one of two walls,
    which differs in nothing there."""
    vpls, bound = vpls_of(device, room([LAMP]))
    distance = np.linalg.norm(vpls["position"].astype(np.float64) - LAMP.position, axis=-1)
    solid = np.broadcast_to(reference.texel_solid_angles(64), distance.shape)
    albedo = np.array([0.8, 0.5, 0.1])
    wanted = reference.vpl_flux_point(albedo, LAMP.intensity, solid, distance)
    np.testing.assert_allclose(vpls["flux"], wanted, rtol=1e-3)
    whole = vpls["flux"].sum(axis=(0, 1, 2), dtype=np.float64)
    np.testing.assert_allclose(whole, albedo * box_flux(LAMP), rtol=2e-3)
    assert np.all(whole <= bound[0])


@pytest.mark.parametrize("inverse_square", [True, False])
def test_the_first_bounce_is_that_of_the_vpls(device, inverse_square):
    """On a patch of the room's floor, away from its walls: the paths that a path tracer draws, and the sum over VPLs,
    flux / pi * cosines / r^2, which errs by their size over their distance: 2 / 64 of 0.6 m, squared."""
    patch = Camera.look_at((0.0, 0.2, -0.3), (0.0, -0.5, -0.3), up=(0.0, 0.0, -1.0), orthographic_height=0.4)
    vpls, _ = vpls_of(device, room([LAMP]), inverse_square)
    settings = {"samples": 256, "pixel": "centre", "paths": "first-bounce"}
    picture = renderer(device, room([LAMP]), "path-tracer", settings, inverse_square).render(patch)
    places = picture.layers["position"].reshape(-1, 3).astype(np.float64)
    away = vpls["position"].reshape(-1, 3).astype(np.float64)[None] - places[:, None]
    leaving = -(away * unpack_normals(vpls["normal"]).reshape(-1, 3)).sum(axis=-1)
    cosines = np.maximum(away[..., 1], 0.0) * np.maximum(leaving, 0.0)  # 0 from the floor itself
    form = cosines / np.maximum((away**2).sum(axis=-1), 1e-6) ** 2
    wanted = np.array([0.8, 0.5, 0.1]) / pi * (form @ vpls["flux"].reshape(-1, 3).astype(np.float64)) / pi
    assert_mean(picture, wanted.reshape(picture.radiance.shape), rounding=3e-3)


@pytest.mark.parametrize("kind", ["point", "spot"])
def test_what_is_reflected_is_injected(device, kind):
    """The bound of the flux holds: sums in fixed point do not overflow."""
    light = replace(LIGHTS[kind], position=(0.3, 1.2, -0.4))
    scene = room([light])
    vpls, bound = vpls_of(device, scene)
    reflected = vpls["flux"].sum(axis=(0, 1, 2), dtype=np.float64)
    assert np.all((reflected > 0.0) & (reflected <= bound[0]))
    made = renderer(device, scene, "uniform-lpv", {"n": 16})
    made.render(ABOVE)
    np.testing.assert_allclose(total_flux(made.technique.debug_views()["injected"]), reflected, rtol=1e-2)


@pytest.mark.parametrize("lights", [[FOG_LAMP], [FOG_LAMP, FOG_SPOT]], ids=["lamp", "both"])
def test_fog(device, lights):
    """As tests/kernels/test_fog.py has it of lamps with falloff, where the filter errs more."""
    picture = render_fog(device, wall(), lights=lights, fog_resolution=1, size=(192, 128), inverse_square=False)
    wanted, _ = expected(picture, HAZE, fog.of_lights(lights, HAZE, BOX, inverse_square=False), steps=256)
    found = picture.layers["fog"].astype(np.float64)[PLACES]
    assert abs(found.mean() / wanted.mean() - 1.0) < 0.02
    if FOG_SPOT not in lights:
        assert relative(found, wanted) < 0.02


@pytest.mark.parametrize("technique", ["uniform-lpv", "path-tracer"])
def test_what_is_no_lamp_shines_as_ever(device, technique):
    """Area lights, glowing surfaces, the sky and the sun, and the points that stand for them: the same bits."""
    settings = {"uniform-lpv": {"n": 16, "iterations": 2}, "path-tracer": {"samples": 2}}[technique]
    panel = AreaLight(corners=((-0.5, 2, -0.5), (0.5, 2, -0.5), (0.5, 2, 0.5), (-0.5, 2, 0.5)), radiance=(9.0,) * 3)
    glowing = Material(emissive=(3.0, 2.0, 1.0))
    scene = floor_scene(
        box((-0.6, 0.0, -0.6), (-0.3, 0.4, -0.3), material=1), materials=(WHITE, glowing),
        lights=[panel, LIGHTS["directional"]], environment=Environment((0.5, 0.6, 0.8)),
    )  # fmt: skip
    off, on = (renderer(device, scene, technique, settings, value).render(ABOVE) for value in (False, True))
    assert off.layers["indirect"].any()
    for name, layer in off.layers.items():
        np.testing.assert_array_equal(layer, on.layers[name], err_msg=name)
