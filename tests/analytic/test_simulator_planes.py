"""Where the geometry volume's surfaces lie in its cells (simulator/lpv/geometry.py). Ways: test_simulator_cones.py."""

from __future__ import annotations

import numpy as np
import pytest
from test_simulator_geometry import GRID, ROUNDING, H, N, plane

from octolux.simulator.lpv import geometry
from octolux.simulator.lpv.geometry import BEHIND
from octolux.simulator.lpv.strips import Planes

PLACE = 1.0 / 64  # of a cell: what packing moves a plane by, at most


def wall(axis: int, place: float, share: float = 1.0, n: int = N) -> list[Planes]:
    """All levels of a volume whose only surface is a wall across `axis` (0 is x), at `place` in cells."""
    shares, offsets = np.zeros((n, n, n, 3)), np.full((n, n, n, 3), place % 1.0)
    np.moveaxis(shares, 2 - axis, 0)[int(place), ..., axis] = share
    return geometry.plane_levels(Planes.sheets(shares, offsets))


def test_planes_lie_where_surfels_do():
    flat = geometry.inject_planes(*plane(), GRID)
    np.testing.assert_array_equal(flat.shares, geometry.inject_surfels(*plane(), GRID))
    np.testing.assert_allclose(flat.offsets[5, ..., 2], 0.3 - BEHIND, **ROUNDING)


def test_planes_of_a_slanted_wall_are_at_its_mean():
    """z = 5.1 + x / 4 (cells) is in its columns' middles at 5.1 + (x + 1/2) / 4, in one cell for x from 0 to 2. Across
    x it lies in the middle of the cells that it crosses whole. Both but for how far it is moved behind."""
    planes = geometry.inject_planes(*plane(0.25, 5.1), GRID)
    behind = BEHIND * np.array([-0.25, 0.0, 1.0]) / np.sqrt(1.0 + 0.25**2)
    for x in (1, 2):
        middle = 0.1 + 0.25 * (x + 0.5) - behind[2]
        np.testing.assert_allclose(planes.offsets[5, 4, x, 2], middle, atol=0.25 / 8 * BEHIND)
        np.testing.assert_allclose(planes.offsets[5, 4, x, 0], 0.5 - behind[0], atol=BEHIND)


def test_surfels_count_by_their_shares():
    """Three quarters of a wall at 0.2 and a quarter at 0.6; two whole ones are as closed as one, in their middle."""
    normal = np.tile([0.0, 1.0, 0.0], (2, 1))
    for areas, share, mean in (((0.75, 0.25), 1.0, 0.3), ((0.3, 0.1), 0.4, 0.3), ((1.0, 1.0), 1.0, 0.4)):
        places = GRID.origin + H * np.array([[3.5, 4.2, 5.5], [3.5, 4.6, 5.5]])
        planes = geometry.inject_planes(places, normal, H * H * np.array(areas), GRID)
        np.testing.assert_allclose(planes.shares[5, 4, 3], [0.0, share, 0.0], **ROUNDING)
        np.testing.assert_allclose(planes.offsets[5, 4, 3, 1], mean - BEHIND, **ROUNDING)


