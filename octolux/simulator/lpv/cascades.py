"""Cascades: nested windows of n^3 cells around the camera, each with cells twice as large as the one inside it.

Kaplanyan & Dachsbacher 2010, 4. All windows lie on one lattice: the cells of level i + 1 are those of level i two by
two, counted from the corner of the whole volume, which the coarsest window is. So the windows are the levels of an
octree of which only a part is kept, finer and finer towards the camera. They are moved in whole cells, which keeps what
cells hold when the camera moves ("one-cell grid snapping", 4.2): four of them, so that blocks of 4^3 cells and their
parents lie within one window.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from octolux.simulator.grid import Grid

SNAP = 4
"""Cells of its own by which a window moves."""

AHEAD = 0.25
"""Share of its side by which a window's middle lies before the camera (4: "displaced into the view direction")."""


@dataclass(frozen=True)
class Window:
    """Cells origin to origin + n of a level, counted from the volume's corner (x, y, z). size: of its cells, in those
    of level 0. at_low, at_high: by axis, whether it ends with the whole volume there."""

    origin: tuple[int, int, int]
    size: int
    at_low: tuple[bool, ...]
    at_high: tuple[bool, ...]


def transition(n: int) -> int:
    """Cells over which a window gives way to the next."""
    return n // 8


def place_windows(n: int, count: int, volume: Grid, position, forward) -> list[Window]:
    """The windows around a camera at `position` (3,) that looks along `forward` (3,), the finest first; the last is
    `volume`, n^3 cells, whole. A window leaves room for its transition inside the next but at the volume's ends.

    Raises ValueError for fewer than one, or n that is not a multiple of 16.
    """
    if count < 1 or n % 16:
        raise ValueError(f"windows of a multiple of 16 cells, one at least; got {count} of {n}")
    position, forward = np.asarray(position, dtype=np.float64), np.asarray(forward, dtype=np.float64)
    windows = [_window(np.zeros(3, dtype=int), n, 1 << (count - 1), n)]
    spare = transition(n) + 2
    for level in reversed(range(count - 1)):
        outer = np.array(windows[0].origin)
        size, cells = 1 << level, n << (count - 1 - level)  # of the whole volume, along each side
        middle = (position - volume.origin) / (volume.cell_size * n / cells) + AHEAD * n * forward
        wanted = SNAP * np.rint((middle - 0.5 * n) / SNAP).astype(int)
        low = np.where(np.array(windows[0].at_low), 0, 2 * (outer + spare))
        high = np.where(np.array(windows[0].at_high), cells - n, 2 * (outer + n - spare) - n)
        windows.insert(0, _window(np.clip(wanted, low, high), n, size, cells))
    return windows


def _window(origin: np.ndarray, n: int, size: int, cells: int) -> Window:
    x, y, z = (int(o) for o in origin)
    return Window((x, y, z), size, tuple(origin == 0), tuple(origin + n == cells))


def grids_of(windows: Sequence[Window], volume: Grid) -> list[Grid]:
    """The windows as grids of their own, in world space. volume: the last of them."""
    h = volume.cell_size / windows[-1].size
    made = []
    for window in windows:
        x, y, z = (c + o * h * window.size for c, o in zip(volume.origin, window.origin, strict=True))
        made.append(Grid((x, y, z), h * window.size, volume.n))
    return made


def weights(places, windows: Sequence[Window], n: int) -> np.ndarray:
    """Share (count, M) of each window in what is read at `places` (count, M, 3), in cells of each window from its
    corner: the finest that holds the place, giving way to the next over its last cells but one, as filters reach half
    a cell beyond a place."""
    left, result = np.ones(np.shape(places)[1]), []
    for place, window in zip(places, windows, strict=True):
        low = np.where(window.at_low, np.inf, place)
        high = np.where(window.at_high, np.inf, n - place)
        inside = np.all((place >= 0.0) & (place <= n), axis=-1)
        room = np.minimum(low, high).min(axis=-1)
        share = np.where(inside, np.clip((room - 1.0) / transition(n), 0.0, 1.0), 0.0)
        result.append(left * share)
        left = left * (1.0 - share)
    return np.array(result)
