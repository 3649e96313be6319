"""The voxel octree (techniques/voxel_cones/octree): its nodes, pools and errors."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import scene_of
from voxel_scenes import grid_of, random_scene
from voxel_tools import built, cells_of, read, sampled

from octolux.gpu.device import DeviceError
from octolux.techniques.voxel_cones.octree.pools import Pool
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree


def test_nodes_of_a_level_stand_together(device):
    """Numbers go by codes, from the root; each level has as many as it says; parents are there."""
    grid = grid_of(6)
    octree = built(device, random_scene(grid, 60, 20.0, 4)[0], grid)
    codes, counts = octree.codes(), octree.octree.counts
    assert np.all(np.diff(codes.astype(np.int64)) > 0) and codes[0] == 1
    for level, (first, count) in enumerate(counts.levels):
        assert np.all(codes[first : first + count].astype(np.int64) >> (3 * (5 - level)) == 1)
    assert set(codes[1:] >> 3) <= set(codes)
    assert sum(count for _, count in counts.levels) == counts.nodes == len(codes)


def test_which_nodes_there_are(device):
    """One for every 3^3 voxels of a brick of which one is occupied, on every level."""
    grid = grid_of(5)
    scene, expected = random_scene(grid, 25, 6.0, 5)
    octree = built(device, scene, grid)
    codes, touched = octree.codes(), expected.touched
    for first, count in octree.octree.counts.levels:
        m = len(touched) // 2
        padded = np.pad(touched, (0, 1))
        needed = np.zeros((m, m, m), bool)
        for offset in np.ndindex(3, 3, 3):
            z, y, x = (slice(o, o + 2 * m - 1, 2) for o in offset)
            needed |= padded[z, y, x]
        x, y, z = cells_of(codes[first : first + count]).T
        there = np.zeros_like(needed)
        there[z, y, x] = True
        np.testing.assert_array_equal(there, needed)
        touched = touched.reshape(m, 2, m, 2, m, 2).any(axis=(1, 3, 5))


def test_the_same_bits_in_two_runs(device):
    grid = grid_of(6)
    scene, _ = random_scene(grid, 3000, 4.0, 6, emissive=(1.0, 2.0, 3.0))
    octree = built(device, scene, grid, peak=3.0)
    first, before = octree.codes().copy(), read(octree)
    facing = bytes(device.queue.read_buffer(octree.bricks.facing.resource))
    again = built(device, scene, grid, octree, peak=3.0)
    np.testing.assert_array_equal(again.codes(), first)
    assert bytes(device.queue.read_buffer(again.bricks.facing.resource)) == facing
    for a, b in zip(vars(before).values(), vars(read(again)).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_pools_grow_and_say_how_full_they_are(device):
    grid = grid_of(5)
    octree = built(device, random_scene(grid, 5, 3.0, 11)[0], grid)
    small = octree.pools()
    assert all(pool["used"] == pool["room"] > 0 for pool in small.values())
    scene, expected = random_scene(grid, 200, 8.0, 12)
    built(device, scene, grid, octree)
    for name, pool in octree.pools().items():
        assert small[name]["room"] < pool["used"] <= pool["room"] <= pool["most"], name
    np.testing.assert_array_equal(read(octree).touched, expected.touched)
    largest = octree.pools()
    built(device, random_scene(grid, 5, 3.0, 11)[0], grid, octree)
    for name, pool in octree.pools().items():
        assert pool["used"] == small[name]["used"] and pool["room"] == largest[name]["room"], name


def test_a_pool_that_cannot_grow_says_so():
    pool = Pool("nodes", lambda count: count, limit=10)
    assert pool.need(4) and not pool.need(3) and pool.need(9) and pool.capacity == 10
    with pytest.raises(DeviceError, match=r"11 nodes; there can be 10.*smaller depth"):
        pool.need(11)
    assert (pool.used, pool.capacity) == (9, 10)


def test_an_empty_scene_has_no_nodes(device):
    octree = built(device, scene_of([]), grid_of(4))
    assert octree.octree.counts.nodes == 0 and not read(octree).touched.any()
    values, some = sampled(octree, np.full((1, 3), 5.0), 0, (1.0, 0.0, 0.0))
    assert not values.any() and not some.any()


def test_another_grid_is_refused(device):
    octree = VoxelOctree(device, 4)
    with pytest.raises(ValueError, match="16 voxels a side, not 32"):
        built(device, scene_of([]), grid_of(5), octree)
