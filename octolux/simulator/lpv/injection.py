"""Injection: every VPL becomes a cosine lobe in the cell before its surface.

A VPL that reflects flux Phi at normal n radiates the intensity I(w) = Phi / pi * max(0, n.w). CLPV 3.1 and OLPV 3.2.2
write Phi <n|w>+ and leave the 1/pi out; `intensity_per_flux` is that factor: 1/pi keeps the flux, 1 is the
thesis. Each VPL is moved half a cell along its normal first, so that it does not light the surface it sits on. Each of
nested grids has all that lies in it, moved by half a cell of its own: what it holds does not depend on the others.
"""

from __future__ import annotations

from math import pi

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.grid import Grid

INT32_MAX = 2**31 - 1

ARITHMETIC_SLACK = 2.0**-20
"""Relative room for rounding in float32 when a coefficient is computed: 16 roundings of 2^-24, of which the product
flux * intensity_per_flux * lobe * scale has four and a normalised normal about six."""

SCALE_EXPONENTS = (-126, 127)
"""Powers of two that are normal float32 numbers."""


def vpl_coefficients(normal, flux, intensity_per_flux: float = 1.0 / pi) -> np.ndarray:
    """SH intensity (M, 3, 4) of VPLs with unit `normal` (M, 3) and reflected `flux` (M, 3), W (lm)."""
    flux = np.asarray(flux, dtype=np.float64)
    return intensity_per_flux * flux[..., :, None] * harmonics.cosine_lobe(normal)[..., None, :]


def vpl_cells(position, normal, grid: Grid) -> np.ndarray:
    """Cells (x, y, z), int64 (M, 3), of VPLs at world `position` (M, 3), moved half a cell along `normal` (M, 3)."""
    return grid.cell_of(np.asarray(position, dtype=np.float64) + 0.5 * grid.cell_size * np.asarray(normal))


def small_object_share(size, cell_size: float) -> np.ndarray:
    """Share of the light of objects of `size` (M,), metres, that goes into cells of `cell_size`: none of those up to
    half a cell, all of those of a cell and more, and smoothly more between.

    Kaplanyan & Dachsbacher 2010, 4.1 inject nothing of an object whose bounding box is smaller than a cell, and 4.2
    "fade out" those that move, as their light would jump from cell to cell. An object that is as long as a cell never
    leaves one all at once. The fade has no steps, so that nothing appears suddenly when a cascade's cells change size.
    """
    x = np.clip(2.0 * np.asarray(size, dtype=np.float64) / cell_size - 1.0, 0.0, 1.0)
    return x * x * (3.0 - 2.0 * x)


def _scatter(values: np.ndarray, cells: np.ndarray, n: int) -> np.ndarray:
    """Sum of `values` (M, ...) by cell: [z][y][x]... of the same type. Cells outside the grid are omitted."""
    kept = np.all((cells >= 0) & (cells < n), axis=-1)
    x, y, z = cells[kept].T
    volume = np.zeros((n, n, n, *values.shape[1:]), dtype=values.dtype)
    np.add.at(volume, (z, y, x), values[kept])
    return volume


def inject(position, normal, flux, grid: Grid, intensity_per_flux: float = 1.0 / pi) -> np.ndarray:
    """Initial light S_0, float64 [z][y][x][rgb][4], W/sr (cd), of M VPLs (Kaplanyan & Dachsbacher 2010, 3.1).

    position: (M, 3) world space, metres.  normal: (M, 3) unit.  flux: (M, 3) reflected flux, W (lm).
    VPLs that lie outside the grid after the move are omitted.
    """
    cells = vpl_cells(position, normal, grid)
    return _scatter(vpl_coefficients(normal, flux, intensity_per_flux), cells, grid.n)


def inject_moments(position, normal, flux, grid: Grid, intensity_per_flux: float = 1.0 / pi) -> np.ndarray:
    """Where in its cells the light of `inject` comes from, [z][y][x][3]: the sum over VPLs of band 0 of all channels
    times the place of the surface, which has not been moved, in cells from the middle of its light's cell."""
    cells = vpl_cells(position, normal, grid)
    weight = vpl_coefficients(normal, flux, intensity_per_flux)[..., 0].sum(axis=-1)
    return _scatter(weight[:, None] * (grid.to_cells(position) - (cells + 0.5)), cells, grid.n)


def fixed_point_scale(total_flux_bound, count: int, intensity_per_flux: float = 1.0 / pi) -> np.ndarray:
    """Largest power of two by which coefficients may be multiplied so that no sum of them overflows an int32.

    total_flux_bound: scalar or (3,), at least the sum of the flux of all VPLs, W (lm).  count: number of VPLs.
    Returns float64 of the bound's shape. Raises ValueError on a negative or unusably large bound, or too many
    VPLs.

    Band 1 of a unit lobe is sqrt(pi/3) d, so no coefficient of a VPL exceeds sqrt(pi/3) * intensity_per_flux * Phi
    (band 0 has sqrt(pi)/2, which is less). Rounding moves each by at most 1/2. The worst case, all VPLs
    in one cell and along one axis, therefore stays in range when

        scale * sqrt(pi/3) * intensity_per_flux * total_flux * (1 + 2^-20) + count / 2 <= 2^31 - 1.

    A power of two makes the multiplication and the division exact. Without any flux every scale will do; it is 1.
    """
    bound = np.asarray(total_flux_bound, dtype=np.float64)
    if not np.isfinite(bound).all() or (bound < 0.0).any():
        raise ValueError(f"the bound of the total flux must be finite and not negative, got {total_flux_bound}")
    room = INT32_MAX - 0.5 * count
    if count < 0 or room < 1.0:
        raise ValueError(f"cannot sum {count} VPLs in an int32 without overflow")
    largest = harmonics.COSINE_LOBE_1 * intensity_per_flux * (1.0 + ARITHMETIC_SLACK) * bound
    exponent = np.where(largest > 0.0, _floor_log2_ratio(room, largest), 0)
    if (exponent < SCALE_EXPONENTS[0]).any():
        raise ValueError(f"a total flux of {total_flux_bound} is too large for float32")
    return np.ldexp(1.0, np.minimum(exponent, SCALE_EXPONENTS[1]))


def _floor_log2_ratio(numerator, denominator) -> np.ndarray:
    """floor(log2(numerator / denominator)) without rounding or overflow: the mantissas are in [1/2, 1)."""
    mantissa_n, exponent_n = np.frexp(numerator)
    mantissa_d, exponent_d = np.frexp(denominator)
    return exponent_n - exponent_d - (mantissa_n < mantissa_d)


def inject_fixed_point(position, normal, flux, grid: Grid, scale, intensity_per_flux: float = 1.0 / pi) -> np.ndarray:
    """The sums that the GPU forms with atomic adds: int64 [z][y][x][rgb][4]; intensity = sum / `scale`.

    Arguments as `inject`; `scale` scalar or (3,), from `fixed_point_scale`. Each coefficient is rounded to the nearest
    integer, halves to even, as WGSL's round() does. Integers add in any order to the same bits.
    """
    per_channel = np.broadcast_to(np.asarray(scale, dtype=np.float64), (3,))[:, None]
    quantised = np.rint(vpl_coefficients(normal, flux, intensity_per_flux) * per_channel).astype(np.int64)
    return _scatter(quantised, vpl_cells(position, normal, grid), grid.n)
