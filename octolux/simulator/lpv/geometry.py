"""The geometry volume: how much surface lies in each cell, and where. What of a way it lets through: cones.py.

Each surfel (a texel of an RSM or of the G-buffer) has an area and a normal. A cell holds the three projected areas
a = sum of area |n| over the square of the cell size: the share of the cell's cross section that is blocked for light
along x, y and z. Kaplanyan & Dachsbacher 2010, 3.2 hold the same, area / s^2 times the cosine, as a two-band SH lobe
around the normal; its band 1 cancels for a thin wall that is seen from both sides, which three sizes do not.

Steps of propagation pass faces between cells and need the shares alone (`face_transmittance`). A march has to know
where in its cells the surfaces lie, too: a way of length L (in cells) through a cell along u meets a surface that may
be anywhere in it with a chance of |u| L along each axis, so that shares alone let 1 - a.|u| L pass. That is right on
average and wrong each time: a wall dims what runs past it within its cells, and of what goes through it some passes.
So a cell also has three planes, one across each axis, at the mean place of the surfels by their shares (`Planes`), and
of each plane a part, a strip around that place (`Strips`). A way is blocked by each strip it crosses, and by none that
it does not: of a wall across an axis exactly what goes through, of a curtain's folds, whose sides face along it, what
goes through the curtain and not what runs along before it. Surfaces anywhere in the cell give a.|u| L again, as the
chance to cross their plane is its |u| L.

A plane is crossed once, but a closed object twice: by a front, which faces the way, and by a back. Over a closed
surface the integral of n dA is zero, so that along each axis the fronts, n > 0, and the backs, n < 0, have the same
projected area, and each of them is what the object blocks, if no way goes into it more than once. So fronts and backs
are summed apart, and the plane's share is the larger of the two: a column or a cushion smaller than the cell counts
once, as does a wall of two faces, or of one. A coarser cell's fronts are made of its children's fronts and its backs of
their backs, as an object may be cut by the face between two children, each of which has one of its sides.

Where this is not exact:
- Surfaces at a slant are stairs: each of their cells has a strip across either axis, as high as the surface rises
  in it. What goes through is blocked, but so is some of what runs along within their cells.
- Of several parallel walls in a cell there is one, in their middle, as closed as all that face one way together, up to
  a wall. Sheets beside one another that face either way, as leaves may, block no more than the larger part of them.
- An object that is cut by the face between two cells has a plane in each, and a way may cross both.
- Of a surface that is no strip, or of several, what is known is where its middle lies and how much it blocks.
- Planes of a coarser cell lie at the mean of its children's (`coarser_planes`): a wall along the axes where it was, two
  walls that it holds in their middle. The coarser the cells, the farther away is what they block (cones.py).
- Strips are what gathering marches through. Lookups (corners.py) and reflected rays (glossy.py) take a share all over
  its plane: the ones go through half a cell, of the others the edges of strips would show.

Nested windows (cascades.py) have no coarser levels but those above the last: each surfel is in every window that holds
it, so that what a window's cells block does not depend on where the others lie.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from octolux.simulator.grid import Grid
from octolux.simulator.lpv.octree import downsample, level_sizes
from octolux.simulator.lpv.strips import Planes

BEHIND = 2.0**-8
"""Cells by which a surfel counts behind its surface, against the normal: a wall that lies on a face between cells is
then in one of them whole, and rounding of its place (some 1e-5 of a cell) does not share it out among both."""


def inject_surfels(position, normal, area, grid: Grid) -> np.ndarray:
    """Blocked shares [z][y][x][3] of M surfels of one buffer, whichever way they face, at most 1 each: several layers
    of a surface in one cell, or texels that overlap, block no more than a wall does.

    position: (M, 3), world space.  normal: (M, 3) unit.  area: (M,), m^2. Surfels outside the grid are omitted.
    """
    cells, weights, _, _ = _surfels_in_cells(position, normal, area, grid)
    return np.minimum(_sum_in_cells(cells, weights, grid), 1.0)


def inject_planes(position, normal, area, grid: Grid) -> Planes:
    """What faces along the axes, and against them, and where both lie: the mean, of which a surfel has its share, at
    most 1, as weight."""
    cells, weights, within, front = _surfels_in_cells(position, normal, area, grid)
    sides = (np.where(front, weights, 0.0), np.where(front, 0.0, weights))
    moments = (weights * np.roll(within, -aside, axis=-1) for aside in range(3))
    return planes_of(*(_sum_in_cells(cells, values, grid) for values in (*sides, *moments)))


def _surfels_in_cells(position, normal, area, grid: Grid):
    """Of those in the grid: number [z][y][x] of the cell, and along each axis share of its cross section, at most 1,
    place in it, and whether the normal points along it."""
    normal = np.asarray(normal, dtype=np.float64)
    places = grid.to_cells(np.asarray(position) - BEHIND * grid.cell_size * normal)
    cells = np.floor(places).astype(np.int64)
    kept = np.all((cells >= 0) & (cells < grid.n), axis=-1)
    shares = np.abs(normal) * np.asarray(area)[:, None] / grid.cell_size**2
    x, y, z = cells[kept].T
    return (z, y, x), np.minimum(shares[kept], 1.0), (places - cells)[kept], normal[kept] > 0.0


def _sum_in_cells(cells, values: np.ndarray, grid: Grid) -> np.ndarray:
    sums = np.zeros((*(grid.n,) * 3, 3))
    np.add.at(sums, cells, values)
    return sums


def planes_of(fronts: np.ndarray, backs: np.ndarray, *moments: np.ndarray) -> Planes:
    """Shares of at most 1 each, at their mean places: moments are sums of shares of both times places, along the
    share's own axis, the next and the last."""
    both = np.where(fronts + backs > 0.0, fronts + backs, 1.0)
    return Planes(np.minimum(fronts, 1.0), np.minimum(backs, 1.0), *(m / both for m in moments))


