"""Single scattering in float64 against closed forms."""

from __future__ import annotations

from math import atan, exp, pi

import numpy as np
import pytest

from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.medium import Medium
from octolux.simulator import fog

BOX = (np.array([-3.0, 0.0, -10.0]), np.array([3.0, 4.0, 0.0]))
HAZE = Medium(scattering=(0.1, 0.2, 0.3), absorption=(0.05, 0.0, 0.1))
SUN = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(9.0, 8.0, 7.0))
ROUNDING = 1e-12


def even(value: float):
    """The same fluence everywhere."""
    return lambda positions: np.full(positions.shape, value)


def smoke() -> Medium:
    density = np.random.default_rng(3).uniform(0, 2, (5, 4, 3)).astype(np.float32)
    return Medium(scattering=HAZE.scattering, absorption=HAZE.absorption, density=density, low=tuple(BOX[0]),
                  high=tuple(BOX[1]))  # fmt: skip


@pytest.mark.parametrize("steps", [1, 7, 64])
def test_even_light_is_exact_whatever_the_steps(steps):
    """L = s / (4 pi x) * F * (1 - e^(-x l)): the ray enters the box after 2 m and leaves it after 12."""
    found, passed = fog.single_scattering(HAZE, BOX, (0.0, 1.0, 2.0), (0.0, 0.0, -1.0), np.inf, even(5.0), steps)
    expected = np.exp(-10.0 * HAZE.extinction)
    np.testing.assert_allclose(passed, expected, rtol=ROUNDING)
    albedo = np.array(HAZE.scattering) / HAZE.extinction
    np.testing.assert_allclose(found, albedo / (4 * pi) * 5.0 * (1 - expected), rtol=ROUNDING)


@pytest.mark.parametrize("slope", [0.0, 0.25, -0.25])
def test_a_sun_that_the_medium_dims(slope):
    """The sun stands above and has come through x (4 - y); y changes along the ray, which stays in the box."""
    direction = np.array([0.0, slope, -1.0]) / np.hypot(slope, 1.0)
    length, steps, x = 6.0, 256, HAZE.extinction
    fluence = fog.of_lights([SUN], HAZE, BOX)
    found, _ = fog.single_scattering(HAZE, BOX, (0.0, 2.0, -1.0), direction, length, fluence, steps)
    rate = x * (1.0 - direction[1])  # of sun and sight together along the ray
    before = np.array(HAZE.scattering) / (4 * pi) * np.array(SUN.illuminance) * np.exp(-2.0 * x)
    expected = before * (1 - np.exp(-rate * length)) / rate
    # Midpoints instead of means: of e^(k t) over a step h, with k = x |dy|, off by (k h)^2 / 24, and by k x h^2 / 12
    # since the weights fall within the step.
    h, k = length / steps, x.max() * abs(direction[1])
    np.testing.assert_allclose(found, expected, rtol=(k * h) ** 2 / 24 + k * x.max() * h * h / 12 + ROUNDING)


def test_a_lamp_in_thin_air():
    """Without extinction worth naming: the integral of s I / (4 pi (h^2 + t^2)) dt is an angle over h."""
    thin = Medium(scattering=(1e-9,) * 3)
    lamp = PointLight(position=(1.0, 2.0, -4.0), intensity=(3.0, 2.0, 1.0))
    fluence = fog.of_lights([lamp], thin, BOX)
    found, _ = fog.single_scattering(thin, BOX, (0.0, 2.0, 0.0), (0.0, 0.0, -1.0), 10.0, fluence, 2000)
    expected = 1e-9 / (4 * pi) * np.array(lamp.intensity) * (atan(6.0) + atan(4.0))
    # The midpoint rule errs by at most h^2 / 24 times length times |f''|, 2 for 1 / (1 + t^2); extinction by 1e-8.
    np.testing.assert_allclose(found, expected, rtol=0.005**2 / 24 * 10 * 2 / (atan(6.0) + atan(4.0)) + 2e-8)


@pytest.mark.parametrize("medium", [HAZE, smoke()], ids=["haze", "smoke"])
def test_a_furnace_without_absorption_stays_as_it_is(medium):
    """Radiance 2 from everywhere is the fluence 8 pi; what is scattered in replaces what is scattered out."""
    medium = Medium(scattering=tuple(medium.extinction), density=medium.density, low=medium.low, high=medium.high)
    rng = np.random.default_rng(4)
    for direction in rng.normal(size=(20, 3)):
        direction /= np.linalg.norm(direction)
        found, passed = fog.single_scattering(medium, BOX, (0.5, 1.0, -5.0), direction, np.inf, even(8 * pi), 50)
        np.testing.assert_allclose(found + 2.0 * passed, 2.0, rtol=ROUNDING)


def test_absorption_takes_light_away():
    found, passed = fog.single_scattering(smoke(), BOX, (0.5, 1.0, -5.0), (0.0, 0.0, 1.0), np.inf, even(8 * pi), 50)
    assert np.all(found + 2.0 * passed <= 2.0) and np.all((found + 2.0 * passed)[[0, 2]] < 1.9)


def test_steps_converge_in_second_order():
    lamp = PointLight(position=(1.0, 2.0, -4.0), intensity=(3.0, 2.0, 1.0))
    fluence = fog.of_lights([lamp, SUN], HAZE, BOX)
    ray = (HAZE, BOX, (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), np.inf, fluence)
    coarse, middle, fine = (fog.single_scattering(*ray, steps)[0] for steps in (100, 200, 400))
    np.testing.assert_allclose((coarse - middle) / (middle - fine), 4.0, rtol=0.05)


def test_density_is_linear_between_the_centres_of_cells():
    """Along x: cells of 2 m hold 1, 3 and 0; half a cell at each end is even."""
    density = np.array([1.0, 3.0, 0.0], np.float32).reshape(1, 1, 3)
    medium = Medium(scattering=(1.0,) * 3, density=density, low=tuple(BOX[0]), high=tuple(BOX[1]))
    expected = 1.0 * 1.0 + 2.0 * 2.0 + 2.0 * 1.5 + 0.0
    found = fog.depth(medium, BOX, (-9.0, 1.0, -1.0), (1.0, 0.0, 0.0), np.inf, 6 * 32)
    assert found == pytest.approx(expected, rel=ROUNDING)  # its bends lie between steps, where midpoints are exact
    assert fog.depth(medium, BOX, (-9.0, 1.0, -1.0), (1.0, 0.0, 0.0), 6.0) == 0.0
    assert fog.density(medium, BOX, [(-3.1, 1, -1), (0.0, 1, -1), (0, 1, 0.1)]).tolist() == [0.0, 3.0, 0.0]


def test_lines_along_and_beside_the_box():
    first, last = fog.span([(0, 0, 1), (0, 5, 1), (0, 1, -1)], [(0, 0, -1), (0, 0, -1), (0, 0, -2)], BOX)
    assert first[0] == 1.0 and last[0] == 11.0  # in the box's floor
    assert last[1] < first[1]
    assert (first[2], last[2]) == (0.0, 4.5)


def test_light_is_dimmed_between_its_place_and_the_point():
    lamp = PointLight(position=(0.0, 9.0, -5.0), intensity=(1.0, 1.0, 1.0))  # 5 m above the box
    found = fog.light_fluence(lamp, HAZE, BOX, np.array([[0.0, 1.0, -5.0]]))[0]
    np.testing.assert_allclose(found, [exp(-3.0 * x) / 64.0 for x in HAZE.extinction], rtol=ROUNDING)
