"""The first part of a cone, followed among what the picture shows: voxels blur what is as near as their edges.

A way goes out from a surface that is seen, in steps that grow with the square root of the distance, and each
point on it is compared with what the pixel shows that it falls on: the tangent plane there. In front of it the way is
free. Behind it the way has met that surface, if it was in front of the same plane one step before; else it went behind
what stands nearer to the camera, where the picture knows nothing, and voxels say the rest, from where it went through
that plane at the latest: it may have gone through the surface where a pixel shows what is beside it. So do they where
the way leaves the picture, or what it shows. They resume CLEAR earlier, for voxels there blur what may be met at once.
There is no thickness to be chosen, and flat surfaces are never met by their own ways.

In front of what is shown a way is free only if all surfaces are: a camera looks through the backs of single-sided
ones, as from above into rooms through their ceilings. Where anything has such backs, ways therefore end as high above
what is shown as it may still be in the voxels that are read there (`ceiling`).

Two depths that are compared are of different pixels, so on a plane a nearest pixel's depth alone would shadow what
it slants away from: planes do not (McGuire and Mara 2014, "Efficient GPU screen-space ray tracing", compare depths and
choose a thickness).

What is met reflects its direct light, of which the picture has the diffuse part. What it receives besides is taken for
what the pixel itself receives, as both are near one another (as Jimenez et al. 2016, "Practical real-time strategies
for accurate indirect occlusion", do for ambient occlusion). With the mean albedo k that a pixel's cones meet, what they
bring, F, and the sky between, S, after n reflections it is E(n) = F + k (E(n - 1) + S), E(0) = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..camera import seen_at
from ..gtao import GOLDEN, Seen
from .directions import PHASES, phase_shift

CLEARANCE = 2.0**-6
"""Voxels above the surface that ways start from: its normal has 12 bits in each of two numbers, and is off by 2^-10."""
LEAST_STEPS = 4
CLEAR = 1.5
"""Voxels: a trilinear sample reaches one to either side, and a surface lies up to half of one off the middle of its
own; along a normal that is not along an axis as many times more as the sum of its parts."""
BOUNDLESS = 1e30


class ScreenWay(NamedTuple):
    """met: (m,), whether anything is.  free: (m,), voxels, how far nothing was in the way, or where it is met.  pixel:
    (m, 2), the row and column that shows it, -1 where nothing is met.  margin: (m, 2), by how much anything on the way
    would have had to lie elsewhere for another answer: pixels in the picture, and metres."""

    met: np.ndarray
    free: np.ndarray
    pixel: np.ndarray
    margin: np.ndarray


def ceiling(culls: bool) -> float:
    """Voxels above what is shown up to which ways go. culls: whether anything has backs that are not shown."""
    return CLEAR if culls else BOUNDLESS


def steps_of(reach: float) -> int:
    """So many that the last is 2 voxels long. reach: voxels."""
    return max(LEAST_STEPS, round(reach))


def jitter(number: int, phase: int) -> float:
    """Where in its step a cone looks: its own place among all phases' cones, times the golden ratio, modulo 1."""
    return PHASES * GOLDEN * (number + phase_shift(phase)[0]) % 1.0


def screen_way(seen: Seen, start, towards, reach: float, shift: float, highest: float = BOUNDLESS) -> ScreenWay:
    """From points (m, 3), metres, along vectors (m, 3), as long as a voxel's edge. reach: voxels.  shift: of the
    steps, 0 to 1.  highest: above what is shown, metres."""
    positions, steps, shape = seen.positions(), steps_of(reach), seen.depth.shape
    free, going = np.zeros(len(start)), np.ones(len(start), bool)
    met, pixel = np.zeros(len(start), bool), np.full((len(start), 2), -1)
    margin = np.full((len(start), 2), np.inf)
    for number in range(steps):
        travelled = reach * ((number + shift) / steps) ** 2
        point = start + travelled * towards
        exact = seen_at(seen.camera, point, shape[1], shape[0])[0]
        place = np.floor(exact).astype(int)
        to_edge = np.abs(exact - np.rint(exact)).min(axis=-1)
        margin[going, 0] = np.minimum(margin[going, 0], to_edge[going])
        going &= ((place >= 0) & (place < shape)).all(axis=-1)
        at = tuple(np.where(going[:, None], place, 0).T)
        height = np.sum((point - positions[at]) * seen.geometric[at], axis=-1)
        going &= seen.depth[at] > 0.0
        margin[going, 1] = np.minimum(margin[going, 1], np.abs(height - highest)[going])
        going &= height <= highest
        behind = going & (height < 0.0)
        sinks = -np.sum(towards * seen.geometric[at], axis=-1)
        sunk = (travelled - free) * sinks
        crossed = -height <= sunk
        sure = np.where(behind, np.minimum(-height, np.abs(height + sunk)), np.abs(height))
        margin[going, 1] = np.minimum(margin[going, 1], sure[going])
        met |= behind & crossed
        pixel = np.where((behind & crossed)[:, None], place, pixel)
        going &= ~(behind & ~crossed)
        entered = travelled + height / np.where(sinks > 0.0, sinks, 1.0)
        free = np.where(behind & ~crossed & (sinks > 0.0), np.clip(entered, 0.0, free), free)
        free = np.where(going, travelled, free)
        going &= ~behind
    return ScreenWay(met, free, pixel, margin)


class Shown(NamedTuple):
    """Of a set of ways: met and free as of ScreenWay; light (m, k), which what is met reflects of direct light, and its
    albedo (m, k); both anything where nothing is met."""

    met: np.ndarray
    free: np.ndarray
    light: np.ndarray
    albedo: np.ndarray


def again(found, albedo, sky, bounces: int) -> np.ndarray:
    """E(bounces) + S of the module's text: `found`, `albedo` and `sky` are F, k and S."""
    light = np.zeros_like(found)
    for _ in range(bounces):
        light = found + albedo * (light + sky)
    return light + sky
