"""Gathering: light goes from every cell straight to every other, over long ways in large cells.

The papers' steps are a diffusion: light forgets its direction, and how much arrives depends on the number of steps
(Kaplanyan & Dachsbacher 2010, 3.3; Olovsson 2012, 6.1). Here a cell receives, by the inverse square, from nodes of the
octree, each as large as its distance allows: a node of level i is read by cells that its parent, but not itself,
is next to. So each part of space sends its light once to each cell, on the level that suits the way (Olovsson 2012,
7.1, "propagation between octree levels on the fly"), and 189 nodes a level at most suffice, and 504 of the coarsest
that is read (COARSEST).

What arrives is held as irradiance on six faces, for normals along the axes (an ambient cube). Cells have no single
direction of incoming light, as it comes from all sides; on walls along the axes the cube is exact.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.form_factors import squares_with_a_common_edge
from octolux.simulator.lpv.cones import CONE_LENGTH, TOUCHES, WHOLE, cone_transmittance
from octolux.simulator.lpv.octree import build_levels
from octolux.simulator.lpv.strips import Blockers
from octolux.simulator.lpv.transfer import DIRECTIONS

SPREAD = 1.0 / 3.0
"""E = I / (r^2 + SPREAD s^2) of a node of size s: a lit square of side s straight ahead gives
I / r^2 * (1 - s^2 / (3 r^2)) to second order (form_factors.py expanded in s/r), and 1.003 times this expression even at
r = s."""

COARSEST = 8
"""Cells along each side of the coarsest level that is read, by all that are not next to a node there. Light of a node
comes along one way, to its mean place, and all of it comes or goes when that moves past an edge. With four cells a side
that could be most of what lit a dim place (benchmarks, clpv_stability_lamp)."""

SIDE = squares_with_a_common_edge()
"""Share of a surface's flux that arrives on another, as large as a cell's face, that meets it at a right angle."""


@dataclass(frozen=True)
class Nodes:
    """The cells of one level that hold light. cell: int (M, 3) x, y, z.  place: (M, 3), the centroid of the flux, in
    cells of level 0.  flux, fraction: (M, 3) per channel, direction: (M, 3, 3): dominant lobes (sh.py)."""

    level: int
    cell: np.ndarray
    place: np.ndarray
    flux: np.ndarray
    fraction: np.ndarray
    direction: np.ndarray


def light_nodes(injected, moments=None) -> list[Nodes]:
    """Nodes of every level of `injected` [z][y][x][rgb][4], the finest first. moments: its own, if not
    `first_moments`."""
    injected = np.asarray(injected, dtype=np.float64)
    moments = first_moments(injected) if moments is None else moments
    levels = zip(build_levels(injected), build_levels(moments), strict=True)
    return [nodes_of(i, cells, own) for i, (cells, own) in enumerate(levels)]


def first_moments(injected, origin=(0, 0, 0), size: float = 1.0, placed=None) -> np.ndarray:
    """[z][y][x][4]: weight times the light's place, in cells of level 0, and the weight: band 0 of all channels.
    origin: of the first cell; size: of the cells, in those of level 0. placed: [z][y][x][3], weight times the place in
    the cell, in cells from its middle (injection.inject_moments).

    Where no one has told: VPLs were moved half a cell along their normals when they were injected, and lie anywhere in
    their cells then. On average their surfaces are half a cell behind the middle, against the light's own first moment,
    which is sqrt(3)/2 |c1| / c00 of the flux long (harmonics.dominant_lobe).
    """
    weight = injected[..., 0].sum(axis=-1, keepdims=True)
    z, y, x = np.indices(weight.shape[:3])
    if placed is None:
        placed = -0.5 * 0.5 * np.sqrt(3.0) * harmonics.vector(injected).sum(axis=-2)
    places = weight * (np.stack([x, y, z], axis=-1) + origin + 0.5) + placed
    return np.concatenate([size * places, weight], axis=-1)


def nodes_of(level: int, cells: np.ndarray, moments: np.ndarray, origin=(0, 0, 0)) -> Nodes:
    """The nodes of a level from its light [z][y][x][rgb][4] and its first moments."""
    lit = np.nonzero(moments[..., 3] > 0.0)
    place = moments[lit][:, :3] / moments[lit][:, 3:]
    return Nodes(level, np.stack(lit[::-1], axis=-1) + origin, place, *harmonics.dominant_lobe(cells[lit]))


def takes(cell: np.ndarray, node: np.ndarray, steps: int, last: bool, whole=True) -> np.ndarray:
    """Whether cells (..., 3) read nodes (..., 3) that are `steps` levels coarser: next to the node's parent, but not to
    it, unless it has no children in its place (`whole` is false); of their own level next to it as well, but for the
    cell itself (`_from_own_cell`); and on the last level without a parent."""
    near = np.abs(node - (cell >> steps)).max(axis=-1) <= 1
    wide = np.abs((node >> 1) - (cell >> (steps + 1))).max(axis=-1) <= 1
    far = ~(near & whole) if steps else (node != cell).any(axis=-1)
    return far if last else far & wide


def coarsest_read(levels: int, base: int = 0) -> int:
    """Number of the coarsest of so many levels, down to one cell, that cells of level `base` read: one of COARSEST
    cells a side, and coarser than theirs."""
    return max(levels - COARSEST.bit_length(), base + 1)


def gather(
    cells, nodes: Sequence[Nodes], cell_size: float, geometry: Sequence[Blockers] | None = None, *,
    base: int = 0, origins: Sequence[tuple[int, int, int]] = (), ends: Sequence[np.ndarray] = (), n: int = 0,
) -> np.ndarray:  # fmt: skip
    """Irradiance (M, 6, 3) [face][rgb], W/m^2 (lx), on small faces in the middle of `cells` (M, 3) of level `base`
    whose normals are `transfer.DIRECTIONS`. cell_size: of that level, m. geometry: the geometry volume's levels, which
    block; None for no occlusion. origins, ends: of those levels that are windows of n^3 cells (cascades.py); the last
    is whole, as are the levels above it."""
    cells = np.asarray(cells)
    result = np.zeros((len(cells), 6, 3))
    starts = np.zeros((len(nodes), 3), dtype=int)
    starts[: len(origins)] = np.reshape(origins, (-1, 3))
    left_at = np.concatenate([np.reshape(ends, (-1, 2, 3)), np.tile(WHOLE, (len(nodes) - len(ends), 1, 1))])
    blockers = None if geometry is None else (geometry[base:], starts[base:], left_at[base:])
    coarsest = coarsest_read(len(nodes), base)
    for level in nodes[base : coarsest + 1]:
        whole: np.ndarray | bool = True
        if 0 < level.level < len(origins):
            child = 2 * level.cell - starts[level.level - 1]
            whole = np.all((child >= 0) & (child < n), axis=-1)[None]
        last = level.level == coarsest
        read = takes(cells[:, None], level.cell[None], level.level - base, last, whole)
        for number in range(len(level.cell)):
            near = np.nonzero(read[:, number])[0]
            result[near] += _received(cells[near] + 0.5, level, number, base, last, blockers)
        if level.level == base:
            for number, cell in enumerate(level.cell):
                result[np.all(cells == cell, axis=-1)] += _from_own_cell(level, number)
    return result / cell_size**2


def _from_own_cell(nodes: Nodes, number: int) -> np.ndarray:
    """What the faces of a cell receive of the light of its own surfaces (6, 3), times the square of the cell size.

    A surface across an axis fills one side of the cell, and a face along that axis is beside it, at a right angle: of
    its flux the form factor of two squares with a common edge arrives. A lobe's flux is that of three such surfaces by
    the squares of its direction's components, as surfaces read the cube; the rest comes from all three alike.
    """
    squares = np.repeat(nodes.direction[number] ** 2, 2, axis=-1).T
    fraction = nodes.fraction[number]
    return SIDE * nodes.flux[number] * (fraction * (1.0 - squares) + (1.0 - fraction) * (2.0 / 3.0))


def _received(points: np.ndarray, nodes: Nodes, number: int, base: int, last: bool, blockers: Any) -> np.ndarray:
    """What one node sends to each of `points` (M, 3), in cells of `base`: (M, 6, 3), times the square of their size.
    last: whether it is of the coarsest level that is read."""
    place = nodes.place[number] / 2.0**base
    way = points - place
    square = np.sum(way * way, axis=-1)
    direction = way / np.sqrt(np.maximum(square, 1e-12))[:, None]
    cosine = np.maximum(0.0, direction @ nodes.direction[number].T)
    flux, fraction = nodes.flux[number], nodes.fraction[number]
    intensity = flux * (fraction * cosine / pi + (1.0 - fraction) / (4.0 * pi))
    size = 2.0 ** (nodes.level - base)
    arriving = intensity / (square + SPREAD * size**2)[:, None]
    if blockers is not None:
        geometry, *where = blockers
        arriving *= cone_transmittance(
            geometry, points, np.broadcast_to(place, points.shape), size, *where,
            room=_room(size * nodes.cell[number], size, place, direction),
            cone_length=2.0 * CONE_LENGTH if last else CONE_LENGTH,
        )[:, None]  # fmt: skip
    return np.maximum(0.0, -direction @ DIRECTIONS.T)[:, :, None] * arriving[:, None, :]


def _room(corner: np.ndarray, size: float, place: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """How far (M,) a node from its `corner` on goes from `place` along `direction` (M, 3)."""
    sides = corner + size * (direction > 0.0) - place
    along = np.abs(direction) > TOUCHES
    return np.where(along, sides / np.where(along, direction, 1.0), np.inf).min(axis=-1)


def read_cube(cube, normals) -> np.ndarray:
    """Irradiance (..., 3) for unit `normals` (..., 3) from `cube` (..., 6, 3): the three faces that the normal sees,
    by the squares of its components, which add up to 1 (McTaggart 2004, "Half-Life 2 / Valve Source Shading")."""
    normals = np.asarray(normals, dtype=np.float64)
    result = np.zeros((*np.broadcast_shapes(cube.shape[:-2], normals.shape[:-1]), 3))
    for axis in range(3):
        towards = np.where(normals[..., axis, None] >= 0.0, cube[..., 2 * axis, :], cube[..., 2 * axis + 1, :])
        result += normals[..., axis, None] ** 2 * towards
    return result
