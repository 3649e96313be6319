"""Direct light (direct.wgsl) without occluders against the simulator, pixel by pixel.

The reference takes positions, normals and materials as the picture's G-buffer holds them, so that only the arithmetic
is compared; output is rgba32float.
"""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import front_camera, material_of, scene_of

from octolux.frame.frame import FrameSettings
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad, revolve
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.simulator import brdf, direct

SUN = DirectionalLight(direction=(0.3, -0.5, -1.0), illuminance=(3.0, 2.0, 1.0))
LAMP = PointLight(position=(0.6, 0.8, 1.5), intensity=(5.0, 7.0, 9.0))
SPOT = SpotLight(position=(-0.7, 0.4, 1.4), direction=(0.3, -0.2, -1.0), intensity=(9.0, 4.0, 6.0), inner_angle=0.2,
                 outer_angle=0.7)  # fmt: skip
NARROW = SpotLight(position=(0.0, 0.0, 2.5), direction=(0.05, 0.0, -1.0), intensity=(9.0, 9.0, 9.0), inner_angle=0.1,
                   outer_angle=0.1)  # fmt: skip
LIGHTS = {"directional": [SUN], "point": [LAMP], "spot": [SPOT], "all": [LAMP, SPOT, SUN, NARROW, LAMP]}
EPSILON = 2.0**-23


def tiles() -> tuple[list, list[Material]]:
    """A wall of 4 x 3 tiles at z = 0, each with a random material of roughness from 0.3."""
    rng = np.random.default_rng(8)
    meshes, materials = [], []
    for number, (i, j) in enumerate(np.ndindex(4, 3)):
        x, y = -1 + i / 2, -1 + 2 * j / 3
        meshes.append(quad([(x, y, 0), (x + 0.5, y, 0), (x + 0.5, y + 2 / 3, 0), (x, y + 2 / 3, 0)], material=number))
        materials.append(Material(
            base_color=tuple(rng.uniform(0, 1, 3)), metallic=float(rng.choice([0.0, 0.5, 1.0])),
            roughness=float(rng.uniform(0.3, 1.0)), specular=float(rng.choice([0.0, 0.5, 1.0])),
        ))  # fmt: skip
    return meshes, materials


def ball(material: Material, radius: float = 0.8):
    angles = np.linspace(-np.pi / 2, np.pi / 2, 33)
    profile = np.stack([radius * np.cos(angles).clip(1e-4), radius * np.sin(angles)], axis=1)
    return scene_of([revolve(profile, segments=64)], [material])


def expected_radiance(picture, lights, camera: Camera) -> np.ndarray:
    """Sum over the lights of the simulator's radiance; orthographic cameras see along their axis."""
    surface = material_of(picture)
    material = brdf.surface(surface["base_color"], surface["metallic"], surface["roughness"], surface["specular"])
    position = picture.layers["position"].astype(np.float64)
    normal = picture.layers["normal"].astype(np.float64)
    eye = camera.position if camera.orthographic_height is None else position - 1e9 * camera.forward
    total = np.zeros(position.shape)
    for light in lights:
        if np.ndim(eye) == 1:
            total += direct.radiance(light, position, normal, eye, material)
            continue
        to_light, illuminance = direct.incident(light, position)
        cosine = np.maximum(0, (normal * to_light).sum(axis=-1, keepdims=True))
        total += brdf.evaluate(material, normal, to_light, -camera.forward) * illuminance * cosine
    return total


def relative_error(found: np.ndarray, expected: np.ndarray, where: np.ndarray) -> float:
    """Largest difference of a pixel relative to its largest channel."""
    peak = expected.max(axis=-1)[where]
    assert np.all(peak > 0)
    return float((np.abs(found - expected).max(axis=-1)[where] / peak).max())


def steady(lights, position: np.ndarray) -> np.ndarray:
    """Where no cone's ramp magnifies rounding: 2 roundings times its slope, relative to the ramp, stay below 1e-5."""
    keep = np.ones(position.shape[:2], bool)
    for light in lights:
        if isinstance(light, SpotLight):
            to_light, _ = direct.incident(light, position)
            ramp = np.sqrt(direct.spot_attenuation(light, to_light))
            slope = 1 / max(0.001, np.cos(light.inner_angle) - np.cos(light.outer_angle))
            keep &= (ramp == 1) | (4 * EPSILON * slope <= 1e-5 * ramp) | ((ramp == 0) & (len(lights) > 1))
    return keep


