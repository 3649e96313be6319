"""The grid: which cell a point belongs to, and the default volume of a scene."""

import numpy as np
import pytest

from octolux.simulator.grid import Grid


def test_point_on_a_face_belongs_to_the_upper_cell():
    grid = Grid((-1.0, 0.0, 2.0), 0.25, 8)
    cells = grid.cell_of([[-1.0, 0.0, 2.0], [-0.75, 0.25, 2.5], [-0.7500001, 0.2499999, 2.4999999]])
    np.testing.assert_array_equal(cells, [[0, 0, 0], [1, 1, 2], [0, 0, 1]])


def test_inside_excludes_the_upper_border():
    grid = Grid((0.0, 0.0, 0.0), 0.5, 4)
    points = np.array([[0.0, 0, 0], [1.999, 1.999, 1.999], [2.0, 1, 1], [1, -1e-9, 1]])
    np.testing.assert_array_equal(grid.inside(points), [True, True, False, False])


def test_cell_centres_are_indexed_z_y_x():
    grid = Grid((1.0, 2.0, 3.0), 0.5, 4)
    np.testing.assert_allclose(grid.cell_centres()[3, 2, 1], [1.75, 3.25, 4.75])
    x, y, z = np.moveaxis(grid.cell_of(grid.cell_centres()), -1, 0)
    np.testing.assert_array_equal([z, y, x], np.indices((4, 4, 4)))


def test_around_is_the_bounding_cube_plus_one_cell():
    low, high = np.array([-1.0, 0.0, 2.0]), np.array([5.0, 3.0, 4.0])
    grid = Grid.around(low, high, 32)
    assert grid.cell_size == pytest.approx(6.0 / 30)
    margin_low, margin_high = grid.to_cells(low), 32 - grid.to_cells(high)
    np.testing.assert_allclose(margin_low, margin_high)
    assert margin_low[0] == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Grid((0, 0, 0), 0.0, 4), "cell size"),
        (lambda: Grid((0, 0, float("nan")), 1.0, 4), "finite"),
        (lambda: Grid((0, 0, 0), 1.0, 0), "at least one cell"),
        (lambda: Grid.around([0, 0, 0], [1, 1, 1], 2), "n >= 3"),
        (lambda: Grid.around([1, 1, 1], [1, 1, 1], 8), "no extent"),
    ],
)
def test_bad_grids_are_refused(make, message):
    with pytest.raises(ValueError, match=message):
        make()
