"""Lookup: filtering, the beam and the furnace that fix the readings, damping."""

from math import pi, sqrt

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import lookup, propagation

GRID = Grid((-1.0, 0.0, 2.0), 0.25, 6)
ISOTROPIC = np.array([1.0, 0.0, 0.0, 0.0]) / (2.0 * sqrt(pi))
"""Unit flux, the same in all directions."""


def coloured(coefficients) -> np.ndarray:
    return np.asarray(coefficients)[..., None, :] * np.array([1.0, 2.0, 0.5])[:, None]


def ramp(along: int) -> np.ndarray:
    """Light that grows by 1 a cell along an axis, 0 in the first, [z][y][x][rgb][4]."""
    return np.indices((6, 6, 6))[2 - along][..., None, None] * np.ones((3, 4))


def test_centres_return_their_cells():
    sh = np.random.default_rng(2).random((6, 6, 6, 3, 4))
    np.testing.assert_allclose(lookup.sample_trilinear(sh, GRID, GRID.cell_centres()), sh)


@pytest.mark.parametrize("along", range(3))
def test_linear_light_is_reproduced_and_clamped_at_the_edge(along):
    cells = np.random.default_rng(4).uniform(-1.0, 7.0, (50, 3))
    points = np.array(GRID.origin) + GRID.cell_size * cells
    expected = np.clip(cells[:, along] - 0.5, 0.0, 5.0)
    found = lookup.sample_trilinear(ramp(along), GRID, points)
    np.testing.assert_allclose(found, np.broadcast_to(expected[:, None, None], found.shape), atol=1e-12)


def test_trilinear_weights_are_products():
    sh = np.zeros((6, 6, 6, 3, 4))
    sh[2, 3, 4] = 1.0
    point = GRID.cell_centres()[2, 3, 4] + GRID.cell_size * np.array([0.25, -0.5, 0.75])
    np.testing.assert_allclose(lookup.sample_trilinear(sh, GRID, point), 0.75 * 0.5 * 0.25)


@pytest.mark.parametrize(("reading", "factor"), [("paper", 3 / pi), ("dominant_lobe", 1.0)])
def test_beam(reading, factor):
    """A beam of flux F through a cell gives F / h^2 head on; CLPV's reading of two-band SH gives 0.955 of it."""
    direction, h = np.array([2.0, -1.0, 2.0]) / 3.0, 0.25
    beam = coloured(harmonics.cosine_lobe(direction) / pi)
    found = lookup.irradiance(beam, -direction, h, reading)
    np.testing.assert_allclose(found, factor * np.array([1.0, 2.0, 0.5]) / h**2)


def test_beam_at_an_angle_follows_the_cosine():
    beam, h = coloured(harmonics.cosine_lobe([0.0, 0.0, -1.0]) / pi), 0.5
    for angle in np.radians([0, 30, 60, 89, 91, 180]):
        found = lookup.irradiance(beam, np.array([np.sin(angle), 0.0, np.cos(angle)]), h, "dominant_lobe")
        np.testing.assert_allclose(found[0], max(0.0, np.cos(angle)) / h**2, atol=1e-12)


@pytest.mark.parametrize(("reading", "factor"), [("paper", 6 / pi), ("dominant_lobe", 1.0)])
def test_furnace(reading, factor):
    """Isotropic light of flux Phi in every cell: what the propagation sends through a face is the irradiance on it."""
    h = 0.25
    through_a_face = propagation.face_flux(ISOTROPIC, "signed")[3].sum()
    np.testing.assert_allclose(through_a_face, 1.0 / 6.0)
    found = lookup.irradiance(coloured(ISOTROPIC), np.array([0.0, 0.6, 0.8]), h, reading)
    np.testing.assert_allclose(found[0], factor * through_a_face / h**2)


def test_published_factors_of_the_papers_reading():
    """4 I / h^2 of a dominant lobe is 4/pi of the beam; with two-band SH 3/pi; the furnace reads 6/pi."""
    lobe = harmonics.cosine_lobe([1.0, 0.0, 0.0]) / pi
    assert 4.0 * harmonics.evaluate_dominant_lobe(lobe, [1.0, 0.0, 0.0]) == pytest.approx(1.273, abs=5e-4)
    assert 4.0 * harmonics.evaluate(lobe, [1.0, 0.0, 0.0]) == pytest.approx(0.955, abs=5e-4)
    assert 6.0 * 4.0 * harmonics.evaluate(ISOTROPIC, [1.0, 0.0, 0.0]) == pytest.approx(1.910, abs=5e-4)


def test_thesis_reading_is_the_scaled_product_of_lobes():
    """Lobe dot lobe head on: pi/4 + pi/3; facing away it would be negative and is clamped."""
    lobe = coloured(harmonics.cosine_lobe([0.0, 1.0, 0.0]))
    head_on = lookup.irradiance(lobe, np.array([0.0, -1.0, 0.0]), 123.0, "thesis", scale=2.0)
    np.testing.assert_allclose(head_on, 2.0 * (pi / 4 + pi / 3) * np.array([1.0, 2.0, 0.5]))
    np.testing.assert_array_equal(lookup.irradiance(lobe, np.array([0.0, 1.0, 0.0]), 123.0, "thesis"), 0.0)


def test_unknown_reading_is_refused():
    with pytest.raises(ValueError, match="unknown reading 'papr'"):
        lookup.irradiance(np.zeros((3, 4)), np.array([0.0, 1.0, 0.0]), 1.0, "papr")


def test_damping_keeps_what_is_still_there_one_cell_ahead():
    """In a ramp of slope 1 per cell, 4 at the point, one cell back along x holds 3/4 of it; forward is no loss."""
    point = GRID.cell_centres()[1, 2, 4]
    np.testing.assert_allclose(lookup.damping(ramp(0), GRID, point, [-1.0, 0.0, 0.0]), 0.75)
    np.testing.assert_allclose(lookup.damping(ramp(0), GRID, point, [1.0, 0.0, 0.0]), 1.0)
    np.testing.assert_allclose(lookup.damping(ramp(0), GRID, point, [0.0, 1.0, 0.0]), 1.0)


def test_damping_of_darkness_is_one_and_of_a_light_behind_zero():
    sh = np.zeros((6, 6, 6, 3, 4))
    point = GRID.cell_centres()[2, 2, 2]
    np.testing.assert_array_equal(lookup.damping(sh, GRID, point, [1.0, 0.0, 0.0]), 1.0)
    sh[2, 2, 2] = 1.0
    sh[2, 2, 1] = 4.0
    np.testing.assert_array_equal(lookup.damping(sh, GRID, point, [1.0, 0.0, 0.0]), 0.0)
