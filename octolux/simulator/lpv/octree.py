"""The full octree over a volume of n^3 cells: levels, index volume and merge (Olovsson 2012, 4.2).

Level i has (n / 2^i)^3 cells of size h 2^i; level 0 is the finest. A level is an array [z][y][x]... as all volumes are.

Combining. A parent is the mean of its eight children in the thesis (eq. 11), so that a number means the same on every
level. But a cell holds intensity, and irradiance is read as intensity over the square of the cell size: the parent
that keeps the flux is the sum, read with the parent's cell size. A lit wall fills 4 of 8 children, so the sum is
4 times the intensity over 4 times the area: the same irradiance on each level, where the mean gives half.
`reading_factor` is what a level's numbers are multiplied by to be read with the cell size of level 0.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from octolux.simulator.grid import Grid
from octolux.simulator.lpv.lookup import sample_trilinear

COMBINATIONS = ("sum", "average")


def level_sizes(n: int, coarsest: int = 1) -> list[int]:
    """Cells along each side of the levels: n, n/2, ... `coarsest`. Raises ValueError unless both are powers of two and
    coarsest <= n."""
    for name, size in (("n", n), ("coarsest", coarsest)):
        if size < 1 or size & (size - 1):
            raise ValueError(f"{name} must be a power of two, got {size}")
    if coarsest > n:
        raise ValueError(f"the coarsest level cannot be larger than n = {n}, got {coarsest}")
    return [n >> i for i in range(n.bit_length() - coarsest.bit_length() + 1)]


def downsample(cells, combine: str = "sum") -> np.ndarray:
    """The next coarser level of `cells` [z][y][x]...: float64, half as many along each side (Olovsson 2012, eq. 11, and
    the sum as described at the top). Raises ValueError for an unknown combination or an odd size."""
    cells = np.asarray(cells, dtype=np.float64)
    if combine not in COMBINATIONS:
        raise ValueError(f"unknown combination '{combine}'; choose one of {', '.join(COMBINATIONS)}")
    n = cells.shape[0]
    if cells.shape[:3] != (n, n, n) or n % 2:
        raise ValueError(f"a level to downsample is a cube of an even number of cells, got {cells.shape[:3]}")
    half = n // 2
    children = cells.reshape(half, 2, half, 2, half, 2, *cells.shape[3:])
    total = children.sum(axis=(1, 3, 5))
    return total if combine == "sum" else total / 8.0


def build_levels(finest, combine: str = "sum", coarsest: int = 1) -> list[np.ndarray]:
    """All levels of the octree whose level 0 is `finest` [z][y][x]..., down to `coarsest` cells along each side."""
    levels = [np.asarray(finest, dtype=np.float64)]
    for _ in level_sizes(levels[0].shape[0], coarsest)[1:]:
        levels.append(downsample(levels[-1], combine))
    return levels


def reading_factor(level: int, combine: str = "sum") -> float:
    """Factor with which `level`'s intensity is read as one of level 0: (h / h_i)^2 = 4^-i for sums, 1 for averages."""
    return 4.0**-level if combine == "sum" else 1.0


def index_levels(n: int, coarsest: int = 1) -> list[np.ndarray]:
    """The hierarchical index volume I_i as it begins: int64 [z][y][x] on each level, all l - 1."""
    sizes = level_sizes(n, coarsest)
    return [np.full((size,) * 3, len(sizes) - 1, dtype=np.int64) for size in sizes]


def mark(index: Sequence[np.ndarray], contributions: Sequence[np.ndarray], threshold: float = 0.0) -> list[np.ndarray]:
    """I_i = i wherever level i receives a contribution that is not zero: new index levels.

    contributions: what injection, downsampling or one propagation step added to each level, [z][y][x]...[4]; shorter
    than `index` when the coarser levels received nothing. threshold: band 0 up to it is zero, in the contribution's
    unit: float light never dies out exactly. (The thesis's 2^i - 1 steps for full coverage are 2^(l-1-i) - 1.)
    """
    marked = [level.copy() for level in index]
    for i, added in enumerate(contributions):
        band0 = np.asarray(added)[..., 0]
        marked[i][band0.reshape(*band0.shape[:3], -1).max(axis=-1) > threshold] = i
    return marked


def upsample(cells, n: int) -> np.ndarray:
    """`cells` [z][y][x]... repeated to n along each side: every child gets its parent's value."""
    times = n // np.shape(cells)[0]
    for axis in range(3):
        cells = np.repeat(cells, times, axis=axis)
    return np.asarray(cells)


def flat_index(index: Sequence[np.ndarray]) -> np.ndarray:
    """I(x, y, z) = min over i of I_i(x / 2^i, ...): int64 [z][y][x] of level 0's size (Olovsson 2012, 4.2)."""
    n = index[0].shape[0]
    return np.min([upsample(level, n) for level in index], axis=0)


def merge(levels: Sequence[np.ndarray], index: Sequence[np.ndarray], combine: str = "sum") -> np.ndarray:
    """M(x, y, z) = S(x, y, z): the level that the index volume names at each cell of level 0 (Olovsson 2012, eq. 10),
    times `reading_factor`. Levels are merged two at a time from coarse to fine, as in 5.2; the result is the same."""
    merged = np.asarray(levels[-1]) * reading_factor(len(levels) - 1, combine)
    for i in range(len(levels) - 2, -1, -1):
        n = np.shape(levels[i])[0]
        here = index[i] == i
        coarser = upsample(merged, n)
        own = np.asarray(levels[i]) * reading_factor(i, combine)
        merged = np.where(here.reshape(*here.shape, *[1] * (own.ndim - 3)), own, coarser)
    return merged


def merge_by_arrival(sums: Sequence[np.ndarray], last: Sequence[np.ndarray], combine: str = "sum") -> np.ndarray:
    """`sums` of the levels, [z][y][x][rgb][4] each, blended from coarse to fine by how much of a level's light has
    arrived: float64 of level 0's size, as `merge`, but without a border where one level ends (Olovsson 2012, 6.1).

    arrived = 1 - 2 S_k / (S_0 + ... + S_k), at least 0, of band 0 of all channels: nothing while the last step brings
    as much as all before it, all when nothing more comes. last: S_k of each level. Coarser levels are filtered between
    the middles of their cells.
    """
    merged = np.asarray(sums[-1]) * reading_factor(len(sums) - 1, combine)
    for i in range(len(sums) - 2, -1, -1):
        here, n = np.asarray(sums[i]), np.shape(sums[i])[0]
        total, step = (np.asarray(light)[..., 0].sum(axis=-1)[..., None, None] for light in (here, last[i]))
        arrived = np.maximum(0.0, 1.0 - 2.0 * step / np.where(total > 0.0, total, np.inf)) * (total > 0.0)
        whole = Grid((0.0, 0.0, 0.0), 1.0, n)
        coarser = sample_trilinear(merged, Grid((0.0, 0.0, 0.0), 2.0, n // 2), whole.cell_centres())
        merged = coarser + arrived * (here * reading_factor(i, combine) - coarser)
    return merged
