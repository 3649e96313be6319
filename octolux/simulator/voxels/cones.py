"""Cones through voxels: what a point receives and reflects of the light around it (Drinovsky 2013, "VCT", 5.6).

Directions are those of directions.py.

Sizes. The thesis reads voxels as wide as the cone. A trilinear sample is a tent of their edge s to either side, of
variance s^2 / 6 along each axis; a disc of diameter d has d^2 / 16: s = SIZE d blurs as much as the cone does.

Cover. Voxels hold shares of their sections, so opacity times steps in voxels adds up to the number of surfaces that a
ray meets on the average. They cover what is left of it until nothing is: `surfaces`. That does not depend on the step,
and a wall one voxel thick lets nothing through wherever samples fall, as tents along a way add up to 1. In `medium`
each sample lets (1 - opacity)^step through. Of that wall's tents exp(-2) = 13 % pass then, the mean of log(1 - tent)
over its width being -1: it is right for leaves and fog, whose layers do not know of each other.

Starts, and distance from the own surface: starts.py.

Air. Where it takes a share `absorbed` of light for each voxel of its way, exp(-absorbed t) of what a sample at t finds
arrives (Beer and Lambert). It is not what hides: opacity stays.

A sample stands for the way to the next one, as long as its distance. So where a wall falls between two samples, of
which either sees it through a half of its tent, they cover it together. Where one level follows another, which starts
late for what lies a voxel behind, up to an eighth of a thin wall stays open.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import ceil, inf, pi, sqrt, tan
from typing import Any, NamedTuple

import numpy as np

from ..brdf import alpha_of
from ..reflection import CONE, reflected_direction
from .directions import PHASES, directions, half_angle
from .screen import CLEAR, Shown, again, jitter
from .starts import Plane, Read, cone_start, lifted

SIZE = sqrt(3.0 / 8.0)
LEFT = 2.0**-9
"""Share of a ray that is no longer followed: half a step of an 8-bit picture."""
COVERS = ("surfaces", "medium")

class Sample(NamedTuple):
    """A sample of a cone: where, in voxels of level 0 from its start; on which level; and the length of the way for
    which it stands, in voxels of that level."""

    distance: float
    level: int
    step: float


def first_distance(count: int, width: float) -> float:
    """Voxels of level 0 from a cone's start to where they are as large as it wants."""
    return 1.0 / (width * SIZE * 2.0 * tan(half_angle(count)))


def near_samples(count: int, width: float = 1.0) -> list[Sample]:
    """The first samples of each of `count` cones: adjacent, of level 0, up to where its voxels are as large as the cone
    wants. width: of what is read, over what blurs as much as the cone does."""
    first = first_distance(count, width)
    near = ceil(first - 0.5)
    return [Sample((i + 0.5) * first / near, 0, first / near) for i in range(near)]


def first_level_samples(count: int, per_level: int, width: float = 1.0) -> list[Sample]:
    """Those after them, `per_level` up to where the cone wants voxels twice as large; on each further level they are
    twice as far away. Each stands for the way to the next."""
    first = first_distance(count, width)
    return [Sample(first * (1.0 + i / per_level), 0, first / per_level) for i in range(per_level)]


def diffuse_samples(count: int, depth: int, per_level: int = 2, width: float = 1.0) -> list[Sample]:
    """Of each of `count` cones through (2^depth)^3 voxels, whose coarsest level has 2^3: so that voxels match the cone
    (VCT 5.6), as far as the cube reaches."""
    found, level = near_samples(count, width), 0
    while found[-1].distance < sqrt(3.0) * 2**depth:
        size, top = 2.0**level, min(level, depth - 1)
        own = first_level_samples(count, per_level, width)
        found += [Sample(s.distance * size, top, s.step * size / 2.0**top) for s in own]
        level += 1
    return found


@dataclass(frozen=True)
class Traced:
    """radiance: (m, k), of what rays have met, for what it covers of them.  left: (m,), the share that met nothing;
    open: nothing within a reach."""

    radiance: np.ndarray
    left: np.ndarray
    open: np.ndarray


