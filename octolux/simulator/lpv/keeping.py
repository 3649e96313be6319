"""Surfels of static geometry kept from earlier frames (Kaplanyan & Dachsbacher 2010, 3.2).

"As an optimization we can also reuse the surface samples from previous frames (for static geometry), which reduces the
cases where surfaces are not captured by the current view or RSMs." Samples lie in cells, so cells are kept: what static
surfaces have filled of them stays, and is merged by maximum with what a frame brings, as a buffer of its own
(geometry.merge_buffers, merge_planes). So the volume fills as the camera looks around, and what it has of a surface is
the most that any frame has seen of it, by the errors of sampling more than one frame's mean.

- A window that moves does so by whole cells: contents keep their place in the world, and cells that come in are empty.
- What moves gives surfels for its frame alone. Cells in which something static stood that began to move, has gone or is
  another are emptied (`forgotten_cells`), whatever else they held: that comes back when it is seen.
"""

from __future__ import annotations

import numpy as np

from octolux.simulator.grid import Grid

OFF_LATTICE = 1e-6
"""Cells by which a window may have moved beside whole ones: rounding of origins in float64. More is another lattice."""

BESIDE = 1.0
"""Cells around a box in which surfels of what is in it may lie: rasterisers snap corners to 1/256 of a texel, so that a
ray may meet the plane of a triangle beside it, the farther the more it grazes it."""


def window_shift(before: Grid, now: Grid) -> tuple[int, int, int] | None:
    """By how many whole cells (x, y, z) a window has moved; None where its cells are others."""
    if (before.n, before.cell_size) != (now.n, now.cell_size):
        return None
    moved = np.subtract(now.origin, before.origin) / now.cell_size
    whole = np.rint(moved)
    x, y, z = whole.astype(int).tolist()
    return (x, y, z) if np.all(np.abs(moved - whole) <= OFF_LATTICE) else None


def shifted(cells: np.ndarray, shift: tuple[int, int, int]) -> np.ndarray:
    """Contents [z][y][x]... of a window that has moved by `shift` cells; 0 in those that have come in."""
    n, result = cells.shape[0], np.zeros_like(cells)
    to, source = [], []
    for moved in reversed(shift):
        to.append(slice(max(0, -moved), max(0, n - max(0, moved))))
        source.append(slice(max(0, moved), max(0, n + min(0, moved))))
    result[tuple(to)] = cells[tuple(source)]
    return result


def forgotten_cells(grid: Grid, low, high, offset: float = 0.0) -> np.ndarray:
    """Bool [z][y][x]: cells in which surfels of what stood in boxes from `low` to `high`, (k, 3) each, m, may lie, that
    have been moved by up to `offset` cells along their normals."""
    result, beside = np.zeros((grid.n,) * 3, bool), BESIDE + abs(offset)
    first = np.clip(np.floor(grid.to_cells(low) - beside), 0, grid.n).astype(int)
    end = np.clip(np.floor(grid.to_cells(high) + beside) + 1, 0, grid.n).astype(int)
    for (x0, y0, z0), (x1, y1, z1) in zip(first, end, strict=True):
        result[z0:z1, y0:y1, x0:x1] = True
    return result


def has_seen_more(newer: np.ndarray, older: np.ndarray) -> np.ndarray:
    """Bool [z][y][x], of reflectors [z][y][x][3][4] (reflectors.py): where a frame's have more shares in all than those
    kept of earlier ones."""
    return newer[..., :2, :].sum(axis=(-2, -1)) > older[..., :2, :].sum(axis=(-2, -1))


def merge_kept_reflectors(newer: np.ndarray, older: np.ndarray) -> np.ndarray:
    """Of shares the most, and the albedo of who has seen more: a glance at a corner says little of a cell. Their places
    (reflectors.inject_places) go with the albedo."""
    result = np.maximum(newer, older)
    result[..., 2, :] = np.where(has_seen_more(newer, older)[..., None], newer[..., 2, :], older[..., 2, :])
    return result
