"""Reflectors: what the surfaces of the geometry volume send back of the light that they block.

Kaplanyan & Dachsbacher 2010, 7 reflect by the geometry volume's own lobe B, area / s^2 times the clamped cosine around
the normal. Here a cell holds that lobe's values towards the six axes instead, sum of area max(0, +-n) / h^2 each: a
thin wall that is seen from both sides faces both ways, which two bands would cancel. Beside them it has the mean albedo
of its surfels, weighted by area: "spectral reflectivity" of section 6, and its luminance for monochrome reflection;
and, where gathered light bounces, the mean place of its surfels, from which what they reflect is sent.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from octolux.simulator.environment import LUMINANCE
from octolux.simulator.grid import Grid

MOST_WALLS = 128
"""Cross sections of its cell that a surfel's area counts for in the mean of albedos at most, so that sums of fixed
point have a bound. Only texels many cells wide come near it."""


def reflector_cells(position, normal, grid: Grid, offset: float) -> np.ndarray:
    """Cells (x, y, z), int64 (M, 3), of surfels at `position` (M, 3), moved along `normal` (M, 3) by `offset` cells."""
    return grid.cell_of(np.asarray(position, dtype=np.float64) + offset * grid.cell_size * np.asarray(normal))


def inject_reflectors(position, normal, area, albedo, grid: Grid, offset: float) -> tuple[np.ndarray, np.ndarray]:
    """Of M surfels of one buffer, the shares [z][y][x][6] of the cells' cross sections that face +x, -x, +y, -y, +z,
    -z, at most 1 each; and the sums [z][y][x][4] of albedo times area, and of area, in cross sections.

    position: (M, 3), world space.  normal: (M, 3) unit.  area: (M,), m^2.  albedo: (M, 3).  Surfels outside the grid
    are omitted.
    """
    cells = reflector_cells(position, normal, grid, offset)
    kept = np.all((cells >= 0) & (cells < grid.n), axis=-1)
    x, y, z = cells[kept].T
    walls = (np.asarray(area, dtype=np.float64) / grid.cell_size**2)[kept, None]
    towards, albedo = np.asarray(normal, dtype=np.float64)[kept], np.asarray(albedo, dtype=np.float64)[kept]
    facing = np.stack([np.maximum(towards, 0.0), np.maximum(-towards, 0.0)], axis=-1).reshape(-1, 6)
    shares, tints = np.zeros((grid.n,) * 3 + (6,)), np.zeros((grid.n,) * 3 + (4,))
    np.add.at(shares, (z, y, x), facing * walls)
    weight = np.minimum(walls, MOST_WALLS)
    np.add.at(tints, (z, y, x), np.concatenate([albedo * weight, weight], axis=1))
    return np.minimum(shares, 1.0), tints


def inject_places(position, normal, area, grid: Grid, offset: float) -> np.ndarray:
    """Where in their cells M surfels of any buffers lie, [z][y][x][3]: the mean by area of the places of the surfaces
    themselves, which have not been moved, in cells from the middle; 0 where nothing lies. Arguments as above."""
    cells = reflector_cells(position, normal, grid, offset)
    kept = np.all((cells >= 0) & (cells < grid.n), axis=-1)
    x, y, z = cells[kept].T
    weight = np.minimum(np.asarray(area, dtype=np.float64)[kept, None] / grid.cell_size**2, MOST_WALLS)
    beside = grid.to_cells(np.asarray(position)[kept]) - (cells[kept] + 0.5)
    sums = np.zeros((grid.n,) * 3 + (4,))
    np.add.at(sums, (z, y, x), np.concatenate([beside * weight, weight], axis=1))
    return sums[..., :3] / np.where(sums[..., 3:] > 0.0, sums[..., 3:], 1.0)


def merge_reflectors(buffers: Sequence[tuple[np.ndarray, np.ndarray]]) -> np.ndarray:
    """Reflectors [z][y][x][3][4] from those of several buffers: +x, -x, +y, -y | +z, -z, 0, 0 | albedo, its luminance.

    Shares are merged by maximum, as each buffer may have seen the same surface (CLPV 3.2). The albedo is the mean of
    all, 0 where nothing lies.
    """
    result = np.zeros((*buffers[0][0].shape[:3], 12))
    result[..., :6] = np.max([shares for shares, _ in buffers], axis=0)
    tint = np.sum([tints for _, tints in buffers], axis=0)
    result[..., 8:11] = tint[..., :3] / np.where(tint[..., 3:] > 0.0, tint[..., 3:], 1.0)
    result[..., 11] = result[..., 8:11] @ LUMINANCE
    return result.reshape(*result.shape[:3], 3, 4)
