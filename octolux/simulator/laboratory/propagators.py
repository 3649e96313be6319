"""Propagators: ways of sending light from cell to cell, by name.

Each is a set of links. A link leads from a cell to the neighbour at its offset; along it goes a flux that is worked out
from the cell's four coefficients, and that becomes a lobe in the neighbour. Every propagator states its step gain, flux
after / flux before for signed evaluation, in the middle of a volume; clamping negative intensities to zero adds to it
(`octolux.simulator.lpv.propagation` says how much, and what the evaluations are).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from math import cos, pi, sin

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.lpv import propagation, transfer

from . import occlusion


@dataclass(frozen=True, eq=False)
class Propagator:
    """One way of propagating.

    name, meaning, source: what it is called, does, and comes from.  gain: its step gain with a factor of 1.
    offsets: (L, 3) int64, to the neighbour of each of the L links, cells.  directions: (L, 3) unit, of the light on it.
    lobes: (L, 4), intensity in the neighbour per flux.  flux: coefficients (..., 4) to flux along the links (..., L).
    """

    name: str
    meaning: str
    source: str
    gain: float
    offsets: np.ndarray
    directions: np.ndarray
    lobes: np.ndarray
    flux: Callable[[np.ndarray], np.ndarray]

    def step(self, cells: np.ndarray, factor: float = 1.0, corners: np.ndarray | None = None) -> np.ndarray:
        """S_(i-1) to S_i, both [z][y][x][4]; all flux times `factor`. corners: the geometry volume [z][y][x][4], n + 1
        along each side, that light has to pass (`occlusion`). Light that leaves the volume is lost.

        It goes by slabs of z whose flux fits into a processor's cache.
        """
        result = np.zeros(np.shape(cells))
        thickness = max(1, _SLAB_CELLS // cells.shape[1] ** 2)
        groups = [(o, np.flatnonzero((self.offsets == o).all(axis=1))) for o in np.unique(self.offsets, axis=0)]
        for low in range(0, len(cells), thickness):
            sent = factor * self.flux(cells[low : low + thickness])
            if corners is not None:
                sent *= occlusion.transmittance(corners[low : low + thickness + 1], self)
            for offset, links in groups:
                _add_shifted(result, sent[..., links] @ self.lobes[links], low, offset)
        return result


_SLAB_CELLS = 8192


def _add_shifted(result: np.ndarray, slab: np.ndarray, low: int, offset: np.ndarray) -> None:
    """Add `slab` [z][y][x][4], which begins at z = `low`, to `result` moved by `offset` (x, y, z), in place."""
    x, y, z = (int(step) for step in offset)
    n, start = len(result), low + z
    first, end = max(0, -start), min(len(slab), n - start)
    if first >= end:
        return
    inside = [(slice(max(0, step), n + min(0, step)), slice(max(0, -step), n - max(0, step))) for step in (y, x)]
    (to_y, from_y), (to_x, from_x) = inside
    result[start + first : start + end, to_y, to_x] += slab[first:end, from_y, from_x]


def _faces(name: str, meaning: str, source: str, evaluation: str, reprojection: str, gain: float = 1.0) -> Propagator:
    """The 30 faces of the six neighbours, as `propagation` has them."""
    return Propagator(
        name, meaning, source, gain,
        np.repeat(transfer.DIRECTIONS, 5, axis=0), transfer.CENTRE_DIRECTIONS.reshape(30, 3),
        propagation.reprojection_lobes(reprojection).reshape(30, 4),
        lambda cells: gain * propagation.face_flux(cells, evaluation).reshape(*np.shape(cells)[:-1], 30),
    )  # fmt: skip


NVIDIA_WEIGHTS = np.tile([22.95668, *[24.26083] * 4], 6) / (4.0 * 180.0)
"""Shares of the sphere as the sample's source has them, far face and four side faces; they add to 1.0000."""


