"""Direct light of area lights on the device: closed forms, the float64 reference, shadows, and what stands for what."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from gpu_tools import front_camera, material_of, scene_of, small_settings

from octolux.frame.area_lights import AreaLightBuffers, area_lights
from octolux.frame.direct import light_groups
from octolux.frame.emitters import emitter_lights
from octolux.frame.shader_values import CONSTANTS
from octolux.gpu.shaders import compose
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.errors import OctoluxError
from octolux.scene.lights import AreaLight, Light, PointLight
from octolux.scene.materials import Material
from octolux.scene.scene import Scene
from octolux.simulator import brdf, direct, ltc

GLOW = (10.0, 20.0, 30.0)
WHITE = Material(specular=0.0)
BLACK = Material(specular=0.0, base_color=(0.0, 0.0, 0.0))
ROUNDING = 2.0**-23


def lamp(height: float = 2.0, side: float = 1.0, x: float = 0.0, glow=GLOW) -> AreaLight:
    """A square that shines down."""
    low, high, s = x - 0.5 * side, x + 0.5 * side, 0.5 * side
    corners = ((low, height, -s), (high, height, -s), (high, height, s), (low, height, s))
    return AreaLight(corners=corners, radiance=glow)


def floor(size: float = 8.0, material: int = 0):
    s = 0.5 * size
    return quad([(-s, 0, s), (s, 0, s), (s, 0, -s), (-s, 0, -s)], material=material)


def above(width: float = 4.0, eye: float = 0.05) -> Camera:
    """Straight down on the floor, from below the lamps."""
    return Camera.look_at((0.0, eye, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=width)


class Studio:
    """One renderer for many scenes."""

    def __init__(self, device, size: int = 16):
        self.device, self.size = device, (size, size)
        self.renderers: dict[int, Renderer] = {}

    def __call__(self, scene: Scene, camera: Camera, emitters: int = 4):
        if emitters not in self.renderers:
            settings = small_settings(sky_lights=0, emitter_lights=emitters, coarse_resolution=256)
            self.renderers[emitters] = Renderer(
                scene, "none", size=self.size, device=self.device, exposure=0.0, frame_settings=settings
            )
        self.renderers[emitters].scene = scene
        return self.renderers[emitters].render(camera)


@pytest.fixture(scope="module")
def studio(device) -> Studio:
    return Studio(device)


def lit_by(lights: list[Light], *meshes, materials=(WHITE, BLACK)) -> Scene:
    return scene_of([floor(), *meshes], list(materials), lights=lights)


def of_surface(picture) -> tuple[np.ndarray, np.ndarray]:
    return picture.layers["position"].astype(np.float64), picture.layers["normal"].astype(np.float64)


@pytest.mark.parametrize("distance", [0.1, 0.3, 1.0, 3.0, 10.0, 300.0])
def test_irradiance_below_a_square(studio, distance):
    """At 0.1 to 300 edges of 1 m, up to 2 m off the axis. An outline of edges e seen from a has rounding errors of some
    16 steps in e / a, while its moment falls with (e / a)^2; errors are shares of the brightest point's light."""
    light = lamp(distance)
    picture = studio(lit_by([light]), above())
    expected = direct.area_light_irradiance(light, *of_surface(picture)) / pi
    error = np.abs(picture.layers["direct"] - expected).max() / expected.max()
    assert picture.mask.all() and error <= 16 * ROUNDING * max(1.0, distance) + 2e-6


def test_a_tilted_light_that_horizons_cut(studio):
    """A rectangle that stands in the floor: of each point's view the horizon cuts away half, and one side is behind it.
    Roundings are those of 8 m in distances of 0.125 m."""
    upright = AreaLight(corners=((-1, -1, -4), (-1, 1, -4), (-1, 1, 4), (-1, -1, 4)), radiance=GLOW)
    picture = studio(lit_by([upright]), above())
    position, normal = of_surface(picture)
    expected = direct.area_light_irradiance(upright, position, normal) / pi
    np.testing.assert_allclose(picture.layers["direct"], expected, atol=64 * ROUNDING * expected.max())
    lit = picture.layers["direct"].max(axis=-1) > 0
    assert np.array_equal(lit, (expected.max(axis=-1) > 0)) and 0.2 < lit.mean() < 0.8


@pytest.mark.parametrize("turned", [0.3, 0.9, 1.4])
def test_tilted_receivers(studio, turned):
    """A floor turned about z, away from the light: most of its horizon cuts the light at 1.4 rad."""
    c, s = np.cos(turned), np.sin(turned)
    plate = quad([(-c, s, 1), (c, -s, 1), (c, -s, -1), (-c, s, -1)])
    light = lamp(1.5, side=4.0)
    scene = scene_of([plate], [WHITE], lights=[light])
    camera = Camera.look_at(0.05 * np.array([s, c, 0.0]), (0, 0, 0), up=(0, 0, -1), orthographic_height=1.5)
    picture = studio(scene, camera)
    expected = direct.area_light_irradiance(light, *of_surface(picture)) / pi
    assert picture.mask.all()
    np.testing.assert_allclose(picture.layers["direct"], expected, atol=64 * ROUNDING * expected.max())


