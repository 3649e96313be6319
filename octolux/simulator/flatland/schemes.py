"""One step of propagation in the plane: discrete ordinates with 4 and 8 neighbours, and the light propagation volume.

Every scheme sends the light of an angular sector of a cell to a neighbour, where it becomes a new distribution; the
sectors cover the circle once, so a step keeps the flux but for what leaves the grid.

- "DOM4", "DOM8": a sector for each neighbour; the light that goes there is spread evenly over the same sector. With as
  many ordinates as neighbours (`Sectors`) this is plain discrete ordinates. With harmonics both ends of a step project
  onto the bands, and two projections cannot grow: a beam cut to few bands, in place of the even sector, could, since
  it overshoots in its own direction and its square has no integral.
- "LPV": the sectors are the three faces that a cell's centre sees of each of its four neighbours, and the light becomes
  a cosine lobe towards the face. A face gets its angle times the intensity in its middle (Kaplanyan & Dachsbacher 2010,
  section 3.3). That keeps flux up to four bands; from the fifth on, harmonics of order 4, 8, .. do not cancel over
  the 12 faces.
- "LPV integral": the same with the exact integral over each face, the paper's transfer vectors; keeps flux always.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import atan, atan2, pi

import numpy as np

from .bases import LOBE_FLUX, Basis


@dataclass(frozen=True)
class Transfer:
    """Light of the directions from `begin` to `end` goes to the neighbour at `offset` (x, y) and becomes a lobe.

    `angle`: the lobe's. `crossings`: cells that straight light crosses on the way, which its sum counts.
    """

    offset: tuple[int, int]
    begin: float
    end: float
    angle: float
    crossings: int = 1


@dataclass(frozen=True)
class Scheme:
    """`lobe(basis, transfer)`: what unit flux becomes, (size,). `exact`: whether flux is integrated over the sector, or
    is the sector's angle times the intensity in its middle."""

    name: str
    transfers: tuple[Transfer, ...]
    lobe: Callable[[Basis, Transfer], np.ndarray]
    exact: bool

    def weights(self, basis: Basis) -> np.ndarray:
        """Weights (transfers, size) of a cell's coefficients in the flux of each transfer."""
        begin, end = np.array([(t.begin, t.end) for t in self.transfers]).T
        if self.exact:
            return basis.integral(begin, end)
        return (end - begin)[:, None] * basis.evaluate((begin + end) / 2.0)

    def lobes(self, basis: Basis) -> np.ndarray:
        """Coefficients (transfers, size) of what unit flux becomes."""
        return np.array([self.lobe(basis, t) for t in self.transfers])


def _ordinates(count: int) -> tuple[Transfer, ...]:
    """A sector for each of 4 or 8 neighbours. A diagonal step crosses two cells."""
    width = 2.0 * pi / count
    found = []
    for i in range(count):
        angle = i * width
        offset = (round(np.cos(angle)), round(np.sin(angle)))
        crossings = abs(offset[0]) + abs(offset[1])
        found.append(Transfer(offset, angle - width / 2.0, angle + width / 2.0, angle, crossings))
    return tuple(found)


def _faces() -> tuple[Transfer, ...]:
    """The far face and the two side faces of each of the four neighbours, seen from a cell's centre."""
    near, far = pi / 4.0, atan(1.0 / 3.0)  # corners (0.5, 0.5) and (1.5, 0.5) of the neighbour at +x
    sides = ((-far, far, 0.0), (far, near, pi / 2.0), (-near, -far, -pi / 2.0))
    found = []
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        turn = atan2(y, x)
        found += [Transfer((x, y), turn + begin, turn + end, turn + angle) for begin, end, angle in sides]
    return tuple(found)


def _sector(basis: Basis, transfer: Transfer) -> np.ndarray:
    return basis.uniform(transfer.begin, transfer.end)


def _lobe(basis: Basis, transfer: Transfer) -> np.ndarray:
    return basis.cosine_lobe(transfer.angle) / LOBE_FLUX


DOM4 = Scheme("DOM4", _ordinates(4), _sector, exact=True)
DOM8 = Scheme("DOM8", _ordinates(8), _sector, exact=True)
LPV = Scheme("LPV", _faces(), _lobe, exact=False)
LPV_INTEGRAL = Scheme("LPV integral", _faces(), _lobe, exact=True)
SCHEMES = {scheme.name: scheme for scheme in (DOM4, DOM8, LPV, LPV_INTEGRAL)}


def _moved(cells: np.ndarray, offset: tuple[int, int]) -> np.ndarray:
    """`cells` [y][x]... moved by `offset` (x, y); what leaves is lost."""
    result = np.zeros_like(cells)
    source = tuple(slice(max(0, -d), n - max(0, d)) for d, n in zip(offset[::-1], cells.shape, strict=False))
    target = tuple(slice(max(0, d), n - max(0, -d)) for d, n in zip(offset[::-1], cells.shape, strict=False))
    result[target] = cells[source]
    return result


def _sent(cells: np.ndarray, scheme: Scheme, basis: Basis):
    """For each transfer: itself, and what arrives in every cell (height, width, size)."""
    flux = cells @ scheme.weights(basis).T
    for i, (transfer, lobe) in enumerate(zip(scheme.transfers, scheme.lobes(basis), strict=True)):
        yield transfer, _moved(flux[..., i], transfer.offset)[..., None] * lobe


def step(cells, scheme: Scheme, basis: Basis) -> np.ndarray:
    """One step of `cells` (height, width, size)."""
    cells = np.asarray(cells, dtype=np.float64)
    return sum((arrived for _, arrived in _sent(cells, scheme, basis)), np.zeros_like(cells))


def propagate(cells, iterations: int, scheme: Scheme, basis: Basis) -> tuple[np.ndarray, np.ndarray]:
    """The sum of the light of all steps, and the light that is still under way after the last: both as `cells`.

    The sum is the flux per radian that has crossed each cell: light that came by a diagonal counts twice, since
    straight light crosses two cells on such a step. Raises ValueError for a negative number of iterations.
    """
    if iterations < 0:
        raise ValueError(f"the number of iterations cannot be negative, got {iterations}")
    current = np.asarray(cells, dtype=np.float64)
    total = current.copy()
    for _ in range(iterations):
        arriving = np.zeros_like(current)
        for transfer, arrived in _sent(current, scheme, basis):
            arriving += arrived
            total += transfer.crossings * arrived
        current = arriving
    return total, current


def flux(cells: np.ndarray, basis: Basis) -> np.ndarray:
    """Flux of every cell, (height, width), W."""
    return cells @ basis.integral(0.0, 2.0 * pi)
