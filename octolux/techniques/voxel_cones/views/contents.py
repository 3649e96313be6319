"""What an octree's voxels hold, read back and unpacked: NumPy arrays of a level."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....gpu.records import read_records, read_words
from ....simulator.voxels.lobes import shares_of_ways
from ..octree.pools import OWN
from ..voxels.structure import VOXEL, VoxelOctree

VOXEL_VALUES = np.dtype([
    ("cell", np.int32, 3), ("facing", np.float32, 6), ("light", np.float32, (6, 3)), ("albedo", np.float32, 3),
    ("emission", np.float32, 3), ("occupied", np.bool_), ("comes_from", np.float32, 3),
])  # fmt: skip
"""cell: x, y, z on its level.  facing: shares of its sections that look along each of simulator/voxels/surfaces.
DIRECTIONS.  light: what it sends each way, nits times share.  albedo, emission (nits): of voxels of
level 0 that are `occupied`, else 0.  comes_from: of lobes, the mean of unit vectors to where its light comes from."""


def cells_of(codes: np.ndarray, log2_edge: int) -> np.ndarray:
    """Cells (m, 3) of a level with 2^log2_edge along each side, from their codes (codes.wgsl)."""
    morton = codes.astype(np.int64) & ((1 << 3 * log2_edge) - 1)
    cells = np.zeros((len(codes), 3), np.int32)
    for bit in range(log2_edge):
        cells |= ((morton[:, None] >> (3 * bit + np.arange(3)) & 1) << bit).astype(np.int32)
    return cells


def node_cells(octree: VoxelOctree, level: int) -> np.ndarray:
    """Cells (m, 3) that the nodes of a level have, in their order."""
    first, count = octree.octree.counts.levels[level]
    return cells_of(octree.codes()[first : first + count], octree.depth - 1 - level)


def level_nodes(octree: VoxelOctree) -> np.ndarray:
    """int32 (nodes, 4): level and cell of each node, in their order."""
    levels = range(octree.depth - 1, -1, -1)
    return np.concatenate([np.insert(node_cells(octree, level), 0, level, axis=1) for level in levels])


def level_voxels(octree: VoxelOctree, level: int, unit: float) -> np.ndarray:
    """VOXEL_VALUES of the voxels that nodes of a level own, (8 m,): eight of each, in the order of corners, whether
    there is anything in them or not. unit: of light, nits."""
    found = np.zeros((octree.octree.counts.levels[level][1], OWN), VOXEL_VALUES)
    corners = np.arange(OWN)[:, None] >> np.arange(3) & 1
    found["cell"] = 2 * node_cells(octree, level)[:, None] + corners
    found["facing"] = _facing(octree, level)
    _add_light(octree, level, unit, found)
    if level == 0:
        _add_surfaces(octree, found)
    return found.reshape(-1)


def merged(static: np.ndarray, moving: np.ndarray) -> np.ndarray:
    """VOXEL_VALUES of a level of two octrees: where what moves has a node, its voxels hold all that is there, but only
    the surfaces of what moves or is near (parts.py)."""
    keys, made = keys_of(static["cell"]), moving.copy()
    place = {key: number for number, key in enumerate(keys.tolist())}
    number = np.array([place.get(key, -1) for key in keys_of(moving["cell"]).tolist()], np.int64)
    bare = (number >= 0) & ~moving["occupied"]
    for name in ("albedo", "emission", "occupied"):
        made[name][bare] = static[name][number[bare]]
    return np.concatenate([np.delete(static, number[number >= 0]), made])


def keys_of(cells: np.ndarray) -> np.ndarray:
    """uint32 (m,), one for each of the cells (m, 3): x | y << 10 | z << 20."""
    return (cells << np.array([0, 10, 20])).sum(axis=1).astype(np.uint32)


def _words(octree: VoxelOctree, buffer: Any, first: int, count: int) -> np.ndarray:
    if not count:
        return np.zeros(0, np.uint32)
    return np.frombuffer(octree.device.queue.read_buffer(buffer, 4 * first, 4 * count), np.uint32)


def _facing(octree: VoxelOctree, level: int) -> np.ndarray:
    """facing.wgsl."""
    first, count = octree.octree.counts.levels[level]
    packed = _words(octree, octree.bricks.facing.resource, 2 * OWN * first, 2 * OWN * count).reshape(count, OWN, 2)
    shares = (packed[..., None, :] >> np.array([[0], [10], [20]], np.uint32) & 1023) / 1023.0
    return shares.reshape(count, OWN, 6)  # +x, -x, +y, ...


def _add_light(octree: VoxelOctree, level: int, unit: float, found: np.ndarray) -> None:
    """Of lobes what cones read of them: light of the first brick divided among ways by the moment in the second."""
    bricks, first_node = octree.bricks, octree.octree.counts.levels[level][0]
    first, count = bricks.levels[level]
    owners = _words(octree, bricks.owners.resource, first, count)
    words = _words(octree, bricks.light.resource, OWN * first, OWN * count)
    if bricks.representation.directed:
        parts = words.reshape(-1, 3, OWN)
        light, moment = unpack_bright(parts[:, 0].ravel()), unpack_moment(parts[:, 1].ravel())
        comes_from = moment / np.maximum(light.mean(axis=-1, keepdims=True), 1e-9)
        found["comes_from"] = comes_from.reshape(-1, OWN, 3)
        shares = shares_of_ways(found["facing"].reshape(-1, 6), comes_from)
        found["light"] = unit * (shares[..., None] * light[:, None]).reshape(-1, OWN, 6, 3)
    else:
        sent = unpack_bright(words).reshape(count, OWN, 3)
        found["light"][(owners >> 3) - first_node, :, owners & 7] = unit * sent


def _add_surfaces(octree: VoxelOctree, found: np.ndarray) -> None:
    """Of the voxels that are occupied: voxel.wgsl, octree.py (`leaves`)."""
    leaves = read_words(octree.device, octree.octree.leaves.resource, len(found))
    there = (leaves[:, None] >> np.arange(OWN, dtype=np.uint32) & 1) == 1
    records = read_records(octree.device, octree.voxels.resource, VOXEL, octree.octree.counts.voxels)
    roots = (records["albedo"][:, None] >> np.array([0, 8, 16], np.uint32) & 255) / 255.0
    found["occupied"] = there
    found["albedo"][there], found["emission"][there] = roots**2, octree.peak * unpack_bright(records["emission"])


def unpack_bright(packed: np.ndarray) -> np.ndarray:
    """Shares (m, 3) from words (m,) of bright.wgsl."""
    codes = packed[:, None] >> np.array([0, 9, 18], np.uint32) & 511
    return codes * 2.0 ** ((packed >> 27).astype(np.float64)[:, None] - 40.0)


def unpack_moment(packed: np.ndarray) -> np.ndarray:
    """Moments (m, 3) from words (m,) of lobes/moment.wgsl."""
    codes = (packed[:, None] >> np.array([0, 9, 18], np.uint32) & 511).astype(np.float64) - 256.0
    return np.where(packed[:, None] != 0, codes, 0.0) * 2.0 ** ((packed >> 27).astype(np.float64)[:, None] - 39.0)
