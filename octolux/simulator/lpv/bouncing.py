"""Further bounces of gathered light: gathered where surfaces are, reflected there, and injected again.

Kaplanyan & Dachsbacher 2010, 7 reflect light at the geometry volume while it is handed from cell to cell. Gathered
light arrives at once, so a bounce is a whole gathering: irradiance on the six faces of each cell that lies before
surfaces (gathering.py), times the shares of the cell's cross section that face each way, times their albedo. These
shares are of area times the squares of the normal's components (`squares` of the device's reflectors.py), as a surface
reads the cube of irradiance by them (gathering.read_cube): it then receives what its area and its irradiance say. No
bounce lands with more than was sent (`_kept`).

Light arrives in the cells of the last window, which is whole: it changes slowly, but for what comes from near by. What
the surfaces in any window's cells reflect is made of the same irradiance, filtered between those cells, and is added to
all that the cell has already, whether finer windows are there or not: so what is sent from far away does not depend on
where they lie. It comes from the mean place of the cell's surfaces (reflectors.inject_places).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import pi

import numpy as np

from octolux.simulator import sh
from octolux.simulator.lpv.cascades import Window
from octolux.simulator.lpv.gathering import first_moments, gather, light_nodes
from octolux.simulator.lpv.strips import Blockers
from octolux.simulator.lpv.transfer import DIRECTIONS


def reflected(reflectors, cube) -> np.ndarray:
    """Light (..., rgb, 4), W/sr, that cells send back: of `cube` (..., 6, 3), irradiance on their faces times the
    square of their size, what `reflectors` (..., 3, 4) (reflectors.py) reflect, as a cosine lobe along each face's
    normal."""
    reflectors = np.asarray(reflectors, dtype=np.float64)
    shares = np.concatenate([reflectors[..., 0, :], reflectors[..., 1, :2]], axis=-1)
    flux = shares[..., :, None] * reflectors[..., 2, None, :3] * cube
    return np.einsum("...fc,fk->...ck", flux, sh.cosine_lobe(DIRECTIONS)) / pi


def moments_at(light: np.ndarray, places: np.ndarray, origin=(0, 0, 0), size: float = 1.0) -> np.ndarray:
    """As gathering.first_moments, of `light` [z][y][x][rgb][4] from surfaces at `places` [z][y][x][3], in cells from
    the middles of theirs."""
    return first_moments(light, origin, size, light[..., 0].sum(axis=-1)[..., None] * places)


def irradiance(
    light: np.ndarray, reflectors: np.ndarray, count: int, geometry: Sequence[Blockers] | None = None, *,
    moments: np.ndarray, places: np.ndarray,
) -> np.ndarray:  # fmt: skip
    """Irradiance times the square of the cell size [z][y][x][6][3] of `count` bounces together in a whole volume of
    `light` [z][y][x][rgb][4] (W/sr), at the cells that have reflectors; 0 elsewhere. geometry: as in `gather`; moments:
    of `light`, as in gathering.light_nodes; places: of the reflectors."""
    n = light.shape[0]
    cells = np.argwhere(reflectors[..., :2, :].sum(axis=(-1, -2)) > 0.0)[:, ::-1]
    total, current = np.zeros((n, n, n, 6, 3)), np.asarray(light, dtype=np.float64)
    x, y, z = cells.T
    for _ in range(count):
        found = np.zeros_like(total)
        found[z, y, x] = gather(cells, light_nodes(current, moments), 1.0, geometry)
        found *= _kept(current, reflectors, found)
        total += found
        current = reflected(reflectors, found)
        moments = moments_at(current, places)
    return total


def _kept(light: np.ndarray, reflectors: np.ndarray, cube: np.ndarray) -> np.ndarray:
    """Share (3,) of what has been gathered that can have arrived: all light lands once at most, on all surfaces
    together no more than was sent. Where surfaces fill many cells side by side they would receive more than that, as
    cells that are next to one another do not block; with light enough going round it would grow by each bounce."""
    white = np.array(reflectors, dtype=np.float64)
    white[..., 2, :3] = 1.0
    received, sent = (cells[..., 0].sum(axis=(0, 1, 2)) for cells in (reflected(white, cube), light))
    return np.minimum(1.0, sent / np.where(received > 0.0, received, 1.0))


def injected_bounces(
    arrived: np.ndarray, marked: np.ndarray, reflectors: Sequence[np.ndarray], windows: Sequence[Window]
) -> list[np.ndarray]:
    """What each window's surfaces reflect of `arrived` [z][y][x][6][3], irradiance times the square of the last
    window's cell size in those of its cells that are `marked`: light [z][y][x][rgb][4] of each.

    A fine cell lies close before its surfaces, and would have part of what arrives behind them: what a face receives is
    read as far before it as a cell of the last window lies on average.
    """
    n, last = arrived.shape[0], windows[-1].size
    result = []
    z, y, x = np.indices((n, n, n))
    for own, window in zip(reflectors, windows, strict=True):
        ratio = window.size / last
        middle = ratio * (np.stack([x, y, z], axis=-1) + window.origin + 0.5)
        cube = np.zeros((n, n, n, 6, 3))
        for face, outward in enumerate(DIRECTIONS):
            cube[..., face, :] = _filtered(arrived[..., face, :], marked, middle + (0.5 - 0.5 * ratio) * outward)
        result.append(reflected(own, ratio**2 * cube))
    return result


def _filtered(values: np.ndarray, marked: np.ndarray, places: np.ndarray) -> np.ndarray:
    """`values` [z][y][x][3] between cells' middles at `places` (..., 3), of those cells around that are `marked`."""
    n = values.shape[0]
    at = np.clip(places, 0.5, n - 0.5) - 0.5
    low = np.minimum(np.floor(at).astype(int), n - 2)
    part = at - low
    total, weight = np.zeros((*places.shape[:-1], 3)), np.zeros(places.shape[:-1])
    for corner in np.ndindex(2, 2, 2):
        x, y, z = np.moveaxis(low + corner, -1, 0)
        share = np.prod(np.where(corner, part, 1.0 - part), axis=-1) * marked[z, y, x]
        total += share[..., None] * values[z, y, x]
        weight += share
    return total / np.maximum(weight, LEAST)[..., None]


LEAST = 1e-3
"""Weight of marked cells below which what is read fades: there is none near enough to tell."""
