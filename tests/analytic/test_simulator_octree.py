"""The octree over a volume: levels, index volume, merge (Olovsson 2012, 4.2)."""

from math import pi

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import lookup, octree, propagation

ROUNDING = {"rtol": 1e-13, "atol": 0.0}  # float64, sums of 8^5 positive numbers at most: 15 levels of adding pairs


def random_cells(n: int, seed: int = 0) -> np.ndarray:
    """Positive in band 0, so that sums have no cancellation."""
    return np.random.default_rng(seed).uniform(0.5, 2.0, (n, n, n, 3, 4))


def test_level_sizes_go_down_by_halves():
    assert octree.level_sizes(32) == [32, 16, 8, 4, 2, 1]
    assert octree.level_sizes(32, 2) == [32, 16, 8, 4, 2]
    assert octree.level_sizes(1) == [1]


@pytest.mark.parametrize(("n", "coarsest"), [(12, 1), (0, 1), (16, 3), (4, 8)])
def test_sizes_that_are_no_octree_are_refused(n, coarsest):
    with pytest.raises(ValueError, match=r"power of two|cannot be larger"):
        octree.level_sizes(n, coarsest)


def test_sums_keep_flux_on_every_level():
    levels = octree.build_levels(random_cells(8))
    for level in levels[1:]:
        np.testing.assert_allclose(propagation.total_flux(level), propagation.total_flux(levels[0]), **ROUNDING)


def test_averages_are_the_means_of_the_children():
    cells = random_cells(4)
    parent = octree.downsample(cells, "average")
    np.testing.assert_allclose(parent[1, 0, 1], cells[2:4, 0:2, 2:4].mean(axis=(0, 1, 2)), **ROUNDING)


def test_a_wall_reads_the_same_irradiance_on_every_level_of_sums():
    """Light of one layer of cells that all face +z, as a lit wall injects it, is read as F / h^2 on each level."""
    n, flux, h = 16, 3.0, 0.25
    cells = np.zeros((n, n, n, 3, 4))
    cells[5] = flux / pi * sh.cosine_lobe([0.0, 0.0, 1.0])
    for i, level in enumerate(octree.build_levels(cells)):
        grid = Grid((0.0, 0.0, 0.0), h * 2**i, n >> i)
        lit = level[5 >> i]
        read = lookup.irradiance(lit[0, 0], [0.0, 0.0, -1.0], grid.cell_size)
        np.testing.assert_allclose(read, flux / h**2, **ROUNDING)
        as_finest = lookup.irradiance(lit[0, 0] * octree.reading_factor(i), [0.0, 0.0, -1.0], h)
        np.testing.assert_allclose(as_finest, read, **ROUNDING)


def test_the_index_names_the_finest_level_that_was_touched():
    """One lit cell of 8^3: itself on level 0, then what lies in its ancestors, then the last level."""
    cells = np.zeros((8, 8, 8, 3, 4))
    cells[0, 0, 0] = 1.0
    index = octree.mark(octree.index_levels(8), octree.build_levels(cells))
    flat = octree.flat_index(index)
    assert flat[0, 0, 0] == 0
    assert (flat[:2, :2, :2].ravel()[1:] == 1).all()
    assert flat[3, 3, 3] == 2 and flat[0, 2, 0] == 2
    assert flat[4, 0, 0] == 3


def test_contributions_up_to_the_threshold_are_none():
    cells = np.zeros((4, 4, 4, 3, 4))
    cells[0, 0, 0, 1, 0], cells[3, 3, 3, 2, 0] = 0.5, 0.25
    marked = octree.mark(octree.index_levels(4), [cells], threshold=0.25)[0]
    assert marked[0, 0, 0] == 0 and marked[3, 3, 3] == 2


@pytest.mark.parametrize("combine", octree.COMBINATIONS)
def test_merging_is_equation_10(combine):
    """Against the definition, cell by cell, with a random index volume."""
    rng, n = np.random.default_rng(3), 8
    levels = octree.build_levels(random_cells(n), combine)
    index = [np.where(rng.random(level.shape[:3]) < 0.4, i, 3) for i, level in enumerate(levels)]
    flat, merged = octree.flat_index(index), octree.merge(levels, index, combine)
    for z, y, x in np.ndindex(n, n, n):
        i = flat[z, y, x]
        expected = levels[i][z >> i, y >> i, x >> i] * octree.reading_factor(i, combine)
        np.testing.assert_array_equal(merged[z, y, x], expected)


@pytest.mark.parametrize("shape", [(3, 3, 3), (4, 4, 2), (5, 4, 4)])
def test_levels_are_even_cubes(shape):
    with pytest.raises(ValueError, match="even number of cells"):
        octree.downsample(np.zeros((*shape, 3, 4)))


def test_unknown_combinations_are_refused():
    with pytest.raises(ValueError, match="unknown combination 'mean'"):
        octree.downsample(np.zeros((2, 2, 2, 3, 4)), "mean")
