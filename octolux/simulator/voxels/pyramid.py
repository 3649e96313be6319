"""Pyramids of a dense grid of voxels, and trilinear reading: what bricks hold and return (VCT 3.6.3, 5.4.3).

Level 0 is the finest; a voxel of level i + 1 is made of the 2^3 of level i that it covers, down to 2^3 voxels. Values
belong to the middles of voxels.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def _pairs(values: np.ndarray, axis: int) -> tuple[np.ndarray, np.ndarray]:
    """The lower and the upper of each two voxels along x, y or z (0, 1, 2)."""
    take: list[slice] = [slice(None)] * 3
    lower, upper = list(take), list(take)
    lower[2 - axis], upper[2 - axis] = slice(0, None, 2), slice(1, None, 2)
    return values[tuple(lower)], values[tuple(upper)]


def _across(values: np.ndarray, axis: int) -> np.ndarray:
    """Means of each 2 x 2 voxels across x, y or z."""
    for other in range(3):
        if other != axis:
            lower, upper = _pairs(values, other)
            values = 0.5 * (lower + upper)
    return values


def coarser_opacity(opacity) -> np.ndarray:
    """Of each axis the maximum along it, then the mean over the 2 x 2 across (VCT 5.4.3): [z][y][x][3] of the next
    level."""
    return np.stack([_across(np.maximum(*_pairs(opacity[..., a], a)), a) for a in range(3)], axis=-1)


def coarser_intensity(intensity, opacity) -> np.ndarray:
    """Six axial intensities of the next level, [z][y][x][6][k], from those of this one and its opacity [z][y][x][3].

    An intensity is radiance times opacity along its axis. The thesis weighs radiances with opacities (5.4.3); here the
    voxel behind counts for what the one in front of it lets through, o' = (1 - o_front) o_back. The mean radiance times
    the coarser opacity is the coarser intensity: so what shines evenly shines as evenly from every level.
    """
    result = []
    for way in range(6):
        axis, up = way // 2, way % 2 == 0
        back, front = _pairs(intensity[..., way, :], axis)[:: 1 if up else -1]
        o_back, o_front = _pairs(opacity[..., axis, None], axis)[:: 1 if up else -1]
        seen = o_front + (1.0 - o_front) * o_back
        radiance = (front + (1.0 - o_front) * back) / np.where(seen > 0.0, seen, 1.0)
        result.append(_across(radiance * np.maximum(o_front, o_back), axis))
    return np.stack(result, axis=-2)


def opacity_levels(opacity) -> list[np.ndarray]:
    """float64 [z][y][x][3] on every level, from level 0, a cube of 2^depth along each side, to 2^3 voxels."""
    levels = [np.asarray(opacity, dtype=np.float64)]
    while len(levels[-1]) > 2:
        levels.append(coarser_opacity(levels[-1]))
    return levels


def intensity_levels(intensity, opacities: Sequence[np.ndarray]) -> list[np.ndarray]:
    """float64 [z][y][x][6][k] on every level. opacities: of the levels."""
    levels = [np.asarray(intensity, dtype=np.float64)]
    for opacity in opacities[:-1]:
        levels.append(coarser_intensity(levels[-1], opacity))
    return levels


def sample(level, points) -> np.ndarray:
    """Trilinear values at `points` (m, 3), x, y, z in voxels of this level from the grid's corner: (m, ...).

    Half a voxel from the border inwards the outermost voxels hold; outside it is nothing.
    """
    level, points = np.asarray(level, dtype=np.float64), np.asarray(points, dtype=np.float64)
    n = len(level)
    at = np.clip(points - 0.5, 0.0, n - 1.0)
    lower = np.minimum(at.astype(np.int64), n - 2)
    f = at - lower
    result = np.zeros((len(points), *level.shape[3:]))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (lower + corner).T
        weight = np.where(corner, f, 1.0 - f).prod(axis=1)
        result += weight.reshape(-1, *(1,) * (result.ndim - 1)) * level[z, y, x]
    inside = ((points >= 0.0) & (points <= n)).all(axis=1)
    return np.where(inside.reshape(-1, *(1,) * (result.ndim - 1)), result, 0.0)


def sample_levels(levels: Sequence[np.ndarray], points, level) -> np.ndarray:
    """Quadrilinear values (VCT 5.6): between the two levels around `level` (m,), a real number. points: in voxels of
    level 0."""
    points = np.asarray(points, dtype=np.float64)
    level = np.clip(np.asarray(level, dtype=np.float64), 0.0, len(levels) - 1.0)
    each = [sample(values, points / 2.0**i) for i, values in enumerate(levels)]
    weights = [np.maximum(1.0 - np.abs(level - i), 0.0) for i in range(len(levels))]
    shape = (-1, *(1,) * (each[0].ndim - 1))
    return np.sum([w.reshape(shape) * e for w, e in zip(weights, each, strict=True)], axis=0)
