"""Corners: light of a place from the eight cells around it, as far as surfaces between let it through.

A place lies between the middles of eight cells, of which some may be in a wall or behind it: light filtered between all
of them, as textures are, would leak in from there. So a cell counts by its trilinear weight and by what the geometry
volume's planes let through on the way from the place to its middle. Along each axis that way lies in the cell's own
layer and in the one beside it: what counts are the planes of the cell and of its neighbour along that axis, if they lie
between place and middle, and the larger share of both, not their product: a wall that is cut by the face between two
cells has a plane in each.

A plane that is less than UNSURE from the place may be before or behind it: it counts in part, whichever way. Beside a
wall, whose plane may lie a little before it where other surfaces are in its cells, all would be read from behind it
otherwise, and the cells of another window, whose plane lies elsewhere, would say something else by far.

Where planes lie on all sides the cells around are all there is: then they count as if nothing were between.
"""

from __future__ import annotations

import numpy as np

from octolux.simulator.lpv.strips import STEPS, Blockers

LEAST = 2.0**-10
"""Sum of weights below which all corners are as good as blocked: what little passes would be rounding's choice."""

UNSURE = 1.0 / STEPS
"""Cells on either side of a plane from which on it is known where a place is: the step in which planes are kept."""

CORNERS = np.array(list(np.ndindex(2, 2, 2)))[:, ::-1]
"""The eight cells from the lowest one, (8, 3) x, y, z: x changes first."""


def corner_weights(place, planes: Blockers | None = None) -> tuple[np.ndarray, np.ndarray]:
    """How much each of the eight cells around places (M, 3), in cells of a volume from its corner, counts: the lowest
    of them (M, 3), which may lie one beyond the volume, and weights (M, 8), which add up to 1, of CORNERS. planes: of
    the volume, as at its rim also beyond it; None for no occlusion."""
    place = np.asarray(place, dtype=np.float64)
    first = np.floor(place - 0.5).astype(int)
    part = place - 0.5 - first
    between = np.where(CORNERS == 1, part[:, None], 1.0 - part[:, None]).prod(axis=-1)
    if planes is None:
        return first, between
    x, y, z = np.moveaxis(corner_cells(first, len(planes.offsets)), -1, 0)
    seen = between * _passed(part + 0.5, planes.shares[z, y, x], planes.offsets[z, y, x])
    whole = seen.sum(axis=-1, keepdims=True)
    return first, np.where(whole > LEAST, seen / np.maximum(whole, LEAST), between)


def corner_cells(first: np.ndarray, n: int) -> np.ndarray:
    """Cells (M, 8, 3), x, y, z, of n^3: at its rim, those that would lie beyond."""
    return np.clip(first[:, None] + CORNERS, 0, n - 1)


def read_corners(cells, place, planes: Blockers | None = None) -> np.ndarray:
    """What `cells` [z][y][x]... hold at places (M, 3): (M, ...)."""
    first, weights = corner_weights(place, planes)
    x, y, z = np.moveaxis(corner_cells(first, len(cells)), -1, 0)
    return np.einsum("mk,mk...->m...", weights, cells[z, y, x])


def _passed(place: np.ndarray, shares: np.ndarray, offsets: np.ndarray) -> np.ndarray:
    """What planes let through (M, 8) from places (M, 3), in cells from the lowest one's corner, to the corners. shares,
    offsets: (M, 8, 3), of the eight cells' planes."""
    passed = np.ones(shares.shape[:2])
    for axis in range(3):
        at, middle, beside = place[:, None, axis], CORNERS[:, axis] + 0.5, np.arange(8) ^ (1 << axis)
        plane, share = CORNERS[:, axis] + offsets[..., axis], shares[..., axis]
        own, other = (_blocked(at, middle, plane[:, c], share[:, c]) for c in (np.arange(8), beside))
        passed *= 1.0 - np.maximum(own, other)
    return passed


def _blocked(place: np.ndarray, middle: np.ndarray, plane: np.ndarray, share: np.ndarray) -> np.ndarray:
    """What a plane blocks of the way along an axis from place to middle: its share, if it lies between."""
    upwards = middle > place
    ahead, before = np.where(upwards, plane - place, place - plane), np.where(upwards, plane < middle, plane > middle)
    return np.where(before, share * np.clip(0.5 + 0.5 * ahead / UNSURE, 0.0, 1.0), 0.0)
