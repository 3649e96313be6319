"""Bricks of the voxel octree (techniques/voxel_cones/bricks): filtered values against the dense float64 pyramid."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import random_directions, read_buffer, scene_of
from voxel_scenes import BYTE, grid_of, near_and_far, random_scene
from voxel_tools import built, cells_of, read, sampled, shine

from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.raytracing.bvh import triangle_ids
from octolux.scene.builtin.shapes import box
from octolux.simulator.voxels.pyramid import facing_levels, intensity_levels, sample
from octolux.simulator.voxels.surfaces import DIRECTIONS, around
from octolux.techniques.voxel_cones.bricks.representation import REPRESENTATIONS
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree

WITHIN = 1e-2  # what filtered values may differ by from those of the dense grid


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 20, 12.0), (5, 300, 4.0), (6, 60, 40.0)])
def test_filtered_values(device, depth, count, size):
    """On every level trilinear values are those of the dense pyramid, near surfaces and far from them, also where nodes
    are missing (VCT figure 5.10)."""
    grid = grid_of(depth)
    scene, expected = random_scene(grid, count, size, 10 + depth)
    octree = built(device, scene, grid)
    points, towards = near_and_far(expected, np.random.default_rng(1))
    for level, facing in enumerate(facing_levels(expected.facing)):
        found, some = sampled(octree, points, level, towards)
        exact = (np.maximum(-towards @ DIRECTIONS.T, 0.0) * sample(facing, points / 2.0**level)).sum(axis=1)
        np.testing.assert_allclose(found[:, 3], exact, atol=WITHIN, err_msg=f"level {level}")
        assert not found[:, :3].any() and not exact[~some].any(), "a node is missing where something is"
        assert exact.max() > 3 * WITHIN


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 20, 12.0), (6, 60, 40.0)])
def test_filtered_light(device, depth, count, size):
    """Light that voxels of level 0 send six ways comes back from every level as from the dense pyramid."""
    grid, rng = grid_of(depth), np.random.default_rng(7)
    scene, expected = random_scene(grid, count, size, 20 + depth)
    octree = built(device, scene, grid)
    radiance = 40.0 * rng.uniform(size=(*expected.facing.shape, 3)) ** 2
    light = radiance * expected.facing[..., None]
    shine(octree, light, unit=50.0)
    points, towards = near_and_far(expected, rng)
    facings = facing_levels(expected.facing)
    for level, intensity in enumerate(intensity_levels(light, facings)):
        found, _ = sampled(octree, points, level, towards)
        against = np.maximum(-towards @ DIRECTIONS.T, 0.0)
        exact = np.einsum("mw,mwk->mk", against, sample(intensity, points / 2.0**level))
        np.testing.assert_allclose(found[:, :3], exact, atol=40.0 * WITHIN, err_msg=f"level {level}")
        assert exact.max() > 3 * 40.0 * WITHIN


def test_only_what_is_touched_is_filtered(device):
    """Light that changes in a corner of the scene: the same as when all is filtered, from fewer bricks."""
    grid, rng = grid_of(6), np.random.default_rng(8)
    scene, expected = random_scene(grid, 300, 5.0, 30)
    octree = built(device, scene, grid)
    light = 9.0 * rng.uniform(size=(*expected.facing.shape, 3)) * expected.facing[..., None]
    shine(octree, light, unit=10.0)
    first, count = octree.octree.counts.levels[0]
    cells = cells_of(octree.codes()[first : first + count])
    touched = (cells < 10).all(axis=1)
    x, y, z = np.concatenate([2 * cells[touched] + [c & 1, c >> 1 & 1, c >> 2] for c in range(8)]).T
    light[z, y, x] = light[z, y, x][:, ::-1] * 0.3
    shine(octree, light, 10.0, touched)
    updated = int(np.frombuffer(device.queue.read_buffer(octree.filtering.updates.count), np.uint32)[0])
    points, towards = near_and_far(expected, rng)
    partly = [sampled(octree, points, level, towards)[0] for level in range(6)]
    shine(octree, light, unit=10.0)
    for level in range(6):
        np.testing.assert_array_equal(partly[level], sampled(octree, points, level, towards)[0])
    assert 0 < updated < 0.4 * octree.bricks.bricks.used
    left = octree.filtering.updates.resources
    assert not read_buffer(device, left["touched"], np.uint32).any()
    assert not read_buffer(device, left["lists"], np.uint32).reshape(-1, 4)[:, [0, 3]].any()


def test_no_jump_at_the_faces_of_bricks(device):
    """Values on both sides of faces between bricks, and between a brick and nothing, are the same."""
    grid = grid_of(5)
    scene, _ = random_scene(grid, 40, 10.0, 3)
    octree = built(device, scene, grid)
    rng = np.random.default_rng(2)
    for level in range(4):
        cells = rng.integers(0, (grid.n >> level) // 2 - 1, (2000, 3))
        middle = 2.0 * (cells + 1) + 0.5  # the upper corner of a brick
        across = np.eye(3)[rng.integers(0, 3, len(cells))]
        at = middle - (1 - across) * rng.uniform(0, 2, (len(cells), 3))
        towards = random_directions(rng, len(cells))
        below, above = (sampled(octree, 2.0**level * (at + s * 1e-4 * across), level, towards)[0] for s in (-1, 1))
        # Two voxels may differ by 1 for each of three ways, and 2e-4 of them lie between; the filter's weights have 8
        # bits, as texels have.
        np.testing.assert_allclose(below[:, 3], above[:, 3], atol=np.sqrt(3) * (2e-4 + 2 / 256))
        assert level == 3 or (below[:, 3] > 0.1).any()


def test_a_closed_box_is_closed(device):
    """Along each axis both walls of a box stop everything, from within and from without as its sides look; on the next
    level too."""
    grid = around((0, 0, 0), (1, 1, 1), 5)
    for inward, ways in ((False, 0), (True, 1)):
        octree = built(device, scene_of([box((0, 0, 0), (1, 1, 1), inward=inward)]), grid)
        inside = np.random.default_rng(3).uniform(4.0, grid.n - 4.0, (200, 3))
        for axis in range(3):
            for level, walls in ((0, (1.5, grid.n - 1.5)), (1, (1.0, grid.n - 1.0))):
                for side, wall in enumerate(walls):
                    points = inside.copy()
                    points[:, axis] = wall
                    way = 2 * axis + (1 - side if ways == 0 else side)
                    found, _ = sampled(octree, points, level, -DIRECTIONS[way])
                    np.testing.assert_allclose(found[:, 3], 1.0, atol=BYTE + 1 / 256)


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 20, 10.0), (5, 200, 5.0), (6, 1500, 2.0)])
def test_what_moves_beside_what_is_static(device, depth, count, size):
    """Two octrees of a scene's parts, that of what moves beside that of the rest, are read as one of the whole: to the
    bit, what faces and light, on all levels; whichever triangles move. They are single-sided: what moves does not cover
    the backs of what is static."""
    grid, rng = grid_of(depth), np.random.default_rng(16)
    scene, expected = random_scene(grid, count, size, 15, double_sided=False)
    light = 9.0 * rng.uniform(size=(*expected.facing.shape, 3)) * expected.facing[..., None]
    points, towards = near_and_far(expected, rng)
    whole = built(device, scene, grid)
    shine(whole, light, unit=16.0)
    gpu_scene = GpuScene(device)
    gpu_scene.sync(scene)
    ids = triangle_ids(gpu_scene)
    static = VoxelOctree(device, depth)
    moving = VoxelOctree(device, depth, static=static)
    for moves in (ids % 10 == 3, ids % 2 == 0, ids >= 0):
        built(device, scene, grid, static, ids=ids[~moves])
        built(device, scene, grid, moving, ids=ids[moves], near=ids[~moves])
        for octree in (static, moving):
            shine(octree, light, unit=16.0)
        for level in range(depth):
            for one, other in zip(sampled((static, moving), points, level, towards),
                                  sampled(whole, points, level, towards), strict=True):  # fmt: skip
                np.testing.assert_array_equal(one, other, err_msg=f"level {level}")
        assert read(moving).touched.any()


@pytest.mark.parametrize("kept", REPRESENTATIONS)
@pytest.mark.parametrize("room", [100_000, 150_000])
def test_samples_do_not_hang_on_room(device, kept, room):
    """Where there is room for more bricks than there are, in a deeper texture, samples are the same bits."""
    grid, rng = grid_of(5), np.random.default_rng(18)
    scene, expected = random_scene(grid, 200, 5.0, 15)
    points, towards = near_and_far(expected, rng)
    tight, wide = (VoxelOctree(device, 5, representation=kept) for _ in range(2))
    wide.bricks.bricks.need(room)
    for octree in (tight, wide):
        built(device, scene, grid, octree)
    assert wide.bricks.bricks.resource.size[2] > 4 * tight.bricks.bricks.resource.size[2]
    for level in range(5):
        each = [sampled(octree, points, level, towards)[0] for octree in (tight, wide)]
        np.testing.assert_array_equal(*each, err_msg=f"level {level}")
        assert each[0].any()


def test_octrees_of_other_depths_are_not_read_together(device):
    with pytest.raises(ValueError, match="have one depth"):
        VoxelOctree(device, 5, static=VoxelOctree(device, 4))
