"""Direct light of every kind, shadows, and the choice between lights, against closed forms and the simulator."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise
from math import cos, pi, sin

import numpy as np
import pytest
from gpu_tools import scene_of
from path_tracing import (
    WHITE,
    Tracer,
    assert_mean,
    assert_picture,
    ceiling,
    floor,
    floor_scene,
    luminance,
    mean_and_error,
)

from octolux.scene.builtin.shapes import merge, quad, quads
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight, DirectionalLight, ParticleLights, PointLight, SpotLight
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance
from octolux.simulator import brdf, direct
from octolux.simulator.environment import sampled, texel_directions, texel_solid_angles

UP = np.array([0.0, 1.0, 0.0])
ALBEDO = np.array(WHITE.base_color)
LAMPS = {
    "directional": DirectionalLight(direction=(0.3, -1.0, 0.2), illuminance=(3.0, 2.0, 1.0)),
    "point": PointLight(position=(0.4, 1.2, -0.3), intensity=(1.0, 2.0, 4.0)),
    "spot": SpotLight(position=(0.2, 1.8, 0.1), direction=(-0.1, -1.0, 0.1), intensity=(9.0, 6.0, 3.0),
                      inner_angle=0.15, outer_angle=0.5),
}  # fmt: skip
GLOW = (10.0, 20.0, 30.0)
AREA = AreaLight(corners=((-0.5, 2.0, -0.5), (0.5, 2.0, -0.5), (0.5, 2.0, 0.5), (-0.5, 2.0, 0.5)), radiance=GLOW)


@pytest.fixture(scope="module")
def trace(device) -> Tracer:
    return Tracer(device)


def lit_floor(picture, light, albedo=ALBEDO) -> np.ndarray:
    """What the simulator says of a Lambertian floor at the pixels' centres."""
    return direct.lambert_radiance(light, picture.layers["position"].astype(np.float64), UP, albedo)


@pytest.mark.parametrize("kind", LAMPS)
def test_one_lamp(trace, kind):
    """There is nothing to be drawn: float32 arithmetic, and the slope of a spot's ramp, 1 / 0.111."""
    picture = trace(floor_scene(lights=[LAMPS[kind]]), samples=2, pixel="centre", paths="direct")
    expected = lit_floor(picture, LAMPS[kind])
    np.testing.assert_allclose(picture.radiance, expected, rtol=1e-4, atol=1e-4 * expected.max())
    assert np.all(picture.noise <= 1e-3 * luminance(picture.radiance))
    assert np.array_equal(picture.radiance, picture.layers["direct"]) and not picture.layers["indirect"].any()


def test_lamps_chosen_at_random(trace):
    """Each sample asks one of five, by what each would bring: the mean is that of all."""
    lights = [*LAMPS.values(), LAMPS["point"], PointLight(position=(-1.0, 0.5, 1.0), intensity=(0.1, 0.0, 0.0))]
    picture = trace(floor_scene(lights=lights), pixel="centre", paths="direct")
    expected = sum(lit_floor(picture, light) for light in lights)
    assert_picture(picture, expected)
    # By the light each brings: the noise is that of the lamps' colours and shadows, none here.
    assert mean_and_error(picture)[1] < 1e-4 * luminance(expected).mean()
    assert np.abs(picture.radiance[..., 0] / expected[..., 0] - 1).max() > 1e-3


