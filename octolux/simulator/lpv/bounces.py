"""Further bounces: what blockers take from the light that travels, they reflect at once (CLPV 7).

Kaplanyan & Dachsbacher 2010, 7 look up the geometry volume one cell ahead of the step, take B(-w_c) of it as the light
that the blockers there receive, and put B(w) times the reflected intensity into the destination cell. Ours keeps the
idea and differs in four things:

- Flux. B scales light that has been handed on already, so light would be both reflected and let through. Here
  only what a face has blocked in the step (geometry.py, `face_transmittance`) is reflected, times an albedo of at most
  1: received + reflected + absorbed is what was sent, whatever the volumes hold.
- Place. Blockers are those at the cell's eight corners, where the geometry volume, half a cell aside, has its cells,
  and not one point a cell ahead: all that a cell's faces block lies there, so that blockers that reflect everything
  lose nothing. Those behind, at the face through which light came in, face it only where it has leaked through them.
- Direction. Our geometry volume holds shares of the cross section along three axes, not an SH lobe (geometry.py says
  why), so what is reflected is a cosine lobe along one of six directions. Light that meets a side face s while it
  travels along d is blocked by shares.w, w = (2 d + s) / sqrt(5): the part b_s / sqrt(5) is met by surfaces across s
  and goes back along -s, the rest by surfaces across d and goes back along -d.
- Sides. Blockers of closed objects are met from their front: of the share b of a cell that is blocked along an axis,
  min(p, b) is the front of surfaces that face the light, p their share, and reflects. The rest is back faces: it
  absorbs.

The first step after injection has no occlusion (CLPV 3.3), and so no reflection either: nothing is blocked, and light
that is let through whole cannot be reflected besides.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.environment import LUMINANCE
from octolux.simulator.lpv import transfer

BOUNCES = ("none", "mono", "spectral")

LOBES = harmonics.cosine_lobe(-transfer.DIRECTIONS.astype(np.float64)) / pi
"""Coefficients of one unit of flux reflected at each of the faces in the order of DIRECTIONS, into the cell: (6, 4)."""


def reflectors(facing, albedo) -> np.ndarray:
    """What the step's pre-pass reads of a geometry volume's cells, as reflectors.py makes it: float64 (..., 3, 4).

    facing: (..., 6) shares of the cell's cross section covered by surfaces that face +x, -x, +y, -y, +z, -z.
    albedo: (..., 3), their mean; its luminance lies beside it.
    """
    facing, albedo = np.asarray(facing, dtype=np.float64), np.asarray(albedo, dtype=np.float64)
    packed = np.zeros((*facing.shape[:-1], 12))
    packed[..., :6], packed[..., 8:11] = facing, albedo
    packed[..., 11] = albedo @ np.asarray(LUMINANCE)
    return packed.reshape(*facing.shape[:-1], 3, 4)


def corner_sum(cells: np.ndarray) -> np.ndarray:
    """Sum of the geometry volume's cells (n, n, n, ...), half a cell aside, at the eight corners of each cell."""
    padded = np.pad(cells, [(1, 0)] * 3 + [(0, 0)] * (cells.ndim - 3))
    for axis in range(3):
        lined = np.moveaxis(padded, axis, 0)
        padded = np.moveaxis(lined[:-1] + lined[1:], 0, axis)
    return padded


def cell_reflectance(reflectors, shares, spectral: bool) -> np.ndarray:
    """Of what the blockers around each cell take from light in it, the share that they reflect: float64 (n, n, n, 6, 1
    or 3), [z][y][x][travel][channel] for light that travels along each of transfer.DIRECTIONS.

    reflectors: (n, n, n, 3, 4) as above and shares: (n, n, n, 3), on a grid that lies half a cell aside. All that the
    cell's faces block lies at its eight corners: the sum over them of what reflects, over that of what blocks.
    """
    reflectors, shares = np.asarray(reflectors, dtype=np.float64), np.asarray(shares, dtype=np.float64)
    albedo = np.minimum(reflectors[..., 2, :3] if spectral else reflectors[..., 2, 3:], 1.0)
    facing = reflectors[..., :2, :].reshape(*shares.shape[:3], 8)
    blocked = corner_sum(shares)
    result = []
    for travel in range(6):
        front = np.minimum(facing[..., travel ^ 1], shares[..., travel // 2])  # along +x light meets what faces -x
        total = blocked[..., travel // 2, None]
        reflecting = corner_sum(front[..., None] * albedo)
        result.append(np.where(total > 0.0, reflecting / np.where(total > 0.0, total, 1.0), 0.0))
    return np.stack(result, axis=3)


def at_faces(lower: np.ndarray, axis: int, upper: bool) -> np.ndarray:
    """Of numbers [z][y][x][axis]... of lower faces, (n + 1) along each side, those of each cell's face at an end."""
    n = lower.shape[0] - 1
    x, y, z = (slice(int(upper and a == axis), n + int(upper and a == axis)) for a in range(3))
    return lower[z, y, x, axis]


def reflected(arrived: np.ndarray, faces: np.ndarray, reflectance: np.ndarray) -> np.ndarray:
    """What blockers send back into each cell in a step: coefficients [z][y][x][channel][4].

    arrived: flux [z][y][x][channel][travel][face] at the faces of each cell, before any is blocked.
    faces: geometry.face_transmittance.  reflectance: `cell_reflectance`.
    """
    back = np.zeros((*arrived.shape[:4], 6))
    for travel in range(6):
        for number, face in enumerate(transfer.FACES[travel]):
            axis, upper = int(face) // 2, int(face) % 2 == 0  # DIRECTIONS: +x -x +y ...
            passing = at_faces(faces, axis, upper)
            blocked = 1.0 - passing[..., travel // 2]
            straight = np.minimum((1.0 - passing[..., axis]) / sqrt(5.0), blocked) if number else blocked
            back[..., face] += arrived[..., travel, number] * straight[..., None]
            back[..., travel] += arrived[..., travel, number] * (blocked - straight)[..., None]
    return (back * np.moveaxis(reflectance, 3, 4)) @ LOBES
