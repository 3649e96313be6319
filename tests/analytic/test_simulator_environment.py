"""Light of the surroundings: closed forms of irradiance, what distant lights keep, directions, the BRDF's table."""

from __future__ import annotations

from math import log, pi

import numpy as np
import pytest

from octolux.scene.environment import Environment
from octolux.simulator import brdf
from octolux.simulator import environment as reference

# What the midpoint rule over texels of edge h (radians) errs of the integral of f over the sphere: h^2 / 24 of the
# integral of |Laplacian f|. Of max(0, n.w) that is 2 pi from the cosine, and 2 pi from its kink at the horizon.
MAP = (64, 128)
CLAMPED_COSINE_ERROR = (pi / MAP[0]) ** 2 / 24 * 4 * pi
# The table's midpoint rule has 64 strata in each of two dimensions; the integrand has a kink where light goes below the
# horizon, and its slope may be that of a square root there: of the order of 64^-1.5.
TABLE_ERROR = 64**-1.5


def random_map(seed: int = 0, height: int = 16) -> np.ndarray:
    return (10 ** np.random.default_rng(seed).uniform(-2, 3, (height, 2 * height, 3))).astype(np.float32)


@pytest.mark.parametrize("size", [(1, 1), (2, 5), (64, 128), (128, 256)])
def test_texels_cover_the_sphere(size):
    angles = np.broadcast_to(reference.texel_solid_angles(*size), size)
    assert angles.sum() == pytest.approx(4 * pi, rel=1e-13)
    assert (angles > 0).all()


def test_constant_light_brings_pi_times_its_radiance():
    radiance = np.array([1.0, 0.5, 2.0])
    whole = reference.total_map(Environment(tuple(radiance)), 64)
    assert np.array_equal(whole, np.broadcast_to(radiance, whole.shape))
    image = np.broadcast_to(radiance, (*MAP, 3)).astype(np.float32)
    found = reference.irradiance_map(image, 8, 16)
    # float32 sums of 8192 terms add a little: some 1e-6 when they are added in blocks, as BLAS does.
    assert np.abs(found / radiance - pi).max() <= CLAMPED_COSINE_ERROR + 1e-5


def test_light_that_grows_upwards():
    """L = 1 + d.y: the first band of the cosine lobe is 2 pi / 3 (Ramamoorthi and Hanrahan 2001), so that
    E = pi (1 + 2/3 n.y)."""
    above = reference.texel_directions(*MAP)[..., 1:2]
    found = reference.irradiance_map(np.repeat(1 + above, 3, axis=2).astype(np.float32), 8, 16)
    expected = pi * (1 + 2 / 3 * reference.texel_directions(8, 16)[..., 1:2])
    # L is at most 2, and its own Laplacian and gradient, at most 2 and 1, take part: 4 times the constant's at most.
    assert np.abs(found - expected).max() <= 4 * CLAMPED_COSINE_ERROR
    assert np.abs(found - expected).max() > 0  # a quadrature, not the formula


@pytest.mark.parametrize("count", [1, 2, 3, 7, 16, 64])
@pytest.mark.parametrize("rotation", [0.0, 1.0])
def test_distant_lights_keep_the_light(count, rotation):
    """Of lights that lie in one texel one is left."""
    image = random_map()
    directions, illuminance = reference.distant_lights(image, count, rotation)
    assert directions.shape == illuminance.shape and count / 2 <= len(directions) <= count
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0, rtol=1e-12)
    power = (image * reference.texel_solid_angles(*image.shape[:2])[..., None].astype(np.float64)).sum(axis=(0, 1))
    np.testing.assert_allclose(illuminance.sum(axis=0), power, rtol=1e-12)


