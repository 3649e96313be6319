"""Pyramids of a dense grid of voxels, and trilinear reading: what bricks hold and return (VCT 3.6.3, 5.4.3).

Level 0 is the finest; a voxel of level i + 1 is made of the 2^3 of level i that it covers, down to 2^3 voxels. Values
belong to the middles of voxels.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def _pairs(values: np.ndarray, way: int) -> tuple[np.ndarray, np.ndarray]:
    """Of each two voxels along an axis the one that lies farther along DIRECTIONS[way], in front, and that behind."""
    lower: list[slice] = [slice(None)] * 3
    upper = list(lower)
    lower[2 - way // 2], upper[2 - way // 2] = slice(0, None, 2), slice(1, None, 2)
    front, behind = (upper, lower) if way % 2 == 0 else (lower, upper)
    return values[tuple(front)], values[tuple(behind)]


def _across(values: np.ndarray, way: int) -> np.ndarray:
    """Means of each 2 x 2 voxels across the axis of a way."""
    for axis in range(3):
        if axis != way // 2:
            values = 0.5 * np.add(*_pairs(values, 2 * axis))
    return values


def coarser_facing(facing) -> np.ndarray:
    """[z][y][x][6] of the next level from that of this one: of each way the maximum along its axis, then the mean over
    the 2 x 2 across (VCT 5.4.3).

    The thesis has one opacity for both ways along an axis. Here what looks along +y blocks what goes down: a floor does
    not hide the sky from what stands on it, wherever its coarse voxels reach.
    """
    return np.stack([_across(np.maximum(*_pairs(facing[..., w], w)), w) for w in range(6)], axis=-1)


def coarser_intensity(intensity, facing) -> np.ndarray:
    """Six axial intensities of the next level, [z][y][x][6][k], from those of this one and its `facing`.

    An intensity is radiance times what faces its way. The thesis weighs radiances with opacities (5.4.3); here what is
    behind counts for what the voxel in front of it lets through. The mean radiance times the coarser facing is the
    coarser intensity: so what shines evenly shines as evenly from every level.
    """
    result = []
    for way in range(6):
        front, behind = _pairs(intensity[..., way, :], way)
        in_front, hidden = _pairs(facing[..., way, None], way)
        seen = in_front + (1.0 - in_front) * hidden
        radiance = (front + (1.0 - in_front) * behind) / np.where(seen > 0.0, seen, 1.0)
        result.append(_across(radiance * np.maximum(in_front, hidden), way))
    return np.stack(result, axis=-2)


def facing_levels(facing) -> list[np.ndarray]:
    """float64 [z][y][x][6] on every level, from level 0, a cube of 2^depth along each side, to 2^3 voxels."""
    levels = [np.asarray(facing, dtype=np.float64)]
    while len(levels[-1]) > 2:
        levels.append(coarser_facing(levels[-1]))
    return levels


def intensity_levels(intensity, facings: Sequence[np.ndarray]) -> list[np.ndarray]:
    """float64 [z][y][x][6][k] on every level. facings: of the levels."""
    levels = [np.asarray(intensity, dtype=np.float64)]
    for facing in facings[:-1]:
        levels.append(coarser_intensity(levels[-1], facing))
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
