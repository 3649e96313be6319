"""Voxels of surfaces and their pyramids (simulator/voxels): areas, tessellations, filters, closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.grid import Grid
from octolux.simulator.voxels import pyramid
from octolux.simulator.voxels.fragments import SAMPLES, dominant_axis, fragments
from octolux.simulator.voxels.surfaces import DIRECTIONS, Voxels, around, voxelise

UNIT = Grid((0.0, 0.0, 0.0), 1.0, 32)


def square(low, e1, e2, parts: int = 1) -> np.ndarray:
    """Triangles of a parallelogram, parts^2 pairs: (2 parts^2, 3, 3)."""
    u, v = np.meshgrid(np.arange(parts), np.arange(parts))
    corner = np.stack([u.ravel(), v.ravel()], axis=-1)[:, None, :] + np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    points = np.asarray(low) + corner @ np.array([e1, e2], dtype=np.float64) / parts
    return points[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


def voxels_of(corners: np.ndarray, grid: Grid, double_sided: bool = False) -> Voxels:
    """Of white surfaces without emission."""
    found = fragments(corners, grid)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    white, count = np.ones((len(found.share), 3)), len(found.share)
    return voxelise(found, normals, grid.n, white, 0.0 * white, np.ones(count), np.full(count, double_sided))


def test_a_surface_has_its_projected_areas():
    """What faces each way adds up to the surface's area across it. Of a parallelogram of about 20 x 20 voxels samples
    along its edges are missed or too many: at most as many as a strip has that is 1 / SAMPLES voxels wide."""
    e1, e2 = np.array([18.0, 3.0, 5.0]), np.array([-4.0, 20.0, 2.0])
    facing = voxels_of(square((7.0, 4.0, 10.0), e1, e2), UNIT).facing.sum(axis=(0, 1, 2))
    area = np.cross(e1, e2)
    expected = np.maximum(DIRECTIONS @ area, 0.0)
    edges = 2 * (np.linalg.norm(e1) + np.linalg.norm(e2)) / SAMPLES
    np.testing.assert_allclose(facing, expected, atol=edges)
    assert np.all((facing > 0) == (expected > 0))


@pytest.mark.parametrize("normal", [(1.0, 0.2, 0.1), (1.0, 1.0, 0.3), (1.0, 1.0, 1.0), (-0.3, 0.9, 0.8)])
def test_a_tessellation_is_what_it_was(normal):
    """A wall and the same wall in 200 triangles, many smaller than a voxel: the same voxels with the same shares."""
    n = np.array(normal) / np.linalg.norm(normal)
    e1 = np.cross(n, (0.0, 0.37, 1.0))
    e1 *= 9.3 / np.linalg.norm(e1)
    e2 = np.cross(n, e1)
    low = np.array([16.2, 15.9, 15.7]) - (e1 + e2) / 2
    once, often = (voxels_of(square(low, e1, e2, parts), UNIT) for parts in (1, 10))
    np.testing.assert_array_equal(often.touched, once.touched)
    np.testing.assert_allclose(often.facing, once.facing, atol=1e-9)


@pytest.mark.parametrize("slope", [0.0, 0.3, 0.77, 1.0])
def test_a_wall_has_one_voxel_on_every_line(slope):
    """However it leans, each line along the axis nearest to its normal meets one voxel of it, and is stopped there."""
    wall = square((1.0, 1.0, 4.13), (30.0, 0.0, 30.0 * slope * 0.8), (0.0, 30.0, 0.0))
    facing = voxels_of(wall, UNIT).facing[:, 2:-2, 2:-2, 4]
    np.testing.assert_allclose(facing.max(axis=0), 1.0)
    np.testing.assert_array_equal((facing > 0).sum(axis=0), 1)


def test_walls_along_the_faces_of_voxels_do_not_fall_to_rounding():
    """A wall between two layers lies in the upper one, though its depths are off by rounding; and normals between two
    axes are taken along the first."""
    wall = square((1.0, 1.0, 5.0), (30.0, 0.0, 1e-6), (0.0, 30.0, -1e-6))
    assert set(fragments(wall, UNIT).voxel[:, 2]) == {5}
    tilted = np.array([[1.0, 1.0 + 1e-6, 0.2], [1.0, 1.0 - 1e-6, 0.2], [0.1, -1.0, 1.0], [0.0, 0.3, 0.5]])
    np.testing.assert_array_equal(dominant_axis(tilted), [0, 0, 1, 2])


def test_both_sides_of_a_double_sided_wall_face():
    wall = square((2.0, 2.0, 7.5), (20.0, 0.0, 0.0), (0.0, 20.0, 0.0))
    one, both = (voxels_of(wall, UNIT, double).facing[7, 10, 10] for double in (False, True))
    np.testing.assert_array_equal(one, [0, 0, 0, 0, 1, 0])
    np.testing.assert_array_equal(both, [0, 0, 0, 0, 1, 1])


@pytest.mark.parametrize(("gap", "back"), [(1.0, 0), (2.0, 1)])
def test_backs_that_nothing_can_see_do_not_count(gap, back):
    """Two double-sided walls back to back, without or with a voxel of air between them."""
    upper = square((2.0, 2.0, 9.5), (20.0, 0.0, 0.0), (0.0, 20.0, 0.0))
    lower = (upper - (0.0, 0.0, gap))[:, ::-1]
    facing = voxels_of(np.concatenate([upper, lower]), UNIT, True).facing[:, 10, 10]
    np.testing.assert_array_equal(facing[9], [0, 0, 0, 0, 1, back])
    np.testing.assert_array_equal(facing[9 - int(gap)], [0, 0, 0, 0, back, 1])


def test_means_are_weighted_by_area():
    """A wall of one colour before half a wall of another in the same voxels: 2 to 1."""
    walls = np.concatenate([
        square((4.0, 4.0, 7.3), (8.0, 0.0, 0.0), (0.0, 8.0, 0.0)),
        square((4.0, 4.0, 7.6), (8.0, 0.0, 0.0), (0.0, 8.0, 0.0)),
    ])  # fmt: skip
    found = fragments(walls, UNIT)
    first = (found.triangle < 2)[:, None]
    normals = np.tile((0.0, 0.0, 1.0), (4, 1))
    made = voxelise(found, normals, 32, np.where(first, (0.9, 0.6, 0.0), 0.3), np.where(first, 12.0, (0.0, 3.0, 6.0)),
                    np.where(first[:, 0], 1.0, 0.5), np.zeros(len(first), bool))  # fmt: skip
    np.testing.assert_allclose(made.albedo[7, 6, 6], (0.7, 0.5, 0.1))
    np.testing.assert_allclose(made.emission[7, 6, 6], (8.0, 9.0, 10.0))
    assert made.facing[7, 6, 6, 4] == 1.0  # a voxel's section is covered once at most


def test_the_cube_around_a_box():
    """Faces of the box that are lowest, and the highest of its longest edge, lie in the middle of the second layer."""
    grid = around((-1.0, 2.0, 0.5), (3.0, 3.0, 1.0), 6)
    np.testing.assert_allclose(grid.to_cells([(-1.0, 2.0, 0.5)]), 1.5)
    np.testing.assert_allclose(grid.to_cells([(3.0, 2.0, 0.5)])[0, 0], grid.n - 1.5)
    for low, high, depth in (((0, 0, 0), (0, 0, 0), 6), ((0, 0, 0), (1, 1, 1), 1)):
        with pytest.raises(ValueError, match="depth of 2 or more around a box"):
            around(low, high, depth)


def test_bad_triangles_are_refused():
    for bad in (np.full((1, 3, 3), np.nan), np.zeros((1, 4, 3))):
        with pytest.raises(ValueError, match="triangles are finite numbers"):
            fragments(bad, UNIT)
    assert len(fragments(np.zeros((1, 3, 3)), UNIT).share) == 0  # a point covers nothing


def test_the_next_level_is_the_maximum_along_then_the_mean():
    """Worked out by hand for one voxel of the next level (VCT figure 5.13)."""
    facing = np.zeros((2, 2, 2, 6))
    facing[0, :, :, 4] = [[1.0, 0.5], [0.0, 0.25]]  # what looks along +z in the lower layer
    facing[1, :, :, 4] = [[0.5, 0.75], [0.0, 0.0]]
    assert pyramid.coarser_facing(facing)[0, 0, 0, 4] == (1.0 + 0.75 + 0.0 + 0.25) / 4
    facing = np.zeros((2, 2, 2, 6))
    facing[1, 0, :, 1] = [0.5, 1.0]  # along -x
    assert pyramid.coarser_facing(facing)[0, 0, 0, 1] == 0.25


def test_walls_stay_closed_on_all_levels():
    """Each line through a flat wall is stopped by its coarse voxels as by its fine ones."""
    levels = pyramid.facing_levels(voxels_of(square((0, 0, 9.5), (32.0, 0, 0), (0, 32.0, 0)), UNIT).facing)
    assert [len(level) for level in levels] == [32, 16, 8, 4, 2]
    for level in levels:
        np.testing.assert_allclose(level[..., 4].max(axis=0), 1.0)
        assert not level[..., 5].any()


def test_what_shines_evenly_shines_as_evenly_from_every_level():
    rng = np.random.default_rng(4)
    facings = pyramid.facing_levels(rng.uniform(size=(16, 16, 16, 6)) * (rng.uniform(size=(16, 16, 16, 1)) < 0.3))
    light = np.array([3.0, 0.5])
    for facing, made in zip(facings, pyramid.intensity_levels(facings[0][..., None] * light, facings), strict=True):
        np.testing.assert_allclose(made, facing[..., None] * light)


def test_what_is_hidden_does_not_shine():
    """Of two full voxels the one in front is seen, each way."""
    facing = np.ones((2, 2, 2, 6))
    light = np.zeros((2, 2, 2, 6, 1))
    light[:, :, 1] = 5.0  # the half at +x
    made = pyramid.coarser_intensity(light, facing)[0, 0, 0, :, 0]
    np.testing.assert_allclose(made, [5.0, 0.0, 2.5, 2.5, 2.5, 2.5])


def test_sampling():
    """Linear functions come back between the middles of voxels; the outermost hold up to the border."""
    z, y, x = np.indices((8, 8, 8)) + 0.5
    level = np.stack([x, y + 2 * z], axis=-1)
    points = np.random.default_rng(5).uniform(0.5, 7.5, (100, 3))
    np.testing.assert_allclose(
        pyramid.sample(level, points), np.stack([points[:, 0], points[:, 1] + 2 * points[:, 2]], axis=-1)
    )
    edge = pyramid.sample(level, [(0.1, 4.0, 4.0), (7.9, 4.0, 4.0), (-0.1, 4.0, 4.0), (4.0, 8.1, 4.0)])[:, 0]
    np.testing.assert_allclose(edge, [0.5, 7.5, 0.0, 0.0])


def test_between_levels():
    levels = [np.full((8, 8, 8), 1.0), np.full((4, 4, 4), 3.0), np.full((2, 2, 2), 7.0)]
    found = pyramid.sample_levels(levels, np.full((5, 3), 4.0), [-1.0, 0.0, 0.25, 1.5, 9.0])
    np.testing.assert_allclose(found, [1.0, 1.0, 1.5, 5.0, 7.0])
