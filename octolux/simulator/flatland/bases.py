"""Intensity as a function of direction in the plane: circular harmonics, or one number for each of n directions.

Directions are angles in radians, from +x towards +y. The last axis of an array of coefficients is the basis.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import pi, sqrt
from typing import Protocol

import numpy as np

LOBE_FLUX = 2.0
"""Integral of max(0, cos t) over the circle: a surface of flux Phi has intensity Phi/2 max(0, cos t)."""


class Basis(Protocol):
    """What propagation needs to know of a basis."""

    @property
    def size(self) -> int:
        """Coefficients of a cell."""

    @property
    def label(self) -> str:
        """Its name in tables."""

    def evaluate(self, angles) -> np.ndarray:
        """Weights (..., size) of the coefficients in the intensity at `angles` (...)."""

    def integral(self, begin, end) -> np.ndarray:
        """Weights (..., size) of the coefficients in the integral of the intensity from `begin` to `end` (...)."""

    def uniform(self, begin: float, end: float) -> np.ndarray:
        """Coefficients (size,) of unit flux, spread evenly over the directions from `begin` to `end`."""

    def cosine_lobe(self, angle: float) -> np.ndarray:
        """Coefficients (size,) of max(0, cos(t - angle)), whose flux is 2."""


@dataclass(frozen=True)
class Harmonics:
    """The orthonormal functions 1/sqrt(2 pi), cos(k t)/sqrt(pi), sin(k t)/sqrt(pi) for k below `bands`.

    Two bands are what the paper calls two SH bands: three coefficients in the plane. Raises ValueError below 1.
    """

    bands: int

    def __post_init__(self) -> None:
        if self.bands < 1:
            raise ValueError(f"circular harmonics have at least 1 band, not {self.bands}")

    @property
    def size(self) -> int:
        return 2 * self.bands - 1

    @property
    def label(self) -> str:
        return f"{self.bands} band{'s' if self.bands > 1 else ''}"

    @property
    def _orders(self) -> np.ndarray:
        return np.arange(1, self.bands)

    def _joined(self, constant: np.ndarray, cosines: np.ndarray, sines: np.ndarray) -> np.ndarray:
        both = np.stack([cosines, sines], axis=-1).reshape(*constant.shape, self.size - 1)
        return np.concatenate([constant[..., None] / sqrt(2.0 * pi), both / sqrt(pi)], axis=-1)

    def evaluate(self, angles) -> np.ndarray:
        angles = np.asarray(angles, dtype=np.float64)
        phase = angles[..., None] * self._orders
        return self._joined(np.ones_like(angles), np.cos(phase), np.sin(phase))

    def integral(self, begin, end) -> np.ndarray:
        begin, end = np.broadcast_arrays(np.asarray(begin, np.float64), np.asarray(end, np.float64))
        k = self._orders
        cosines = (np.sin(k * end[..., None]) - np.sin(k * begin[..., None])) / k
        sines = (np.cos(k * begin[..., None]) - np.cos(k * end[..., None])) / k
        return self._joined(end - begin, cosines, sines)

    def uniform(self, begin: float, end: float) -> np.ndarray:
        return self.integral(begin, end) / (end - begin)

    def cosine_lobe(self, angle: float) -> np.ndarray:
        # The integral of cos t cos k t over the half circle: pi/2 for k = 1, 0 for the other odd k, else this.
        k = np.arange(self.bands)
        even = np.where(k % 4 == 0, -2.0, 2.0) / np.where(k == 1, 1.0, k**2 - 1.0)
        moments = np.where(k == 1, pi / 2.0, np.where(k % 2 == 1, 0.0, even))
        return np.repeat(moments, 2)[1:] * self.evaluate(angle)


@dataclass(frozen=True)
class Sectors:
    """One intensity for each of `count` equal sectors, the first around +x: the ordinates of plain discrete ordinates.

    Raises ValueError below 1.
    """

    count: int

    def __post_init__(self) -> None:
        if self.count < 1:
            raise ValueError(f"there is at least 1 sector, not {self.count}")

    @property
    def size(self) -> int:
        return self.count

    @property
    def label(self) -> str:
        return f"{self.count} ordinates"

    @property
    def _width(self) -> float:
        return 2.0 * pi / self.count

    def evaluate(self, angles) -> np.ndarray:
        nearest = np.rint(np.asarray(angles, dtype=np.float64) / self._width).astype(int) % self.count
        return np.eye(self.count)[nearest]

    def integral(self, begin, end) -> np.ndarray:
        begin, end = np.asarray(begin, np.float64)[..., None], np.asarray(end, np.float64)[..., None]
        return self._below(end) - self._below(begin)

    def _below(self, angle: np.ndarray) -> np.ndarray:
        """Length of each sector between a multiple of the circle and `angle`: grows by a width each turn."""
        start = (np.arange(self.count) - 0.5) * self._width
        turns, rest = np.divmod(angle - start, 2.0 * pi)
        return turns * self._width + np.minimum(rest, self._width)

    def uniform(self, begin: float, end: float) -> np.ndarray:
        return self.integral(begin, end) / (self._width * (end - begin))

    def cosine_lobe(self, angle: float) -> np.ndarray:
        middle = np.arange(self.count) * self._width - angle
        return (_lobe_below(middle + self._width / 2.0) - _lobe_below(middle - self._width / 2.0)) / self._width


def _lobe_below(angle: np.ndarray) -> np.ndarray:
    """Antiderivative of max(0, cos t): 2 more each turn, sin between -pi/2 and pi/2, constant between."""
    turns, rest = np.divmod(angle + pi / 2.0, 2.0 * pi)
    return 2.0 * turns + np.where(rest < pi, 1.0 - np.cos(rest), 2.0)
