"""Closed forms of radiative exchange between rectangles: what a technique must give in scenes simple enough to solve.

Lambertian, unoccluded. A surface of radiance L in front of a point with form factor F gives the irradiance pi L F.
"""

from __future__ import annotations

from math import pi

import numpy as np


def _corner_form_factor(a, b) -> np.ndarray:
    """Form factor from a point to a parallel rectangle a x b (in units of the distance) with one corner on its normal;
    odd in a and in b, so that rectangles elsewhere are signed sums of four (Howell
    2010, catalogue of configuration factors, B-3)."""
    along_a = a / np.sqrt(1.0 + a * a) * np.arctan(b / np.sqrt(1.0 + a * a))
    along_b = b / np.sqrt(1.0 + b * b) * np.arctan(a / np.sqrt(1.0 + b * b))
    return (along_a + along_b) / (2.0 * pi)


def point_to_parallel_square(side: float, distance: float, offset_u=0.0, offset_v=0.0) -> np.ndarray:
    """Form factor from a point that faces a parallel square plate of `side` at `distance`, metres.

    offset_u, offset_v: the point's displacement from the plate's axis, along its two edges; arrays broadcast.
    Raises ValueError when side or distance is not positive.
    """
    _require_positive(side=side, distance=distance)
    u, v = np.asarray(offset_u, dtype=np.float64), np.asarray(offset_v, dtype=np.float64)
    high_u, low_u = (0.5 * side - u) / distance, (-0.5 * side - u) / distance
    high_v, low_v = (0.5 * side - v) / distance, (-0.5 * side - v) / distance
    upper = _corner_form_factor(high_u, high_v) - _corner_form_factor(low_u, high_v)
    return upper - _corner_form_factor(high_u, low_v) + _corner_form_factor(low_u, low_v)


def irradiance_from_parallel_square(radiance, side: float, distance: float, offset_u=0.0, offset_v=0.0) -> np.ndarray:
    """Irradiance, W/m^2 (lx), at a point facing a parallel Lambertian square plate of `radiance` (nits).

    Geometry as in `point_to_parallel_square`. `radiance` broadcasts with the offsets; pi L F.
    """
    return pi * np.asarray(radiance, dtype=np.float64) * point_to_parallel_square(side, distance, offset_u, offset_v)


def parallel_squares(side: float, distance: float) -> float:
    """Form factor between two equal, directly opposed squares of `side` at `distance`, metres.

    The mean of `point_to_parallel_square` over the other plate (Howell 2010, C-11 with X = Y):
    2 / (pi X^2) * (ln((1 + X^2) / sqrt(1 + 2 X^2)) + 2 X sqrt(1 + X^2) atan(X / sqrt(1 + X^2)) - 2 X atan X).
    Raises ValueError when side or distance is not positive.
    """
    _require_positive(side=side, distance=distance)
    x = side / distance
    root = np.sqrt(1.0 + x * x)
    logarithm = np.log((1.0 + x * x) / np.sqrt(1.0 + 2.0 * x * x))
    return float(2.0 / (pi * x * x) * (logarithm + 2.0 * x * root * np.arctan(x / root) - 2.0 * x * np.arctan(x)))


def squares_with_a_common_edge() -> float:
    """Form factor between two perpendicular squares that share an edge (Howell, catalogue C-14, with W = H = 1)."""
    diagonal = np.sqrt(2.0)
    arcs = 2.0 * np.arctan(1.0) - diagonal * np.arctan(1.0 / diagonal)
    return float((arcs + 0.25 * np.log(0.75)) / np.pi)


def parallel_plates_irradiance(emitted: float, albedo: float, form_factor: float) -> tuple[float, float]:
    """Mean irradiance on a passive and on an emitting plate that face each other, all bounces.

    emitted: exitance M of the emitting plate, W/m^2 (lm/m^2).  albedo: of both plates.  form_factor: between them.
    Radiosities are taken as constant over each plate (exact for infinite plates, F = 1):
    B1 = M + albedo F B2 and B2 = albedo F B1, so E2 = F B1 = F M / (1 - (albedo F)^2) and E1 = albedo F E2.
    Returns (E2, E1). Raises ValueError when albedo * form_factor is not below 1.
    """
    share = albedo * form_factor
    if not 0.0 <= share < 1.0:
        raise ValueError(f"albedo times form factor must be in [0, 1), got {share}")
    passive = form_factor * emitted / (1.0 - share * share)
    return passive, share * passive


def _require_positive(**lengths: float) -> None:
    for name, length in lengths.items():
        if not length > 0.0:
            raise ValueError(f"{name} must be positive, got {length}")
