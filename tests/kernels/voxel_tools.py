"""What tests of voxels share: scenes whose voxels do not hang on rounding, their octrees, and reading these."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
from gpu_tools import TESTS, one_stage, read_buffer

from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.passes import ComputePass
from octolux.gpu.profiler import Profiler
from octolux.gpu.records import read_records, read_words
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.scene.meshes import Mesh
from octolux.simulator.grid import Grid
from octolux.simulator.voxels.fragments import fragments
from octolux.techniques.voxel_cones.bricks.reading import Reading
from octolux.techniques.voxel_cones.voxels.structure import VOXEL, VoxelOctree
from octolux.techniques.voxel_cones.voxels.voxeliser import CUBE

Octrees = VoxelOctree | tuple[VoxelOctree, ...]
ROUNDING = 1e-4
"""Voxels by which float32 may move a surface in a grid of up to 64: coordinates have 24 bits, and a corner takes some
ten operations, 64 * 2^-24 * 10 = 4e-5."""


def clear_triangles(corners: np.ndarray, grid: Grid) -> np.ndarray:
    """Those of the triangles (T, 3, 3) whose fragments stay the same when they are moved by ROUNDING either way along
    each axis: no sample lies so near to an edge, and none of their depths so near to a face between voxels."""
    keep = np.ones(len(corners), bool)
    plain = _as_sets(corners, grid)
    for way in product((-1, 1), repeat=3):
        moved = _as_sets(corners + ROUNDING * grid.cell_size * np.array(way), grid)
        keep &= [a == b for a, b in zip(plain, moved, strict=True)]
    return corners[keep]


def _as_sets(corners: np.ndarray, grid: Grid) -> list[set[tuple[float, ...]]]:
    found = fragments(corners, grid)
    sets: list[set[tuple[float, ...]]] = [set() for _ in corners]
    for triangle, voxel, share in zip(found.triangle, found.voxel, found.share, strict=True):
        sets[triangle].add((*voxel.tolist(), float(share)))
    return sets


def random_triangles(grid: Grid, count: int, size: float, seed: int) -> np.ndarray:
    """Triangles inside the grid, with corners up to `size` voxels away from each other along each axis; float32."""
    rng = np.random.default_rng(seed)
    corners = rng.uniform(1.0, grid.n - 1.0, (count, 1, 3)) + rng.uniform(-size / 2, size / 2, (count, 3, 3))
    corners = np.clip(corners, 0.5, grid.n - 0.5) * grid.cell_size + np.array(grid.origin)
    corners = corners.astype(np.float32).astype(np.float64)
    area = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    return clear_triangles(corners[area > 1e-3 * grid.cell_size**2], grid)


def mesh_of(corners: np.ndarray, material: int = 0, uvs: np.ndarray | None = None) -> Mesh:
    """A mesh of single triangles (T, 3, 3) with flat normals; uvs: (T, 3, 2)."""
    flat, count = unit_normals(corners), 3 * len(corners)
    return Mesh(
        positions=corners.reshape(-1, 3).astype(np.float32), normals=np.repeat(flat, 3, axis=0).astype(np.float32),
        uvs=(np.zeros((count, 2)) if uvs is None else uvs.reshape(-1, 2)).astype(np.float32),
        tangents=np.tile(np.float32([1, 0, 0, 1]), (count, 1)), material=material,
        indices=np.arange(count, dtype=np.uint32).reshape(-1, 3),
    )  # fmt: skip


def unit_normals(corners: np.ndarray) -> np.ndarray:
    """Float64 (T, 3)."""
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return normals / np.linalg.norm(normals, axis=1, keepdims=True)


def built(device: Any, scene: Any, grid: Grid, octree: VoxelOctree | None = None, **given: Any) -> VoxelOctree:
    """The octree of a scene, or `octree` built anew for it."""
    octree = octree or VoxelOctree(device, grid.n.bit_length() - 1)
    gpu_scene = GpuScene(device)
    gpu_scene.sync(scene)
    profiler = Profiler(device, "off")
    with profiler.frame():
        octree.build(profiler, gpu_scene, grid, **given)
    return octree


@dataclass(frozen=True)
class Read:
    """What the octree's voxels of level 0 hold, dense: as simulator/voxels/surfaces.Voxels, but emission as a share."""

    touched: np.ndarray
    facing: np.ndarray
    albedo: np.ndarray
    emission: np.ndarray


def read(octree: VoxelOctree) -> Read:
    """The records of all voxels, in a dense grid."""
    n, counts = octree.grid.n, octree.octree.counts
    first, count = counts.levels[0]
    cells = cells_of(octree.codes()[first : first + count])
    words = read_words(octree.device, octree.octree.leaves.resource, count)
    voxels = read_records(octree.device, octree.voxels.resource, VOXEL, counts.voxels)
    made = Read(np.zeros((n, n, n), bool), *(np.zeros((n, n, n, k)) for k in (6, 3, 3)))
    number = (words >> 8).astype(np.int64)
    for corner in range(8):
        here = (words >> corner & 1) == 1
        x, y, z = (2 * cells[here] + [corner & 1, corner >> 1 & 1, corner >> 2]).T
        record = voxels[number[here]]
        number[here] += 1
        made.touched[z, y, x] = True
        made.albedo[z, y, x] = _bytes(record["albedo"]) ** 2
        made.facing[z, y, x, 0::2], made.facing[z, y, x, 1::2] = (
            _bytes(record["facing_up"]),
            _bytes(record["facing_down"]),
        )
        packed = record["emission"]
        codes = packed[:, None] >> np.array([0, 9, 18], np.uint32) & 511
        made.emission[z, y, x] = codes * 2.0 ** ((packed >> 27).astype(np.float64)[:, None] - 40.0)
    return made


