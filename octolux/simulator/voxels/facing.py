"""Pyramids of what looks along each of six ways: one-sided opacity and radiance, for cones (cones.py).

The thesis blocks along x, y and z alike from both sides (VCT 5.4.3). A floor then hides the sky from every point on it:
a cone that leaves it at 60 degrees is as wide as it is high, so the filtered floor reaches into it on every level. Here
what faces +y blocks what goes down, and nothing that goes up. A ray through air meets no back of a closed body before
its front, and both sides of a sheet are there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .pyramid import sample
from .surfaces import DIRECTIONS


def _front_and_back(values: np.ndarray, way: int) -> tuple[np.ndarray, np.ndarray]:
    """Of each two voxels along an axis that which lies further along DIRECTIONS[way], and the other."""
    index = [slice(None)] * 3
    halves = []
    for first in (1, 0) if way % 2 == 0 else (0, 1):
        index[2 - way // 2] = slice(first, None, 2)
        halves.append(values[tuple(index)])
    return halves[0], halves[1]


def _across(values: np.ndarray, way: int) -> np.ndarray:
    """Means of 2 x 2 voxels across an axis."""
    for axis in (i for i in range(3) if i != 2 - way // 2):
        shape = values.shape
        values = values.reshape(*shape[:axis], shape[axis] // 2, 2, *shape[axis + 1 :]).mean(axis=axis + 1)
    return values


def coarser(facing, intensity) -> tuple[np.ndarray, np.ndarray]:
    """The next level of `facing` [z][y][x][6] and of `intensity` [z][y][x][6][k], which is radiance times facing.

    Of each way the maximum along its axis, then the mean across (VCT 5.4.3). Radiance is what is seen from the front:
    the voxel behind counts for what the one in front lets through; times the maximum, so that what shines evenly shines
    as evenly from every level.
    """
    facings, intensities = [], []
    for way in range(6):
        front, back = _front_and_back(facing[..., way], way)
        near, far = _front_and_back(intensity[..., way, :], way)
        seen = front + (1.0 - front) * back
        most = np.maximum(front, back)
        share = np.where(seen > 0.0, most / np.where(seen > 0.0, seen, 1.0), 0.0)
        facings.append(_across(most, way))
        intensities.append(_across((near + (1.0 - front)[..., None] * far) * share[..., None], way))
    return np.stack(facings, axis=-1), np.stack(intensities, axis=-2)


class FacingVoxels:
    """A pyramid that cones read: cones.Read, between levels quadrilinear (VCT 5.6).

    facing: [z][y][x][6], share of the section that looks along each of DIRECTIONS; intensity: [z][y][x][6][k], radiance
    times facing. Both of level 0, cubes of 2^depth; the coarsest level has 2^3 voxels.
    """

    def __init__(self, facing, intensity):
        level = (np.asarray(facing, dtype=np.float64), np.asarray(intensity, dtype=np.float64))
        self.levels = [level]
        while len(level[0]) > 2:
            level = coarser(*level)
            self.levels.append(level)
        self.n = len(self.levels[0][0])

    def __call__(self, points, level, towards) -> tuple[np.ndarray, np.ndarray]:
        points, towards = np.asarray(points, dtype=np.float64), np.asarray(towards, dtype=np.float64)
        level = np.clip(np.broadcast_to(level, len(points)), 0.0, len(self.levels) - 1.0)
        radiance, opacity = np.zeros((len(points), self.levels[0][1].shape[-1])), np.zeros(len(points))
        for i, values in enumerate(self.levels):
            r = np.nonzero(np.abs(level - i) < 1.0)[0]
            weight = 1.0 - np.abs(level[r] - i)
            found = _met(values, points[r] / 2.0**i, towards[r])
            radiance[r] += weight[:, None] * found[0]
            opacity[r] += weight * found[1]
        return radiance, opacity


def _met(level: Sequence[np.ndarray], points: np.ndarray, towards: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A way of one edge along d crosses |d_a| of the sections across each axis a, of what looks against it."""
    against = np.maximum(-towards @ DIRECTIONS.T, 0.0)
    facing, intensity = sample(level[0], points), sample(level[1], points)
    return np.einsum("mf,mfk->mk", against, intensity), np.einsum("mf,mf->m", against, facing)
