"""Large groups of point lights: sparks, fireflies, the particles of an effect."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from .errors import SceneError

MOST_PARTICLES = 1 << 20
"""Of one group: 32 MiB on the device."""

_LARGEST = 1e30
"""float32 holds 3.4e38; this leaves room for factors."""


@dataclass(frozen=True, kw_only=True, eq=False)
class ParticleLights:
    """Many points that shine alike in all directions, without shadow maps of their own.

    positions: (N, 3), metres.  intensities: (N, 3), or one rgb (3,) for all, candela. Both are copied, and kept as
    float64 (N, 3) that cannot be written to: make another group to change it (`dataclasses.replace`).
    Raises SceneError for other shapes, more than MOST_PARTICLES, numbers that are not finite or above 1e30, and
    negative intensities.
    """

    positions: np.ndarray
    intensities: np.ndarray
    name: str = ""

    def __post_init__(self) -> None:
        positions = self._numbers("positions", self.positions)
        if positions.ndim != 2 or positions.shape[1] != 3:
            raise self._error("positions", f"have the shape {positions.shape}", "give (N, 3), metres")
        if len(positions) > MOST_PARTICLES:
            raise self._error("positions", f"are {len(positions):,}", f"give at most {MOST_PARTICLES:,} to a group")
        intensities = self._numbers("intensities", self.intensities)
        if intensities.shape not in ((3,), positions.shape):
            raise self._error("intensities", f"have the shape {intensities.shape}",
                              f"give {positions.shape}, or (3,) for all alike, candela")
        if (intensities < 0).any():
            raise self._error("intensities", f"hold {intensities.min():g}", "give candela from 0")
        for key, values in (("positions", positions), ("intensities", intensities)):
            values = np.array(np.broadcast_to(values, positions.shape))
            values.setflags(write=False)
            object.__setattr__(self, key, values)

    def moved(self, matrix: np.ndarray) -> ParticleLights:
        """The group, its points led through `matrix`, float64 (4, 4). Light keeps its intensity."""
        return replace(self, positions=self.positions @ matrix[:3, :3].T + matrix[:3, 3])

    def _numbers(self, key: str, given: Any) -> np.ndarray:
        try:
            values = np.asarray(given, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise self._error(key, "are no array of numbers", "give rows of three numbers") from error
        if not (np.abs(values) <= _LARGEST).all():
            raise self._error(key, "hold a number that is not finite, or too large",
                              f"give numbers from {-_LARGEST:g} to {_LARGEST:g}")
        return values

    def _error(self, key: str, problem: str, remedy: str) -> SceneError:
        name = f"ParticleLights '{self.name}'" if self.name else "ParticleLights"
        return SceneError(name, key, problem, remedy)