def test_distant_lights_stand_where_the_light_is():
    """Half of the map, +x, shines: all of the lights stand there, none is lost on the other."""
    image = np.zeros((*MAP, 3), np.float32)
    image[:, MAP[1] // 2 :] = 9.0
    directions, _ = reference.distant_lights(image, 64, 0.0)
    assert len(directions) == 64
    assert (directions[:, 0] > 0).all()


@pytest.mark.parametrize("half", [0.15, 0.28, 0.5, 0.8])
def test_even_sky_through_a_slot(half):
    """On the floor of a long court, which sees the sky `half` radians to each side of the zenith, arrives sin(half) of
    it. Over courts that run in all directions, and for those along the map's axes, 32 lights err less than 32
    directions at random would: with the weights 4 cos over the slot, whose mean square is
    16 / (4 pi) * integral of cos^2 = 16 / (3 pi) (half + sin(half) cos(half))."""
    directions, illuminance = reference.distant_lights(np.ones((*MAP, 3), np.float32), 32, 0.0)
    irradiance = illuminance[:, 0] * np.maximum(directions[:, 1], 0.0)
    turns = np.arange(180) / 180 * pi
    across = directions[:, [0]] * np.cos(turns) + directions[:, [2]] * np.sin(turns)
    seen = np.abs(np.arctan2(across, directions[:, [1]])) < half
    error = (irradiance[:, None] * seen).sum(axis=0) / pi - np.sin(half)
    at_random = np.sqrt((16 / (3 * pi) * (half + np.sin(half) * np.cos(half)) - np.sin(half) ** 2) / 32)
    assert np.sqrt((error**2).mean()) < at_random
    assert np.abs(error[[0, 90]]).max() < at_random


def test_distant_lights_of_nothing_and_of_more_than_texels():
    for image, count in ((np.zeros((8, 16, 3), np.float32), 5), (random_map(), 0)):
        directions, illuminance = reference.distant_lights(image, count, 0.0)
        assert directions.shape == illuminance.shape == (0, 3)
    image = random_map(height=2)
    directions, illuminance = reference.distant_lights(image, 100, 0.0)
    assert 1 < len(directions) <= image.shape[0] * image.shape[1]
    assert (illuminance > 0).all()


@pytest.mark.parametrize("rotation", [0.0, 0.7, -2.5])
@pytest.mark.parametrize("texel", [(0, 0), (3, 9), (15, 31)])
@pytest.mark.parametrize("count", [1, 8])
def test_a_bright_texel_is_one_light(texel, rotation, count):
    image = np.zeros((16, 32, 3), np.float32)
    image[texel] = (3.0, 2.0, 1.0)
    directions, illuminance = reference.distant_lights(image, count, rotation)
    assert len(directions) == 1
    np.testing.assert_allclose(directions[0], reference.texel_directions(16, 32, rotation)[texel], atol=1e-14)
    np.testing.assert_allclose(illuminance[0], np.array([3, 2, 1]) * reference.texel_solid_angles(16, 32)[texel[0]])


@pytest.mark.parametrize(("direction", "uv"), [
    ((0, 0, -1), (0.5, 0.5)), ((1, 0, 0), (0.75, 0.5)), ((0, 0, 1), (0.0, 0.5)), ((-1, 0, 0), (0.25, 0.5)),
    ((1, 1, 0), (0.75, 0.25)), ((0, -1, 1e-9), (0.0, 1.0)),
])  # fmt: skip
def test_where_directions_lie_in_the_map(direction, uv):
    """Environment's docstring: the middle is -z, +x a quarter to the right, the top +y."""
    found = reference.coordinates(np.array(direction, float), 0.0) - uv
    found[0] -= np.round(found[0])  # u = 0 and u = 1 are one place
    np.testing.assert_allclose(found, 0.0, atol=1e-12)


def test_rotation_turns_the_map_counter_clockwise_seen_from_above():
    """From above, with -z up and +x to the right, counter-clockwise leads from -z to -x."""
    assert reference.coordinates(np.array([-1.0, 0, 0]), pi / 2)[0] == pytest.approx(0.5)
    middle = reference.texel_directions(1, 1, pi / 2)[0, 0]
    np.testing.assert_allclose(middle, [-1.0, 0.0, 0.0], atol=1e-15)


@pytest.mark.parametrize("rotation", [0.0, 0.3, -4.0])
def test_texel_centres_hold_the_texels(rotation):
    """`radiance` in the direction of each texel's centre is that texel, plus the constant."""
    image = random_map()
    sky = Environment((0.5, 0.25, 0.125), image, rotation)
    found = reference.radiance(sky, 3.0 * reference.texel_directions(16, 32, rotation))
    # A coordinate is exact to some 1e-15 of 32 texels, beside neighbours up to 1e5 times as bright.
    np.testing.assert_allclose(found, image + np.array([0.5, 0.25, 0.125]), rtol=1e-8)


def test_between_texels_and_across_the_seam():
    image = random_map()
    u, v = 0.0, 5.0 / 16  # between the last and the first column, between rows 4 and 5
    direction = np.array([np.sin(pi * v) * np.sin(2 * pi * (u - 0.5)), np.cos(pi * v), -np.sin(pi * v) * np.cos(pi)])
    expected = image[4:6][:, [-1, 0]].astype(np.float64).mean(axis=(0, 1))
    np.testing.assert_allclose(reference.radiance(Environment(image=image), direction), expected, rtol=1e-8)


@pytest.mark.parametrize("most", [64, 16, 5])
def test_a_reduced_map_keeps_its_light(most):
    image = random_map(height=64)
    small = reference.reduced(image, most)
    assert small.dtype == np.float32 and small.shape[1] <= most < 2 * small.shape[1]
    power = [(i * reference.texel_solid_angles(*i.shape[:2])[..., None].astype(np.float64)).sum(axis=(0, 1))
             for i in (image, small)]  # fmt: skip
    np.testing.assert_allclose(power[1], power[0], rtol=5 * 2.0**-24)  # one rounding to float32 a step


def directional_albedo(roughness: float, n_dot_v: float, f0: float) -> np.ndarray:
    """Specular albedo, and mean diffuse transmission (1 - F), by quadrature of simulator/brdf.py."""
    polar = (np.arange(400) + 0.5) / 400  # sin^2 of the angle: even in projected solid angle
    azimuth = (np.arange(800) + 0.5) / 800 * 2 * pi
    square, around = np.meshgrid(polar, azimuth, indexing="ij")
    sine = np.sqrt(square)
    light = np.stack([sine * np.cos(around), sine * np.sin(around), np.sqrt(1 - square)], axis=-1)
    eye = np.array([np.sqrt(1 - n_dot_v**2), 0.0, n_dot_v])
    half = light + eye
    half /= np.linalg.norm(half, axis=-1, keepdims=True)
    alpha = brdf.alpha_of(roughness)
    lobe = brdf.ggx_distribution(half[..., 2], alpha) * brdf.smith_visibility(light[..., 2], n_dot_v, alpha)
    fresnel = brdf.schlick_fresnel(f0, 1.0, half @ eye)
    return np.array([pi * (fresnel * lobe).mean(), (1 - fresnel).mean()])


@pytest.mark.parametrize(("row", "column"), [(31, 31), (31, 16), (20, 28), (16, 8), (24, 2), (10, 20), (16, 1)])
@pytest.mark.parametrize("f0", [0.04, 0.6, 1.0])
def test_brdf_table_against_quadrature(row, column, f0):
    table = reference.brdf_table().astype(np.float64)
    x, y, z = table[row, column]
    specular, diffuse = directional_albedo((row + 0.5) / 32, (column + 0.5) / 32, f0)
    assert f0 * x + y == pytest.approx(specular, abs=TABLE_ERROR)
    assert 1 - ((1 - z) * f0 + z) == pytest.approx(diffuse, abs=TABLE_ERROR)


def test_brdf_table_at_its_ends():
    table = reference.brdf_table().astype(np.float64)
    assert table.shape == (32, 32, 3) and table.min() >= 0 and table.max() <= 1
    assert (table[..., 0] + table[..., 1]).max() <= 1 + TABLE_ERROR
    # A mirror reflects all (white metal, F0 = 1). At n.v from 1/2; towards grazing even a narrow lobe dips below.
    np.testing.assert_allclose(table[0, 16:, :2].sum(axis=1), 1.0, atol=TABLE_ERROR)
    # Roughness 1 seen along the normal: with alpha = 1, D is 1 / pi and V is 1 / (2 (n.l + 1)), so that the albedo is
    # the integral of n.l / (1 + n.l) over n.l: 1 - ln 2. By lines through the last two cells, half a cell further.
    whole = table[..., :2].sum(axis=-1)
    along = whole[-2:, -1] + 0.5 * (whole[-2:, -1] - whole[-2:, -2])
    corner = along[1] + 0.5 * (along[1] - along[0])
    curvature = abs(whole[-1, -1] - 2 * whole[-2, -1] + whole[-3, -1])
    curvature += abs(whole[-1, -1] - 2 * whole[-1, -2] + whole[-1, -3])
    assert corner == pytest.approx(1 - log(2), abs=curvature + TABLE_ERROR)


def test_maps_are_reduced_in_bands_to_the_same_bits(monkeypatch):
    image = np.random.default_rng(3).random((75, 301, 3)).astype(np.float32)
    whole = reference.reduced(image, 40)
    assert whole.shape == (9, 37, 3)
    monkeypatch.setattr(reference, "_BAND", 500)
    np.testing.assert_array_equal(reference.reduced(image, 40), whole)
