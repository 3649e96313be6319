"""Surroundings in pictures: seen behind the scene, reflected and shadowed; against the simulator and closed forms."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np
import pytest
from gpu_tools import front_camera, material_of, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad, revolve
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.materials import Material
from octolux.scene.scene import Scene
from octolux.simulator import brdf
from octolux.simulator import environment as reference
from octolux.simulator.camera import pixel_rays

LAMBERT = Material(specular=0.0, double_sided=True)
FLOOR = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
# Irradiance of a constant is a sum over a map of 32 rows: h^2 / 24 of the Laplacian of max(0, n.w), 4 pi in all.
IRRADIANCE_ERROR = (pi / 32) ** 2 / 24 * 4


def render(device, scene, camera, technique="none", size=(32, 32), **rest):
    settings = small_settings(**{"sky_lights": 16, **rest})
    renderer = Renderer(scene, technique, size=size, device=device, default_light=False, frame_settings=settings)
    return renderer.render(camera)


def random_map(height: int = 8) -> np.ndarray:
    return np.random.default_rng(2).uniform(0, 10, (height, 2 * height, 3)).astype(np.float32)


@pytest.mark.parametrize("rotation", [0.0, 2.0])
@pytest.mark.parametrize("height", [None, 2.0], ids=["perspective", "orthographic"])
def test_what_is_seen_behind(device, rotation, height):
    sky = Environment((0.5, 0.25, 0.125), random_map(), rotation)
    camera = Camera.look_at((1, 2, 3), (0.3, 3, -0.5), vertical_fov=2.0, orthographic_height=height)
    found = render(device, Scene(environment=sky, exposure=0.0), camera).radiance
    expected = reference.radiance(sky, pixel_rays(camera, 32, 32)[1])
    # acos may err by 6.8e-5, atan2 by 4096 roundings of pi (WGSL 15.7.4): of 8 rows in pi and 16 columns in 2 pi.
    # From texel to texel the map changes by up to 10.
    assert np.abs(found - expected).max() <= 10 * (6.8e-5 / pi * 8 + 4096 * 2.0**-24 * pi / (2 * pi) * 16)
    assert np.ptp(expected) > 1 if height is None else np.ptp(expected, axis=(0, 1)).max() < 1e-9


def test_a_sun_of_1e9_nits_is_seen(device):
    """float32 all the way: 16-bit floats end at 65504."""
    image = np.full((32, 64, 3), 1e9, np.float32)
    camera = front_camera()
    found = render(device, Scene(environment=Environment(image=image), exposure=0.0), camera).radiance
    np.testing.assert_allclose(found, 1e9, rtol=8 * 2.0**-24)
    lit = render(device, scene_of([FLOOR], [LAMBERT], environment=Environment(image=image)), above())
    np.testing.assert_allclose(lit.radiance[lit.mask], 1e9, rtol=IRRADIANCE_ERROR + 1e-5)


def above(height: float = 2.0, aside: float = 1.0) -> Camera:
    return Camera.look_at((aside, height, 0.0), (0.0, 0.0, 0.0), vertical_fov=0.8)


MATERIALS = {
    "lambert": Material(base_color=(0.8, 0.5, 0.2), specular=0.0),
    "dielectric": Material(base_color=(0.8, 0.5, 0.2), roughness=0.5),
    "half specular": Material(base_color=(0.1, 0.2, 0.9), roughness=0.2, specular=0.5),
    "gold": Material(base_color=(1.0, 0.7, 0.3), metallic=1.0, roughness=0.3),
    "rough metal": Material(base_color=(1.0, 0.7, 0.3), metallic=1.0, roughness=1.0),
    "half metal": Material(base_color=(0.5, 0.7, 0.3), metallic=0.5, roughness=0.7),
}


def table_at(roughness: np.ndarray, n_dot_v: np.ndarray) -> np.ndarray:
    """The table of the BRDF, bilinear, held at its rim: (..., 3)."""
    table = reference.brdf_table().astype(np.float64)
    row, column = (np.clip(v * len(table) - 0.5, 0, len(table) - 1) for v in (roughness, n_dot_v))
    i, j = (np.minimum(v.astype(int), len(table) - 2) for v in (row, column))
    y, x = (row - i)[..., None], (column - j)[..., None]
    upper = table[i, j] * (1 - x) + table[i, j + 1] * x
    return upper * (1 - y) + (table[i + 1, j] * (1 - x) + table[i + 1, j + 1] * x) * y


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("aside", [0.5, 3.0], ids=["steep", "grazing"])
def test_a_plane_under_an_even_sky(device, name, aside):
    """(F0 x + F90 y) L from the table, and albedo L of what Fresnel leaves, in every pixel: nothing casts a shadow."""
    sky = np.array([3.0, 2.0, 1.0])
    camera = above(1.0, aside)
    picture = render(device, scene_of([FLOOR], [MATERIALS[name]], environment=Environment(tuple(sky))), camera)
    m, mask = {key: value[picture.mask] for key, value in material_of(picture).items()}, picture.mask
    surface = brdf.surface(m["base_color"], m["metallic"], m["roughness"], m["specular"])
    albedo, f0, f90 = brdf.reflectances(surface)
    to_eye = -pixel_rays(camera, 32, 32)[1][mask]
    n_dot_v = (picture.layers["normal"][mask] * to_eye).sum(axis=-1)
    x, y, z = (table_at(np.maximum(m["roughness"], brdf.MIN_ROUGHNESS), n_dot_v)[:, i, None] for i in range(3))
    expected = (f0 * x + f90 * y + (1 - ((1 - z) * f0 + z * f90)) * albedo) * sky
    assert mask.sum() > 50
    np.testing.assert_allclose(picture.radiance[mask], expected, rtol=IRRADIANCE_ERROR)
    assert np.array_equal(picture.radiance[~mask], np.broadcast_to(sky, picture.radiance[~mask].shape))


def test_a_white_mirror_shows_the_sky(device):
    """The furnace test: smooth white metal is as bright as what surrounds it, to the table's 64^-1.5 and a rounding."""
    metal = Material(metallic=1.0, roughness=0.05)
    picture = render(device, scene_of([FLOOR], [metal], environment=Environment((2.0, 2.0, 2.0))), above())
    np.testing.assert_allclose(picture.radiance, 2.0, rtol=64**-1.5)


