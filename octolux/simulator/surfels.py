"""Surfels of a whole scene: samples of its triangles on a lattice."""

from __future__ import annotations

import numpy as np

ASIDE = 2.0**-10, 0.618 * 2.0**-10
"""Of the spacing, by which lines lie aside of the middle of the lattice's cells: else they would meet the diagonals of
rectangles, which two triangles share."""

_AT_ONCE = 1 << 22  # lattice points that are tried at a time: some 200 MB


def lattice_samples(corners, origin, spacing: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the lines of a lattice along the axis that is nearest to each triangle's normal meet it.

    corners: (T, 3, 3), world space.  origin: (3,), a corner of the lattice's cells, in whose middle the lines lie, but
    for ASIDE. Returns the triangles' numbers, int64 (M,); weights of their second and third corner, float64 (M, 2); and
    what each stands for of its triangle's area, float64 (M,).

    Each line stands for spacing^2 across the axis. So of a wall across it any square of k spacings, on the lattice,
    has k^2 samples, neither more nor fewer; and triangles smaller than the spacing are met as often as their size says.
    """
    corners = np.asarray(corners, dtype=np.float64)
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    axis = np.abs(normal).argmax(axis=1)
    across = np.stack([(axis + 1) % 3, (axis + 2) % 3], axis=1)[:, None, :]
    flat = (np.take_along_axis(corners - np.asarray(origin), across, axis=2)) / spacing - 0.5 - np.array(ASIDE)
    area = np.take_along_axis(normal, axis[:, None], axis=1)[:, 0] / spacing**2  # twice, with the sense of the winding
    low, high = np.ceil(flat.min(axis=1)).astype(np.int64), np.floor(flat.max(axis=1)).astype(np.int64)
    size = np.where((area != 0.0)[:, None], np.maximum(high - low + 1, 0), 0)
    counts = size.prod(axis=1)
    found = []
    ends = np.cumsum(counts)
    first = 0
    while first < len(counts):
        before = ends[first - 1] if first else 0
        last = max(first + 1, int(np.searchsorted(ends, before + _AT_ONCE, side="right")))
        found.append(_met(first, slice(first, last), flat, area, low, size, counts))
        first = last
    numbers, weights = (np.concatenate([f[i] for f in found]) if found else np.zeros((0,) * (i + 1)) for i in range(2))
    return numbers.astype(np.int64), weights.reshape(-1, 2), 2.0 / np.abs(area[numbers.astype(np.int64)])


def _met(
    first: int, part: slice, flat: np.ndarray, area: np.ndarray, low: np.ndarray, size: np.ndarray, counts: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Numbers and weights of the lattice's points that lie in the triangles of a part."""
    number = first + np.repeat(np.arange(len(counts[part])), counts[part])
    within = np.arange(len(number)) - np.repeat(np.cumsum(counts[part]) - counts[part], counts[part])
    width = size[number, 0]
    point = low[number] + np.stack([within % width, within // width], axis=1)
    a, b, c = (flat[number, i] - point for i in range(3))
    second = (c[:, 0] * a[:, 1] - c[:, 1] * a[:, 0]) / area[number]
    third = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / area[number]
    inside = (second >= 0.0) & (third >= 0.0) & (second + third <= 1.0)
    return number[inside], np.stack([second, third], axis=1)[inside]
