"""Propagation: each step hands the light of every cell to its six neighbours.

The scheme of Kaplanyan & Dachsbacher 2010, 3.3 (the same as Olovsson 2012, 3.2.3): the flux a cell sends to each of
the five faces it sees of a neighbour becomes, in that neighbour, a cosine lobe of the same flux. SH arrays are
float64 [z][y][x][rgb][4], radiant intensity in W/sr (cd) per channel; light that leaves the grid is lost.

Flux. CLPV prints solid_angle / (4 pi) * I(w_c), which is not a flux and loses all but 1/(4 pi) per step;
solid_angle * I(w_c) is meant, and with the reprojection Phi_f / pi keeps energy: over the 30 faces the band-0 part
adds to 4 pi Y0 c00, the flux of the cell, and the band-1 part to zero by symmetry. `gain` multiplies
the flux; it is the step gain, flux after / flux before, of the signed and of the dominant-lobe evaluation. Olovsson's
step, p = 3 times solid_angle / (4 pi) * I with a lobe that lacks the 1/pi, has gain 3 pi / (4 pi) = 0.75.

Evaluations:

- "signed": I(w_c) as the two-band SH has it, negative behind a lobe. Gain exactly 1; linear.
- "clamped": max(0, I(w_c)), the papers' choice. A cosine lobe gains 11 to 14 % in its first step, by its direction,
  since it is negative behind itself. A cell that is non-negative everywhere sends each neighbour light that is again
  non-negative, so for it the step is the signed one and the gain 1: with "face", nothing more than a few tenths of a
  percent follows. With "travel" the reprojected lobes are negative behind themselves again, and flux keeps growing, to
  1.6 times in 30 steps.
- "dominant_lobe": ours. The cell is read as a lobe plus an isotropic rest (`sh.dominant_lobe`). The rest
  sends solid_angle / (4 pi) of its flux to each face; the lobe sends max(0, d.m_f) / sum of max(0, d.m_f), m_f the
  first moment of the face, that is the face's share of the integral of max(0, d.w) but for faces across the horizon.
  Never negative, gain exactly 1.
"""

from __future__ import annotations

from math import pi

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.lpv import bounces, transfer

EVALUATIONS = ("clamped", "signed", "dominant_lobe")
REPROJECTIONS = ("face", "travel")

SIGNED_WEIGHTS = transfer.SOLID_ANGLES[..., None] * harmonics.basis(transfer.CENTRE_DIRECTIONS)
"""Flux through face f when travelling along d = SIGNED_WEIGHTS[d, f] . coefficients: (6, 5, 4)."""


def face_flux(sh, evaluation: str = "clamped") -> np.ndarray:
    """Flux each cell sends through each face of its neighbours: (..., 4) coefficients to (..., 6, 5), W (lm).

    The last two axes are travel direction and face, as in `transfer.FACES`. Raises ValueError on an unknown name.
    """
    sh = np.asarray(sh, dtype=np.float64)
    if evaluation == "dominant_lobe":
        return _dominant_lobe_flux(sh)
    if evaluation not in EVALUATIONS:
        raise ValueError(f"unknown evaluation '{evaluation}'; choose one of {', '.join(EVALUATIONS)}")
    signed = (sh @ SIGNED_WEIGHTS.reshape(30, 4).T).reshape(*sh.shape[:-1], 6, 5)
    return signed if evaluation == "signed" else np.maximum(0.0, signed)


def _dominant_lobe_flux(sh: np.ndarray) -> np.ndarray:
    flux, fraction, direction = harmonics.dominant_lobe(sh)
    towards = np.maximum(0.0, direction @ transfer.MOMENTS.reshape(30, 3).T)
    total = towards.sum(axis=-1, keepdims=True)
    shares = towards / np.where(total > 0.0, total, 1.0)
    isotropic = transfer.SOLID_ANGLES.ravel() / (4.0 * pi)
    sent = flux[..., None] * (fraction[..., None] * shares + (1.0 - fraction[..., None]) * isotropic)
    return sent.reshape(*sh.shape[:-1], 6, 5)