def _covered(traced: Traced, found: tuple[np.ndarray, np.ndarray], step, cover: str, within: Any = 1.0) -> Traced:
    """step: in voxels of the level that was read.  within: of the step, what lies within the reach."""
    radiance, opacity = found
    if cover == "surfaces":
        share = np.minimum(traced.left, opacity * step)
    else:
        share = traced.left * (1.0 - (1.0 - np.minimum(opacity, 1.0)) ** step)
    scale = np.where(opacity > 0.0, share / np.where(opacity > 0.0, opacity, 1.0), 0.0)
    return Traced(traced.radiance + scale[:, None] * radiance, traced.left - share,
                  traced.open - within * share)  # fmt: skip


def trace(
    read: Read, start, towards, samples: Sequence[Sample], n: int, cover: str = "surfaces", plane: Plane | None = None,
    absorbed: float = 0.0, air_reach: float = inf, free: Any = 0.0,
) -> Traced:  # fmt: skip
    """Wide cones from points `start` (m, 3), voxels, along unit `towards` (m, 3), through n^3 voxels. plane: that they
    start on, if any.  absorbed: of light, for each voxel of its way.  air_reach: voxels, of `open`.  free: (m,),
    voxels from `start` on which nothing is to be met (screen.py).

    The last sample of a cone is where it leaves them, for the way from the one before, of whose level it is.
    """
    reach, traced, before = way_out(start, towards, n), None, Sample(0.0, 0, 0.0)
    for sample in samples:
        leaves = sample.distance > reach
        travelled = np.minimum(sample.distance, reach)
        level = np.where(leaves, float(before.level), float(sample.level))
        points = _along(start, towards, travelled, n)
        light, opacity = read(lifted(points, plane, travelled, towards, 2.0**level, n), level, towards)
        found = light * np.exp(-absorbed * travelled)[:, None], opacity
        traced = traced or Traced(np.zeros_like(light), np.ones(len(start)), np.ones(len(start)))
        step = np.where(leaves, np.maximum(reach - before.distance, 0.0) / 2.0**before.level, sample.step)
        stands = np.maximum(step * 2.0**level, 1e-6)
        step = step * np.clip((travelled + stands - free) / stands, 0.0, 1.0)
        within = np.clip((air_reach - travelled) / np.maximum(step * 2.0**level, 1e-6), 0.0, 1.0)
        traced, before = _covered(traced, found, step, cover, within), sample
    assert traced
    return traced


def _along(start, towards, distance: np.ndarray, n: int) -> np.ndarray:
    """Points (m, 3) on ways that end on the border, which rounding would place outside."""
    return np.clip(start + distance[:, None] * towards, 0.0, n)


def way_out(start, towards, n: int) -> np.ndarray:
    """Voxels from points (m, 3) along unit directions (m, 3) to the border of a grid of n^3; 0 outside."""
    steep = np.where(np.abs(towards) > 1e-12, towards, 1e-12)
    return np.maximum(((np.where(steep > 0.0, n, 0.0) - start) / steep).min(axis=1), 0.0)


def basis(normals) -> np.ndarray:
    """Matrices (m, 3, 3) whose columns are two tangents and the unit normal (m, 3) (Duff et al. 2017)."""
    n = np.asarray(normals, dtype=np.float64)
    side = np.where(n[:, 2] >= 0.0, 1.0, -1.0)
    a = -1.0 / (side + n[:, 2])
    b = n[:, 0] * n[:, 1] * a
    tangent = np.stack([1.0 + side * n[:, 0] ** 2 * a, side * b, -side * n[:, 0]], axis=-1)
    return np.stack([tangent, np.stack([b, side + n[:, 1] ** 2 * a, -n[:, 1]], axis=-1), n], axis=-1)


def above(towards, geometric) -> np.ndarray:
    """Directions that shading normals turn below the surface, mirrored to above it: (m, 3)."""
    return towards - 2.0 * np.minimum(0.0, np.sum(towards * geometric, axis=-1, keepdims=True)) * geometric


