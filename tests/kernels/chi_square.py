"""Chi-square tests of sampled directions and points against their densities (Pearson 1900)."""

from __future__ import annotations

from math import pi

import numpy as np
from scipy import stats

TOGETHER = 1e-3
"""Significance of all tests of a file together: each is given this over their number (Bonferroni)."""


def p_value(counts: np.ndarray, probabilities: np.ndarray, fewest: float = 10.0) -> float:
    """Of counts (k,) of independent draws; probabilities (k,), sum 1. Bins that expect fewer draws are put together."""
    counts, expected = counts.ravel(), probabilities.ravel() * counts.sum()
    few = expected < fewest
    counts, expected = np.r_[counts[~few], counts[few].sum()], np.r_[expected[~few], expected[few].sum()]
    assert expected[-1] > 0 or counts[-1] == 0, "drawn where the density is 0"
    there = expected > 0
    return float(stats.chisquare(counts[there], expected[there] * counts.sum() / expected.sum()).pvalue)


class HemisphereBins:
    """Bins even in t = sqrt(1 - n.w) and in azimuth, n = +z, and a last one for the other hemisphere; `fine` points
    across a bin. t goes with the angle at the pole: narrow lobes there are resolved."""

    def __init__(self, rows: int = 16, columns: int = 32, fine: int = 16):
        self.rows, self.columns, self.fine = rows, columns, fine

    def _steps(self) -> np.ndarray:
        return (np.arange(self.rows * self.fine) + 0.5) / (self.rows * self.fine)

    def counts(self, directions: np.ndarray) -> np.ndarray:
        """(rows * columns + 1,) of unit vectors (n, 3)."""
        row = np.minimum((np.sqrt(np.clip(1.0 - directions[:, 2], 0.0, 1.0)) * self.rows).astype(int), self.rows - 1)
        turn = np.arctan2(directions[:, 1], directions[:, 0]) / (2.0 * pi)
        column = ((turn - np.floor(turn)) * self.columns).astype(int) % self.columns
        number = np.where(directions[:, 2] < 0, self.rows * self.columns, row * self.columns + column)
        return np.bincount(number, minlength=self.rows * self.columns + 1)

    def points(self) -> np.ndarray:
        """Where densities are wanted: unit vectors (m, 3), the midpoints of the bins' parts."""
        cosine = 1.0 - self._steps() ** 2
        turn = (np.arange(self.columns * self.fine) + 0.5) / (self.columns * self.fine) * 2.0 * pi
        c, a = np.meshgrid(cosine, turn, indexing="ij")
        s = np.sqrt(1.0 - c * c)
        return np.stack([s * np.cos(a), s * np.sin(a), c], axis=-1).reshape(-1, 3)

    def probabilities(self, densities: np.ndarray) -> np.ndarray:
        """(rows * columns + 1,) from densities (m,), 1/sr, at `points`; what they leave of 1 is below."""
        weighted = densities.reshape(self.rows * self.fine, -1) * 2.0 * self._steps()[:, None]  # d(1 - t^2) = 2 t dt
        parts = weighted.reshape(self.rows, self.fine, self.columns, self.fine).mean(axis=(1, 3))
        inside = parts.ravel() * 2.0 * pi / (self.rows * self.columns)
        return np.r_[inside, max(1.0 - inside.sum(), 0.0)]
