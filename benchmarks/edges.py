"""Where a picture of direct light is free of shadow edges, told from the reference alone."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from octolux.scene.lights import Light
from octolux.simulator.direct import incident, lambert_radiance

DISTANCE = 2
"""Pixels that a pixel away from edges keeps from them, in rows and columns."""
GRAZING = 0.1
"""Cosine below which a light counts as grazing."""
CREASE = np.cos(np.radians(10.0))
"""Cosine between neighbouring normals below which there is a crease."""
STEP = 0.01
"""Distance of a neighbour from the tangent plane, relative to its depth, above which it is another surface."""


def unshadowed(lights: Sequence[Light], truth) -> np.ndarray:
    """What each light alone would bring without shadows, by the closed form: (lights, height, width, 3), nits."""
    return np.stack([lambert_radiance(light, truth["position"], truth["normal"], truth["albedo"]) for light in lights])


def lit_by(lights: Sequence[Light], truth) -> np.ndarray:
    """Which lights reach each pixel, as a number whose bit i is light i: the set whose sum is nearest to `direct`."""
    alone, direct = unshadowed(lights, truth), truth["direct"].astype(np.float64)
    misses = []
    for chosen in product((0, 1), repeat=len(lights)):
        misses.append(np.abs(np.tensordot(chosen, alone, axes=1) - direct).sum(axis=-1))
    sets = np.array([sum(bit << i for i, bit in enumerate(c)) for c in product((0, 1), repeat=len(lights))])
    return sets[np.argmin(misses, axis=0)]


def grazing(lights: Sequence[Light], truth) -> np.ndarray:
    """Where some light comes from above the surface but at a cosine below GRAZING: bool (height, width)."""
    cosines = [np.sum(truth["normal"] * incident(light, truth["position"])[0], axis=-1) for light in lights]
    return np.any([(c > 0.0) & (c < GRAZING) for c in cosines], axis=0)


def _differs(truth, lit: np.ndarray, axis: int) -> np.ndarray:
    """Between each pixel and the next along `axis`: does visibility, the surface or its normal change?"""
    size = lit.shape[axis]

    def pair(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return values.take(range(size - 1), axis), values.take(range(1, size), axis)

    (n0, n1), (p0, p1) = pair(truth["normal"].astype(np.float64)), pair(truth["position"].astype(np.float64))
    (lit0, lit1), (mask0, mask1), (depth0, _) = pair(lit), pair(truth["mask"]), pair(truth["depth"])
    crease = np.sum(n0 * n1, axis=-1) < CREASE
    step = np.abs(np.sum((p1 - p0) * n0, axis=-1)) > STEP * depth0
    return (lit0 != lit1) | (mask0 != mask1) | crease | step


def away_from_edges(lights: Sequence[Light], truth) -> np.ndarray:
    """Masked pixels away from shadow edges: bool (height, width).

    An edge lies between two neighbours (of a row or a column) where the set of lights that reach them changes, or where
    the surface does: the mask, a normal turned by more than 10 degrees, a neighbour off the tangent plane by more than
    1 % of the depth (a shadow map's filter there reaches another surface). Pixels within 2 rows and columns of an edge
    are left out, and those under a light at a cosine between 0 and 0.1.
    """
    lit = lit_by(lights, truth)
    near = np.zeros(lit.shape, bool)
    for axis in (0, 1):
        between = _differs(truth, lit, axis)
        near |= _both_sides(between, axis)
    return truth["mask"] & ~_grown(near, DISTANCE - 1) & ~grazing(lights, truth)


def _both_sides(between: np.ndarray, axis: int) -> np.ndarray:
    none = np.zeros_like(between.take([0], axis))
    return np.concatenate([between, none], axis) | np.concatenate([none, between], axis)


def _grown(marked: np.ndarray, distance: int) -> np.ndarray:
    """`marked` and all pixels within `distance` rows and columns of it."""
    padded = np.pad(marked, distance)
    height, width = marked.shape
    shifts = product(range(2 * distance + 1), repeat=2)
    return np.any([padded[y : y + height, x : x + width] for y, x in shifts], axis=0)
