"""The geometry volume: how much surface lies in each cell, and what of a ray it lets through.

Each surfel (a texel of an RSM or of the G-buffer) has an area and a normal. A cell holds the three projected areas
a = sum of area |n| over the square of the cell size: the share of the cell's cross section that is blocked for light
along x, y and z. Kaplanyan & Dachsbacher 2010, 3.2 hold the same, area / s^2 times the cosine, as a two-band SH lobe
around the normal; its band 1 cancels for a thin wall that is seen from both sides, which three sizes do not.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from octolux.simulator.grid import Grid
from octolux.simulator.lpv.octree import downsample, level_sizes

CONE_LENGTH = 5.0
"""Length over cell size at which the march along a cone goes on to the next level. A node is read from 1.5 to 3.5 of
its sizes away (gathering.py), 2.5 on average: the cone to it is 1/2.5 as wide as it is long, and cells of half its
width resolve what lies in it."""

LEFT_OUT = 1.5
"""Cells before the middle of a node of one cell that do not block its light: its own half, and the next."""

SHORT = 0.9999
"""Points are read a little before where they lie, so that rounding decides nothing where a way passes through edges."""


BEHIND = 2.0**-8
"""Cells by which a surfel counts behind its surface, against the normal: a wall that lies on a face between cells is
then in one of them whole, and rounding of its place (some 1e-5 of a cell) does not share it out among both."""


def inject_surfels(position, normal, area, grid: Grid) -> np.ndarray:
    """Blocked shares [z][y][x][3] of M surfels of one buffer, at most 1 each: several layers of a surface in one cell,
    or texels that overlap, block no more than a wall does.

    position: (M, 3), world space.  normal: (M, 3) unit.  area: (M,), m^2. Surfels outside the grid are omitted.
    """
    cells = grid.cell_of(np.asarray(position) - BEHIND * grid.cell_size * np.asarray(normal))
    kept = np.all((cells >= 0) & (cells < grid.n), axis=-1)
    x, y, z = cells[kept].T
    volume = np.zeros((grid.n,) * 3 + (3,))
    shares = np.abs(np.asarray(normal, dtype=np.float64)) * np.asarray(area)[:, None] / grid.cell_size**2
    np.add.at(volume, (z, y, x), shares[kept])
    return np.minimum(volume, 1.0)


def merge_buffers(volumes: Sequence[np.ndarray]) -> np.ndarray:
    """One volume from those of several buffers, by maximum: each may have seen the same surface (CLPV 3.2)."""
    return np.max(volumes, axis=0)


def geometry_levels(finest: np.ndarray, coarsest: int = 1) -> list[np.ndarray]:
    """The geometry volume's octree: areas add up and the cross section is 4 times as large, so a parent is a quarter of
    its children's sum, at most 1 (a wall fills 4 of 8 children)."""
    levels = [np.asarray(finest, dtype=np.float64)]
    for _ in level_sizes(levels[0].shape[0], coarsest)[1:]:
        levels.append(np.minimum(0.25 * downsample(levels[-1], "sum"), 1.0))
    return levels


def face_transmittance(shares) -> np.ndarray:
    """What faces let through in a propagation step: float64 (n + 1, n + 1, n + 1, 3, 3), [z][y][x][axis][travel] of
    the lower face, across `axis`, of each cell, for light that travels along +-`travel`.

    shares: [z][y][x][3] of a geometry volume that lies half a cell aside, so that four of its cells meet in the
    middle of a face; their mean is the bilinear value there (CLPV 3.3). Light comes from the neighbour's middle:
    straight to the far face, and along (2 travel + side) / sqrt(5) to the sides (transfer.CENTRE_DIRECTIONS); a cell
    blocks shares.|w| of it. Nothing blocks beyond the volume.
    """
    n = shares.shape[0]
    padded = np.zeros((n + 2,) * 3 + (3,))
    padded[1:-1, 1:-1, 1:-1] = shares
    result = np.empty((n + 1,) * 3 + (3, 3))
    for axis in range(3):
        b, c = (axis + 1) % 3, (axis + 2) % 3
        corners = []
        for along_b, along_c in ((0, 0), (1, 0), (0, 1), (1, 1)):
            first = np.zeros(3, dtype=int)
            first[b], first[c] = along_b, along_c
            x, y, z = (slice(f, f + n + 1) for f in first)
            corners.append(padded[z, y, x])
        blocked = np.mean(corners, axis=0)
        for travel in range(3):
            side = (2.0 * blocked[..., travel] + blocked[..., axis]) / np.sqrt(5.0)
            result[..., axis, travel] = 1.0 - np.minimum(blocked[..., axis] if travel == axis else side, 1.0)
    return result


