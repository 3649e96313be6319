"""Single scattering along a line of sight: what frame/fog.wgsl works out, step by step in float64.

A medium has the scattering s and the absorption a, 1/m, times a density; x = s + a is its extinction. Along a line with
the length l in the medium, whose point at t receives the fluence F(t) (radiance integrated over all directions, lx or
W/m^2), isotropic scattering sends

    L = integral of s(t) / (4 pi) * F(t) * exp(-integral of x from 0 to t) dt

to the eye, and what is behind is multiplied by T = exp(-integral of x over l). In a step of even x and F the integral
is s / (4 pi) * F * (1 - exp(-x d)) / x (Hillaire 2015, "Physically based and unified volumetric rendering in
Frostbite"). A light brings its illuminance on a plane that faces it, times what the medium leaves of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from math import pi

import numpy as np

from ..scene.lights import DirectionalLight, PointLight, SpotLight
from ..scene.medium import Medium
from .direct import incident

Box = tuple[np.ndarray, np.ndarray]
Fluence = Callable[[np.ndarray], np.ndarray]


def span(origins, directions, box: Box) -> tuple[np.ndarray, np.ndarray]:
    """Where lines (..., 3) enter and leave a box, in lengths of their directions (...), from 0 on. They miss it where
    the second is not larger."""
    origins, directions = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
    with np.errstate(divide="ignore", invalid="ignore"):
        faces = np.stack([(np.asarray(corner) - origins) / directions for corner in box])
    ends = np.array([-np.inf, np.inf]).reshape(2, *[1] * (faces.ndim - 1))
    faces = np.where(np.isnan(faces), ends, faces)  # a line within a face never leaves that slab
    return np.maximum(faces.min(axis=0).max(axis=-1), 0.0), faces.max(axis=0).min(axis=-1)


def density(medium: Medium, box: Box, positions) -> np.ndarray:
    """Of a medium at points (..., 3): float64 (...); 0 outside of the box, linear between the centres of cells."""
    share = (np.asarray(positions, np.float64) - box[0]) / (np.asarray(box[1]) - box[0])
    inside = ((share >= 0.0) & (share <= 1.0)).all(axis=-1)
    if medium.density is None:
        return inside.astype(np.float64)
    cells = np.array(medium.density.shape[::-1])
    place = np.clip(share * cells - 0.5, 0.0, cells - 1.0)
    low = np.floor(place).astype(np.int64)
    part, high = place - low, np.minimum(low + 1, cells - 1)
    result = np.zeros(share.shape[:-1])
    for corner in np.ndindex(2, 2, 2):
        upper = np.array(corner, bool)
        cell, weight = np.where(upper, high, low), np.prod(np.where(upper, part, 1.0 - part), axis=-1)
        result += weight * medium.density[cell[..., 2], cell[..., 1], cell[..., 0]]
    return np.where(inside, result, 0.0)


def depth(medium: Medium, box: Box, origins, directions, distances, steps: int = 64) -> np.ndarray:
    """Density times length (...), metres, from points (..., 3) along unit directions (..., 3) as far as `distances`
    (...): by the midpoint rule, which is exact where the density is even."""
    origins, directions = np.asarray(origins, np.float64), np.asarray(directions, np.float64)
    first, last = span(origins, directions, box)
    length = np.maximum(np.minimum(last, distances) - first, 0.0)
    if medium.density is None:
        return length
    total = np.zeros(length.shape)
    for number in range(steps):
        at = first + (number + 0.5) / steps * length
        total += density(medium, box, origins + at[..., None] * directions)
    return total / steps * length


def light_fluence(
    light: DirectionalLight | PointLight | SpotLight, medium: Medium, box: Box, positions, steps: int = 64,
    inverse_square: bool = True,
) -> np.ndarray:  # fmt: skip
    """(..., 3), lx: what a light brings to points (..., 3) through the medium, past nothing else; inverse_square: as in
    direct.incident."""
    to_light, illuminance = incident(light, positions, inverse_square)
    distances: np.ndarray | float = np.inf
    if not isinstance(light, DirectionalLight):
        distances = np.linalg.norm(np.asarray(light.position) - positions, axis=-1)
    passed = depth(medium, box, positions, to_light, distances, steps)
    return illuminance * np.exp(-medium.extinction * passed[..., None])


def of_lights(
    lights: Sequence, medium: Medium, box: Box, steps: int = 64, inverse_square: bool = True
) -> Fluence:  # fmt: skip
    """The fluence of all `lights`, for `single_scattering`; steps: through a density; inverse_square: as in
    direct.incident."""
    return lambda positions: sum(
        (light_fluence(light, medium, box, positions, steps, inverse_square) for light in lights),
        start=np.zeros(positions.shape),
    )


def single_scattering(
    medium: Medium, box: Box, origin, direction, distance: float, fluence: Fluence, steps: int = 256
) -> tuple[np.ndarray, np.ndarray]:
    """Radiance (3,), nits, that the medium sends along a line of sight, and what it leaves (3,) of what is behind.

    origin: (3,).  direction: (3,), unit.  distance: to what is seen, metres, or infinity.  fluence: at points (..., 3).
    """
    origin, direction = np.asarray(origin, np.float64), np.asarray(direction, np.float64)
    first, last = span(origin, direction, box)
    length = max(min(float(last), distance) - float(first), 0.0)
    step = length / steps
    points = origin + (first + (np.arange(steps)[:, None] + 0.5) * step) * direction
    optical = step * density(medium, box, points)[:, None] * medium.extinction  # (steps, 3)
    before = np.exp(-np.concatenate([np.zeros((1, 3)), np.cumsum(optical, axis=0)]))
    extinction = medium.extinction
    albedo = np.divide(medium.scattering, extinction, out=np.zeros(3), where=extinction > 0.0)
    scattered = albedo / (4.0 * pi) * fluence(points) * before[:-1] * -np.expm1(-optical)
    return scattered.sum(axis=0), before[-1]
