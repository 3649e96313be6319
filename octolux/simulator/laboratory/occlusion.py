"""Fuzzy occlusion: the geometry volume and what it lets through (Kaplanyan & Dachsbacher 2010, 3.2 and 3.3).

The geometry volume holds blocking probabilities B(w) as SH. Its cells are centred on the corners of the light's cells:
[z][y][x][4] with n + 1 along each side, corner (x, y, z) at that many cells from the origin. Light that goes from a
cell to a neighbour is attenuated by 1 - B(w), B interpolated where the way crosses between the two: halfway. For
the six neighbours that is the centre of the shared face, the mean of its four corners.

B(w) = A/s^2 <n|w>+ blocks light that travels along n, at most 3/4 of it in two bands: for a surface to be opaque it
takes A/s^2 = 4/3.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from octolux.simulator import sh as harmonics

if TYPE_CHECKING:
    from .propagators import Propagator


def coarser(corners: np.ndarray) -> np.ndarray:
    """The geometry volume of the next coarser level: (n + 1)^3 corners to (n/2 + 1)^3, [z][y][x][4].

    Blocking is blocking area over s^2. A coarse corner lies on every second fine one and takes the area around it: fine
    corners between two coarse ones give half to each, along each axis. s^2 is 4 times as large, so the sum is divided
    by 4: a plane of corners that blocks b still blocks b in total.
    """
    for axis in range(3):
        moved = np.moveaxis(corners, axis, 0)
        result = moved[::2].copy()
        result[:-1] += 0.5 * moved[1::2]
        result[1:] += 0.5 * moved[1::2]
        corners = np.moveaxis(result, 0, axis)
    return corners / 4.0


def levels(corners: np.ndarray, count: int) -> tuple[np.ndarray, ...]:
    """The geometry octree of `count` levels whose level 0 is `corners`."""
    result = [corners]
    for _ in range(count - 1):
        result.append(coarser(result[-1]))
    return tuple(result)


def halfway(corners: np.ndarray, offset: np.ndarray) -> np.ndarray:
    """B [z][y][x][4] halfway from each cell to its neighbour at `offset` (x, y, z), each -1, 0 or 1; `corners` are one
    more along each side."""
    for axis, step in enumerate(offset[::-1]):
        low, high = np.moveaxis(corners, axis, 0)[:-1], np.moveaxis(corners, axis, 0)[1:]
        here = 0.5 * (low + high) if step == 0 else high if step > 0 else low
        corners = np.moveaxis(here, 0, axis)
    return corners


def transmittance(corners: np.ndarray, propagator: Propagator) -> np.ndarray:
    """Share of the light that passes from each cell along each of the propagator's L links: [z][y][x][L], in [0, 1];
    `corners` [z][y][x][4] are one more along each side."""
    result = np.empty((*(size - 1 for size in corners.shape[:3]), len(propagator.offsets)))
    basis = harmonics.basis(propagator.directions)
    for offset in np.unique(propagator.offsets, axis=0):
        links = np.flatnonzero((propagator.offsets == offset).all(axis=1))
        result[..., links] = 1.0 - np.clip(halfway(corners, offset) @ basis[links].T, 0.0, 1.0)
    return result
