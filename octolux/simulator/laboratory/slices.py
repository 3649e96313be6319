"""A slice through a volume as geometry: the polar curve of every cell, and the borders between levels (OLPV 5.1).

In-plane coordinates are cells of level 0. The axes (u, v) of the picture are (x, y) for a slice across z, (x, z) across
y and (z, y) across x: u to the right, v up.
"""

from __future__ import annotations

from math import log1p, pi

import numpy as np

from octolux.simulator import sh as harmonics

from .errors import SimulationError
from .injectors import AXES as AXES

SCALES = ("linear", "log")
DECADES = 4.0
"""Of intensity that the logarithmic scale shows: 10^-4 of the largest is a visible dot."""

SAMPLES = 48
"""Points along a curve."""

_PLANES = {"x": (2, 1), "y": (0, 2), "z": (0, 1)}


def plane_names(axis: str) -> tuple[str, str]:
    """Names of the picture's axes u and v for a slice across `axis`. Raises SimulationError."""
    if axis not in _PLANES:
        raise SimulationError(f"the axis of a slice is '{axis}'", f"give one of {', '.join(AXES)}")
    u, v = _PLANES[axis]
    return AXES[u], AXES[v]


def cut(volume: np.ndarray, axis: str, index: int) -> np.ndarray:
    """Plane `index` of `volume` [z][y][x]... across `axis`, as [v][u]...: a cell of level 0 picks the cell of a coarser
    level that it lies in by index * m / n beforehand. Raises SimulationError."""
    u, v = (AXES.index(name) for name in plane_names(axis))
    m = volume.shape[0]
    if isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < m:
        raise SimulationError(f"there is no slice {index!r}", f"give 0 to {m - 1}")
    place = [AXES[::-1].index(name) for name in (axis, AXES[v], AXES[u])]
    return np.moveaxis(volume, place, [0, 1, 2])[index]


def directions(axis: str, samples: int = SAMPLES) -> np.ndarray:
    """Unit directions (samples, 3) around the circle in the plane across `axis`, from u towards v."""
    u, v = (AXES.index(name) for name in plane_names(axis))
    angle = np.arange(samples) * (2.0 * pi / samples)
    result = np.zeros((samples, 3))
    result[:, u], result[:, v] = np.cos(angle), np.sin(angle)
    return result


def radii(intensity: np.ndarray, largest: float, scale: str = "linear", zoom: float = 1.0) -> np.ndarray:
    """Lengths in units of half a cell for `intensity`, of the same sign and at most 1: `largest` over `zoom` gives 1.

    "log": log(1 + 10^4 I/largest) / log(1 + 10^4), which is linear near 0. Raises SimulationError.
    """
    if scale not in SCALES:
        raise SimulationError(f"the scale is '{scale}'", f"give one of {', '.join(SCALES)}")
    if not largest > 0.0:
        return np.zeros_like(intensity)
    share = np.clip(intensity * (zoom / largest), -1.0, 1.0)
    if scale == "linear":
        return share
    return np.sign(share) * np.log1p(10.0**DECADES * np.abs(share)) / log1p(10.0**DECADES)


def polar_curves(
    plane: np.ndarray, axis: str, cell: float = 1.0, scale: str = "linear", zoom: float = 1.0,
    largest: float | None = None, samples: int = SAMPLES,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Closed curves (K, samples, 2) in (u, v) of the K cells of `plane` [v][u][4] that hold light, and which of their
    points (K, samples) are negative.

    The point in direction d is |I(d)|, scaled, from the centre of the cell; cells are `cell` wide. largest: intensity
    that fills a cell; by default the largest of the plane.
    """
    around = directions(axis, samples)
    lit = np.argwhere(plane.any(axis=-1))
    intensity = plane[tuple(lit.T)] @ harmonics.basis(around).T
    top = largest if largest is not None else float(np.abs(intensity).max(initial=0.0))
    length = 0.5 * cell * radii(intensity, top, scale, zoom)
    u, v = (AXES.index(name) for name in plane_names(axis))
    centres = (lit[:, ::-1] + 0.5) * cell
    return centres[:, None, :] + np.abs(length)[..., None] * around[:, (u, v)], intensity < 0.0


def level_borders(index: np.ndarray) -> np.ndarray:
    """Segments (K, 2, 2), ends in (u, v), between cells of `index` [v][u] that are read from different levels."""
    v, u = np.nonzero(index[:, 1:] != index[:, :-1])
    upright = np.stack([np.stack([u + 1, v], -1), np.stack([u + 1, v + 1], -1)], axis=1)
    v, u = np.nonzero(index[1:] != index[:-1])
    level = np.stack([np.stack([u, v + 1], -1), np.stack([u + 1, v + 1], -1)], axis=1)
    return np.concatenate([upright, level]).astype(np.float64)
