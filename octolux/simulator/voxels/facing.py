"""A dense pyramid of what surfaces send along each of six ways, as cones read it (cones.py)."""

from __future__ import annotations

import numpy as np

from .pyramid import facing_levels, intensity_levels, sample
from .surfaces import DIRECTIONS


class FacingVoxels:
    """A cones.Read, between levels quadrilinear (VCT 5.6).

    facing: [z][y][x][6], share of the section that looks along each of DIRECTIONS; intensity: [z][y][x][6][k], radiance
    times facing. Both of level 0, cubes of 2^depth.
    """

    def __init__(self, facing, intensity):
        facings = facing_levels(facing)
        levels = zip(facings, intensity_levels(intensity, facings), strict=True)
        self.levels: list[tuple[np.ndarray, ...]] = list(levels)
        self.n = len(facings[0])

    def __call__(self, points, level, towards) -> tuple[np.ndarray, np.ndarray]:
        points, towards = np.asarray(points, dtype=np.float64), np.asarray(towards, dtype=np.float64)
        level = np.clip(np.broadcast_to(level, len(points)), 0.0, len(self.levels) - 1.0)
        radiance, opacity = np.zeros((len(points), self.levels[0][1].shape[-1])), np.zeros(len(points))
        for i, values in enumerate(self.levels):
            r = np.nonzero(np.abs(level - i) < 1.0)[0]
            weight = 1.0 - np.abs(level[r] - i)
            found = self.met(values, points[r] / 2.0**i, towards[r])
            radiance[r] += weight[:, None] * found[0]
            opacity[r] += weight * found[1]
        return radiance, opacity

    def met(self, level: tuple[np.ndarray, ...], points: np.ndarray, towards: np.ndarray):
        """Radiance times opacity, and opacity, at points in voxels of a level: a way of one edge along d crosses |d_a|
        of the sections across each axis a, of what looks against it."""
        against = np.maximum(-towards @ DIRECTIONS.T, 0.0)
        facing, intensity = sample(level[0], points), sample(level[1], points)
        return np.einsum("mf,mfk->mk", against, intensity), np.einsum("mf,mf->m", against, facing)
