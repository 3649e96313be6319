"""Lookup: from the accumulated volume to irradiance on a surface.

From intensity to irradiance. A cell stores intensity I(w) at its centre; what irradiance does it cause on a surface
with normal n in the same cell? Two cases are known exactly.

Beam: flux F passes through a cell of size h along d, so its density on a plane across it is F / h^2, and a surface
receives E = F / h^2 * max(0, -n.d). A cell that holds the beam holds the flux F.

Furnace: light is isotropic, the same in every cell. Each cell sends its whole flux Phi on in a step and by symmetry
1/6 of it through each face, which has the area h^2; a wall in the place of a face receives E = Phi / (6 h^2).

The dominant-lobe reading splits a cell into a lobe a Phi along d and an isotropic rest (1 - a) Phi, so

    E = Phi / h^2 * (a * max(0, -n.d) + (1 - a) / 6).

CLPV 3.4 reads E = I(-n) / (h/2)^2 = 4 I(-n) / h^2 (all light at the centre, half a cell before the surface). With
I = Phi / pi along a lobe that is 4/pi = 1.273 times the beam (two-band SH: I = 3/4 Phi / pi, 0.955 times), and with
I = Phi / (4 pi) it is 6/pi = 1.910 times the furnace. Ours is CLPV's with the lobe part times pi/4 and the isotropic
part times pi/6.
"""

from __future__ import annotations

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.grid import Grid

READINGS = ("paper", "thesis", "dominant_lobe")


def sample_trilinear(sh, grid: Grid, points) -> np.ndarray:
    """`sh` [z][y][x][rgb][4] at world `points` (..., 3), filtered as a 3D texture is: float64 (..., 3, 4).

    Cell centres are texel centres; beyond the outermost centres the edge is repeated (clamp to edge). Hardware does
    the same, but commonly rounds the interpolation weights to 1/256.
    """
    sh = np.asarray(sh, dtype=np.float64)
    position = np.clip(grid.to_cells(points) - 0.5, 0.0, grid.n - 1.0)
    low = np.floor(position).astype(np.int64)
    weight = position - low
    high = np.minimum(low + 1, grid.n - 1)
    result = np.zeros((*position.shape[:-1], *sh.shape[3:]))
    for corner in np.ndindex(2, 2, 2):
        upper = np.array(corner, dtype=bool)
        cell = np.where(upper, high, low)
        share = np.prod(np.where(upper, weight, 1.0 - weight), axis=-1)
        result += share[..., None, None] * sh[cell[..., 2], cell[..., 1], cell[..., 0]]
    return result


def irradiance(
    coefficients, normals, cell_size: float, reading: str = "dominant_lobe", scale: float = 1.0
) -> np.ndarray:
    """Irradiance (..., 3), W/m^2 (lx), before albedo, on surfaces with unit `normals` (..., 3).

    coefficients: (..., 3, 4), intensity of the volume at the surface.  cell_size: h, metres.

    - "paper": max(0, I(-n)) / (h/2)^2, two-band SH (Kaplanyan & Dachsbacher 2010, 3.4).
    - "thesis": max(0, coefficients . cosine_lobe(-n)) times the free `scale`, without any distance (Olovsson
      2012, 3.2.4); a unit only once `scale` (1/m^2) is chosen.
    - "dominant_lobe": ours, derived at the top of this module.

    Raises ValueError on an unknown reading.
    """
    towards = -np.asarray(normals, dtype=np.float64)[..., None, :]
    if reading == "paper":
        return np.maximum(0.0, harmonics.evaluate(coefficients, towards)) * 4.0 / cell_size**2
    if reading == "thesis":
        return scale * np.maximum(0.0, np.sum(coefficients * harmonics.cosine_lobe(towards), axis=-1))
    if reading == "dominant_lobe":
        flux, fraction, direction = harmonics.dominant_lobe(coefficients)
        cosine = np.maximum(0.0, np.sum(direction * towards, axis=-1))
        return flux / cell_size**2 * (fraction * cosine + (1.0 - fraction) / 6.0)
    raise ValueError(f"unknown reading '{reading}'; choose one of {', '.join(READINGS)}")


def fluence(coefficients, cell_size: float) -> np.ndarray:
    """Radiance integrated over all directions (..., 3), W/m^2 (lx), at points in the air, by the dominant-lobe reading.

    coefficients: (..., 3, 4), intensity of the volume there.  cell_size: h, metres.

    The two cases of the top of this module: a beam of flux F through a cell has the density F / h^2 on a plane across
    it, which is its fluence; in a furnace a wall receives E = Phi / (6 h^2), pi times the radiance, of which the
    fluence is 4 pi times: 4 E = 2/3 Phi / h^2. So it is Phi / h^2 * (a + (1 - a) 2/3).
    """
    flux, fraction, _ = harmonics.dominant_lobe(coefficients)
    return flux / cell_size**2 * (fraction + (1.0 - fraction) * 2.0 / 3.0)


def damping(sh, grid: Grid, points, normals) -> np.ndarray:
    """Factor (..., 3) in [0, 1] against light that bleeds through a surface, for the "paper" reading.

    sh: [z][y][x][rgb][4].  points: (..., 3) world space.  normals: (..., 3) unit.

    Kaplanyan & Dachsbacher 2010, 3.4, damp where the derivative along the normal is large and deviates from the light
    itself, and give no formula. Ours: with c = c(x) and the difference over one cell g = c(x + n h/2) - c(x - n h/2),
    the factor is c.(c + g) / c.c, clamped to [0, 1]: the part of the light at the point that is
    still there one cell ahead of the surface. It is 1 in a constant field and where there is no light.
    """
    points, normals = np.asarray(points, dtype=np.float64), np.asarray(normals, dtype=np.float64)
    half = 0.5 * grid.cell_size * normals
    here = sample_trilinear(sh, grid, points)
    gradient = sample_trilinear(sh, grid, points + half) - sample_trilinear(sh, grid, points - half)
    square = np.sum(here * here, axis=-1)
    kept = np.sum(here * (here + gradient), axis=-1) / np.where(square > 0.0, square, 1.0)
    return np.where(square > 0.0, np.clip(kept, 0.0, 1.0), 1.0)
