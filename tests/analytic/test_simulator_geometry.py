"""The geometry volume: shares of cross sections (simulator/lpv/geometry.py). Planes: test_simulator_planes.py."""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest

from octolux.simulator.grid import Grid
from octolux.simulator.lpv import geometry

N, H = 16, 0.25
GRID = Grid((-1.0, 2.0, 0.5), H, N)
ROUNDING = {"rtol": 0.0, "atol": 1e-12}  # float64, sums of some thousand areas
SAMPLES = 8  # surfels along each side of a cell


def plane(slope: float = 0.0, height: float = 5.3) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Surfels, SAMPLES^2 a column of cells, of z = height + slope * x (in cells) over the whole grid."""
    steps = (np.arange(N * SAMPLES) + 0.5) / SAMPLES
    x, y = np.meshgrid(steps, steps)
    cells = np.stack([x, y, height + slope * x], axis=-1).reshape(-1, 3)
    normal = np.array([-slope, 0.0, 1.0]) / sqrt(1.0 + slope * slope)
    area = np.full(len(cells), (H / SAMPLES) ** 2 / normal[2])
    return GRID.origin + H * cells, np.broadcast_to(normal, cells.shape), area


def wall_levels(axis: int, layer: int, n: int = N) -> list[np.ndarray]:
    """The octree of a volume whose only surface is a closed wall across `axis` (0 is x)."""
    finest = np.zeros((n, n, n, 3))
    np.moveaxis(finest, 2 - axis, 0)[layer, ..., axis] = 1.0
    return geometry.geometry_levels(finest)


def test_a_wall_fills_the_cross_section():
    shares = geometry.inject_surfels(*plane(), GRID)
    np.testing.assert_allclose(shares[5], np.broadcast_to([0.0, 0.0, 1.0], (N, N, 3)), **ROUNDING)
    assert not np.delete(shares, 5, axis=0).any()


@pytest.mark.parametrize("slope", [0.25, 0.5])
def test_a_slanted_wall_fills_each_column_once(slope):
    """Seen along z a column is closed, by one cell or by several together; along x it blocks `slope` of that."""
    columns = geometry.inject_surfels(*plane(slope), GRID).sum(axis=0)
    np.testing.assert_allclose(columns, np.broadcast_to([slope, 0.0, 1.0], (N, N, 3)), **ROUNDING)


def test_a_diagonal_wall_closes_its_cells_along_both_axes():
    """z = x + 5 goes from edge to edge of its cells: area sqrt(2) h^2, of which sqrt(1/2) shows along x and along z."""
    shares = geometry.inject_surfels(*plane(1.0, 5.0), GRID)
    for x in range(N - 5):
        np.testing.assert_allclose(shares[x + 5, :, x], np.broadcast_to([1.0, 0.0, 1.0], (N, 3)), **ROUNDING)


def test_a_wall_between_cells_is_in_those_behind_it():
    """Whatever rounding does to its places: those of float32 in a scene of some ten metres."""
    position, normal, area = plane(height=5.0)
    moved = position + np.random.default_rng(0).uniform(-1e-6, 1e-6, position.shape)
    shares = geometry.inject_surfels(moved, normal, area, GRID)
    np.testing.assert_allclose(shares[4], np.broadcast_to([0.0, 0.0, 1.0], (N, N, 3)), rtol=1e-6)
    assert not shares[5].any()


def test_no_cell_is_more_than_closed():
    position, normal, area = plane()
    twice = geometry.inject_surfels(*(np.concatenate([a, a]) for a in (position, normal, area)), GRID)
    np.testing.assert_allclose(twice, geometry.inject_surfels(position, normal, area, GRID), **ROUNDING)


def test_surfels_outside_the_grid_are_omitted():
    position = np.array(GRID.origin) + H * np.array([[-0.1, 3.0, 3.0], [3.0, N + 0.1, 3.0], [3.0, 3.0, 99.0]])
    assert not geometry.inject_surfels(position, np.eye(3), np.ones(3), GRID).any()


def test_buffers_that_see_the_same_wall_do_not_add_up():
    half = plane()
    other = tuple(a[: len(a) // 2] for a in half)
    volumes = [geometry.inject_surfels(*surfels, GRID) for surfels in (half, other)]
    np.testing.assert_array_equal(geometry.merge_buffers(volumes), volumes[0])


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("layer", [0, 5, 15])
def test_a_wall_stays_closed_on_every_level(axis, layer):
    for i, level in enumerate(wall_levels(axis, layer)):
        closed = np.moveaxis(level[..., axis], 2 - axis, 0)
        assert (closed[layer >> i] == 1.0).all()
        assert np.count_nonzero(level) == (N >> i) ** 2


def test_a_hole_stays_a_hole():
    """A quarter of the cells of a wall are open: on each coarser level a quarter of the section is."""
    finest = np.zeros((N, N, N, 3))
    finest[5, ..., 2] = 1.0
    finest[5, ::2, ::2] = 0.0
    for i, level in enumerate(geometry.geometry_levels(finest)[1:], 1):
        np.testing.assert_allclose(level[5 >> i, ..., 2], 0.75, **ROUNDING)


def test_two_layers_close_a_cell_once():
    finest = np.zeros((4, 4, 4, 3))
    finest[:2, ..., 2] = 1.0
    assert (geometry.geometry_levels(finest)[1][0, ..., 2] == 1.0).all()
