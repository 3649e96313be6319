"""Steps through the leaves of an octree (sparse_*.wgsl) against the simulator's (simulator/lpv/sparse.py)."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from gpu_tools import largest_cell_error
from test_octree_merge import HALF_FLOAT, N, read_volume
from test_propagation import BOUNDS, SCHEMES, random_light

from octolux.gpu.profiler import Profiler
from octolux.simulator.lpv import octree, propagation, sparse
from octolux.techniques.lpv.octree.settings import OctreeLpvSettings
from octolux.techniques.lpv.octree.sparse import SparseStepping
from octolux.techniques.settings import SettingsError


@cache
def kernel(device, **changes) -> SparseStepping:
    return SparseStepping(device, OctreeLpvSettings.make("sparse", **{"n": N, **changes}))


def lit_light(share: float, seed: int = 0) -> np.ndarray:
    """Float32 [z][y][x][rgb][4] with light in that share of the cells."""
    lit = np.random.default_rng(seed).random((N, N, N)) < share
    return random_light(N, seed) * lit[..., None, None].astype(np.float32)


def run(device, made: SparseStepping, light: np.ndarray) -> list[np.ndarray]:
    """The leaves' accumulated light, in W/sr, one array for each level."""
    peak = np.array([light[..., 0].max()], np.float32)
    levels = np.concatenate([level.astype(np.float32).ravel() for level in octree.build_levels(light)])
    profiler = Profiler(device, "off")
    with profiler.frame():
        made.run(profiler, device.buffer("injected", levels), device.buffer("peak", peak))
    return made.accumulated(peak[0])


def tree_of(light: np.ndarray, margin: int = 1) -> sparse.Tree:
    return sparse.build_tree(light[..., 0].max(axis=-1) > 0.0, margin)


@pytest.mark.parametrize("share", [0.0, 0.0003, 0.003, 0.05, 1.0])
@pytest.mark.parametrize("margin", [1, 2, 3])
def test_the_tree_is_the_simulators(device, margin, share):
    light, made = lit_light(share, seed=2), kernel(device, margin=margin)
    run(device, made, light)
    expected = tree_of(light, margin)
    assert made.tree.leaves == sum(int(leaf.sum()) for leaf in expected.leaves)
    levels, places = made.tree.places()
    for level, present in enumerate(expected.present[:-1]):
        found = np.zeros_like(present)
        x, y, z = places[levels == level].T
        found[z, y, x] = True
        np.testing.assert_array_equal(found, present)


@pytest.mark.parametrize(("evaluation", "reprojection"), SCHEMES)
@pytest.mark.parametrize("iterations", [1, 6])
def test_every_scheme(device, evaluation, reprojection, iterations):
    """All leaves hold light from the start, so that every kind of level border is crossed in every direction: most
    cells have at most 0.2, which is below the threshold, 0.3 of the power of two below the peak."""
    bright = lit_light(0.002, seed=iterations)
    light = np.where(bright[..., :1] > 0.0, bright, 0.1 * random_light(N, seed=iterations)).astype(np.float32)
    assert 1.0 <= light[..., 0].max() < 2.0
    made = kernel(device, evaluation=evaluation, reprojection=reprojection, iterations=iterations, threshold=0.3)
    tree = sparse.build_tree(light[..., 0].max(axis=-1) > 0.3)
    assert sum(leaf.any() for leaf in tree.leaves) >= 3
    expected = sparse.propagate(tree, light, iterations, 1.0, evaluation, reprojection)
    for found, right in zip(run(device, made, light), expected, strict=True):
        assert largest_cell_error(found, right) <= BOUNDS["f32"]


def test_half_float_cells(device):
    """A half float is off by 2^-11 of itself, or, below 2^-14, by 2^-25: as the peak is at least 8, by 2^-28 of it. A
    cell adds to its light, 0.28 of the flux, less than that for each of at most 24 leaves in 6 steps: below 1e-6."""
    light = lit_light(0.003, seed=6)
    made = kernel(device, cell_format="f16", iterations=6)
    expected = sparse.propagate(tree_of(light), light, 6, 1.0, "dominant_lobe", "travel")
    for found, right in zip(run(device, made, light), expected, strict=True):
        bound = BOUNDS["f16"] * np.abs(right).max(axis=(-2, -1), keepdims=True) + 1e-6 * light.max()
        assert (np.abs(found - right) <= bound).all()