@pytest.mark.parametrize("corners", [
    ((-0.5, 2, -0.5), (0.5, 2, -0.5), (0.5, 2, 0.5), (0.5, 2, 0.5)),
    ((-1, 2, -1), (0.6, 2, -0.8), (0.5, 2, 0.5), (-0.2, 2, 0.9)),
    ((-1e-3, 2, -1), (1e-3, 2, -1), (1e-3, 2, 1), (-1e-3, 2, 1)),
], ids=["triangle", "uneven", "sliver"])  # fmt: skip
def test_other_shapes(studio, corners):
    light = AreaLight(corners=corners, radiance=GLOW)
    picture = studio(lit_by([light]), above())
    expected = direct.area_light_irradiance(light, *of_surface(picture)) / pi
    shortest = min(d for d in np.linalg.norm(np.diff(corners, axis=0), axis=1) if d > 0)
    np.testing.assert_allclose(picture.layers["direct"], expected, atol=64 * ROUNDING * expected.max() / shortest)


@pytest.mark.parametrize("material", [
    Material(base_color=(0.8, 0.5, 0.2), roughness=0.4), Material(base_color=(0.8, 0.5, 0.2), specular=0.5),
    Material(base_color=(0.9, 0.6, 0.3), metallic=1.0, roughness=0.3), Material(metallic=0.5, roughness=0.7),
], ids=["dielectric", "rough", "metal", "half"])  # fmt: skip
@pytest.mark.parametrize("height", [0.5, 2.0])
def test_glossy_surfaces_against_the_reference(studio, material, height):
    """The reference in float64, of what the G-buffer holds. The lobe's matrix divides by alpha: from roughness 0.3, 11
    times the rounding of directions and of the table between its nodes."""
    light = lamp(height, x=0.4)
    scene = lit_by([light], materials=(material, BLACK))
    camera = Camera.look_at((0.2, 1.5, 3.0), (0.0, 0.0, 0.0), vertical_fov=0.8)
    picture = studio(scene, camera)
    position, normal = of_surface(picture)
    of = material_of(picture)
    expected = np.zeros(position.shape)
    for at in zip(*np.nonzero(picture.mask), strict=True):
        to_eye = camera.position - position[at]
        surface = brdf.surface(of["base_color"][at], of["metallic"][at], of["roughness"][at], of["specular"][at])
        expected[at] = ltc.radiance(light, position[at], normal[at], to_eye / np.linalg.norm(to_eye), surface)
    assert picture.mask.mean() > 0.5
    np.testing.assert_allclose(picture.layers["direct"], expected, atol=1e-4 * expected.max())


@pytest.mark.parametrize("scale", [1e-6, 1e3, 1e8])
@pytest.mark.parametrize("roughness", [0.0, 0.5])
def test_the_scale_does_not_matter(studio, scale, roughness):
    """A metal floor under a square, and both larger or smaller with all distances. Rounding moves the lobe, alpha wide,
    by some 4 steps."""
    pictures = []
    for size in (1.0, scale):
        light = AreaLight(corners=tuple(tuple(size * np.array(c)) for c in lamp(1.0).corners), radiance=GLOW)
        metal = Material(metallic=1.0, roughness=roughness)
        scene = scene_of([floor(8.0 * size)], [metal], lights=[light])
        eye = Camera.look_at((0.0, 1.0 * size, 1.5 * size), (0.0, 0.0, 0.0), vertical_fov=0.8, near=0.01 * size)
        pictures.append(studio(scene, eye).layers["direct"])
    assert pictures[0].max() > 0.1 * GLOW[2]
    tolerance = 4 * ROUNDING / float(brdf.alpha_of(roughness)) + 1e-5
    np.testing.assert_allclose(pictures[1], pictures[0], atol=tolerance * pictures[0].max())


def test_behind_it_is_dark(studio):
    upward = AreaLight(corners=lamp().corners[::-1], radiance=GLOW)
    assert not studio(lit_by([upward]), above()).layers["direct"].any()


@pytest.mark.parametrize("emitters", [1, 2, 4])
def test_a_shadow_takes_its_share(studio, emitters):
    """A plate hides some of the emitters from the floor's middle: what is left is their share of the closed form."""
    light = lamp()
    s = 0.5 * 0.3
    plate = quad([(-1, 1, -1), (s, 1, -1), (s, 1, 1), (-1, 1, 1)], material=1)
    picture = studio(lit_by([light], plate), above(width=0.01), emitters)
    position, normal = of_surface(picture)
    weights = np.zeros(2)
    for one in emitter_lights(Scene(lights=[light]), emitters):
        to_light = np.array(one.position)
        square = to_light @ to_light
        weight = one.intensity[0] * to_light[1] ** 2 / square / (square + one.square_radius)
        weights += weight * np.array([1.0, to_light[0] > 0.3])
    expected = direct.area_light_irradiance(light, position, normal) / pi * weights[1] / weights[0]
    np.testing.assert_allclose(picture.layers["direct"], expected, rtol=0.01)  # emitters are seen from within 5 mm