def test_half_in_the_shadow(trace):
    """A plate over the floor's left half, small lamps: dark below it and lit beside it, to the pixel."""
    plate = quad([(-2, 0.5, 2), (0, 0.5, 2), (0, 0.5, -2), (-2, 0.5, -2)])
    below = Camera.look_at((0.0, 0.4, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=2.0)
    for light in (DirectionalLight(direction=(0, -1, 0), illuminance=(1, 1, 1)),
                  PointLight(position=(0.0, 3.0, 0.0), intensity=(9, 9, 9))):  # fmt: skip
        picture = trace(floor_scene(plate, lights=[light]), below, samples=2, pixel="centre", paths="direct")
        expected = lit_floor(picture, light)
        assert not picture.radiance[:, :8].any()
        np.testing.assert_allclose(picture.radiance[:, 8:], expected[:, 8:], rtol=1e-4)


def test_shadow_of_half_an_area_light(trace):
    """A wall up to the lamp hides the half behind it, from the floor on one side: what is left is a smaller lamp."""
    wall = quad([(0, 0, -4), (0, 0, 4), (0, 2, 4), (0, 2, -4)])
    picture = trace(floor_scene(wall, lights=[AREA]), pixel="centre", paths="direct")
    half = AreaLight(corners=((-0.5, 2, -0.5), (0, 2, -0.5), (0, 2, 0.5), (-0.5, 2, 0.5)), radiance=GLOW)
    left = np.indices((16, 16))[1] < 8
    assert_mean(picture, lit_floor(picture, half), left)
    mirrored = AreaLight(corners=((0, 2, -0.5), (0.5, 2, -0.5), (0.5, 2, 0.5), (0, 2, 0.5)), radiance=GLOW)
    assert_mean(picture, lit_floor(picture, mirrored), ~left)


def test_area_light(trace):
    """Lambert's formula; lamps hide nothing, not even each other."""
    picture = trace(floor_scene(lights=[AREA]), pixel="centre", paths="direct")
    assert_picture(picture, lit_floor(picture, AREA))
    behind = AreaLight(corners=((-1, 3, -1), (1, 3, -1), (1, 3, 1), (-1, 3, 1)), radiance=(5.0, 5.0, 5.0))
    both = trace(floor_scene(lights=[AREA, behind]), pixel="centre", paths="direct")
    assert_picture(both, lit_floor(both, AREA) + lit_floor(both, behind))


def test_area_light_on_a_ceiling(trace):
    """It lies in the plane of a surface, which does not hide it, and is dark from behind."""
    picture = trace(floor_scene(ceiling(4.0), lights=[AREA]), pixel="centre", paths="direct",
                    camera=Camera.look_at((0, 1.5, 0), (0, 0, 0), up=(0, 0, -1), orthographic_height=2.0))  # fmt: skip
    assert_picture(picture, lit_floor(picture, AREA))
    upward = AreaLight(corners=AREA.corners[::-1], radiance=GLOW)
    assert not trace(floor_scene(lights=[upward]), pixel="centre", paths="direct").radiance.any()


def glowing(**rest) -> Material:
    return Material(base_color=(0, 0, 0), specular=0.0, emissive=GLOW, **rest)


@pytest.mark.parametrize("way", ["down", "up", "up, double-sided", "up, mirrored", "down, in a mesh of many"])
def test_glowing_quadrilateral(trace, way):
    """From its front, and from its back where it is double-sided; a mirrored instance is turned round."""
    lamp = ceiling(1.0, material=1)
    if way.startswith("up"):
        lamp = quad([(-0.5, 2, 0.5), (0.5, 2, 0.5), (0.5, 2, -0.5), (-0.5, 2, -0.5)], material=1)
    material = glowing(double_sided="double" in way)
    scene = floor_scene(lamp, materials=(WHITE, material))
    if "mirrored" in way:
        flip = np.diag([1.0, -1.0, 1.0, 1.0])
        flip[1, 3] = 4.0
        scene.instances[1] = Instance(1, flip)
    if "many" in way:  # of 512 triangles, four clusters; the lamp's id leads to its own
        steps = np.linspace(-0.5, 0.5, 17)
        scene.meshes[1] = merge([
            quad([(a, 2, c), (b, 2, c), (b, 2, d), (a, 2, d)], material=1)
            for a, b in pairwise(steps) for c, d in pairwise(steps)
        ])  # fmt: skip
    picture = trace(scene, pixel="centre", paths="direct")
    expected = 0.0 if way == "up" else lit_floor(picture, AREA)
    assert_picture(picture, expected)


def test_glowing_texture(trace):
    """The bright half of the picture, the side where it lies, near enough to the floor to be told from the other.
    Between texels is a ramp of 1/64 of the width."""
    pixels = np.zeros((64, 64, 4), np.uint8)
    pixels[:, :32, :3], pixels[..., 3] = 188, 255
    level = ((188 / 255 + 0.055) / 1.055) ** 2.4
    texture = Texture(Image(pixels), wrap=("clamp_to_edge", "clamp_to_edge"))
    y = 0.4
    camera = Camera.look_at((0, 0.3, 0), (0, 0, 0), up=(0, 0, -1), orthographic_height=2.0)
    corners = [(-0.5, y, -0.5), (0.5, y, -0.5), (0.5, y, 0.5), (-0.5, y, 0.5)]
    uvs = [(0, 0), (1, 0), (1, 1), (0, 1)]
    down, up = quads([corners], uvs=[uvs], material=1), quads([corners[::-1]], uvs=[uvs[::-1]], material=1)
    bright = ((-0.5, y, -0.5), (0, y, -0.5), (0, y, 0.5), (-0.5, y, 0.5))
    half = AreaLight(corners=bright, radiance=tuple(level * np.array(GLOW)))
    for lamp, double_sided in ((down, False), (down, True), (up, True)):
        scene = floor_scene(lamp, materials=(WHITE, glowing(double_sided=double_sided, emissive_texture=texture)))
        picture = trace(scene, camera, pixel="centre", paths="direct", samples=256)
        assert_picture(picture, lit_floor(picture, half), block=2, rounding=5e-3)  # of the ramp, and of mip levels


@pytest.mark.parametrize("alpha_mode", ["blend", "mask"])
def test_glowing_surface_with_alpha(trace, alpha_mode):
    """A blended lamp of alpha 0.3 gives 0.3 of its light; one that its mask cuts away gives none."""
    material = glowing(alpha=0.3, alpha_mode=alpha_mode)
    picture = trace(floor_scene(ceiling(material=1), materials=(WHITE, material)), pixel="centre", paths="direct")
    assert_picture(picture, (0.3 if alpha_mode == "blend" else 0.0) * lit_floor(picture, AREA))


def test_even_sky(trace):
    """Each point of an open floor shows albedo times the sky, and the sky itself is seen beside it."""
    sky = np.array([0.5, 1.0, 2.0])
    scene = floor_scene(environment=Environment(tuple(sky)))
    assert_picture(trace(scene, paths="direct"), ALBEDO * sky)
    aside = trace(scene, Camera.look_at((0, 1, 0), (0, 2, 0.1)), paths="all")
    np.testing.assert_allclose(aside.radiance, np.broadcast_to(sky, aside.radiance.shape), rtol=1e-6)
    # Sums of squares in float32: a difference of some roundings of 2^-24, divided by the root of 63.
    assert not aside.alpha.any() and aside.noise.max() <= 1e-4 * luminance(sky)


def floor_under(environment: Environment) -> np.ndarray:
    """Radiance (3,) of an open floor: the sum over 8 x 8 points of each texel of the filtered map."""
    height, width = (8 * edge for edge in environment.image.shape[:2])
    d = texel_directions(height, width)
    power = sampled(Environment(image=environment.image), d) * texel_solid_angles(height, width)[..., None]
    return ALBEDO / pi * ((power * np.maximum(d[..., 1:2], 0)).sum(axis=(0, 1)) + pi * np.array(environment.radiance))


def test_sky_of_a_picture(trace):
    image = np.random.default_rng(2).uniform(0, 1, (8, 16, 3)).astype(np.float32) ** 4
    environment = Environment((0.1, 0.0, 0.2), image, rotation=1.0)
    picture = trace(floor_scene(environment=environment), paths="direct")
    assert_picture(picture, floor_under(environment), rounding=1e-3)  # of the sum: (pi / 64)^2 / 24 of the Laplacian


def test_one_bright_texel_is_a_sun(trace):
    """Found in every sample. The filtered texel is a tent, the table's density the mean of each texel of it: both ways
    the mean square of their quotient is 7/9 + 2/3, so that of 64 samples the variance is (1.44^2 - 1) / 64 = 0.13^2;
    half as much again is left for how little 64 samples tell of it."""
    image = np.zeros((64, 128, 3), np.float32)
    image[12, 40] = (3e4, 2e4, 1e4)
    environment = Environment((1e-3,) * 3, image)
    picture = trace(floor_scene(environment=environment), paths="direct")
    assert_picture(picture, floor_under(environment), rounding=1e-3)
    assert picture.relative_error < 0.2
    polar, azimuth = 12.5 / 64 * pi, 40.5 / 128 * 2 * pi - pi
    towards = np.array([sin(polar) * sin(azimuth), cos(polar), -sin(polar) * cos(azimuth)])
    lux = np.array([3e4, 2e4, 1e4]) * texel_solid_angles(64, 128)[12]
    sun = DirectionalLight(direction=tuple(-towards), illuminance=tuple(lux))
    lamp = trace(floor_scene(lights=[sun]), paths="direct", samples=2)
    # The texel's neighbours stand a little higher or lower: (pi / 64)^2 of the second derivative.
    np.testing.assert_allclose(mean_and_error(picture)[0], mean_and_error(lamp)[0], rtol=0.01)
    # A wall between floor and sun.
    side = 3 * towards
    across = np.cross(towards, UP)
    up = np.cross(across, towards)
    corners = [side + 4 * (a * across + b * up) for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    dark = trace(floor_scene(quad(corners), environment=environment), paths="direct")
    assert mean_and_error(dark)[0] < 0.01 * mean_and_error(lamp)[0]


def test_polished_metal_under_an_area_light(trace):
    """Roughness 0.1: reflected rays find the lamp, shadow rays hardly; both together give the integral over it."""
    material = Material(base_color=(0.9, 0.7, 0.4), metallic=1.0, roughness=0.1)
    camera = Camera.look_at((0.0, 1.0, 2.0), (0.0, 0.0, 1.33), vertical_fov=0.45)
    picture = trace(scene_of([floor()], [material], lights=[AREA]), camera, samples=256, pixel="centre", paths="direct")
    steps = (np.arange(256) + 0.5) / 256 - 0.5
    x, z = np.meshgrid(steps, steps)
    lamp = np.stack([x, np.full_like(x, 2.0), z], axis=-1).reshape(-1, 3)
    surface = brdf.surface((0.9, 0.7, 0.4), 1.0, 0.1)
    shown, where = np.zeros((16, 16, 3)), np.zeros((16, 16), bool)
    where[::3, ::3] = True
    for row, column in np.argwhere(where):
        point = picture.layers["position"][row, column].astype(np.float64)
        to_lamp, to_eye = lamp - point, camera.position - point
        square = (to_lamp**2).sum(axis=1, keepdims=True)
        light = to_lamp / np.sqrt(square)
        f = brdf.evaluate(surface, UP, light, to_eye / np.linalg.norm(to_eye))
        shown[row, column] = (f * light[:, 1:2] ** 2 / square).mean(axis=0) * GLOW
    bright = where & (luminance(shown) > 1)
    assert 5 < bright.sum() < where.sum()
    # A lobe is 0.02 wide, eight steps of the sum.
    for part in (where, bright, where & ~bright):
        assert_mean(picture, shown, part, rounding=2e-3)
    for row, column in np.argwhere(where):
        found, expected = luminance(picture.radiance[row, column]), luminance(shown[row, column])
        assert abs(found - expected) <= 5 * picture.noise[row, column] + 0.01 * expected


def cloud(count: int, low=(-1.5, 1.0, -1.5), high=(1.5, 3.0, 1.5)) -> ParticleLights:
    """Particles of many colours and strengths in a box."""
    rng = np.random.default_rng(9)
    return ParticleLights(
        positions=rng.uniform(low, high, (count, 3)), intensities=rng.uniform(0, 1, (count, 3)) ** 4 * 40.0 / count
    )


def test_a_cloud_of_particles(trace):
    """Each sample asks one of 10,000: the mean is the sum of I cos / r^2 over all. Two groups are one cloud."""
    half = cloud(5000)
    other = ParticleLights(positions=half.positions * [1.0, 1.2, 1.0], intensities=half.intensities[::-1])
    picture = trace(floor_scene(lights=[half, other]), pixel="centre", paths="direct", samples=256)
    assert_picture(picture, lit_floor(picture, half) + lit_floor(picture, other))


def test_particles_beside_lamps_area_lights_and_sky(trace):
    group, lamp = cloud(300), LAMPS["point"]
    scene = floor_scene(lights=[lamp, AREA, group], environment=Environment((2.0, 2.0, 2.0)))
    picture = trace(scene, pixel="centre", paths="direct", samples=256)
    expected = lit_floor(picture, lamp) + lit_floor(picture, AREA) + lit_floor(picture, group) + ALBEDO * 2.0
    assert_picture(picture, expected)


def test_particles_below_the_floor_or_behind_a_roof_light_nothing(trace):
    below = cloud(100, (-1.0, -2.0, -1.0), (1.0, -0.1, 1.0))
    above = cloud(100, (-0.2, 1.0, -0.2), (0.2, 1.4, 0.2))
    roof = ceiling(4.0, y=0.8)
    scene = floor_scene(roof, lights=[below, above])
    under = Camera.look_at((0.0, 0.7, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=1.0)
    assert not trace(scene, under, paths="direct").radiance.any()


def test_particles_may_be_replaced_between_pictures(trace):
    first, second = cloud(10), ParticleLights(positions=[[0.0, 2.0, 0.0]], intensities=(1.0, 2.0, 3.0))
    for group in (first, second, cloud(20)):
        picture = trace(floor_scene(lights=[group]), pixel="centre", paths="direct", samples=64)
        assert_picture(picture, lit_floor(picture, group))
    assert not trace(floor_scene(lights=[replace(second, intensities=np.zeros(3))]), paths="direct").radiance.any()
