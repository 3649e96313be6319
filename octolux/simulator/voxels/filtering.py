"""The mean over the tile of what pixels around received through other cones
(techniques/voxel_cones/cones/filter.wgsl)."""

from __future__ import annotations

from math import sin

import numpy as np

from ..gtao import LEAST_WEIGHT, TILE, Seen, taken
from .cones import half_angle

TURNED = 2.0 * sin(0.5 * half_angle(8))
"""Distance between unit normals from which a pixel is no neighbour: its cones lie beside the other's."""


def filtered(seen: Seen, raw, place, resolution: int = 1) -> np.ndarray:
    """Means (height, width, k) over windows of 4 x 4 pixels of `raw` (rows, columns, k), those in rows and columns
    gtao.taken, of what is alike: it falls linearly with the height over the pixel's tangent plane, to LEAST_WEIGHT at
    the width of a pixel of `raw`, and with the distance between the normals, to the same at TURNED.

    place: (rows, columns, 4), normals and depths that raw pixels belong to, of depth 0 where they have nothing. Where
    nothing is seen the result is 0.
    """
    height, width = seen.depth.shape
    rows, columns = taken(height, resolution), taken(width, resolution)
    y0, x0 = ((i + resolution // 2) // resolution - TILE // 2 for i in np.indices(seen.depth.shape))
    positions, wide = seen.positions(), resolution * np.linalg.norm(seen.pixel_extent()[0], axis=-1)
    total, weights = np.zeros((height, width, raw.shape[-1])), np.zeros((height, width, 1))
    for dy, dx in np.ndindex(TILE, TILE):
        y, x = np.clip(y0 + dy, 0, len(rows) - 1), np.clip(x0 + dx, 0, len(columns) - 1)
        there = (y == y0 + dy) & (x == x0 + dx) & (place[y, x, 3] > 0.0)
        off = np.abs(np.sum((positions[rows[y], columns[x]] - positions) * seen.geometric, axis=-1)) / wide
        turn = np.linalg.norm(place[y, x, :3] - seen.normal, axis=-1) / TURNED
        alike = np.maximum(1.0 - off, LEAST_WEIGHT) * np.maximum(1.0 - turn, LEAST_WEIGHT)
        weight = np.where(there, alike, 0.0)[..., None]
        total, weights = total + weight * raw[y, x], weights + weight
    return np.where(weights > 0.0, total / np.where(weights > 0.0, weights, 1.0), 0.0) * (seen.depth > 0.0)[..., None]