def _clamped(weights: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """max(0, weights . coefficients) for (L, 4) weights: (..., 4) to (..., L)."""
    return np.maximum(0.0, cells @ weights.T)


def _nvidia() -> Propagator:
    directions = transfer.CENTRE_DIRECTIONS.reshape(30, 3)
    return Propagator(
        "nvidia",
        "NVIDIA's weights: shares of the sphere times intensity, as if that were flux, and lobes without the 1/pi. The "
        "gain is pi / (4 pi) times the sample's flux amplifier, here the factor: 3.8 for cascades, 3 for a hierarchy",
        "NVIDIA SDK 11, Diffuse Global Illumination, LPV_Propagate.hlsl; Olovsson 2012, 5.1",
        0.25, np.repeat(transfer.DIRECTIONS, 5, axis=0), directions,
        harmonics.cosine_lobe(transfer.NORMALS.reshape(30, 3)),
        partial(_clamped, NVIDIA_WEIGHTS[:, None] * harmonics.basis(directions)),
    )  # fmt: skip


def _cone_2009() -> Propagator:
    """The cone's zonal coefficients: the integrals of Y0 and of Y1 cos over the directions within 45 degrees."""
    angle = pi / 4.0
    axes = transfer.DIRECTIONS.astype(np.float64)
    vectors = axes[:, harmonics.VECTOR_TO_BAND1]
    band0 = np.full((6, 1), 2.0 * pi * (1.0 - cos(angle)) * harmonics.Y0)
    cones = np.concatenate([band0, pi * sin(angle) ** 2 * harmonics.Y1 * vectors], axis=1)
    solid_angle = 2.0 * pi * (1.0 - cos(angle))
    # Six cones hold 6 * solid_angle of the sphere; what lies between them is made up for, so that the gain is 1.
    weights = cones * (4.0 * pi / (6.0 * solid_angle))
    return Propagator(
        "cone-2009",
        "the first scheme: each of six neighbours gets what a cone of 90 degrees around the direction to its centre "
        "holds, and sends it on as that cone. Printed with a gain of 1.617 (6 cones squared over 4 pi); here 1",
        "Kaplanyan 2009, Light propagation volumes in CryEngine 3, listing of IVPropagateDir",
        1.0, transfer.DIRECTIONS, axes, cones / solid_angle, partial(_clamped, weights),
    )  # fmt: skip


def _ordinates(neighbours: int) -> Propagator:
    """Centre-to-centre links to all neighbours at a distance of at most 1, sqrt 2 or sqrt 3 cells.

    The directions are a quadrature of the sphere, each with the same weight w = 4 pi / L. By the lattice's symmetry
    the sum of w d d^T is 4 pi / 3 times the identity, so the sum of w b(d) b(d)^T is the identity for two bands:
    flux w I(d) sent as an ordinate, intensity b(d) per flux, keeps the sum over cells of all four coefficients.
    """
    reach = {6: 1, 18: 2, 26: 3}[neighbours]
    lattice = np.stack(np.meshgrid(*[[-1, 0, 1]] * 3, indexing="ij"), axis=-1).reshape(-1, 3)
    squares = np.sum(lattice**2, axis=1)
    offsets = lattice[(squares > 0) & (squares <= reach)]
    directions = offsets / np.linalg.norm(offsets, axis=1, keepdims=True)
    basis = harmonics.basis(directions)
    return Propagator(
        f"dom{neighbours}",
        f"discrete ordinates: centre-to-centre transfer to {neighbours} neighbours, signed; flux and direction are "
        "both kept, but light travels along the links alone",
        "Kaplanyan & Dachsbacher 2010, 5 (DOM4 and DOM8 in flatland); Geist et al. 2004",
        1.0, offsets, directions, basis,
        lambda cells: (4.0 * pi / neighbours) * (cells @ basis.T),
    )  # fmt: skip


_CLPV = "Kaplanyan & Dachsbacher 2010, 3.3"
_OURS = "ours: octolux/simulator/lpv/propagation.py"

PROPAGATORS: dict[str, Propagator] = {
    propagator.name: propagator
    for propagator in (
        _faces("clpv", "flux through the faces of the neighbours, clamped at 0, as lobes towards the faces",
               _CLPV, "clamped", "face"),
        _faces("signed", "as clpv, but negative intensities are sent on too: linear", _CLPV, "signed", "face"),
        _faces("clamped-travel", "as clpv, but the lobes point along the way the light came", _OURS,
               "clamped", "travel"),
        _faces("signed-travel", "as signed, but the lobes point along the way the light came", _OURS,
               "signed", "travel"),
        _faces("dominant-lobe", "a cell is read as one lobe and an isotropic rest; lobes towards the faces", _OURS,
               "dominant_lobe", "face"),
        _faces("best", "dominant lobe, lobes along the way the light came: the default of uniform-lpv", _OURS,
               "dominant_lobe", "travel"),
        _faces("thesis", "as clpv with p = 3, solid angle / (4 pi) and lobes without the 1/pi: 3 pi / (4 pi)",
               "Olovsson 2012, 4.2 and 6", "clamped", "face", 0.75),
        _nvidia(), _cone_2009(), _ordinates(6), _ordinates(18), _ordinates(26),
    )
}  # fmt: skip
"""All propagators by name."""