@pytest.fixture(scope="module")
def wall(device):
    meshes, materials = tiles()
    return Renderer(scene_of(meshes, materials), "none", size=(64, 48), device=device)


@pytest.mark.parametrize("kind", LIGHTS)
@pytest.mark.parametrize("height", [None, 1.6], ids=["perspective", "orthographic"])
def test_every_kind_of_light(wall, kind, height):
    """On a wall of random materials that nothing shadows: float32 arithmetic, 1e-4 of the pixel's largest channel
    (roughness from 0.3; see test_shaders.py for how it grows below)."""
    lights, camera = LIGHTS[kind], front_camera(2.2, orthographic_height=height)
    wall.scene.lights = lights
    picture = wall.render(camera)
    expected = expected_radiance(picture, lights, camera)
    where = picture.mask & steady(lights, picture.layers["position"])
    assert where.mean() > 0.2
    assert relative_error(picture.layers["direct"], expected, where) <= 1e-4
    dark = picture.mask & (expected.max(axis=-1) == 0)
    assert not picture.layers["direct"][dark | ~picture.mask].any()


def test_the_picture_is_direct_light_alone(wall):
    """Technique `none` and nothing that glows: radiance = direct light, background elsewhere."""
    wall.scene.lights = [LAMP]
    picture = wall.render(front_camera(4.0))
    assert np.array_equal(picture.radiance, picture.layers["direct"])
    assert 0.1 < picture.mask.mean() < 0.9
    assert not picture.layers["indirect"].any()


@pytest.mark.parametrize("kind", ["directional", "point", "spot"])
def test_a_sphere(device, kind):
    """All normals. Away from the terminator (cosine from 0.3, where the facets do not shadow each other) lit like the
    simulator says; facing away, black. A glossy metal."""
    material = Material(base_color=(0.9, 0.6, 0.3), metallic=1.0, roughness=0.4)
    scene = ball(material)
    scene.lights = LIGHTS[kind]
    settings = FrameSettings(shadow_resolution=512, rsm_resolution=256)
    picture = Renderer(scene, "none", size=(64, 64), device=device, frame_settings=settings).render(front_camera(2.5))
    position, normal = picture.layers["position"], picture.layers["normal"]
    to_light, _ = direct.incident(scene.lights[0], position.astype(np.float64))
    cosine = (normal * to_light).sum(axis=-1)
    facing = np.sum(normal * (np.array([0, 0, 2.5]) - position), axis=-1) > 0.3
    expected = expected_radiance(picture, scene.lights, front_camera(2.5))
    where = picture.mask & (cosine > 0.3) & facing & steady(scene.lights, position)
    assert where.mean() > 0.05
    assert relative_error(picture.layers["direct"], expected, where) <= 1e-4
    turned_away = picture.mask & (cosine < -0.1)
    assert not picture.layers["direct"][turned_away].any()


@pytest.mark.parametrize("roughness", [0.0, 0.1, 0.2])
def test_glossy_highlights(device, roughness):
    """Below roughness 0.3 rounding of the half vector shows, by 16 roundings over alpha^2 (test_shaders.py)."""
    wall = quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])
    material = Material(base_color=(0.5, 0.5, 0.5), roughness=roughness)
    scene = scene_of([wall], [material], lights=[PointLight(position=(0.0, 0.0, 1.0), intensity=(1.0, 1.0, 1.0))])
    camera = Camera.look_at((0.2, 0.1, 1.5), (0.0, 0.0, 0.0), vertical_fov=0.4)
    picture = Renderer(scene, "none", size=(48, 48), device=device).render(camera)
    expected = expected_radiance(picture, scene.lights, camera)
    alpha = float(brdf.alpha_of(round(roughness * 255) / 255))
    assert relative_error(picture.layers["direct"], expected, picture.mask) <= 1e-4 + 32 * EPSILON / alpha**2