def test_a_white_ball_vanishes(device):
    """Lambert under an even sky is as bright as the sky; a ball of facets shadows itself a little near its horizons.

    A facet is 0.08 rad wide, so that lights less than three times that above the horizon may be lost: of the irradiance
    sin^2 of that, for lights spread evenly."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 41)
    ball = revolve(np.stack([np.cos(angles).clip(1e-4), np.sin(angles)], axis=1), segments=80)
    sky = Environment((1.0, 1.0, 1.0))
    picture = render(device, scene_of([ball], [LAMBERT], environment=sky), front_camera(4.0), sky_lights=64)
    inside = picture.radiance[picture.mask]
    assert inside.max() <= 1 + IRRADIANCE_ERROR
    assert inside.min() >= 1 - IRRADIANCE_ERROR - 2 * np.sin(3 * 0.08) ** 2
    assert inside.mean() >= 1 - IRRADIANCE_ERROR - np.sin(3 * 0.08) ** 2


@pytest.mark.parametrize("lights", [16, 64])
@pytest.mark.parametrize("turn", [0.0, 0.6])
def test_the_foot_of_a_wall_receives_half(device, lights, turn):
    """A wall hides half of the sky. It runs through the regions that lights stand for, of an edge of sqrt(4 pi / n):
    at most half of each may be on the wrong side. Along the half circle over the floor these have the irradiance
    edge * (integral of the sine, 2); the whole is pi."""
    c, s = np.cos(turn), np.sin(turn)
    along, away = np.array([c, 0, -s]), np.array([s, 0, c])
    wall = [-200 * along, 200 * along, 200 * along + [0, 200, 0], -200 * along + [0, 200, 0]]
    ground = [-along - 1e-3 * away, -along + away, along + away, along - 1e-3 * away]
    scene = scene_of([quad(wall, material=1), quad(ground)], [LAMBERT, Material(base_color=(0, 0, 0), specular=0.0)],
                     environment=Environment((1.0, 1.0, 1.0)))  # fmt: skip
    camera = Camera.look_at(0.5 * away + [0, 1, 0], 0.5 * away, up=along, orthographic_height=0.6)
    picture = render(device, scene, camera, sky_lights=lights)
    error = 0.5 * sqrt(4 * pi / lights) * 2 / pi + IRRADIANCE_ERROR
    assert picture.mask.all()
    np.testing.assert_allclose(picture.radiance, 0.5, atol=error)


def test_no_sky_in_a_closed_box(device):
    """Exactly none, but within two texels of the outline in a light's map: there its filter reaches past the room.

    Around a point lies a disk of the wall that ends at the wall's nearest edge. A light at the sine s over the wall
    sees it s times as high: the outline is no nearer than s times the edge."""
    room = box((-1, -1, -1), (1, 1, 1), inward=True)
    scene = scene_of([room], [Material(roughness=0.3)], environment=Environment((9.0, 9.0, 9.0)))
    inside = Camera.look_at((0.0, 0.6, 0.9), (0.0, -0.6, -1.0), vertical_fov=1.2)
    picture = render(device, scene, inside, sky_lights=32, coarse_resolution=512)
    lights, _ = reference.distant_lights(reference.total_map(scene.environment, 256), 32, 0.0)
    sines = picture.layers["normal"] @ lights.T
    flattest = np.where(sines > 0, sines, 1.0).min(axis=-1)
    texel = 2 * sqrt(3) / 512  # a map is at most the box's diagonal wide
    to_edge = np.sort(1 - np.abs(picture.layers["position"]), axis=-1)[..., 1]
    clear = to_edge * flattest > 2 * texel
    assert clear.mean() > 0.4
    assert not picture.radiance[clear].any()


def test_without_sky_lights_it_is_only_seen(device):
    scene = scene_of([FLOOR], [MATERIALS["dielectric"]], environment=Environment((3.0, 2.0, 1.0)))
    picture = render(device, scene, above(), sky_lights=0)
    assert not picture.radiance[picture.mask].any()
    assert (picture.radiance[~picture.mask] == (3.0, 2.0, 1.0)).all()


def test_the_sky_lights_indirectly(device):
    """Its lights have RSMs: a wall beside the floor gets light from it that is not there without sky lights."""
    wall = quad([(-1, 0, -1), (1, 0, -1), (1, 1, -1), (-1, 1, -1)])
    scene = scene_of([FLOOR, wall], [LAMBERT], environment=Environment((3.0, 3.0, 3.0)))
    dark, lit = (render(device, scene, front_camera(3.0), "uniform-lpv", sky_lights=n).energy for n in (0, 8))
    assert dark["indirect_mean"] == 0.0 and lit["indirect_mean"] > 0.01


@pytest.mark.parametrize(("rotation", "lit"), [(0.0, (0, 0, -1)), (pi / 2, (-1, 0, 0)), (pi, (0, 0, 1))])
def test_light_comes_from_where_it_is_seen(device, rotation, lit):
    """One bright texel in the middle of the map, turned about +y: of four walls around a post, that one is bright."""
    image = np.zeros((7, 15, 3), np.float32)
    image[3, 7] = 100.0
    scene = scene_of([box((-1, -1, -1), (1, 1, 1))], [LAMBERT], environment=Environment(image=image, rotation=rotation))
    for side in ((0, 0, -1), (-1, 0, 0), (0, 0, 1), (1, 0, 0)):
        camera = Camera.look_at(3.0 * np.array(side), (0, 0, 0), orthographic_height=1.0)
        # The texel's light lies in its centre, and the irradiance map's 32 x 64 texels are up to 0.1 rad from a wall's
        # normal: walls that it grazes get at most the sine of that.
        bright = render(device, scene, camera, sky_lights=4, size=(8, 8)).radiance.mean()
        full = 100.0 * reference.texel_solid_angles(7, 15)[3, 0] / pi
        assert bright == pytest.approx(full if side == lit else 0.0, rel=1e-2, abs=0.11 * full * (side != lit))


def test_many_lights_on_one_side(device):
    """128 lights behind a metal floor's mirrored direction: the lobe's weights stay within float32."""
    image = np.zeros((128, 256, 3), np.float32)
    image[4:20] = 1000.0
    metal = Material(metallic=1.0, roughness=0.1)
    picture = render(device, scene_of([FLOOR], [metal], environment=Environment(image=image)), above(0.3, 3.0),
                     sky_lights=128, coarse_resolution=16)  # fmt: skip
    assert np.isfinite(picture.radiance).all()


def test_another_environment(device):
    """Replaced in a live scene: the picture of a fresh renderer."""
    settings = small_settings(sky_lights=8)
    scene = scene_of([FLOOR], [MATERIALS["dielectric"]], environment=Environment((3.0, 2.0, 1.0)))
    renderer = Renderer(scene, "uniform-lpv", size=(16, 16), device=device, frame_settings=settings)
    before = renderer.render(above())
    scene.environment = Environment((0.0, 1.0, 0.0), random_map(), 0.5)
    after = renderer.render(above())
    fresh = Renderer(scene, "uniform-lpv", size=(16, 16), device=device, frame_settings=settings).render(above())
    assert np.array_equal(after.radiance, fresh.radiance) and not np.array_equal(after.radiance, before.radiance)