def test_each_lamp_has_its_own_shadow(studio):
    """Of two equal lamps one is hidden: the other's closed form is left, whatever the emitters' number."""
    left, right = lamp(x=-2.0), lamp(x=2.0)
    wall = quad([(-0.5, 0, -4), (-0.5, 4, -4), (-0.5, 4, 4), (-0.5, 0, 4)], material=1)
    for emitters in (2, 4):
        picture = studio(lit_by([left, right], wall), above(width=0.1), emitters)
        expected = direct.area_light_irradiance(right, *of_surface(picture)) / pi
        np.testing.assert_allclose(picture.layers["direct"], expected, rtol=1e-5)


def test_many_lights_are_looped_over(studio):
    """Nine lamps and a point light are more than are unrolled; a lamp that is in the scene twice shines twice."""
    lamps = [lamp(x=0.5 * k, side=0.3, glow=(1.0 + k, 2.0, 3.0)) for k in range(-3, 5)]
    lamps.append(lamps[0])
    point = PointLight(position=(0.0, 1.0, 0.0), intensity=(1.0, 1.0, 1.0))
    picture = studio(lit_by([*lamps, point]), above(), 9)
    position, normal = of_surface(picture)
    expected = sum(direct.irradiance(light, position, normal) for light in (*lamps, point)) / pi
    np.testing.assert_allclose(picture.layers["direct"], expected, rtol=2e-5)


def test_more_lamps_than_emitters():
    """The weakest share one with the glowing surfaces; all flux is there, and the strongest have their own."""
    scene = lit_by([lamp(x=k, glow=(1.0 + k, 1.0, 1.0)) for k in range(5)], quad(lamp(5.0).corners, material=1))
    scene.materials[1] = Material(emissive=(0.5, 0.5, 0.5))
    total = np.array([1 + 2 + 3 + 4 + 5 + 0.5, 5.5, 5.5]) * pi
    for count in (1, 2, 3, 4, 6, 9):
        emitters = emitter_lights(scene, count)
        assert len(emitters) == count
        np.testing.assert_allclose(sum(4 * pi * np.array(e.intensity) for e in emitters), total, rtol=1e-5)
        found = area_lights(emitters)
        own = min(count - 1, 5)
        assert len(found.packed) == own and found.points >= 1
        assert found.points + sum(found.emitters) == count
        np.testing.assert_array_equal(found.packed["radiance"][:, 0], np.arange(6 - own, 6))
        assert found.packed["first"].tolist() == np.cumsum([found.points, *found.emitters])[:-1].tolist()
        for row, number in zip(found.packed, found.emitters, strict=True):
            for one in emitters[row["first"] : row["first"] + number]:
                assert one.lamp is not None and one.lamp.radiance == tuple(row["radiance"])


def test_a_dark_or_flat_lamp_is_none():
    line = AreaLight(corners=((0, 1, 0), (1, 1, 0), (2, 1, 0), (1, 1, 0)), radiance=GLOW)
    assert emitter_lights(Scene(lights=[lamp(glow=(0.0, 0.0, 0.0)), line]), 4) == []
    assert not area_lights([]).emitters


@pytest.mark.parametrize(("corner", "words"), [((0.5, 2.2, 0.5), "one plane"), ((-0.4, 2.0, -0.4), "convex")])
def test_what_is_no_flat_convex_shape_is_refused(studio, corner, words):
    a, b, _, d = lamp().corners
    bad = AreaLight(corners=(a, b, corner, d), radiance=GLOW, name="panel")
    with pytest.raises(OctoluxError, match=f"'panel'.*{words}"):
        studio(lit_by([bad]), front_camera())


@pytest.mark.parametrize("lit", [False, True])
def test_scenes_without_area_lights_pay_nothing(lit):
    """Their shader has not a word of it."""
    glow = Material(emissive=(1.0, 1.0, 1.0))
    scene = lit_by([lamp()] if lit else [], quad(lamp(5.0).corners, material=1), materials=(WHITE, glow))
    emitters = emitter_lights(scene, 4)
    values = light_groups((1, 0, 0, len(emitters), 8), area_lights(emitters))
    values |= {**AreaLightBuffers.values(), **CONSTANTS, "shadow_filter": 2, "inverse_square": True}
    text = compose("frame/direct.wgsl", shadows=True, medium=False, diffuse=False, workgroup="8, 8", **values).text
    assert ("ltc_table" in text) == ("area_lights" in text) == lit
