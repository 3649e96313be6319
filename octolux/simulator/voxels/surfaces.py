"""What the voxels of a dense grid hold of the scene's surfaces (VCT 5.3, 5.4.1)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..grid import Grid
from .fragments import Fragments

DIRECTIONS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
"""The six ways that axial values look."""


def around(low, high, depth: int) -> Grid:
    """The cube of (2^depth)^3 voxels around the box from `low` to `high` (3,), m (VCT 5.2.1: as tight as it can be).

    Its lowest faces, and the highest of its longest edge, lie in the middle of the second layer of voxels: the layer
    outside is air, so that nothing is cut off where values are filtered, and no face of the box lies between two
    layers. Raises ValueError for a depth below 2 or an empty box.
    """
    low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
    edge = float(np.max(high - low))
    if depth < 2 or not edge > 0.0:
        raise ValueError(f"an octree has a depth of 2 or more around a box, got {depth} from {low} to {high}")
    size = edge / (2**depth - 3)
    x, y, z = low - 1.5 * size
    return Grid((x, y, z), size, 2**depth)


@dataclass(frozen=True, eq=False)
class Voxels:
    """touched: bool [z][y][x], whether it has a fragment, even one that is cut out.

    facing: float64 [z][y][x][6], of the voxel's section across each axis, the share that surfaces cover which look
    along each of DIRECTIONS, at most 1: opacity for what comes from there (VCT 5.4.3).  albedo, emission: float64
    [z][y][x][3], means over the surfaces' areas; emission is radiance, nits.
    """

    touched: np.ndarray
    facing: np.ndarray
    albedo: np.ndarray
    emission: np.ndarray


def voxelise(found: Fragments, normals, n: int, albedo, emission, coverage, double_sided) -> Voxels:
    """Sum fragments into n^3 voxels; those outside are dropped.

    normals: unit vectors of the triangles, (T, 3).  For each fragment: albedo (M, 3); emission (M, 3), nits; coverage
    (M,): what alpha leaves of it; double_sided (M,): seen from both sides, so it faces either way. Paths of light meet
    all surfaces on both sides, single-sided ones too; a camera looks through the backs of these.

    A back counts where it can be seen: where the voxel that it looks at is not `touched`. A solid whose materials are
    double-sided, as all are in files that do not say, would else be hidden in part by its own dark inside, wherever it
    is slanted: its back looks along the axes across which its front does not.
    """
    normal = np.asarray(normals, dtype=np.float64)[found.triangle]
    steepest = np.abs(normal).max(axis=1, keepdims=True)
    share = (found.share * coverage)[:, None]
    along = normal @ DIRECTIONS.T / steepest
    area = share / steepest
    here = ((found.voxel >= 0) & (found.voxel < n)).all(axis=1)
    x, y, z = found.voxel[here].T
    touched = np.zeros((n, n, n), bool)
    touched[z, y, x] = True
    back = np.asarray(double_sided)[:, None] & ~_covered(touched, found.voxel)
    facing = share * np.where(back, np.abs(along), np.maximum(along, 0.0))

    def summed(values: np.ndarray) -> np.ndarray:
        sums = np.zeros((n, n, n, values.shape[1]))
        np.add.at(sums, (z, y, x), values[here])
        return sums

    areas = summed(area)
    means = [summed(area * np.asarray(v)) / np.where(areas > 0.0, areas, 1.0) for v in (albedo, emission)]
    return Voxels(touched, np.minimum(summed(facing), 1.0), *means)


def _covered(touched: np.ndarray, voxels: np.ndarray) -> np.ndarray:
    """Whether the voxel that each of DIRECTIONS leads to from voxels (M, 3) is touched: (M, 6)."""
    padded, inside = np.pad(touched, 1), np.clip(voxels, 0, len(touched) - 1)
    x, y, z = np.moveaxis(inside[:, None] + DIRECTIONS.astype(np.int64) + 1, -1, 0)
    return padded[z, y, x]