def shine(octree: VoxelOctree, light: np.ndarray, unit: float, touched: np.ndarray | None = None) -> None:
    """Let voxels of level 0 send `light` [z][y][x][6][3], nits times share of section, and filter it: all, or what
    comes of the nodes of level 0 that are `touched`, bool (nodes,). unit: nits, at least the brightest."""
    bricks, device = octree.bricks, octree.device
    first, count = bricks.levels[0]
    owners = np.frombuffer(device.queue.read_buffer(bricks.owners.resource), np.uint32)[first : first + count]
    cells = cells_of(octree.codes()[owners >> 3])
    words = np.zeros((count, 8), np.uint32)
    for corner in range(8):
        x, y, z = (2 * cells + [corner & 1, corner >> 1 & 1, corner >> 2]).T
        words[:, corner] = pack_bright(light[z, y, x, owners & 7] / unit)
    device.write(bricks.light.resource, words, 32 * first)
    with one_stage(device) as stage:
        if touched is None:
            octree.filtering.everything(stage, unit)
        else:
            touch(octree, np.flatnonzero(touched) + octree.octree.counts.levels[0][0])
            octree.filtering.touched(stage, unit)


def touch(octree: VoxelOctree, nodes: np.ndarray) -> None:
    """techniques/voxel_cones/bricks/touch.wgsl."""
    to, device = octree.filtering.updates.resources, octree.device
    marks = np.zeros(octree.octree.counts.nodes, np.uint32)
    marks[nodes] = 1
    device.write(to["touched"], marks)
    device.write(to["node_list"], nodes.astype(np.uint32))
    device.write(to["lists"], np.array([-(-8 * len(nodes) // 64), 1, 1, len(nodes)], np.uint32))


def pack_bright(colors: np.ndarray) -> np.ndarray:
    """techniques/voxel_cones/bricks/bright.wgsl."""
    largest = np.maximum(colors.max(axis=1), 1e-30)
    exponent = np.clip(np.ceil(np.log2(largest * 512 / 511)), -31, 0)
    codes = np.minimum(np.round(colors * 2.0 ** (9 - exponent)[:, None]), 511).astype(np.uint32)
    return codes[:, 0] | codes[:, 1] << 9 | codes[:, 2] << 18 | (exponent + 31).astype(np.uint32) << 27


def _bytes(packed: np.ndarray) -> np.ndarray:
    return (packed[:, None] >> np.array([0, 8, 16], np.uint32) & 255) / 255.0


def cells_of(codes: np.ndarray) -> np.ndarray:
    """Cells (x, y, z) that codes (techniques/voxel_cones/octree/codes.wgsl) stand for, int64 (m, 3)."""
    codes = codes.astype(np.int64)
    cells = np.zeros((len(codes), 3), np.int64)
    top = np.array([(int(code).bit_length() - 1) // 3 for code in codes], np.int64)
    for bit in range(10):
        for axis in range(3):
            cells[:, axis] |= np.where(bit < top, (codes >> (3 * bit + axis) & 1) << bit, 0)
    return cells


def sampled(octrees: Octrees, points: np.ndarray, level: int, towards: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """`sample_voxels` at points (m, 3) in voxels of level 0, on a level, along unit vectors (m, 3) or (3,): radiance
    times opacity and opacity, (m, 4); and whether there is a node, bool (m,)."""
    both = octrees if isinstance(octrees, tuple) else (octrees,)
    device, reading = both[0].device, Reading(both[0].device, both[0].bricks)
    reading.moving = both[1].bricks if len(both) > 1 else None
    given = np.zeros((len(points), 8), np.float32)
    given[:, :3], given[:, 3], given[:, 4:7] = points, level, towards
    result = device.buffer("result", size=32 * len(points))
    kernel = ComputePass(
        device, "bricks", str(TESTS / "kernels" / "voxel_bricks.wgsl"),
        [*reading.bindings, storage("given", "vec4f"), storage_rw("result", "vec4f", "write")],
        structs=reading.structs, workgroup=(64, 1, 1), count=len(points), file=reading.file, **reading.values,
    )  # fmt: skip
    with one_stage(device) as stage:
        kernel.run(stage, (len(points),), given=device.buffer("given", given), result=result, **reading.resources)
    values = read_buffer(device, result).reshape(-1, 8)[: len(points)]
    return values[:, :4].astype(np.float64), values[:, 4] == 0.0


def leaves_of(
    octree: VoxelOctree, points: np.ndarray, normals: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The voxels (m, 3) of level 0 in which points (m, 3) of surfaces lie, world space, normals (m, 3); the numbers of
    their records (m,); and whether there is one, bool (m,)."""
    device = octree.device
    given = np.zeros((len(points), 8), np.float32)
    given[:, :3], given[:, 4:7] = points, normals
    result = device.buffer("result", size=16 * len(points))
    kernel = ComputePass(
        device, "leaves", str(TESTS / "kernels" / "voxel_leaves.wgsl"),
        [*octree.leaf_bindings, storage("given", "vec4f"), storage_rw("result", "vec4u", "write")],
        structs=[CUBE], workgroup=(64, 1, 1), count=len(points), **octree.leaf_values,
    )  # fmt: skip
    with one_stage(device) as stage:
        kernel.run(stage, (len(points),), given=device.buffer("given", given), result=result, **octree.leaf_resources())
    node, corner, number, some = read_buffer(device, result, np.uint32).reshape(-1, 4)[: len(points)].T.astype(np.int64)
    cells = 2 * cells_of(octree.codes()[node]) + np.stack([corner & 1, corner >> 1 & 1, corner >> 2], axis=-1)
    return cells, number, some == 1
