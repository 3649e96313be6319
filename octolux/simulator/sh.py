"""Two-band real spherical harmonics, the directional basis of every light propagation volume.

One convention for the whole code base: all-positive real basis, coefficients in the order (c00, c1-1, c10, c11),
which belong to (1, y, z, x). Olovsson 2012 uses this sign in eq. (7) and the Condon-Shortley sign in eq. (3); the two
cannot be mixed, and (7) is the one in which the band-1 coefficients are a plain vector.
"""

from __future__ import annotations

from collections.abc import Callable
from math import pi, sqrt

import numpy as np

Y0 = 1.0 / (2.0 * sqrt(pi))
"""Value of the constant basis function."""

Y1 = sqrt(3.0) / (2.0 * sqrt(pi))
"""Factor of the three linear basis functions Y1 * (y, z, x)."""

COSINE_LOBE_0 = sqrt(pi) / 2.0
"""Coefficient of band 0 of max(0, d.w): integral of Y0 cos = Y0 * pi (Olovsson 2012, eq. 7)."""

COSINE_LOBE_1 = sqrt(pi / 3.0)
"""Factor of d in band 1 of max(0, d.w): integral of Y1 cos^2 over the hemisphere = Y1 * 2 pi / 3 (eq. 7)."""

VECTOR_TO_BAND1 = (1, 2, 0)
"""Component of an (x, y, z) vector that each of the coefficients 1, 2, 3 belongs to."""

BAND1_TO_VECTOR = (3, 1, 2)
"""Coefficient that each of x, y, z belongs to."""


def basis(directions) -> np.ndarray:
    """The four basis functions at unit `directions` (..., 3): float64 (..., 4)."""
    return _linear(directions, Y0, Y1)


def cosine_lobe(directions) -> np.ndarray:
    """Projection of max(0, d.w) for unit `directions` d (..., 3): float64 (..., 4) (Olovsson 2012, eq. 7).

    Its flux (integral over the sphere) is pi: a surface that reflects flux Phi has intensity Phi/pi times this.
    """
    return _linear(directions, COSINE_LOBE_0, COSINE_LOBE_1)


def _linear(directions, constant: float, slope: float) -> np.ndarray:
    directions = np.asarray(directions, dtype=np.float64)
    band0 = np.full((*directions.shape[:-1], 1), constant)
    return np.concatenate([band0, slope * directions[..., VECTOR_TO_BAND1]], axis=-1)


def evaluate(coefficients, directions) -> np.ndarray:
    """The function with `coefficients` (..., 4) at unit `directions` (..., 3); broadcasts (Olovsson 2012, eq. 5)."""
    return np.sum(np.asarray(coefficients, dtype=np.float64) * basis(directions), axis=-1)


def flux(coefficients) -> np.ndarray:
    """Integral over the sphere of the function with `coefficients` (..., 4): 4 pi Y0 c00 = 2 sqrt(pi) c00."""
    return 2.0 * sqrt(pi) * np.asarray(coefficients, dtype=np.float64)[..., 0]


def vector(coefficients) -> np.ndarray:
    """Band 1 of `coefficients` (..., 4) as a vector (..., 3) in the order x, y, z."""
    return np.asarray(coefficients, dtype=np.float64)[..., BAND1_TO_VECTOR]


def sphere_quadrature(samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Directions (M, 3) and weights (M,) that sum to 4 pi.

    `samples` Gauss-Legendre nodes in z on each hemisphere (so that a kink on the equator costs nothing) times the
    trapezoid rule with 2 * `samples` steps around z, which is exact for trigonometric polynomials of lower degree.
    Raises ValueError for fewer than 2 samples.
    """
    if samples < 2:
        raise ValueError(f"quadrature needs at least 2 samples, got {samples}")
    nodes, weights = np.polynomial.legendre.leggauss(samples)
    z = np.concatenate([0.5 * (nodes - 1.0), 0.5 * (nodes + 1.0)])
    z_weights = np.concatenate([weights, weights]) * 0.5
    phi = np.arange(2 * samples) * (pi / samples)
    radius = np.sqrt(1.0 - z * z)[:, None]
    directions = np.stack(np.broadcast_arrays(radius * np.cos(phi), radius * np.sin(phi), z[:, None]), axis=-1)
    return directions.reshape(-1, 3), np.repeat(z_weights * (pi / samples), 2 * samples)


def project(function: Callable[[np.ndarray], np.ndarray], samples: int = 32) -> np.ndarray:
    """Coefficients (4,) of `function`, which maps directions (M, 3) to values (M,), by quadrature over the sphere
    (Olovsson 2012, eq. 4; `sphere_quadrature` says what it is exact for)."""
    directions, weights = sphere_quadrature(samples)
    return np.einsum("m,m,mc->c", weights, function(directions), basis(directions))


def rotate(coefficients, matrix) -> np.ndarray:
    """Coefficients (..., 4) of f(M^-1 w), the function turned by the rotation `matrix` M (3, 3): band 0 stays, band 1
    turns as a vector."""
    coefficients = np.asarray(coefficients, dtype=np.float64)
    turned = vector(coefficients) @ np.asarray(matrix, dtype=np.float64).T
    return np.concatenate([coefficients[..., :1], turned[..., VECTOR_TO_BAND1]], axis=-1)


def dominant_lobe(coefficients) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`coefficients` (..., 4) of a non-negative intensity read as one cosine lobe plus an isotropic rest:

        I(w) = Phi * (a * max(0, d.w) / pi + (1 - a) / (4 pi))

    Returns the flux Phi (...), the fraction a (...) of it that is in the lobe, and the unit direction d (..., 3).
    Flux and first moment are kept: the lobe a Phi/pi has band 1 of length a (Phi/pi) sqrt(pi/3), and
    Phi = 2 sqrt(pi) c00, hence a = sqrt(3)/2 |c1| / c00. No mix of cosine lobes has a > 1; rounding and
    clamped light can, and then a is 1. Where there is no direction or no flux (c1 = 0 or c00 <= 0) a is 0 and d is 0.
    """
    coefficients = np.asarray(coefficients, dtype=np.float64)
    c00, c1 = coefficients[..., 0], vector(coefficients)
    length = np.linalg.norm(c1, axis=-1)
    directed = (length > 0.0) & (c00 > 0.0)
    fraction = np.minimum(1.0, 0.5 * sqrt(3.0) * length / np.where(directed, c00, np.inf))
    direction = np.where(directed[..., None], c1 / np.where(directed, length, 1.0)[..., None], 0.0)
    return flux(coefficients), fraction, direction


def evaluate_dominant_lobe(coefficients, directions) -> np.ndarray:
    """Intensity (...) of the dominant-lobe reading of `coefficients` (..., 4) at unit `directions` (..., 3); it is
    never negative where the flux is not."""
    total, fraction, axis = dominant_lobe(coefficients)
    cosine = np.maximum(0.0, np.sum(axis * np.asarray(directions, dtype=np.float64), axis=-1))
    return total * (fraction * cosine / pi + (1.0 - fraction) / (4.0 * pi))
