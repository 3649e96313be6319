"""What makes four corners a quadrilateral that an area light can be."""

from __future__ import annotations

import numpy as np

PLANARITY = 1e-3
"""How far a corner may lie out of the others' plane, as a share of the quadrilateral's size."""


def flaw(corners) -> tuple[str, str] | None:
    """What is wrong with `corners` (4, 3), and what to do about it, or None: out of plane, or not convex.

    Corners that coincide, or enclose no area at all, are no flaw: such a light has no flux, or is a triangle.
    """
    points = np.asarray(corners, dtype=np.float64)
    a, b, c, d = points
    size = max(float(np.linalg.norm(c - a)), float(np.linalg.norm(d - b)))
    normal = np.cross(c - a, d - b)  # twice the area
    length = float(np.linalg.norm(normal))
    if length <= 1e-9 * size**2:
        return None
    if abs((b - a) @ normal) > PLANARITY * size * length:
        return "do not lie in one plane", "Use two area lights, or move a corner"
    edges = np.roll(points, -1, axis=0) - points
    turns = np.cross(edges, np.roll(edges, -1, axis=0)) @ normal / length
    if turns.min() < -PLANARITY * size**2:
        return "are those of a shape that is not convex", "Give them in order around it, or use two area lights"
    return None