def box(low, size) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Surfels of a closed box, 8 x 8 on each side, whose normals point outwards. low, size: (3,), in cells."""
    steps = (np.arange(8) + 0.5) / 8
    positions, normals, areas = [], [], []
    for axis in range(3):
        a, b = np.meshgrid(steps, steps)
        for side in (0.0, 1.0):
            unit = np.insert(np.stack([a.ravel(), b.ravel()], axis=-1), axis, side, axis=-1)
            positions.append(GRID.origin + H * (np.array(low) + unit * size))
            normals.append(np.broadcast_to((2.0 * side - 1.0) * np.eye(3)[axis], (64, 3)))
            areas.append(np.full(64, np.delete(size, axis).prod() * H * H / 64))
    return np.concatenate(positions), np.concatenate(normals), np.concatenate(areas)


def test_a_box_smaller_than_a_cell_blocks_its_projected_area_once():
    """Along each axis, on each coarser level a quarter of that, from its middle: its sides lie as far behind their
    surfaces each way. Nothing else is blocked."""
    low, size = np.array([5.2, 10.3, 7.1]), np.array([0.2, 0.5, 0.7])
    for i, level in enumerate(geometry.plane_levels(geometry.inject_planes(*box(low, size), GRID))):
        x, y, z = (low / 2**i).astype(int)
        once = size.prod() / size / 4**i
        for found in (level.shares, level.fronts, level.backs):
            np.testing.assert_allclose(found[z, y, x], once, **ROUNDING)
            assert np.count_nonzero(found) == 3
        np.testing.assert_allclose(level.offsets[z, y, x], (low + size / 2) / 2**i % 1.0, **ROUNDING)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_box_cut_by_a_face_between_cells_blocks_once_where_a_cell_holds_all_of_it(axis):
    """Of cells 6 and 7 one has its back and the other its front; their parent has both."""
    low, size = np.full(3, 4.2), np.full(3, 0.5)
    low[axis] = 6.8
    levels = geometry.plane_levels(geometry.inject_planes(*box(low, size), GRID))
    cells = [tuple(np.where(np.arange(3) == axis, layer, 4))[::-1] for layer in (6, 7)]
    found = [(levels[0].fronts[c][axis], levels[0].backs[c][axis]) for c in cells]
    np.testing.assert_allclose(found, [(0.0, 0.25), (0.25, 0.0)], **ROUNDING)
    for i, level in enumerate(levels[1:], 1):
        x, y, z = (low / 2**i).astype(int)
        np.testing.assert_allclose(level.shares[z, y, x], 0.25 / 4**i, **ROUNDING)
        np.testing.assert_allclose(level.offsets[z, y, x], (low + size / 2) / 2**i % 1.0, **ROUNDING)


@pytest.mark.parametrize("share", [1.0, 0.5])
@pytest.mark.parametrize("faces", [(1,), (-1,), (1, -1)], ids=["front", "back", "both"])
def test_a_wall_of_one_face_or_two_blocks_once(faces, share):
    """All, or where half of it is there, half; on every level, in the middle of its faces. A face at 5.3 or 5.5."""
    position, normal, area = plane()
    made = [(position - (0.0, 0.0, 0.0 if s > 0 else -0.2 * H), s * normal, share * area) for s in faces]
    surfels = (np.concatenate(a) for a in zip(*made, strict=True))
    middle = np.mean([{1: 5.3 - BEHIND, -1: 5.5 + BEHIND}[s] for s in faces])
    for i, level in enumerate(geometry.plane_levels(geometry.inject_planes(*surfels, GRID))):
        layer = 5 >> i
        expected = np.zeros_like(level.shares)
        expected[layer, ..., 2] = share
        np.testing.assert_allclose(level.shares, expected, **ROUNDING)
        np.testing.assert_allclose(level.offsets[layer, ..., 2], middle / 2**i % 1.0, **ROUNDING)


def test_the_buffer_with_the_most_says_where():
    """Along each axis by itself, and of equals the first."""
    numbers = (0.5, 0.1), (0.7, 0.2), (0.7, 0.3)
    made = [Planes.sheets(np.full((2, 2, 2, 3), s), np.full((2, 2, 2, 3), o)) for s, o in numbers]
    made[0].fronts[1, 0, 0, 2] = 0.8
    merged = geometry.merge_planes(made)
    expected = np.full((2, 2, 2, 3), 0.2)
    expected[1, 0, 0, 2] = 0.1
    np.testing.assert_array_equal(merged.offsets, expected)
    np.testing.assert_array_equal(merged.shares, geometry.merge_buffers([m.shares for m in made]))


def test_buffers_that_see_one_side_each_are_merged_by_sides():
    """What one sees of the front, and another of the back, at 0.2 and 0.9: both are kept, so that coarser cells have
    both, and the larger says where."""
    front, back = (np.zeros((2, 2, 2, 3)) for _ in range(2))
    front[0, 0, 0, 0], back[0, 0, 0, 0] = 0.5, 0.75
    sides = (front, 0.0 * back, 0.2), (0.0 * front, back, 0.9)
    made = [Planes(f, b, *np.full((3, *f.shape), place)) for f, b, place in sides]
    for buffers in (made, made[::-1]):
        merged = geometry.merge_planes(buffers)
        assert np.array_equal(merged.fronts, front) and np.array_equal(merged.backs, back)
        assert merged.shares[0, 0, 0, 0] == 0.75 and merged.offsets[0, 0, 0, 0] == 0.9
        coarser = geometry.plane_levels(merged)[1]
        assert coarser.fronts[0, 0, 0, 0] == 0.125 and coarser.shares[0, 0, 0, 0] == 0.1875


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_wall_stays_where_it_is_on_every_level(axis):
    for place in (0.3, 5.75, 10.0, 15.99):
        for i, level in enumerate(wall(axis, place)):
            at = np.moveaxis(level.offsets[..., axis], 2 - axis, 0)[int(place) >> i]
            np.testing.assert_allclose(at, place / 2**i % 1.0, **ROUNDING)
            assert np.array_equal(level.shares, geometry.geometry_levels(wall(axis, place)[0].shares)[i])


def test_two_walls_in_a_coarser_cell_are_one_between():
    """By their shares: a whole one at 2.5 and a half one at 3.1 are a whole one at 2.7 of four, 0.35 of the cell."""
    one, half = wall(0, 2.5)[0], wall(0, 3.1, 0.5)[0]
    both = Planes.sheets(one.shares + half.shares, np.where(half.shares > 0.0, half.offsets, one.offsets))
    level = geometry.plane_levels(both)[1]
    np.testing.assert_allclose(level.offsets[:, :, 1, 0], 0.35, **ROUNDING)
    assert (level.shares[:, :, 1, 0] == 1.0).all()


def test_middles_lie_where_surfels_do():
    """Three quarters of what faces along y at (0.3, 0.2) of (z, x), a quarter at (0.7, 0.4)."""
    normal, places = np.tile([0.0, 1.0, 0.0], (2, 1)), np.array([[3.2, 4.5, 5.3], [3.4, 4.5, 5.7]])
    planes = geometry.inject_planes(GRID.origin + H * places, normal, H * H * np.array([0.6, 0.2]), GRID)
    np.testing.assert_allclose(planes.nexts[5, 4, 3, 1], 0.4, **ROUNDING)  # along z
    np.testing.assert_allclose(planes.lasts[5, 4, 3, 1], 0.25, **ROUNDING)  # along x
    coarser = geometry.plane_levels(planes)[1]
    np.testing.assert_allclose(coarser.nexts[2, 2, 1, 1], 0.5 + 0.2, **ROUNDING)
    np.testing.assert_allclose(coarser.lasts[2, 2, 1, 1], 0.5 + 0.125, **ROUNDING)
