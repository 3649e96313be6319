"""What makes four corners a quadrilateral that an area light can be."""

from __future__ import annotations

import numpy as np

PLANARITY = 1e-3
"""How far a corner may lie out of the others' plane, as a share of the quadrilateral's size."""


def flaw(corners) -> tuple[str, str] | None:
    """What is wrong with `corners` (4, 3), and what to do about it, or None: out of plane, or not convex.

    Corners that coincide, or all lie on one line, are no flaw: such a light is a triangle, or has no flux.
    """
    points = np.asarray(corners, dtype=np.float64)
    edges = np.roll(points, -1, axis=0) - points
    size = float(np.ptp(points, axis=0).max())
    bends = np.cross(edges, np.roll(edges, -1, axis=0))
    if np.linalg.norm(bends, axis=1).max() <= 1e-9 * size**2:
        return None
    normal = np.cross(points[2] - points[0], points[3] - points[1])  # twice the area
    length = max(float(np.linalg.norm(normal)), 1e-300)
    if abs(edges[0] @ normal) > PLANARITY * size * length:
        return "do not lie in one plane", "use two area lights, or move a corner"
    if length <= 1e-9 * size**2 or (bends @ normal).min() < -PLANARITY * size**2 * length:
        return "are not those of a convex shape", "give them in order around it, or use two area lights"
    return None
