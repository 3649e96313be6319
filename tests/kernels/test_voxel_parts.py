"""What is static and what moves (techniques/voxel_cones/voxels/parts.py): whose triangles, and the cube of both."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import random_directions, scene_of
from voxel_scenes import grid_of
from voxel_tools import built, mesh_of, random_triangles, sampled

from octolux.gpu.profiler import Profiler
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.scene.meshes import Instance
from octolux.simulator.voxels.surfaces import around
from octolux.techniques.voxel_cones.voxels.parts import Parts, cube_of


@pytest.mark.parametrize(("depth", "size", "apart"), [(5, 6.0, 0.0), (6, 1.5, 1.5)])
def test_parts_read_as_one_octree(device, depth, size, apart):
    """Of many small things some move, twice, among the others: of those that stay enough is voxelised again. So it is
    where each has others `apart` voxels, which share its nodes, though not its box."""
    grid, rng = grid_of(depth), np.random.default_rng(depth)
    corners = random_triangles(grid, 300, size, 3)
    shift = apart * grid.cell_size * random_directions(rng, len(corners))[:, None]
    meshes = [mesh_of(some) for some in np.array_split(corners, 60 if not apart else len(corners))]
    scene = scene_of(meshes + ([mesh_of(one) for one in (corners + shift)[:, None]] if apart else []))
    gpu_scene, parts, profiler = GpuScene(device), Parts(device, depth, 0.0), Profiler(device, "off")
    points, towards = rng.uniform(0.0, grid.n, (4000, 3)), random_directions(rng, 4000)
    for moves, far in (([], 0.0), (range(0, 60, 9), 0.1), (range(9, 60, 9), 0.001)):
        for number in moves:
            transform = np.eye(4)
            transform[:3, 3] = rng.uniform(-far, far, 3) * grid.n * grid.cell_size
            scene.instances[number] = Instance(number, transform)
        gpu_scene.sync(scene)
        parts.prepare(gpu_scene)
        with profiler.frame():
            if parts.build(profiler, gpu_scene):
                with profiler.stage("filtering") as stage:
                    for octree in parts.octrees:
                        octree.filtering.everything(stage)
        assert len(parts.octrees) == (2 if moves else 1)
        whole = built(device, scene, parts.static.grid)
        for level in range(depth):
            for one, other in zip(sampled(tuple(parts.octrees), points, level, towards),
                                  sampled(whole, points, level, towards), strict=True):  # fmt: skip
                np.testing.assert_array_equal(one, other, err_msg=f"level {level}")


def boxes(*sides: float) -> tuple[np.ndarray, np.ndarray]:
    """Of cubes around the origin with these edges."""
    edges = np.array(sides)[:, None] * np.full(3, 0.5)
    return -edges, edges


def test_the_cube_is_that_of_what_is_static():
    """Where all that moves lies in it, or else, and where nothing is static, that of all."""
    small, large = around([-1] * 3, [1] * 3, 6), around([-1.5] * 3, [1.5] * 3, 6)
    assert cube_of(boxes(1.0, 2.0), boxes(), 6) == cube_of(boxes(2.0), boxes(0.5, 2.0), 6) == small
    assert cube_of(boxes(2.0), boxes(3.0), 6) == cube_of(boxes(), boxes(3.0), 6) == large
    assert cube_of(boxes(), boxes(), 6).n == cube_of(boxes(0.0), boxes(), 6).n == 64
