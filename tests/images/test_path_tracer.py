"""The path tracer's light in closed form: furnaces, light-path sets, plates, and path-traced ground truth.

Means lie within four standard errors, which come with the pictures (`Picture.noise`).
"""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from gpu_tools import TESTS, scene_of
from path_tracing import (
    ERRORS,
    WHITE,
    Tracer,
    assert_mean,
    assert_picture,
    ceiling,
    directional_albedo,
    floor,
    inward_and_flat,
    luminance,
    mean_and_error,
)

from octolux.data import data_folder
from octolux.scene.builtin.round_shapes import sphere
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.load import load_scene
from octolux.scene.materials import Material
from octolux.simulator import brdf
from octolux.simulator.form_factors import point_to_parallel_square

GLOW = np.array([1.0, 2.0, 3.0])
INSIDE = Camera.look_at((0.3, 0.1, 0.4), (-0.2, 0.0, -1.0))
HOLLOWS = {
    "box": box((-1, -1, -1), (1, 1, 1), inward=True),
    "sphere": inward_and_flat(sphere(1.0, rows=4)),
}


@pytest.fixture(scope="module")
def trace(device) -> Tracer:
    return Tracer(device)


def furnace(shape: str, albedo: float):
    return scene_of([HOLLOWS[shape]], [Material(base_color=(albedo,) * 3, specular=0.0, emissive=tuple(GLOW))])


@pytest.mark.parametrize("shape", HOLLOWS)
@pytest.mark.parametrize("albedo", [0.2, 0.5, 0.8])
def test_a_closed_room_shines_evenly(trace, shape, albedo):
    """L = e + a L everywhere; after 256 bounces 0.8^257 = 1e-25 of it is missing."""
    picture = trace(furnace(shape, albedo), INSIDE, bounces=256)
    assert_picture(picture, GLOW / (1 - albedo))
    # Grey walls: the colours' paths are the same.
    np.testing.assert_allclose(picture.radiance / GLOW, picture.radiance[..., :1].repeat(3, -1), rtol=1e-5)
    np.testing.assert_allclose(picture.layers["emissive"], np.broadcast_to(GLOW, picture.radiance.shape), rtol=1e-6)
    assert np.all(picture.alpha == 1)


# What the light-path sets show of L = e (1 + a + a^2 + ...), and the layers direct and indirect beside it.
SETS = {
    "all": lambda e, a, n: e * (1 - a ** (n + 2)) / (1 - a),
    "direct": lambda e, a, n: e * (1 + a),
    "first-bounce": lambda e, a, n: e * a**2,
    "indirect": lambda e, a, n: e * a**2 * (1 - a**n) / (1 - a),
}


@pytest.mark.parametrize("paths", SETS)
def test_light_path_sets(trace, paths):
    albedo, bounces = 0.6, 3
    picture = trace(furnace("box", albedo), INSIDE, paths=paths, bounces=bounces)
    assert_mean(picture, SETS[paths](GLOW, albedo, bounces))
    direct, indirect = (luminance(picture.layers[name]).mean() for name in ("direct", "indirect"))
    # The picture's error bounds that of its parts: none of their noise is negative.
    slack = ERRORS * mean_and_error(picture)[1] / min(albedo, 1 - albedo) + 1e-4
    assert abs(direct - albedo * luminance(GLOW)) <= slack
    if paths in ("all", "indirect"):
        assert abs(indirect - luminance(SETS["indirect"](GLOW, albedo, bounces))) <= slack


def test_sets_add_up(trace):
    """With the same seed, direct light and what was reflected before are the same paths' parts of the whole."""
    scene = furnace("box", 0.6)
    whole, direct, indirect = (trace(scene, INSIDE, paths=paths) for paths in ("all", "direct", "indirect"))
    np.testing.assert_allclose(whole.radiance, whole.layers["emissive"] + whole.layers["direct"]
                               + whole.layers["indirect"], rtol=1e-5)  # fmt: skip
    assert np.array_equal(direct.layers["direct"], whole.layers["direct"])
    np.testing.assert_allclose(indirect.radiance, whole.layers["indirect"], rtol=1e-5)
    np.testing.assert_allclose(direct.radiance + indirect.radiance, whole.radiance, rtol=1e-5)


