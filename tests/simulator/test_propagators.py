"""Every propagator: its stated gain, and what it does to flux and direction, in closed form."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.laboratory import PROPAGATORS
from octolux.simulator.laboratory.propagators import NVIDIA_WEIGHTS
from octolux.simulator.lpv import propagation

ROUNDING = 2.0**-44
"""Relative, for some 2^8 operations in float64, each within 2^-53, with room for the order of sums."""

NAMES = list(PROPAGATORS)
LINEAR = ("signed", "signed-travel", "dom6", "dom18", "dom26")


def one_cell(coefficients, n=5):
    """A volume with `coefficients` in its middle, from which nothing leaves it in a step."""
    cells = np.zeros((n, n, n, 4))
    cells[n // 2, n // 2, n // 2] = coefficients
    return cells


@pytest.mark.parametrize("name", NAMES)
def test_isotropic_light_has_the_stated_gain(name):
    """An isotropic cell is positive everywhere, so clamping changes nothing and a dominant lobe is all rest."""
    before = one_cell([1.0, 0.0, 0.0, 0.0])
    after = PROPAGATORS[name].step(before, factor=0.5)
    # NVIDIA's printed degrees are rounded to 1e-5, the smallest being 22.95668.
    tolerance = 0.5e-5 / 22.95668 if name == "nvidia" else ROUNDING
    gain = harmonics.flux(after).sum() / harmonics.flux(before).sum()
    assert gain == pytest.approx(0.5 * PROPAGATORS[name].gain, rel=tolerance)


@pytest.mark.parametrize("name", NAMES)
def test_a_positive_cell_has_the_stated_gain(name):
    """|c1| <= c00 / sqrt(3) makes I positive in every direction, so clamping changes nothing; faces, cones and
    ordinates come in opposite pairs, so what band 1 sends sums to 0."""
    rng = np.random.default_rng(1)
    vector = rng.normal(size=3)
    before = one_cell([1.0, *(vector / np.linalg.norm(vector) * 0.99 / sqrt(3.0))])
    after = PROPAGATORS[name].step(before)
    tolerance = 0.5e-5 / 22.95668 if name == "nvidia" else ROUNDING
    gain = harmonics.flux(after).sum() / harmonics.flux(before).sum()
    assert gain == pytest.approx(PROPAGATORS[name].gain, rel=tolerance)


@pytest.mark.parametrize("name", LINEAR)
def test_linear_propagators_add(name):
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(2, 4, 4, 4, 4))
    step = PROPAGATORS[name].step
    np.testing.assert_allclose(step(a + 3.0 * b), step(a) + 3.0 * step(b), atol=1e-13)


@pytest.mark.parametrize("name", ["dom6", "dom18", "dom26"])
def test_ordinates_keep_all_coefficients(name):
    """The sum of w b b^T over the links is the identity, so light of any direction keeps it."""
    coefficients = np.random.default_rng(3).normal(size=4)
    after = PROPAGATORS[name].step(one_cell(coefficients))
    np.testing.assert_allclose(after.sum(axis=(0, 1, 2)), coefficients, atol=1e-14)


@pytest.mark.parametrize("neighbours", [6, 18, 26])
def test_ordinates_reach_that_many_neighbours(neighbours):
    after = PROPAGATORS[f"dom{neighbours}"].step(one_cell([1.0, 0.0, 0.0, 0.0]))
    assert np.count_nonzero(after[..., 0]) == neighbours


@pytest.mark.parametrize("name,evaluation,reprojection,gain", [
    ("clpv", "clamped", "face", 1.0), ("signed", "signed", "face", 1.0), ("clamped-travel", "clamped", "travel", 1.0),
    ("signed-travel", "signed", "travel", 1.0), ("dominant-lobe", "dominant_lobe", "face", 1.0),
    ("best", "dominant_lobe", "travel", 1.0), ("thesis", "clamped", "face", 0.75),
])  # fmt: skip
def test_face_propagators_are_the_reference_step(name, evaluation, reprojection, gain):
    cells = np.random.default_rng(4).normal(size=(4, 4, 4, 4))
    expected = propagation.step(cells[..., None, :], gain, evaluation, reprojection)[..., 0, :]
    np.testing.assert_allclose(PROPAGATORS[name].step(cells), expected, atol=1e-13)


def test_nvidia_with_an_amplifier_of_3_is_the_thesis():
    """Their weights are solid angle / (4 pi) to the digits printed, 0.5e-5 of 22.95668 degrees at worst."""
    assert NVIDIA_WEIGHTS.sum() == pytest.approx(1.0, rel=0.5e-5 / 22.95668)
    lobe = harmonics.cosine_lobe([0.6, 0.0, 0.8])
    nvidia, thesis = (PROPAGATORS[name].step(one_cell(lobe), f) for name, f in (("nvidia", 3.0), ("thesis", 1.0)))
    # Coefficients of both signs are sums of at most 5 lobes a cell, none larger than the largest of all.
    np.testing.assert_allclose(nvidia, thesis, atol=5.0 * 0.5e-5 / 22.95668 * np.abs(thesis).max())


def test_the_cone_of_2009_sends_what_the_listing_sends():
    """The listing: a cone of half angle a has the zonal coefficients 2 sqrt(pi) (1 - cos a) / 2 and
    2 sqrt(pi / 3) * 3/4 sin^2 a, and target += cone * max(0, S . cone). Its gain is 6 solid angle^2 / (4 pi) = 1.617,
    ours 1."""
    angle = pi / 4.0
    solid_angle = 2.0 * pi * (1.0 - cos(angle))
    cone = np.array([sqrt(pi) * (1.0 - cos(angle)), 0.0, 0.0, 1.5 * sqrt(pi / 3.0) * sin(angle) ** 2])
    lobe = harmonics.cosine_lobe([0.8, 0.6, 0.0])
    gain = 6.0 * solid_angle**2 / (4.0 * pi)
    assert gain == pytest.approx(1.617, abs=5e-4)
    after = PROPAGATORS["cone-2009"].step(one_cell(lobe))[2, 2, 3]
    np.testing.assert_allclose(gain * after, cone * (lobe @ cone), atol=1e-14)


@pytest.mark.parametrize("name", NAMES)
def test_light_turns_with_the_volume(name):
    """Every scheme treats the axes alike: turning by 90 degrees about z before or after the step is the same."""
    cells = np.random.default_rng(5).normal(size=(4, 4, 4, 4))
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # x to y, y to -x

    def turned(volume):
        return harmonics.rotate(np.flip(np.swapaxes(volume, 1, 2), axis=2), turn)

    step = PROPAGATORS[name].step
    # NVIDIA's and all others' weights are the same for all axes; only rounding differs.
    np.testing.assert_allclose(turned(step(cells)), step(turned(cells)), atol=1e-13)


@pytest.mark.parametrize("name", NAMES)
def test_every_propagator_says_what_it_is(name):
    propagator = PROPAGATORS[name]
    assert propagator.name == name and propagator.meaning and propagator.source
    np.testing.assert_allclose(np.linalg.norm(propagator.directions, axis=1), 1.0, atol=1e-15)
