"""Light through the leaves of an octree (simulator/lpv/sparse.py): the tree, flux across level borders, reading."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.lpv import octree, propagation, sparse, transfer

CONSERVING = [(e, r) for e in ("signed", "dominant_lobe") for r in propagation.REPROJECTIONS]
# float64: fewer than 1e4 terms of one sign are added up, each rounded by 1e-16 of the sum.
ROUNDING = 1e-12


def some_lit(n: int, seed: int, share: float = 0.01) -> np.ndarray:
    return np.random.default_rng(seed).random((n, n, n)) < share


def lobes_in(lit: np.ndarray, seed: int = 0) -> np.ndarray:
    """Cosine lobes of random strength and direction in the lit cells: [z][y][x][rgb][4]."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(*lit.shape, 3, 3))
    directions /= np.linalg.norm(directions, axis=-1, keepdims=True)
    strength = rng.uniform(0.5, 2.0, (*lit.shape, 3, 1)) * lit[..., None, None]
    return strength * sh.cosine_lobe(directions)


def level_of_each(tree: sparse.Tree) -> np.ndarray:
    """The level of the leaf that holds each cell of level 0."""
    n = tree.split[0].shape[0]
    return np.sum([i * octree.upsample(leaf, n) for i, leaf in enumerate(tree.leaves)], axis=0)


@pytest.mark.parametrize("share", [0.0, 0.0003, 0.01, 0.3, 1.0])
def test_leaves_tile_the_volume(share):
    tree = sparse.build_tree(some_lit(32, 1, share))
    covered = np.sum([octree.upsample(leaf, 32).astype(int) for leaf in tree.leaves], axis=0)
    np.testing.assert_array_equal(covered, 1)


@pytest.mark.parametrize("margin", [1, 2])
@pytest.mark.parametrize("share", [0.0003, 0.003, 0.03])
def test_leaves_that_touch_differ_by_one_level_at_most(share, margin):
    """Also across edges and corners, which the filter relies on; and lit cells lie among cells of level 0."""
    lit = some_lit(32, 2, share)
    level = level_of_each(sparse.build_tree(lit, margin))
    around = np.pad(level, 1, mode="edge")
    for z, y, x in np.ndindex(3, 3, 3):
        beside = around[z : z + 32, y : y + 32, x : x + 32]
        assert np.abs(beside - level).max() <= 1
        assert not beside[lit].any()


def test_the_tree_grows_alike_on_all_sides():
    """OLPV 7.1: lit cells about the centre, which the index volume would surround by eight different quarters."""
    lit = np.zeros((32, 32, 32), dtype=bool)
    lit[15:17, 15:17, 15:17] = True
    level = level_of_each(sparse.build_tree(lit))
    for axis in range(3):
        np.testing.assert_array_equal(level, np.flip(level, axis))
    np.testing.assert_array_equal(level, level.transpose(1, 2, 0))
    # By hand, from the middle: lit up to 1, so level 0 up to 1 + margin; each level then ends `margin` of its cells
    # farther out, at the next border of a larger cell.
    np.testing.assert_array_equal(level[16, 16, 16:], [0] * 2 + [1] * 2 + [2] * 4 + [3] * 8)
    wider = level_of_each(sparse.build_tree(lit, margin=2))
    np.testing.assert_array_equal(wider[16, 16, 16:], [0] * 4 + [1] * 4 + [2] * 8)


def test_without_light_only_the_root_is_split():
    tree = sparse.build_tree(np.zeros((16, 16, 16), dtype=bool))
    assert [int(leaf.sum()) for leaf in tree.leaves] == [0, 0, 0, 8, 0]


@pytest.mark.parametrize("shape", [(1, 1, 1), (12, 12, 12), (8, 8, 4)])
def test_volumes_that_are_no_octree_are_refused(shape):
    with pytest.raises(ValueError, match=r"at least 2 cells|power of two"):
        sparse.build_tree(np.ones(shape, dtype=bool))