def gather(
    read: Read, depth: int, points, normals, geometric=None, *, count: int = 8, phases: Sequence[int] = range(PHASES),
    per_level: int = 2, width: float = 1.0, offset: float = 1.0, cover: str = "surfaces", sky: Callable | None = None,
    absorbed: float = 0.0, air_reach: float = inf, screen: Callable[..., Shown] | None = None, bounces: int = 1,
    to_eye=None,
) -> tuple[np.ndarray, np.ndarray]:  # fmt: skip
    """Irradiance (m, k), radiance's unit times sr, and ambient visibility (m,) at points (m, 3) in voxels.

    normals, geometric: unit (m, 3), of the shading and, where they differ, of the surface.  phases: whose mean is
    taken.  per_level, width: as in `first_level_samples`, `near_samples`.  offset: voxels along the surface's normal
    from which cones start.  sky: radiance (m, k) of unit directions (m, 3), of what is left of cones.  absorbed,
    air_reach: as in `trace`; what meets nothing within the latter is visible.  screen: of unit directions (m, 3) and
    `screen.jitter`, what the picture shows on them; its light is reflected `bounces` times.  to_eye: of `cone_start`.
    """
    normals = np.asarray(normals, dtype=np.float64)
    geometric = normals if geometric is None else np.asarray(geometric, dtype=np.float64)
    start = cone_start(read, depth, points, geometric, to_eye, offset)
    frames, samples = basis(normals), diffuse_samples(count, depth, per_level, width)
    nothing = Shown(np.zeros(len(start), bool), np.zeros(len(start)), np.zeros(1), np.zeros(1))
    visible, each = np.zeros(len(start)), 1.0 / (count * len(phases))
    found, albedo, open_sky = (np.zeros(1) for _ in range(3))
    for number, phase in np.ndindex(count, len(phases)):
        towards = above(frames @ directions(count, phases[phase])[number], geometric)
        shown = screen(towards, jitter(number, phases[phase])) if screen else nothing
        traced = trace(read, start, towards, samples, 2**depth, cover, Plane(geometric, offset), absorbed, air_reach,
                       shown.free - CLEAR)  # fmt: skip
        met = shown.met[:, None]
        through = np.where(shown.met, 0.0, traced.left * np.exp(-absorbed * way_out(start, towards, 2**depth)))
        arrives = shown.light * np.exp(-absorbed * shown.free)[:, None]
        found = found + each * np.where(met, arrives, traced.radiance)
        albedo = albedo + each * np.where(met, shown.albedo, 0.0)
        open_sky = open_sky + each * (through[:, None] * sky(towards) if sky else 0.0)
        visible = visible + each * np.where(shown.met, shown.free > air_reach, traced.open)
    return pi * again(found, albedo, open_sky, bounces), visible


def specular_light(
    read: Read, depth: int, points, normals, geometric, to_eye, roughness, *, offset: float = 1.0, step: float = 1.0,
    cover: str = "surfaces", absorbed: float = 0.0,
) -> tuple[np.ndarray, Traced]:  # fmt: skip
    """Directions (m, 3) and what a cone along each brings, before the BRDF's albedo, to points (m, 3) in voxels.

    The lobe's direction and width are those of simulator/reflection.py: CONE alpha is the edge of voxels that resolve a
    GGX lobe, over the distance. Samples are adjacent (VCT 5.6), `step` voxels of their level apart.
    """
    towards = reflected_direction(to_eye, normals, geometric, roughness)
    start = cone_start(read, depth, points, geometric, to_eye, offset)
    plane = Plane(np.asarray(geometric, dtype=np.float64), offset)
    widening = CONE * np.broadcast_to(alpha_of(roughness), len(start))
    reach, travelled, traced = way_out(start, towards, 2**depth), np.zeros(len(start)), None
    going = np.ones(len(start), bool)
    while going.any():
        level = np.minimum(np.log2(np.maximum(widening * travelled, 1.0)), depth - 1.0)
        size = 2.0**level
        at = np.minimum(travelled + 0.5 * step * size, reach)
        points = _along(start, towards, at, 2**depth)
        light, opacity = read(lifted(points, plane, at, towards, size, 2**depth), level, towards)
        found = light * np.exp(-absorbed * at)[:, None], opacity
        traced = traced or Traced(np.zeros_like(light), np.ones(len(start)), np.ones(len(start)))
        going = (travelled < reach) & (traced.left > LEFT)
        traced = _covered(traced, found, np.where(going, step, 0.0), cover)
        travelled = travelled + step * size
    assert traced
    return towards, traced
