"""Solid angles and first moments of flat polygons, in closed form.

Both are what a point at the origin sees: the zeroth and the first moment of a face's visibility function
V(w) (Kaplanyan & Dachsbacher 2010, 3.3).
"""

from __future__ import annotations

import numpy as np


def rectangle_solid_angle(u_low, u_high, v_low, v_high, distance) -> np.ndarray:
    """Solid angle, steradian, of the rectangle [u_low, u_high] x [v_low, v_high] in the plane at `distance` > 0.

    All arguments broadcast and share one unit of length; u and v are measured from the foot of the perpendicular.
    The integral of distance / r^3 du dv has the antiderivative atan(u v / (distance sqrt(u^2 + v^2 + distance^2))).
    """

    def corner(u, v):
        return np.arctan(u * v / (distance * np.sqrt(u * u + v * v + distance * distance)))

    u_low, u_high, v_low, v_high, distance = (
        np.asarray(value, dtype=np.float64) for value in (u_low, u_high, v_low, v_high, distance)
    )
    return corner(u_high, v_high) - corner(u_low, v_high) - corner(u_high, v_low) + corner(u_low, v_low)


def polygon_moment(vertices) -> np.ndarray:
    """Integral of w dw (..., 3) over the directions in which the origin sees the polygon `vertices` (..., K, 3).

    Lambert's formula: half the sum over the edges of the angle an edge subtends times the unit normal of the plane
    through the edge and the origin (Lambert 1760; Baum, Rushmeier & Winget 1989, eq. 6). The vertices run
    counter-clockwise about the direction of sight, so they look clockwise from the origin; the other order gives the
    negative. Edges of no length, and edges whose line passes through the origin, add nothing, as they should.
    """
    vertices = np.asarray(vertices, dtype=np.float64)
    following = np.roll(vertices, -1, axis=-2)
    normals = np.cross(vertices, following)
    sine = np.linalg.norm(normals, axis=-1)
    angles = np.arctan2(sine, np.sum(vertices * following, axis=-1))
    scale = np.where(sine > 0.0, angles / np.where(sine > 0.0, sine, 1.0), 0.0)
    return 0.5 * np.sum(scale[..., None] * normals, axis=-2)