def merge_buffers(volumes: Sequence[np.ndarray]) -> np.ndarray:
    """One volume from those of several buffers, by maximum: each may have seen the same surface (CLPV 3.2)."""
    return np.max(volumes, axis=0)


def merge_planes(volumes: Sequence[Planes]) -> Planes:
    """As `merge_buffers`, fronts and backs apart: each of the two may be what another buffer has seen. Along each axis
    the plane of the buffer that has the largest share, the first of equals."""
    first = np.argmax([v.shares for v in volumes], axis=0)[None]
    places = (np.take_along_axis(np.stack(each), first, axis=0)[0] for each in list(zip(*volumes, strict=True))[2:])
    return Planes(merge_buffers([v.fronts for v in volumes]), merge_buffers([v.backs for v in volumes]), *places)


def geometry_levels(finest: np.ndarray, coarsest: int = 1) -> list[np.ndarray]:
    """The geometry volume's octree: areas add up and the cross section is 4 times as large, so a parent is a quarter of
    its children's sum, at most 1 (a wall fills 4 of 8 children)."""
    levels = [np.asarray(finest, dtype=np.float64)]
    for _ in level_sizes(levels[0].shape[0], coarsest)[1:]:
        levels.append(np.minimum(0.25 * downsample(levels[-1], "sum"), 1.0))
    return levels


def coarser_planes(planes: Planes) -> list[np.ndarray]:
    """Of the next coarser level, [z][y][x][3] each: a quarter of the sum of the children's fronts, and of their backs,
    as the cross section is 4 times as large, not limited; and the moments of both, with places in the parent."""
    z, y, x = np.indices(planes.fronts.shape[:3]) % 2
    corner, both = np.stack([x, y, z], axis=-1), planes.fronts + planes.backs
    moments = (both * 0.5 * (place + np.roll(corner, -aside, axis=-1)) for aside, place in enumerate(planes[2:]))
    return [downsample(0.25 * values, "sum") for values in (*planes[:2], *moments)]


def plane_levels(finest: Planes) -> list[Planes]:
    """The octree above `finest`, down to one cell."""
    levels = [finest]
    while levels[-1].fronts.shape[0] > 1:
        levels.append(planes_of(*coarser_planes(levels[-1])))
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