def cone_transmittance(geometry: Sequence[np.ndarray], start, end, node_size, origins=None) -> np.ndarray:
    """Share (M,) of light that passes from points `end` (M, 3) in nodes of `node_size` (M,) to points `start` (M, 3),
    in the middle of cells, in cells of level 0: a cone from a point to the node, marched on the level whose cells are
    half as wide as the cone.

    Each step crosses one layer of cells of its level, across the direction's longest component, and reads the cell in
    the middle of the step: it is blocked by the cell's shares a.|u| times the length of the step, at most wholly.
    Steps begin on the faces of their level's cells, if need be one former step earlier, so that each layer is crossed
    and a wall across the way blocks all.
    Of a level whose array does not hold all of space, but begins at the cell `origins` (levels, 3), steps are made
    while their middles lie in it.
    The start's own cell is left out, and before `end` half the node, which is where its own surfaces lie, or its cell
    and another: they are what the light comes from and goes to, each up to half a cell behind its point.
    """
    start, end = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    distance = np.linalg.norm(end - start, axis=-1)
    towards = (end - start) / np.where(distance > 0.0, distance, 1.0)[:, None]
    axis = np.abs(towards).argmax(axis=-1)[:, None]
    longest = np.maximum(np.abs(np.take_along_axis(towards, axis, axis=-1)[:, 0]), 1e-6)
    sense = np.where(np.take_along_axis(towards, axis, axis=-1)[:, 0] > 0.0, 1.0, -1.0)
    along = np.take_along_axis(start, axis, axis=-1)[:, 0]
    last = distance * longest - np.maximum(LEFT_OUT, 0.5 * np.asarray(node_size)) - 0.25  # never half-way by rounding
    passed, travelled, level = np.ones(len(start)), np.full(len(start), 0.5), np.zeros(len(start), dtype=int)
    origins = np.zeros((len(geometry), 3), dtype=int) if origins is None else np.asarray(origins)
    while (inside := travelled < last).any():
        width = 2.0**level
        middle = start + towards * (SHORT * (travelled + 0.5 * width) / longest)[:, None]
        stepped = np.zeros(len(start), dtype=bool)
        for i, shares in enumerate(geometry):
            cell = np.floor(middle / 2**i).astype(int) - origins[i]
            held = np.all((cell >= 0) & (cell < shares.shape[0]), axis=-1) | (i == len(geometry) - 1)
            here = inside & (level == i) & held
            x, y, z = np.clip(cell[here], 0, shares.shape[0] - 1).T
            blocked = np.sum(shares[z, y, x] * np.abs(towards[here]), axis=-1)
            passed[here] *= 1.0 - np.minimum(blocked / longest[here], 1.0)
            stepped |= here
        travelled = travelled + np.where(stepped, width, 0.0)
        long_enough = travelled >= 2.0 * CONE_LENGTH * width * longest
        wider = (travelled < last) & (long_enough | ~stepped) & (level < len(geometry) - 1)
        level = level + wider
        travelled -= np.where(wider, (along + sense * travelled) % 2.0**level, 0.0)
    return passed