@pytest.mark.parametrize(("evaluation", "reprojection"), CONSERVING)
def test_where_all_is_lit_it_is_the_uniform_volume(evaluation, reprojection):
    lit = np.ones((8, 8, 8), dtype=bool)
    light, tree = lobes_in(lit), sparse.build_tree(lit)
    found = sparse.propagate(tree, light, 5, 1.0, evaluation, reprojection)
    np.testing.assert_allclose(found[0], propagation.propagate(light, 5, 1.0, evaluation, reprojection), rtol=ROUNDING,
                               atol=ROUNDING)  # fmt: skip
    np.testing.assert_allclose(sparse.merge(tree, found), found[0], rtol=ROUNDING, atol=ROUNDING)


def outwards(tree: sparse.Tree, cells: list[np.ndarray], evaluation: str) -> np.ndarray:
    """Flux that the next step sends out of the volume, (3,)."""
    lost = np.zeros(3)
    for level in cells:
        sent = propagation.face_flux(level, evaluation).sum(axis=-1)
        for travel, direction in enumerate(transfer.DIRECTIONS):
            axis = 2 - int(np.argmax(np.abs(direction)))
            side = np.take(sent[..., travel], -1 if direction.sum() > 0 else 0, axis=axis)
            lost += side.sum(axis=(0, 1))
    return lost


@pytest.mark.parametrize(("evaluation", "reprojection"), CONSERVING)
def test_flux_is_kept_across_levels(evaluation, reprojection):
    """After every step: what was there, less what went out through the border; four levels deep, for 12 steps."""
    lit = some_lit(16, 3, 0.003)
    tree = sparse.build_tree(lit)
    assert sum(leaf.any() for leaf in tree.leaves) >= 3
    cells = sparse.inject(tree, lobes_in(lit))
    for _ in range(12):
        expected = sparse.total_flux(cells) - outwards(tree, cells, evaluation)
        cells = sparse.step(tree, cells, 1.0, evaluation, reprojection)
        np.testing.assert_allclose(sparse.total_flux(cells), expected, rtol=ROUNDING)


@pytest.mark.parametrize(("evaluation", "reprojection"), CONSERVING)
def test_all_flux_stays_until_light_meets_the_border(evaluation, reprojection):
    """From the centre of 32^3 light crosses from level 0 to level 3 and is all there before it meets the border."""
    lit = np.zeros((32, 32, 32), dtype=bool)
    lit[16, 16, 16] = True
    light, tree = lobes_in(lit), sparse.build_tree(lit)
    cells, before, steps = sparse.inject(tree, light), propagation.total_flux(light), 0
    while not outwards(tree, cells, evaluation).any():
        cells = sparse.step(tree, cells, 1.0, evaluation, reprojection)
        np.testing.assert_allclose(sparse.total_flux(cells), before, rtol=ROUNDING)
        steps += 1
    assert steps >= 3 and cells[3].any()


def test_light_in_an_unlit_leaf_is_its_childrens_sum():
    """Light below the threshold is not lost: the coarse leaf that covers it has it."""
    light, tree = lobes_in(some_lit(16, 4)), sparse.build_tree(some_lit(16, 5, 0.002))
    held = sparse.inject(tree, light)
    assert sum(level.any() for level in held) >= 2
    np.testing.assert_allclose(sparse.total_flux(held), propagation.total_flux(light), rtol=ROUNDING)


