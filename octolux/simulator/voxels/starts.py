"""Where cones start, and how they keep off the surface that they start on (Drinovsky 2013, "VCT", 5.6).

Distance from the own surface. Cones start `offset` voxels above it. What a thin surface faces on its other side would
hide half of the hemisphere from a cone that leaves it: at every level grazing cones are lower above it than voxels are
wide. Samples are therefore lifted to CLEAR voxels of their level above the plane that their cone starts on, where they
read nothing of it.

Distance from other surfaces. A wall is a tent of one voxel to either side, and tents along a way add up to 1. A cone
that starts within a wall's tent has part of it behind: in a corner half of a wall lets through what is outside, or
dark, and its other half hides the room from cones that go away from it. On which side of the wall the start lies,
voxels do not tell, but the eye sees it: that is the side of the eye. So along each axis starts are moved towards the
eye, along their own surface, by what voxels hide of the way from it: 1 - d voxels for a wall d voxels away, to where
its tent ends.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from .screen import CLEAR

Read = Callable[[np.ndarray, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]
"""Of points (m, 3), in voxels of level 0, levels (m,) and unit directions (m, 3): radiance times opacity (m, k), and
opacity (m,), on a way as long as an edge of the level's voxels."""


class Plane(NamedTuple):
    """Of the surfaces that cones start on: unit normals (m, 3), and how far above it that is, voxels of level 0."""

    normals: np.ndarray
    height: float


def lifted(points, plane: Plane | None, travelled, towards, size, n: int) -> np.ndarray:
    """Points (m, 3), `travelled` voxels along `towards` from cones' starts, in a cube of n^3 voxels: CLEAR voxels of an
    edge of `size` above the plane, or as high as they are."""
    if plane is None:
        return points
    height = plane.height + travelled * np.sum(towards * plane.normals, axis=-1)
    lack = np.maximum(CLEAR * size * np.abs(plane.normals).sum(axis=-1) - height, 0.0)
    return np.clip(points + lack[:, None] * plane.normals, 0.0, n)


def cone_start(read: Read, depth: int, points, geometric, to_eye, offset: float) -> np.ndarray:
    """Of cones from points (m, 3) on surfaces of unit normals `geometric` (m, 3), voxels: (m, 3). to_eye: unit vectors
    (m, 3), or None where nobody looks, and other surfaces count for nothing.  offset: voxels above the surface."""
    geometric = np.asarray(geometric, dtype=np.float64)
    start = np.asarray(points, dtype=np.float64) + offset * geometric
    if to_eye is None:
        return start
    away, aside = -np.sign(np.asarray(to_eye, dtype=np.float64)), np.zeros_like(start)
    clear = lifted(start, Plane(geometric, offset), 0.0, geometric, 1.0, 2**depth)
    for axis in range(3):
        way = np.where(np.arange(3) == axis, away, 0.0)
        aside -= way * np.minimum(read(clear, np.zeros(len(start)), way)[1], 1.0)[:, None]
    return start + aside - geometric * np.sum(aside * geometric, axis=-1, keepdims=True)
