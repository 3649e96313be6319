"""Constants of one propagation step: how the centre of a cell sees the faces of its six neighbours.

Lengths are in cells; the source centre is the origin. Light that travels along d enters the neighbour centred at d
and meets five of its faces: the far one, whose outward normal is d, and four side faces (Kaplanyan & Dachsbacher
2010, 3.3 and fig. 2; Olovsson 2012, 3.2.3). The face between the two cells is left out: through it, seen from
the source, lie exactly the five others, so the 30 faces of a step tile the sphere: their solid angles add to 4 pi.
"""

from __future__ import annotations

import numpy as np

from octolux.simulator.solid_angles import polygon_moment, rectangle_solid_angle

DIRECTIONS = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.int64)
"""Travel directions, and outward normals of a cell's faces, int64 (6, 3): +x -x +y -y +z -z."""


def _faces_met() -> np.ndarray:
    """Index into DIRECTIONS of the outward normal of each face, far face first, then the sides in order: (6, 5)."""
    sides = [[face for face in range(6) if face // 2 != travel // 2] for travel in range(6)]
    return np.array([[travel, *sides[travel]] for travel in range(6)])


def _face_vertices(centre: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Corners (4, 3) of the unit face around `centre`, counter-clockwise about `normal`."""
    axis = int(np.argmax(np.abs(normal)))
    u = np.eye(3)[(axis + 1) % 3]
    v = np.cross(normal, u)
    return centre + 0.5 * np.array([-u - v, u - v, u + v, v - u])


FACES = _faces_met()
"""Which of DIRECTIONS is the outward normal of face f met when travelling along d: int64 (6, 5). Face 0 is the far
face, faces 1 to 4 the sides in the order of DIRECTIONS."""

NORMALS = DIRECTIONS[FACES].astype(np.float64)
"""Outward normals of the faces, (6, 5, 3)."""

FACE_CENTRES = DIRECTIONS[:, None, :] + 0.5 * NORMALS
"""Centres of the faces from the source centre, (6, 5, 3), cells."""

CENTRE_DIRECTIONS = FACE_CENTRES / np.linalg.norm(FACE_CENTRES, axis=-1, keepdims=True)
"""Unit directions w_c from the source centre to the face centres, (6, 5, 3). Far: d; side: (2 d + n) / sqrt(5)."""

SOLID_ANGLE_FAR = float(rectangle_solid_angle(-0.5, 0.5, -0.5, 0.5, 1.5))
"""Solid angle of the far face, 1 x 1 at distance 1.5: 4 atan(1 / (3 sqrt(11))) = 0.400670 sr."""

SOLID_ANGLE_SIDE = float(rectangle_solid_angle(0.5, 1.5, -0.5, 0.5, 0.5))
"""Solid angle of a side face, 0.5 to 1.5 along d at distance 0.5: 0.423431 sr."""

SOLID_ANGLES = np.tile([SOLID_ANGLE_FAR, *[SOLID_ANGLE_SIDE] * 4], (6, 1))
"""Solid angles of the faces, (6, 5), sr; they add to 4 pi."""

MOMENTS = np.array(
    [
        [polygon_moment(_face_vertices(FACE_CENTRES[travel, face], NORMALS[travel, face])) for face in range(5)]
        for travel in range(6)
    ]
)
"""Integral of w dw over each face, (6, 5, 3), in closed form; they add to 0."""