def test_entry_shares_are_what_rays_from_the_middle_pass():
    """The share of each child's quarter of the entered side, by rays to a face's points, even in solid angle's weight:
    both halves of a face mirror each other, so any symmetric weight gives the same."""
    grid = (np.arange(64) + 0.5) / 64 - 0.5
    u, v = np.meshgrid(grid, grid)
    for travel, face in np.ndindex(6, 5):
        normal, centre = transfer.NORMALS[travel, face], transfer.FACE_CENTRES[travel, face]
        first, second = np.eye(3)[[a for a in range(3) if normal[a] == 0.0]]
        points = centre + u[..., None] * first + v[..., None] * second
        weight = (points @ normal) / np.linalg.norm(points, axis=-1) ** 3
        forward = transfer.DIRECTIONS[travel]
        crossed = points * (0.5 / (points @ forward))[..., None]  # where the ray passes the side between the two cells
        shares = np.zeros((2, 2, 2))
        for corner in np.ndindex(2, 2, 2):
            at = 2 * np.array(corner[::-1]) - 1
            across = forward == 0
            if at @ forward < 0:
                inside = (np.sign(crossed[..., across]) == at[across]).all(axis=-1)
                shares[corner] = weight[inside].sum() / weight.sum()
        np.testing.assert_allclose(sparse.ENTRY_SHARES[travel][..., face], shares, atol=ROUNDING)


def test_light_into_finer_leaves_by_hand():
    """A coarse leaf shines straight along +x at a split cell: its far face's flux is quartered, its sides' halved."""
    lit = np.zeros((8, 8, 8), dtype=bool)
    lit[4, 4, 6] = True
    tree = sparse.build_tree(lit)
    source, target = (2, 2, 1), (2, 2, 2)
    assert tree.leaves[1][source] and tree.split[1][target]
    cells = [np.zeros((n, n, n, 3, 4)) for n in (8, 4, 2, 1)]
    cells[1][source] = sh.cosine_lobe(np.array([0.8, 0.6, 0.0]))
    after = sparse.step(tree, cells, 1.0, "dominant_lobe", "travel")
    sent = propagation.face_flux(cells[1][source], "dominant_lobe")[0, 0]  # along +x: far, +y, -y, +z, -z
    block = sh.flux(after[0][4:6, 4:6, 4:6, 0])
    for z, y in np.ndindex(2, 2):
        sides = 0.5 * (sent[1 + (y == 0)] + sent[3 + (z == 0)])
        np.testing.assert_allclose(block[z, y, 0], 0.25 * sent[0] + sides, rtol=ROUNDING)
    np.testing.assert_allclose(block.sum(), sent.sum(), rtol=ROUNDING)
    assert not block[:, :, 1].any()


def test_even_light_is_read_as_even():
    """Leaves of level i with 4^i times the intensity are the same irradiance everywhere, filtered or not."""
    tree = sparse.build_tree(some_lit(32, 6, 0.0005))
    even = [leaf[..., None, None] * np.full((3, 4), 4.0**i) for i, leaf in enumerate(tree.leaves)]
    np.testing.assert_allclose(sparse.merge(tree, even), 1.0, rtol=ROUNDING)


def test_a_slope_is_read_as_a_slope_between_leaves_of_one_level():
    """No lit cell: eight leaves. Between their middles light is linear, and beyond them as at the border."""
    tree = sparse.build_tree(np.zeros((16, 16, 16), dtype=bool))
    cells = [np.zeros((n, n, n, 3, 4)) for n in (16, 8, 4, 2, 1)]
    cells[3][:, :, 1] = 64.0  # intensity 4^3 counts 1
    across = np.clip((np.arange(16) + 0.5 - 4.0) / 8.0, 0.0, 1.0)
    np.testing.assert_allclose(sparse.merge(tree, cells)[5, 9, :, 2, 0], across, atol=ROUNDING)


def test_no_margin_is_refused():
    with pytest.raises(ValueError, match="at least one cell"):
        sparse.build_tree(np.zeros((4, 4, 4), dtype=bool), margin=0)


def test_a_negative_number_of_steps_is_refused():
    tree = sparse.build_tree(np.zeros((4, 4, 4), dtype=bool))
    with pytest.raises(ValueError, match="cannot be negative"):
        sparse.propagate(tree, np.zeros((4, 4, 4, 3, 4)), -1)
