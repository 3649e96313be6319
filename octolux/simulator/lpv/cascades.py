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
from typing import Any

import numpy as np

from octolux.simulator.blending import moved_share
from octolux.simulator.grid import Grid
from octolux.simulator.lpv.gathering import Nodes, first_moments, nodes_of
from octolux.simulator.lpv.octree import build_levels

SNAP = 4
"""Cells of its own by which a window moves."""


@dataclass(frozen=True)
class Window:
    """Cells origin to origin + n of a level, counted from the volume's corner (x, y, z). size: of its cells, in those
    of level 0. low, high: where its light is no longer read, in its cells from its own corner; these follow the camera
    without steps, so that what is seen does not jump when the window does."""

    origin: tuple[int, int, int]
    size: int
    low: tuple[float, float, float]
    high: tuple[float, float, float]

    @property
    def ends(self) -> np.ndarray:
        """(2, 3), in its cells from the volume's corner: between these it has cells whichever way it has been snapped.
        Here ways leave it (cones.py): where its own cells end they would meet others whenever it moves."""
        return np.array([np.add(self.origin, self.low) - 0.5, np.add(self.origin, self.high) + 0.5])


def transition(n: int) -> int:
    """Cells over which a window gives way to the next: as many as `place_windows` leaves room for, since the wider, the
    less light changes from frame to frame."""
    return 3 * n // 16 - 1


def place_windows(n: int, count: int, volume: Grid, position, forward) -> list[Window]:
    """The windows around a camera at `position` (3,) that looks along `forward` (3,), the finest first; the last is
    `volume`, n^3 cells, whole.

    Each lies before the camera (4: "displaced into the view direction"), by m = n / 8 - 1/2 cells. It is read up to
    n / 2 - 5 / 2 cells from its middle, two for the snapping and one half for the filter, which lies within that part
    of the next where that one's light is read alone, a transition t less far, of cells of twice the size, from a middle
    that is as much farther ahead: n / 2 - 5 / 2 + m <= 2 (n / 2 - 5 / 2 - t). So two windows at most are read anywhere,
    and t is 3 n / 16 - 1 at most.
    At the volume's ends, beyond which there is nothing to see, it stays inside.

    Raises ValueError for fewer than one window, or n that is not a multiple of 16.
    """
    if count < 1 or n < 16 or n % 16:
        raise ValueError(f"windows of a multiple of 16 cells, one at least; got {count} of {n}")
    position, forward = np.asarray(position, dtype=np.float64), np.asarray(forward, dtype=np.float64)
    windows = []
    for level in range(count - 1):
        size, cells = 1 << level, n << (count - 1 - level)  # of the whole volume, along each side
        wanted = (position - volume.origin) / (volume.cell_size * n / cells) + (n / 8 - 0.5) * forward
        middle = np.clip(wanted, n / 2, cells - n / 2)
        origin = SNAP * np.rint((middle - n / 2) / SNAP).astype(int)
        reach = n / 2 - SNAP / 2 - 0.5
        low, high = np.minimum(wanted, middle) - reach - origin, np.maximum(wanted, middle) + reach - origin
        windows.append(Window(_triple(origin), size, _triple(low), _triple(high)))
    return [*windows, Window((0, 0, 0), 1 << (count - 1), (-np.inf,) * 3, (np.inf,) * 3)]


def moving_volume(spacing: float, n: int, position, forward) -> Grid:
    """A volume of n^3 cells and `spacing` metres along each edge that moves with the camera, instead of one around the
    scene: before it, as windows are, by whole cells of the level of four along each side, so that all levels above keep
    what they hold. Raises ValueError for a spacing that is not positive."""
    if not 0.0 < spacing < np.inf:
        raise ValueError(f"a volume has an edge of more than 0 m, got {spacing}")
    middle = np.asarray(position, dtype=np.float64) + (n / 8 - 0.5) * spacing / n * np.asarray(forward)
    step = spacing / 4
    return Grid(_triple(step * np.rint((middle - spacing / 2) / step)), spacing / n, n)


def _triple(values: np.ndarray) -> tuple[Any, Any, Any]:
    x, y, z = values.tolist()
    return x, y, z


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
    corner: the finest that holds the place, giving way to the next over its last cells."""
    left, result = np.ones(np.shape(places)[1]), []
    for place, window in zip(places, windows, strict=True):
        room = np.minimum(place - window.low, np.array(window.high) - place).min(axis=-1)
        share = np.clip(room / transition(n), 0.0, 1.0)
        result.append(left * share)
        left = left * (1.0 - share)
    return np.array(result)


def blended(values: np.ndarray, shares: np.ndarray) -> np.ndarray:
    """What is read (M, 3) of `values` (count, M, 3) of all windows by their `shares` (count, M), of `weights`: of the
    finest that has one and of the next, by equal factors of all channels together (blending.py)."""
    each, first = np.arange(shares.shape[1]), (shares > 0.0).argmax(axis=0)
    fine, coarse = values[first, each], values[np.minimum(first + 1, len(values) - 1), each]
    moved = moved_share(fine.sum(axis=-1), coarse.sum(axis=-1), shares[first, each])
    return coarse + moved[:, None] * (fine - coarse)


def window_levels(own: Sequence[np.ndarray]) -> list[np.ndarray]:
    """All levels of what each window [z][y][x]... has, which is all that lies in it: the windows' own, and the octree
    above the last, down to one cell."""
    return [*own[:-1], *build_levels(own[-1])]


def window_nodes(
    own: Sequence[np.ndarray], windows: Sequence[Window], placed: Sequence[np.ndarray] | None = None
) -> list[Nodes]:
    """Nodes of all levels, as gathering.light_nodes makes them, from each window's light [z][y][x][rgb][4], and where
    in its cells it lies, as gathering.first_moments takes it."""
    beside = [None] * len(own) if placed is None else placed
    moments = [first_moments(a, w.origin, w.size, b) for a, w, b in zip(own, windows, beside, strict=True)]
    levels = zip(window_levels(own), window_levels(moments), strict=True)
    origins = [w.origin for w in windows]
    return [nodes_of(i, *level, origins[i] if i < len(origins) else (0, 0, 0)) for i, level in enumerate(levels)]
