"""Voxel fragments: triangles cut into the voxels that they meet (Drinovsky 2013, "VCT", 5.2.1).

As in the thesis each triangle is projected once, along the axis nearest to its normal, onto columns of voxels. The
thesis takes one sample in the middle of a column. Here SAMPLES^2 say how much of the column the triangle covers, so
that small triangles and edges count for what they are, and the plane's depth in the middle of the column says which
voxel gets all of it. Both are the same for a surface and for its tessellation, whose triangles lie in one plane: their
shares of a column add up in one voxel. That is why this is neither an exact overlap nor conservative: a wall that
crosses the layers of voxels would be two or three thick, or two layers of half the opacity, which lets light through;
here every line along the axis is stopped by one whole voxel.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..grid import Grid
from ..surfels import ASIDE

SAMPLES = 4
"""Samples along each edge of a column."""
BIAS = ASIDE[0]
"""Voxels by which surfaces lie farther up than they do, and by how much a later axis must be nearer to be taken: walls
along the faces of voxels, and normals in the middle between two axes, are frequent and must not fall to rounding."""
_AT_ONCE = 1 << 20  # columns that are tried at a time: some 300 MB


@dataclass(frozen=True, eq=False)
class Fragments:
    """One for each triangle and column of voxels that it covers, M of them.

    triangle: int64 (M,).  voxel: int64 (M, 3), x, y, z; it may lie outside the grid.  share: float64 (M,), of the
    column's section that the triangle covers.  weights: float64 (M, 2), of the triangle's second and third corner, in
    the middle of what it covers.
    """

    triangle: np.ndarray
    voxel: np.ndarray
    share: np.ndarray
    weights: np.ndarray


def dominant_axis(normals: np.ndarray) -> np.ndarray:
    """int64 (T,): the axis nearest to each of the normals (T, 3) of any length; of about equal ones the first."""
    return (np.abs(normals) * (1.0 - BIAS * np.arange(3))).argmax(axis=1)


def fragments(corners, grid: Grid) -> Fragments:
    """Cut triangles, corners (T, 3, 3) in world space, into fragments. Raises ValueError when they are not finite."""
    corners = grid.to_cells(corners)
    if corners.shape[1:] != (3, 3) or not np.isfinite(corners).all():
        raise ValueError(f"triangles are finite numbers (T, 3, 3), got {corners.shape}")
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = dominant_axis(normal)
    order = (axis[:, None] + np.array([1, 2, 0])) % 3  # two across, then along
    turned = np.take_along_axis(corners, order[:, None, :], axis=2)
    normal = np.take_along_axis(normal, order, axis=1)
    low, high = turned[..., :2].min(axis=1), turned[..., :2].max(axis=1)
    first = np.clip(np.floor(low), 0, grid.n).astype(np.int64)
    size = np.maximum(np.clip(np.floor(high), -1, grid.n - 1).astype(np.int64) - first + 1, 0)
    size[normal[:, 2] == 0.0] = 0
    counts = size.prod(axis=1)
    parts = np.flatnonzero(np.diff(np.cumsum(counts) // _AT_ONCE, prepend=0)) + 1
    made = [_of_part(p, order, turned, normal, first, size) for p in np.split(np.arange(len(axis)), parts)]
    fields = ("triangle", "voxel", "share", "weights")
    return Fragments(*(np.concatenate([getattr(part, name) for part in made]) for name in fields))


def _of_part(
    part: np.ndarray, order: np.ndarray, turned: np.ndarray, normal: np.ndarray, first: np.ndarray, size: np.ndarray
) -> Fragments:  # fmt: skip
    counts = size[part].prod(axis=1)
    t = np.repeat(part, counts)
    within = np.arange(len(t)) - np.repeat(np.cumsum(counts) - counts, counts)
    width = np.maximum(size[t, 0], 1)
    column = first[t] + np.stack([within % width, within // width], axis=1)
    inside, second, third = _covered(turned[t], normal[t, 2], column)
    covered = np.maximum(inside.sum(axis=1), 1)
    weights = np.stack([(w * inside).sum(axis=1) / covered for w in (second, third)], axis=1)
    # Where the plane passes the middle of the column; along it the slope is at most one voxel for each axis across.
    aside = column + 0.5 - turned[t, 0, :2]
    depth = turned[t, 0, 2] - (aside * normal[t, :2]).sum(axis=1) / normal[t, 2]
    voxel = np.empty((len(t), 3), np.int64)
    np.put_along_axis(voxel, order[t], np.column_stack([column, np.floor(depth + BIAS).astype(np.int64)]), axis=1)
    met = inside.any(axis=1)
    return Fragments(t[met], voxel[met], inside.sum(axis=1)[met] / SAMPLES**2, weights[met])


def _covered(turned: np.ndarray, area: np.ndarray, column: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Which samples of each column lie in the triangle, bool (M, SAMPLES^2), and weights there of its second and third
    corner."""
    lattice = (np.arange(SAMPLES) + 0.5) / SAMPLES
    offsets = np.stack(np.meshgrid(lattice, lattice), axis=-1).reshape(-1, 2) + np.array(ASIDE)
    p = column[:, None, :] + offsets - turned[:, None, 0, :2]
    e1, e2 = (turned[:, None, i, :2] - turned[:, None, 0, :2] for i in (1, 2))
    second = (p[..., 0] * e2[..., 1] - p[..., 1] * e2[..., 0]) / area[:, None]
    third = (e1[..., 0] * p[..., 1] - e1[..., 1] * p[..., 0]) / area[:, None]
    return (second >= 0.0) & (third >= 0.0) & (second + third <= 1.0), second, third
