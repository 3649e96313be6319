"""The mean over the tile of what pixels around received through other cones
(techniques/voxel_cones/cones/filter.wgsl)."""

from __future__ import annotations

from math import sin

import numpy as np

from ..gtao import LEAST_WEIGHT, TILE, Seen, taken
from .directions import half_angle

TURNED = 2.0 * sin(0.5 * half_angle(8))
"""Distance between unit normals from which a pixel is no neighbour: its cones lie beside the other's."""


def filtered(seen: Seen, raw, place, resolution: int = 1, tile: int = TILE) -> np.ndarray:
    """Means (height, width, k) over tents that fall to zero `tile` pixels of `raw` (rows, columns, k) away, those in
    rows and columns gtao.taken, of what is alike: this falls linearly with the height over the pixel's tangent plane,
    to LEAST_WEIGHT at the width of a pixel of `raw`, and with the distance between the normals, to the same at TURNED.

    Pixels `tile` apart have the same phases. In such a tent each phase weighs the same, wherever the middle lies, and
    the mean of its places is that middle. So that light of a single phase changes more from pixel to pixel than that of
    all does not show as a weave, as it does in windows that have each phase once, wherever it may be.

    place: (rows, columns, 4), normals and depths that raw pixels belong to, of depth 0 where they have nothing. Where
    nothing is seen the result is 0.
    """
    height, width = seen.depth.shape
    rows, columns = taken(height, resolution), taken(width, resolution)
    own = np.indices(seen.depth.shape)
    y0, x0 = ((i + resolution - resolution // 2) // resolution - tile for i in own)
    positions, wide = seen.positions(), resolution * np.linalg.norm(seen.pixel_extent()[0], axis=-1)
    total, weights = np.zeros((height, width, raw.shape[-1])), np.zeros((height, width, 1))
    for dy, dx in np.ndindex(2 * tile, 2 * tile):
        apart = np.abs(resolution * np.stack([y0 + dy, x0 + dx]) + resolution // 2 - own) / resolution
        tent = np.maximum(1.0 - apart / tile, 0.0).prod(axis=0)
        y, x = np.clip(y0 + dy, 0, len(rows) - 1), np.clip(x0 + dx, 0, len(columns) - 1)
        there = (y == y0 + dy) & (x == x0 + dx) & (place[y, x, 3] > 0.0)
        off = np.abs(np.sum((positions[rows[y], columns[x]] - positions) * seen.geometric, axis=-1)) / wide
        turn = np.linalg.norm(place[y, x, :3] - seen.normal, axis=-1) / TURNED
        alike = np.maximum(1.0 - off, LEAST_WEIGHT) * np.maximum(1.0 - turn, LEAST_WEIGHT)
        weight = np.where(there, tent * alike, 0.0)[..., None]
        total, weights = total + weight * raw[y, x], weights + weight
    return np.where(weights > 0.0, total / np.where(weights > 0.0, weights, 1.0), 0.0) * (seen.depth > 0.0)[..., None]
