"""Participating media: fog, haze or smoke in a box. Plain data, no GPU."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .errors import SceneError
from .lights import Vector
from .materials import Color

MOST_CELLS = 2048
"""Along an edge of a density: as many as every device's 3D textures have."""

FARTHEST = 1e9
"""Metres from the origin to a box's faces: squares of distances are then far within float32."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Medium:
    """What scatters and absorbs light inside a box, outside of which the air is clear. It scatters alike in all
    directions (CLPV 7).

    scattering, absorption: 1/m, for red, green and blue.  density: float32 (z, y, x), not negative, multiplies both;
    its first cell lies at `low`, and between the cells' centres it is interpolated; None for 1 everywhere.
    low, high: corners of the box, metres; None, which a density may not have, for the scene's.

    Raises SceneError: a number that is negative or not finite, a density of another type or shape, an empty box.
    """

    scattering: Color = (0.0, 0.0, 0.0)
    absorption: Color = (0.0, 0.0, 0.0)
    density: np.ndarray | None = None
    low: Vector | None = None
    high: Vector | None = None

    def __post_init__(self) -> None:
        for name in ("scattering", "absorption"):
            self._check_coefficients(name, getattr(self, name))
        if self.density is not None:
            self._check_density(self.density)
        self._check_box()

    @property
    def extinction(self) -> np.ndarray:
        """float64 (3,), 1/m: scattering and absorption together, where the density is 1."""
        return np.add(self.scattering, self.absorption, dtype=np.float64)

    @staticmethod
    def _check_coefficients(name: str, values: Color) -> None:
        if np.shape(values) != (3,):
            raise _fault(name, f"has the shape {np.shape(values)}", "give three numbers, 1/m for red, green and blue")
        for value in values:
            if not 0.0 <= value < np.inf:
                raise _fault(name, f"holds {value:g}", "give finite numbers from 0 on, 1/m")

    @staticmethod
    def _check_density(density: np.ndarray) -> None:
        if density.dtype != np.float32 or density.ndim != 3 or 0 in density.shape:
            raise _fault("density", f"is {density.dtype} {density.shape}", "give a float32 array (z, y, x)")
        if max(density.shape) > MOST_CELLS:
            raise _fault("density", f"has the shape {density.shape}", f"give at most {MOST_CELLS} cells along an edge")
        if not (np.isfinite(density).all() and density.min() >= 0.0):
            raise _fault("density", "holds a number that is negative or not finite", "give finite numbers from 0 on")

    def _check_box(self) -> None:
        if self.low is None or self.high is None:
            if self.low is not self.high or self.density is not None:
                missing = "low" if self.low is None else "high"
                raise _fault(missing, "is missing", "give both corners of the box that the medium fills")
            return
        corners = np.array([self.low, self.high], np.float64)
        if corners.shape != (2, 3) or not np.isfinite(corners).all() or not (corners[0] < corners[1]).all():
            problem = f"the box from {tuple(self.low)} to {tuple(self.high)} is empty or not finite"
            raise _fault("high", problem, "give three numbers, each larger than that of 'low'")
        if np.abs(corners).max() > FARTHEST:
            raise _fault("high", f"the box reaches beyond {FARTHEST:g} m", "give a smaller box")


def _fault(place: str, problem: str, remedy: str) -> SceneError:
    return SceneError("medium", place, problem, remedy)