def test_diffuse_materials(trace):
    """A metal is black then, a dielectric pure Lambert of its base colour."""
    room = [box((-1, -1, -1), (1, 1, 1), inward=True)]
    material = Material(base_color=(0.6,) * 3, roughness=0.3, metallic=0.5, emissive=tuple(GLOW))
    picture = trace(scene_of(room, [material]), INSIDE, materials="diffuse", bounces=64)
    assert_mean(picture, GLOW / (1 - 0.3))


@pytest.mark.parametrize(("metallic", "roughness"), [(1.0, 0.15), (1.0, 0.6), (0.0, 0.3)])
@pytest.mark.parametrize("n_v", [0.95, 0.35])
def test_glossy_surface_under_an_even_sky(trace, metallic, roughness, n_v):
    """It shows its directional albedo: of a metal below 1."""
    eye = np.array([np.sqrt(1 - n_v * n_v), n_v, 0.0])
    camera = Camera.look_at(3 * eye, (0, 0, 0), orthographic_height=0.4)
    material = Material(base_color=(0.9, 0.7, 0.4), metallic=metallic, roughness=roughness)
    picture = trace(scene_of([floor()], [material], environment=Environment((2.0, 2.0, 2.0))), camera)
    expected = directional_albedo(brdf.surface((0.9, 0.7, 0.4), metallic, roughness), eye[[0, 2, 1]])
    assert expected.max() < 1
    assert_mean(picture, 2 * expected, rounding=1e-4)  # 2e-5 of the quadrature, and the size of float32 lobes


def test_first_bounce_between_plates(trace):
    """A glowing plate over a white one: of its own light comes back what the lower plate reflects, whose radiance is
    albedo * e times the form factor of its points."""
    glow, albedo, side, gap = 5.0, 0.8, 1.0, 0.7
    lamp = Material(base_color=(0.5,) * 3, specular=0.0, emissive=(glow,) * 3)
    scene = scene_of([floor(side), ceiling(side, material=1, y=gap)], [WHITE, lamp])
    camera = Camera.look_at((0, 0.05, 0), (0, 1, 0), up=(0, 0, 1), orthographic_height=0.8)
    picture = trace(scene, camera, paths="first-bounce", pixel="centre")
    steps = (np.arange(64) + 0.5) / 64 - 0.5
    x, z = np.meshgrid(steps * side, steps * side)
    lower = albedo * glow * point_to_parallel_square(side, gap, x, z)
    position = picture.layers["position"].astype(np.float64)
    square = (position[..., 0, None, None] - x) ** 2 + (position[..., 2, None, None] - z) ** 2 + gap**2
    irradiance = (lower * gap**2 / square**2).sum(axis=(-2, -1)) * (side / 64) ** 2
    assert_picture(picture, (0.5 / pi * irradiance)[..., None], rounding=1e-3)  # the quadrature: (1/64)^2 / 24 * 4
    assert np.all(picture.layers["indirect"] == picture.radiance)


GROUND_TRUTH = data_folder() / "ground-truth"


@pytest.mark.skipif(not GROUND_TRUTH.is_dir(), reason="needs OCTOLUX_DATA")
@pytest.mark.parametrize("name", ["cornell_point", "cornell_area"])
def test_ground_truth(device, name):
    """Means of an independent renderer's picture, whose halves tell its error. Coarser pixels, each seen all over, have
    the same mean as 256^2 centres, but for the edges in the picture: some 10^3 pixels that are a half off at random."""
    truth = np.load(GROUND_TRUTH / f"{name}.npz")
    scene = load_scene(TESTS.parent / "benchmarks" / "scenes" / f"{name}.toml")
    trace = Tracer(device, (32, 32))
    for paths, key in (("first-bounce", "first_bounce"), ("indirect", "all_indirect")):
        picture = trace(scene, scene.cameras[0], paths=paths, samples=128, materials="diffuse")
        mean, error = mean_and_error(picture)
        expected = luminance(truth[key]).mean()
        difference = luminance(truth[f"seedA_{key}"]) - luminance(truth[f"seedB_{key}"])
        error = np.hypot(error, 0.5 * difference.std() / np.sqrt(difference.size))
        assert abs(mean / expected - 1) <= ERRORS * error / expected + 1e-3, (paths, mean / expected, error / expected)
