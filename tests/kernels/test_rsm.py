"""Reflective shadow maps (rsm.wgsl): where VPLs lie and what they reflect, against the simulator and closed forms."""

from __future__ import annotations

from math import cos, pi, radians

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of

from octolux.frame.frame import FrameSettings
from octolux.frame.structs import VPL
from octolux.gpu.records import read_records
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.simulator import rsm as reference
from octolux.simulator.camera import unpack_normals
from octolux.simulator.lpv.propagation import total_flux
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

ALBEDO = np.array([0.8, 0.5, 0.1])
LOW, HIGH = np.array([-1.0, -0.5, -1.5]), np.array([1.0, 1.5, 0.9])


class Vpls(NoTechnique):
    """A technique that only looks at the VPLs."""

    needs = frozenset({"rsm"})

    def update(self, frame) -> None:
        self.frame = frame


def vpls_of(device, scene, *, shadow=64, rsm=64) -> np.ndarray:
    """The VPLs of a scene's lights: VPL [layer][row][column]."""
    settings = FrameSettings(shadow_resolution=shadow, rsm_resolution=rsm)
    renderer = Renderer(scene, "none", size=(8, 8), device=device, frame_settings=settings)
    renderer.technique = Vpls(device, Settings())
    renderer.render(front_camera())
    frame = renderer.technique.frame
    data = read_records(device, frame.vpls, VPL, sum(count for _, count in frame.vpl_ranges))
    return data.reshape(-1, rsm, rsm)


def room(lights, material=None) -> object:
    """A closed box of one albedo."""
    lambert = Material(base_color=tuple(ALBEDO), specular=0.0)
    return scene_of([box(LOW, HIGH, inward=True)], [material or lambert], lights=lights)


LAMP = PointLight(position=(0.3, 0.6, -0.4), intensity=(10.0, 20.0, 30.0))