def reprojection_lobes(reprojection: str = "face") -> np.ndarray:
    """Coefficients that one unit of flux through each face becomes in the neighbour: (6, 5, 4), intensity per flux.

    "face": a cosine lobe towards the face's outward normal (both papers). "travel": the same lobe along the direction
    w_c in which the light came. The factor 1/pi gives the lobe the flux of the face: its integral over the
    sphere is pi (Kaplanyan & Dachsbacher 2010, 3.3: Phi_l = Phi_f / pi). Raises ValueError on an unknown name.
    """
    if reprojection not in REPROJECTIONS:
        raise ValueError(f"unknown reprojection '{reprojection}'; choose one of {', '.join(REPROJECTIONS)}")
    return harmonics.cosine_lobe(transfer.NORMALS if reprojection == "face" else transfer.CENTRE_DIRECTIONS) / pi


def shifted(cells: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """`cells` [z][y][x]... as seen by the neighbours along `direction` (x, y, z): zero where there is no source."""
    moved = np.zeros_like(cells)
    source = tuple(slice(max(0, -d), cells.shape[i] - max(0, d)) for i, d in enumerate(direction[::-1]))
    destination = tuple(slice(max(0, d), cells.shape[i] - max(0, -d)) for i, d in enumerate(direction[::-1]))
    moved[destination] = cells[source]
    return moved


def step(
    sh, gain: float = 1.0, evaluation: str = "clamped", reprojection: str = "face", faces: np.ndarray | None = None,
    reflectance: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """One propagation step: S_(i-1) to S_i, both float64 [z][y][x][rgb][4].

    `gain` multiplies all flux; `evaluation` and `reprojection` as described at the top of this module.
    faces: what the cells' faces let through (geometry.face_transmittance), all where None.
    reflectance: with faces, the share that they reflect of what they block (bounces.cell_reflectance), none where None.
    Raises ValueError on an unknown name.
    """
    lobes = reprojection_lobes(reprojection)
    flux = gain * face_flux(sh, evaluation)
    arrived = np.stack([shifted(flux[..., t, :], d) for t, d in enumerate(transfer.DIRECTIONS)], axis=-2)
    passed = arrived if faces is None else arrived * _passing(faces)[..., None, :, :]
    result = np.einsum("zyxctf,tfk->zyxck", passed, lobes)
    if faces is not None and reflectance is not None:
        result += bounces.reflected(arrived, faces, reflectance)
    return result


def _passing(faces: np.ndarray) -> np.ndarray:
    """What each cell's faces, in the order of `transfer.FACES`, let through: [z][y][x][6][5]."""
    met = [[bounces.at_faces(faces, f // 2, f % 2 == 0)[..., t // 2] for f in transfer.FACES[t]] for t in range(6)]
    return np.stack([np.stack(passed, axis=-1) for passed in met], axis=-2)


def propagate(
    sh, iterations: int, gain: float = 1.0, evaluation: str = "clamped", reprojection: str = "face",
    faces: np.ndarray | None = None, reflectance: np.ndarray | None = None,
) -> np.ndarray:  # fmt: skip
    """Accumulated light S_0 + S_1 + ... + S_k after k = `iterations` steps from S_0 = `sh` [z][y][x][rgb][4]
    (Olovsson 2012, 3.2.3, S_A). faces, reflectance: as in `step`, but not in the first one (CLPV 3.3). Raises
    ValueError on an unknown name or a negative number of iterations."""
    if iterations < 0:
        raise ValueError(f"the number of iterations cannot be negative, got {iterations}")
    current = np.asarray(sh, dtype=np.float64)
    accumulated = current.copy()
    for number in range(iterations):
        current = step(current, gain, evaluation, reprojection, faces if number else None, reflectance)
        accumulated += current
    return accumulated


def total_flux(sh) -> np.ndarray:
    """Flux of all cells per colour channel, (3,): the sum of 2 sqrt(pi) c00 over `sh` [z][y][x][rgb][4]."""
    return harmonics.flux(sh).sum(axis=(0, 1, 2))


def centre_of_mass(sh) -> np.ndarray:
    """Flux-weighted mean position of the cells of `sh` [z][y][x][rgb][4] per channel: (3, 3) [rgb][x, y, z], in cell
    indices (a cell's centre is its integer index). NaN where a channel holds no flux."""
    flux = harmonics.flux(sh)
    z, y, x = np.indices(flux.shape[:3])
    weighted = np.einsum("zyxc,zyxk->ck", flux, np.stack([x, y, z], axis=-1).astype(np.float64))
    with np.errstate(invalid="ignore", divide="ignore"):
        return weighted / flux.sum(axis=(0, 1, 2))[:, None]
