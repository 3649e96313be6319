"""Lobes of the voxel octree (techniques/voxel_cones/lobes): filtered values against the dense float64 pyramid."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions
from voxel_scenes import grid_of, near_and_far, random_scene
from voxel_tools import built, cells_of, pack_bright, read, sampled, touch

from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.raytracing.bvh import triangle_ids
from octolux.simulator.voxels.lobes import LobeVoxels, shares_of_ways
from octolux.techniques.voxel_cones.views.contents import level_voxels
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree

BRIGHTEST, UNIT = 9.0, 16.0
WITHIN = 1e-2  # what filtered values may differ by from those of the dense grid, of the brightest
SPREAD = 0.5
"""Length of mean vectors in these tests, at most: E is at least (1 - SPREAD) / 4 then."""


def lobes(device, depth: int) -> VoxelOctree:
    return VoxelOctree(device, depth, representation="lobes")


def pack_moment(moments: np.ndarray) -> np.ndarray:
    """techniques/voxel_cones/lobes/moment.wgsl."""
    largest = np.maximum(np.abs(moments).max(axis=1), 1e-30)
    exponent = np.clip(np.ceil(np.log2(largest * 256 / 255)), -31, 0)
    codes = np.clip(np.round(moments * 2.0 ** (8 - exponent)[:, None]), -255, 255).astype(np.int64) + 256
    packed = codes[:, 0] | codes[:, 1] << 9 | codes[:, 2] << 18 | (exponent + 31).astype(np.int64) << 27
    return packed.astype(np.uint32)


def shine(octree: VoxelOctree, light: np.ndarray, moment: np.ndarray, touched: np.ndarray | None = None) -> None:
    """Let voxels of level 0 send `light` [z][y][x][3] with `moment` [z][y][x][3], nits, and filter them, as
    voxel_tools.shine."""
    bricks, device = octree.bricks, octree.device
    (first, count), (first_node, nodes) = bricks.levels[0], octree.octree.counts.levels[0]
    assert count == 3 * nodes
    cells, words = cells_of(octree.codes()[first_node : first_node + nodes]), np.zeros((nodes, 3, 8), np.uint32)
    for corner in range(8):
        x, y, z = (2 * cells + [corner & 1, corner >> 1 & 1, corner >> 2]).T
        words[:, 0, corner] = pack_bright(light[z, y, x] / UNIT)
        words[:, 1, corner] = pack_moment(moment[z, y, x] / UNIT)
    device.write(bricks.light.resource, words, 32 * first)
    with one_stage(device) as stage:
        if touched is None:
            octree.filtering.everything(stage, UNIT)
        else:
            touch(octree, np.flatnonzero(touched) + first_node)
            octree.filtering.touched(stage, UNIT)


def lights(facing: np.ndarray, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Light and moments of voxels that face something: of radiances from half of BRIGHTEST on."""
    shape = facing.shape[:3]
    radiance = BRIGHTEST * rng.uniform(0.5, 1.0, (*shape, 3))
    light = radiance * facing.sum(axis=-1, keepdims=True) / 6.0
    way = random_directions(rng, facing[..., 0].size).reshape(*shape, 3) * rng.uniform(0, SPREAD, (*shape, 1))
    return light, light.mean(axis=-1, keepdims=True) * way


def shown(expected: tuple[np.ndarray, ...], cells: np.ndarray) -> np.ndarray:
    """What voxels of a level of LobeVoxels send each of six ways: (m, 6, 3)."""
    facing, light, moment = (values[tuple(cells.T[::-1])] for values in expected)
    comes_from = moment / np.maximum(light.mean(axis=1, keepdims=True), 1e-9)
    return shares_of_ways(facing, comes_from)[..., None] * light[:, None]


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 20, 12.0), (6, 60, 40.0)])
def test_filtered_lobes(device, depth, count, size):
    grid, rng = grid_of(depth), np.random.default_rng(7)
    scene, _ = random_scene(grid, count, size, 20 + depth)
    octree = built(device, scene, grid, lobes(device, depth))
    facing = read(octree).facing
    light, moment = lights(facing, rng)
    shine(octree, light, moment)
    expected, (points, towards) = LobeVoxels(facing, light, moment), near_and_far(read(octree), rng)
    for level in range(depth):
        found, _ = sampled(octree, points, level, towards)
        radiance, opacity = expected(points, float(level), towards)
        np.testing.assert_allclose(found[:, 3], opacity, atol=WITHIN, err_msg=f"level {level}")
        np.testing.assert_allclose(found[:, :3], radiance, atol=BRIGHTEST * WITHIN, err_msg=f"level {level}")
        views = level_voxels(octree, level, UNIT)
        np.testing.assert_allclose(
            views["light"], shown(expected.levels[level], views["cell"]), atol=BRIGHTEST * WITHIN
        )  # fmt: skip
        assert opacity.max() > 3 * WITHIN and radiance.max() > 3 * BRIGHTEST * WITHIN


def test_only_what_is_touched_is_filtered(device):
    """As with axial values: of lobes a node has three bricks."""
    grid, rng = grid_of(6), np.random.default_rng(8)
    scene, _ = random_scene(grid, 300, 5.0, 30)
    octree = built(device, scene, grid, lobes(device, 6))
    light, moment = lights(read(octree).facing, rng)
    shine(octree, light, moment)
    first, count = octree.octree.counts.levels[0]
    cells = cells_of(octree.codes()[first : first + count])
    touched = (cells < 10).all(axis=1)
    x, y, z = np.concatenate([2 * cells[touched] + [c & 1, c >> 1 & 1, c >> 2] for c in range(8)]).T
    light[z, y, x], moment[z, y, x] = 0.3 * light[z, y, x], -0.1 * moment[z, y, x]
    shine(octree, light, moment, touched)
    updated = int(np.frombuffer(device.queue.read_buffer(octree.filtering.updates.count), np.uint32)[0])
    points, towards = near_and_far(read(octree), rng)
    partly = [sampled(octree, points, level, towards)[0] for level in range(6)]
    shine(octree, light, moment)
    for level in range(6):
        np.testing.assert_array_equal(partly[level], sampled(octree, points, level, towards)[0])
    assert 0 < updated < 0.4 * octree.bricks.bricks.used


def test_what_moves_beside_what_is_static(device):
    """Two octrees of a scene's parts are read as one of the whole, to the bit."""
    grid, rng = grid_of(5), np.random.default_rng(16)
    scene, expected = random_scene(grid, 200, 5.0, 15, double_sided=False)
    whole = built(device, scene, grid, lobes(device, 5))
    light, moment = lights(read(whole).facing, rng)
    shine(whole, light, moment)
    gpu_scene = GpuScene(device)
    gpu_scene.sync(scene)
    ids = triangle_ids(gpu_scene)
    moves = ids % 10 == 3
    static = built(device, scene, grid, lobes(device, 5), ids=ids[~moves])
    moving = VoxelOctree(device, 5, representation="lobes", static=static)
    built(device, scene, grid, moving, ids=ids[moves], near=ids[~moves])
    for octree in (static, moving):
        shine(octree, light, moment)
    points, towards = near_and_far(expected, rng)
    for level in range(5):
        both = sampled((static, moving), points, level, towards)
        for one, other in zip(both, sampled(whole, points, level, towards), strict=True):
            np.testing.assert_array_equal(one, other, err_msg=f"level {level}")


def test_octrees_that_keep_light_otherwise_are_not_read_together(device):
    with pytest.raises(ValueError, match="keep light alike"):
        VoxelOctree(device, 4, static=lobes(device, 4))