def meet_box(origin: np.ndarray, directions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where rays from inside meet the box, and the wall's normal there."""
    with np.errstate(divide="ignore"):
        t = np.where(directions > 0, (HIGH - origin) / directions, (LOW - origin) / directions)
    t = np.where(directions == 0, np.inf, t)
    axis = t.argmin(axis=-1)
    normal = -np.sign(directions) * np.eye(3)[axis]
    return origin + t.min(axis=-1, keepdims=True) * directions, normal


def test_vpls_of_a_point_light(device):
    """One VPL a texel: each lies where the ray through the texel meets the wall, and reflects what it receives."""
    vpls = vpls_of(device, room([LAMP]))
    directions = reference.cube_texel_directions(64)
    position, normal = meet_box(np.array(LAMP.position), directions)
    # At the edge of two walls the rasteriser decides whose a texel is: leave out 1 mm.
    to_walls = np.sort(np.minimum(position - LOW, HIGH - position), axis=-1)
    sure = to_walls[..., 1] > 1e-3
    assert sure.mean() > 0.98
    assert np.abs(vpls["position"] - position)[sure].max() <= 1e-5
    assert np.array_equal(np.round(unpack_normals(vpls["normal"]), 6)[sure], normal[sure])
    solid = np.broadcast_to(reference.texel_solid_angles(64), directions.shape[:3])
    expected = reference.vpl_flux_point(ALBEDO, LAMP.intensity, solid)
    # The albedo is exact here, not of 16 bits; the shader's solid angle errs with the square of the texel's angle.
    np.testing.assert_allclose(vpls["flux"], expected, rtol=1e-3)


@pytest.mark.parametrize(("shadow", "rsm"), [(64, 64), (128, 32)])
def test_a_point_light_in_a_closed_box_is_reflected_whole(device, shadow, rsm):
    vpls = vpls_of(device, room([LAMP]), shadow=shadow, rsm=rsm)
    expected = ALBEDO * 4 * pi * np.array(LAMP.intensity)
    np.testing.assert_allclose(vpls["flux"].sum(axis=(0, 1, 2), dtype=np.float64), expected, rtol=1e-3)


def test_metals_reflect_no_diffuse_light(device):
    material = Material(base_color=tuple(ALBEDO), metallic=0.75, specular=0.0)
    vpls = vpls_of(device, room([LAMP], material), shadow=32, rsm=32)
    expected = 0.25 * ALBEDO * 4 * pi * np.array(LAMP.intensity)
    np.testing.assert_allclose(vpls["flux"].sum(axis=(0, 1, 2), dtype=np.float64), expected, rtol=2e-3)


@pytest.mark.parametrize("inner", [0.0, 20.0])
@pytest.mark.parametrize("outer", [35.0, 70.0])
def test_spot_light(device, inner, outer):
    """Flux of the cone: 2 pi I (1 - cos inner + (cos inner - cos outer) / 3), the integral of the squared ramp."""
    light = SpotLight(
        position=(0.0, 0.5, 0.0), direction=(0.3, -0.5, -1.0), intensity=(10.0, 20.0, 30.0),
        inner_angle=radians(inner), outer_angle=radians(outer),
    )  # fmt: skip
    vpls = vpls_of(device, room([light]), shadow=256, rsm=128)
    a, b = cos(radians(inner)), cos(radians(outer))
    expected = ALBEDO * 2 * pi * np.array(light.intensity) * (1 - a + (a - b) / 3)
    # 128 texels across the cone, midpoint rule for a ramp with a kink at its rim: 1 / 128^2 of it, some 1e-3 at most.
    np.testing.assert_allclose(vpls["flux"].sum(axis=(0, 1, 2), dtype=np.float64), expected, rtol=2e-3)


@pytest.mark.parametrize("direction", [(0.0, -1.0, 0.0), (0.0, -1.0, 0.7), (0.4, -1.0, -0.3)])
def test_directional_light_on_a_floor(device, direction):
    """A floor of area A reflects albedo * illuminance * A * cosine."""
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    light = DirectionalLight(direction=direction, illuminance=(3.0, 2.0, 1.0))
    scene = scene_of([floor], [Material(base_color=tuple(ALBEDO), specular=0.0)], lights=[light])
    vpls = vpls_of(device, scene, shadow=512, rsm=256)
    cosine = 1 / np.linalg.norm(direction)
    expected = ALBEDO * light.illuminance * 4 * cosine
    # The floor's rim passes through 4 * 256 of its texels, each counted whole or not: by chance half, so an error of
    # sqrt(4 * 256) / 2 of 256^2 texels (2.4e-4), or where rows line up with the rim the rows of its ends (1 / 256).
    rtol = 1e-3 if direction[0] == direction[2] == 0 else 1 / 256
    np.testing.assert_allclose(vpls["flux"].sum(axis=(0, 1, 2), dtype=np.float64), expected, rtol=rtol)
    used = vpls[vpls["flux"][..., 0] > 0]
    assert np.abs(used["position"][:, 1]).max() <= 1e-5
    assert np.abs(used["position"][:, [0, 2]]).max() <= 1 + 1e-4
    assert np.allclose(unpack_normals(used["normal"]), [0, 1, 0])


@pytest.mark.parametrize(("shadow", "rsm"), [(64, 64), (128, 32)])
def test_areas_of_a_wall_lit_by_a_point_light(device, shadow, rsm):
    """A wall across one face of the shadow map, from texel border to texel border: its texels' areas are its own. All
    errors are those of float32: some ten roundings of 6e-8 in a texel, and the positions' in a distance of 2."""
    wall = quad([(-1.5, -1.0, -2.0), (1.0, -1.0, -2.0), (1.0, 0.5, -2.0), (-1.5, 0.5, -2.0)])
    light = PointLight(position=(0.0, 0.0, 0.0), intensity=(1.0, 1.0, 1.0))
    vpls = vpls_of(device, scene_of([wall], [Material(double_sided=True)], lights=[light]), shadow=shadow, rsm=rsm)
    assert np.count_nonzero(vpls["area"]) == 2.5 * 1.5 / (4.0 / rsm) ** 2
    assert vpls["area"].sum(dtype=np.float64) == pytest.approx(2.5 * 1.5, rel=1e-5)


def test_areas_of_a_closed_box(device):
    """Slanted surfaces, far and near: together the whole box, and each texel as the simulator has it."""
    vpls = vpls_of(device, room([LAMP]), shadow=128, rsm=128)
    directions = reference.cube_texel_directions(128)
    position, normal = meet_box(np.array(LAMP.position), directions)
    to_walls = np.sort(np.minimum(position - LOW, HIGH - position), axis=-1)
    sure = to_walls[..., 1] > 1e-3
    distance = np.linalg.norm(position - np.array(LAMP.position), axis=-1)
    footprint = distance**2 * reference.texel_solid_angles_thesis(128)
    expected = reference.vpl_area(footprint, np.sum(directions * normal, axis=-1))
    np.testing.assert_allclose(vpls["area"][sure], expected[sure], rtol=1e-4)
    # The texels on the twelve edges go whole to one of two walls: at most half of each is wrong.
    size = HIGH - LOW
    whole = 2 * (size[0] * size[1] + size[1] * size[2] + size[2] * size[0])
    walls = np.abs(normal).argmax(axis=-1)
    on_edges = expected[:, 1:][walls[:, 1:] != walls[:, :-1]].sum()
    on_edges += expected[:, :, 1:][walls[:, :, 1:] != walls[:, :, :-1]].sum()
    assert vpls["area"].sum(dtype=np.float64) == pytest.approx(whole, abs=0.5 * on_edges)
    assert on_edges < 0.05 * whole


@pytest.mark.parametrize("slope", [1.0, 1 / 8, 1 / 32])
def test_areas_under_a_directional_light(device, slope):
    """A floor of 4 m^2 under a sun of slope `slope`: its own area, until it is so edge-on that areas are bounded."""
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    light = DirectionalLight(direction=(0.0, -slope, -1.0), illuminance=(1.0, 1.0, 1.0))
    area = vpls_of(device, scene_of([floor], lights=[light]), shadow=256, rsm=256)["area"][0].astype(np.float64)
    expected = 4.0 * min(1.0, np.sin(np.arctan(slope)) / reference.MIN_COSINE)
    used = np.pad(area > 0, 1)
    rim = area[~(used[:-2, 1:-1] & used[2:, 1:-1] & used[1:-1, :-2] & used[1:-1, 2:]) & (area > 0)]
    # A straight rim puts the texels that it crosses in or out by their centres: at most half of each is wrong.
    assert area.sum() == pytest.approx(expected, abs=0.5 * rim.sum())
    assert rim.sum() < 0.5 * expected


LIGHTS = {
    "point": LAMP,
    "spot": SpotLight(position=(0.0, 0.5, 0.0), direction=(0.0, -1.0, -0.4), intensity=(5.0, 6.0, 7.0)),
    "directional": DirectionalLight(direction=(0.2, -1.0, -0.3), illuminance=(3.0, 2.0, 1.0)),
}


@pytest.mark.parametrize("kind", LIGHTS)
def test_what_is_reflected_is_injected(device, kind):
    """Flux in the volume = flux of the VPLs, for each kind of light. Sun: from outside on a box's roof."""
    scene = room([LIGHTS[kind]])
    if kind == "directional":
        scene.meshes = [box(LOW, HIGH)]
    reflected = vpls_of(device, scene)["flux"].sum(axis=(0, 1, 2), dtype=np.float64)
    settings = FrameSettings(shadow_resolution=64, rsm_resolution=64)
    renderer = Renderer(scene, "uniform-lpv", size=(8, 8), device=device, frame_settings=settings)
    renderer.render(front_camera())
    assert np.all(reflected > 0)
    np.testing.assert_allclose(total_flux(renderer.technique.debug_views()["injected"]), reflected, rtol=1e-2)