def test_where_all_is_lit_it_is_the_uniform_volume(device):
    light = lit_light(1.0, seed=3)
    expected = propagation.propagate(light, 4, 1.0, "dominant_lobe", "travel")
    assert largest_cell_error(run(device, kernel(device, iterations=4), light)[0], expected) <= BOUNDS["f32"]


def test_the_volumes_are_the_merged_leaves(device):
    light, made = lit_light(0.001, seed=4), kernel(device, iterations=6)
    run(device, made, light)
    found = np.stack([read_volume(device, texture) for texture in made.lookup.volumes.values()], axis=3)
    tree, scale = tree_of(light), 2.0 ** (3 - np.floor(np.log2(light[..., 0].max())))
    expected = scale * sparse.merge(tree, sparse.propagate(tree, light, 6, 1.0, "dominant_lobe", "travel"))
    # Each number is stored as a half float, of at least 2^-24; the light itself is right within BOUNDS.
    peaks = np.abs(expected).max(axis=(-2, -1), keepdims=True)
    assert (np.abs(found - expected) <= BOUNDS["f32"] * peaks + HALF_FLOAT * np.abs(expected) + 2.0**-24).all()


@pytest.mark.parametrize("evaluation", ["signed", "dominant_lobe"])
def test_flux_crosses_levels_whole(device, evaluation):
    """From the centre light reaches leaves of level 2 in three steps, before any leaves: S_0 to S_3 have the same flux.

    Float32: a leaf's number is a sum of up to 30 * 24 products, and the last of four such sums: 3000 roundings of 6e-8
    would be 2e-4 if all went one way.
    """
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[8, 8, 8] = random_light(2)[0, 0, 0]
    found = run(device, kernel(device, evaluation=evaluation, iterations=3), light)
    assert found[2].any()
    np.testing.assert_allclose(sparse.total_flux(found), 4.0 * propagation.total_flux(light), rtol=2e-4)


def test_light_never_lacks_room(device):
    """Few leaves first: what holds their light is small; then more of them than there was room for, in one frame."""
    made, few, many = SparseStepping(device, OctreeLpvSettings.make("sparse", n=N)), lit_light(0.0), lit_light(0.05)
    few[3, 3, 3] = random_light(2)[0, 0, 0]
    run(device, made, few)
    small = made.light.size
    assert made.room < N**3 / 7 / 4
    right = [run(device, kernel(device), light) for light in (many, few)]
    for light, expected in zip((many, few), right, strict=True):
        for found, level in zip(run(device, made, light), expected, strict=True):
            np.testing.assert_array_equal(found, level)
    assert small < made.light.size
    assert made.tree.bricks <= made.room <= (N**3 - 1) // 7


def test_every_run_has_the_same_bits(device):
    """Bricks may be numbered in another order; nothing else may change."""
    light = lit_light(0.003, seed=8)
    first, *others = ([level.tobytes() for level in run(device, kernel(device), light)] for _ in range(5))
    assert all(other == first for other in others)


def test_dark_in_dark_out(device):
    run(device, kernel(device), lit_light(0.1))  # whatever was there before must not stay
    assert not any(level.any() for level in run(device, kernel(device), lit_light(0.0)))
    assert not any(read_volume(device, texture).any() for texture in kernel(device).lookup.volumes.values())


def test_light_below_the_threshold_stays_in_a_coarse_leaf(device):
    """One cell of 1/1000 of the peak, with a threshold of 1/100: no leaf of level 0, and none of its flux is lost."""
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[2, 2, 2], light[13, 13, 13] = 1.0, 1e-3
    found = run(device, kernel(device, threshold=0.01, iterations=0), light)
    assert found[0][2, 2, 2].all() and not found[0][13, 13, 13].any()
    # One product more and one less by the storage's power of two: exact, but for the sum.
    np.testing.assert_allclose(sparse.total_flux(found), propagation.total_flux(light), rtol=1e-6)


@pytest.mark.parametrize(("changes", "message"), [
    ({"occlusion": True}, "occlusion=false"), ({"combine": "average"}, "combine=sum"), ({"margin": 0}, "margin"),
])  # fmt: skip
def test_settings_that_do_not_go_together_are_refused(changes, message):
    with pytest.raises(SettingsError, match=message):
        OctreeLpvSettings.make("sparse", **changes)
