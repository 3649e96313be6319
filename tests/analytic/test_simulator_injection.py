"""Injection, in floats and in fixed point."""

from math import pi

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import injection
from octolux.simulator.lpv.propagation import total_flux

GRID = Grid((0.0, 0.0, 0.0), 0.5, 8)


def random_vpls(count: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rng = np.random.default_rng(5)
    normal = rng.normal(size=(count, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    return rng.uniform(0.3, 3.7, (count, 3)), normal, rng.random((count, 3)) * [1.0, 10.0, 0.01]


def test_a_wall_lights_the_cell_before_it():
    """A VPL on the face between cells 1 and 2 is moved half a cell along its normal, to a centre."""
    position, flux = np.array([[1.0, 0.7, 1.2]]), np.array([[1.0, 2.0, 3.0]])
    for sign, cell in ((1.0, 2), (-1.0, 1)):
        normal = np.array([[sign, 0.0, 0.0]])
        sh = injection.inject(position, normal, flux, GRID)
        expected = flux[0][:, None] / pi * harmonics.cosine_lobe(normal[0])
        np.testing.assert_allclose(sh[2, 1, cell], expected)
        assert np.count_nonzero(sh[..., 0]) == 3


def test_flux_is_kept_with_one_over_pi_and_times_pi_without():
    position, normal, flux = random_vpls(500)
    np.testing.assert_allclose(total_flux(injection.inject(position, normal, flux, GRID)), flux.sum(axis=0))
    literal = injection.inject(position, normal, flux, GRID, intensity_per_flux=1.0)
    np.testing.assert_allclose(total_flux(literal), pi * flux.sum(axis=0))


def test_vpls_outside_after_the_move_are_omitted():
    position = np.array([[3.9, 2.0, 2.0], [3.9, 2.0, 2.0], [-0.1, 2.0, 2.0]])
    normal = np.array([[1.0, 0, 0], [-1.0, 0, 0], [1.0, 0, 0]])
    sh = injection.inject(position, normal, np.ones((3, 3)), GRID)
    np.testing.assert_allclose(total_flux(sh), 2.0)


def test_moments_are_of_the_surfaces():
    """Of two VPLs of 1 and 3 lm below the cell before them, 0.3 cells along x from its middle each way."""
    position = np.array([[0.6, 0.7, 1.0], [0.9, 0.8, 1.0]])
    normal, flux = np.tile([0.0, 0.0, 1.0], (2, 1)), np.array([[1.0, 0.0, 0.0], [1.0, 1.0, 1.0]])
    moments = injection.inject_moments(position, normal, flux, GRID)
    band_0 = harmonics.COSINE_LOBE_0 / pi
    expected = band_0 * (1.0 * np.array([-0.3, -0.1, -0.5]) + 3.0 * np.array([0.3, 0.1, -0.5]))
    np.testing.assert_allclose(moments[2, 1, 1], expected, rtol=1e-12)
    assert np.count_nonzero(moments) == 3
    literal = injection.inject_moments(position, normal, flux, GRID, 1.0)
    np.testing.assert_allclose(literal, pi * moments, rtol=1e-12)


def test_moments_say_where_all_light_comes_from():
    """Whichever cells VPLs are moved to: their middles and the moments together have the centroid of all."""
    position, normal, flux = random_vpls(500)
    weight = flux.sum(axis=-1)
    centroid = (weight[:, None] * GRID.to_cells(position)).sum(axis=0) / weight.sum()
    z, y, x = np.indices((8, 8, 8)) + 0.5
    light = injection.inject(position, normal, flux, GRID)[..., 0].sum(axis=-1)
    moments = injection.inject_moments(position, normal, flux, GRID)
    found = (light[..., None] * np.stack([x, y, z], axis=-1) + moments).sum(axis=(0, 1, 2)) / light.sum()
    np.testing.assert_allclose(found, centroid, rtol=1e-12)


def test_fixed_point_is_within_half_a_unit_per_vpl():
    position, normal, flux = random_vpls(2000)
    scale = injection.fixed_point_scale(flux.sum(axis=0), len(flux))
    fixed = injection.inject_fixed_point(position, normal, flux, GRID, scale) / scale[:, None]
    exact = injection.inject(position, normal, flux, GRID)
    x, y, z = injection.vpl_cells(position, normal, GRID).T
    vpls = np.zeros((8, 8, 8))
    np.add.at(vpls, (z, y, x), 1.0)
    bound = 0.5 * vpls[..., None, None] / scale[:, None]
    assert (np.abs(fixed - exact) <= bound * (1 + 1e-9)).all()
    assert np.abs(fixed - exact).max() > 0.0


@pytest.mark.parametrize("intensity_per_flux", [1.0 / pi, 1.0])
def test_worst_case_does_not_overflow_and_the_scale_is_the_largest(intensity_per_flux):
    count = 1000
    flux = np.full((count, 3), [1.0, 0.1234, 777.0])
    position, normal = np.full((count, 3), 1.1), np.tile([0.0, 1.0, 0.0], (count, 1))
    scale = injection.fixed_point_scale(flux.sum(axis=0), count, intensity_per_flux)
    sums = injection.inject_fixed_point(position, normal, flux, GRID, scale, intensity_per_flux)
    assert np.abs(sums).max() <= injection.INT32_MAX
    largest = harmonics.COSINE_LOBE_1 * intensity_per_flux * flux.sum(axis=0) * (1 + injection.ARITHMETIC_SLACK)
    assert (2 * scale * largest + count / 2 > injection.INT32_MAX).all()
    np.testing.assert_array_equal(np.log2(scale), np.round(np.log2(scale)))


def test_scale_of_darkness_and_of_extremes():
    assert injection.fixed_point_scale(0.0, 10) == 1.0
    assert injection.fixed_point_scale(1e-300, 1) == 2.0 ** injection.SCALE_EXPONENTS[1]
    assert injection.fixed_point_scale([1.0, 2.0, 0.0], 10).shape == (3,)


@pytest.mark.parametrize(
    ("bound", "count", "message"),
    [
        (-1.0, 1, "not negative"),
        (np.inf, 1, "finite"),
        (1.0, 2**32, "overflow"),
        (1.0, -1, "overflow"),
        (1e60, 1, "too large"),
    ],
)
def test_impossible_scales_are_refused(bound, count, message):
    with pytest.raises(ValueError, match=message):
        injection.fixed_point_scale(bound, count)


def test_light_of_small_objects_fades_out():
    """None up to half a cell, all from a cell on, in proportion to the cell, and without steps or corners."""
    sizes = np.linspace(0.0, 3.0, 3001)
    share = injection.small_object_share(sizes, 2.0)
    assert not share[sizes <= 1.0].any() and np.all(share[sizes >= 2.0] == 1.0)
    assert injection.small_object_share(1.5, 2.0) == 0.5
    np.testing.assert_array_equal(share, injection.small_object_share(sizes / 8.0, 0.25))
    slope = np.gradient(share, sizes)
    assert slope.min() >= 0.0 and np.abs(np.diff(slope)).max() < 0.01 * slope.max()
