"""Ambient occlusion in screen space by horizons in slices (GTAO), float64.

Jimenez, Wu, Pesce and Jarabo 2016, "Practical real-time strategies for accurate indirect occlusion".

**What is computed.** Ambient visibility is the cosine-weighted share of the hemisphere over a surface that is not
blocked within a radius: V = 1 - 1/pi * integral of w(t) cos dw, where t is the distance at which a ray meets
something and w(t) falls linearly from 1 at (1 - falloff) * radius to 0 at the radius.

**Slices.** Directions are turned about the sight line v: a slice is a half turn of planes through v, and within it a
direction is its angle t from v. A solid angle is |sin t| dt dturn, and the cosine is |p| cos(t - n), where p is the
normal's part in the slice and n its angle from v. So V is the mean over slices of |p| times the two sides' open arcs,
and the arc from v to a horizon has a closed integral (`arc`). The mean is divided by what the same slices give with
nothing in the way: then few slices are exact on an open plane, of whatever slant.

**Horizons.** The depth buffer is a height field seen from the camera: what lies behind a surface counts as solid. So
a side is blocked from its highest sample down to the tangent plane. Samples beyond the radius do not count, which is
also all that is assumed of thickness: a thing is as thick as the radius. (The paper's heuristic lowers the horizon by
a share of what later samples fall short of it, which depends on the number of steps.) Where a sample lies beyond the
radius by less than two steps and the one before within, the surface is taken as straight between them, and its height
at the radius counts: else the tops of all walls would be missed by half a step. Farther off begins another thing,
which must not reach in.

**Falloff.** A linear w is the mean of the step functions of the radii between (1 - falloff) * radius and radius. Each
slice of each pixel takes one of them. (Lowering a sample's horizon with its distance, as is usual, is not this
integral: it shortens the radius.)

**Two radii.** Where the radius is to change from place to place, visibility within one gives way to that within
another (blending.py): within a radius between both other pixels would be found wherever it changes, and it would jump.

**Planes.** A pixel's centre d lies up to half a pixel beside the slice, which is spanned by v and u. It is moved into
it along the tangent plane and across u, so that it keeps its height d.g over that plane and its place d.u: then it
lies at d.u along u and (d.g - d.u g.u) / g.v along v, and planes do not shadow themselves. g is the geometric normal,
whose plane bounds the arcs; the shading normal weighs them, unless it faces away from the camera.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from octolux.scene.cameras import Camera

from .camera import pixel_rays

FALLOFF = 0.5
"""Share of the radius over which a blocker's weight falls from 1 to 0."""
GOLDEN = 0.6180339887498949
"""The golden ratio, of which multiples are spread most evenly: by it the steps of a pixel's sides are shifted."""
BEYOND = 2
"""Steps beyond the radius up to which a sample belongs to the surface of the one before."""
TILE = 4
"""Pixels along the edge of a tile of noise, and of the filter's window."""
LEAST_WEIGHT = 1e-4
"""Weight in the filter of what is no neighbour in space: where nothing is, all of the window counts alike."""


def arc(horizon, normal) -> np.ndarray:
    """Integral of cos(t - normal) sin(t) for t from 0 to `horizon`, radians from the sight line; arrays broadcast."""
    horizon, normal = np.asarray(horizon, dtype=np.float64), np.asarray(normal, dtype=np.float64)
    return 0.25 * (np.cos(normal) - np.cos(2.0 * horizon - normal) + 2.0 * horizon * np.sin(normal))


def tile_noise(rows, columns) -> np.ndarray:
    """Numbers in (0, 1), float64 (..., 3): the slices' turn, the steps' place, the radius's place in its falloff.

    k numbers the pixels of a tile as Bayer's dither matrix does; the three are k, its four bits reversed, and 5 k
    modulo 16, each in the middle of its sixteenth.
    """
    rows, columns = np.asarray(rows), np.asarray(columns)
    mixed = rows ^ columns
    k = (mixed & 1) << 3 | (rows & 1) << 2 | (mixed & 2) | (rows & 2) >> 1
    reverse = (k & 1) << 3 | (k & 2) << 1 | (k & 4) >> 1 | k >> 3
    return (np.stack([k, reverse, 5 * k % 16], axis=-1) + 0.5) / 16.0


@dataclass(frozen=True, eq=False)
class Seen:
    """What a camera sees: depth along its axis, metres, 0 for nothing; geometric and shading normals towards it."""

    camera: Camera
    depth: np.ndarray  # (height, width)
    geometric: np.ndarray  # (height, width, 3)
    normal: np.ndarray  # (height, width, 3)

    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Origins and directions of the pixels' rays; directions of length 1 along the axis."""
        height, width = self.depth.shape
        origins, directions = pixel_rays(self.camera, width, height)
        return origins, directions / (directions @ self.camera.forward)[..., None]

    def positions(self) -> np.ndarray:
        """float64 (height, width, 3), metres."""
        origins, directions = self.rays()
        return origins + self.depth[..., None] * directions

    def pixel_extent(self) -> tuple[np.ndarray, np.ndarray]:
        """What a pixel to the right, and one down, are at each pixel's depth: (height, width, 3), metres."""
        origins, directions = self.rays()
        d = np.where(self.depth > 0.0, self.depth, 1.0)[..., None]
        right = (origins[0, 1] - origins[0, 0]) + d * (directions[0, 1] - directions[0, 0])
        return right, (origins[1, 0] - origins[0, 0]) + d * (directions[1, 0] - directions[0, 0])


def _dot(a, b) -> np.ndarray:
    return np.sum(a * b, axis=-1)


def _unit(v) -> np.ndarray:
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@dataclass(eq=False)
class _Slice:
    """A slice through every pixel: u, the side of its turn; step, its pixels' way in the picture; reach, its radius;
    pixels, the same in the picture; lean, the angle of the geometric normal from the sight line, towards u."""

    u: np.ndarray
    eye: np.ndarray
    step: np.ndarray
    pixels: np.ndarray
    reach: np.ndarray
    lean: np.ndarray


class _Horizons:
    """Finds the horizon of one side of a slice; keeps the margin (`ambient_visibility`) of all that were found."""

    def __init__(self, seen: Seen, steps: int):
        self.seen, self.steps, self.positions = seen, steps, seen.positions()
        rows, columns = np.indices(seen.depth.shape)
        self.grid = np.stack([columns, rows], axis=-1)
        self.margin = np.full(seen.depth.shape, np.inf)

    def cosine(self, cut: _Slice, sign: int, offset: np.ndarray, lowest: np.ndarray) -> np.ndarray:
        """Cosine of the horizon's angle from the sight line, at least `lowest`."""
        highest, far = lowest, (1.0 + BEYOND / self.steps) * cut.reach
        last = (np.zeros_like(highest),) * 3
        for j in range(self.steps):
            away = np.maximum(cut.pixels * ((j + offset) / self.steps), 1.0)
            across, along, distance = self._sample(cut, sign * away)
            within = distance < cut.reach
            leaves = (last[2] < cut.reach) & ~within & (distance < far)
            share = np.where(leaves, (cut.reach - last[2]) / np.where(leaves, distance - last[2], 1.0), 0.0)
            edge = _cosine(last[0] + share * (across - last[0]), last[1] + share * (along - last[1]))
            highest = np.where(within, np.maximum(highest, _cosine(across, along)), highest)
            highest = np.where(leaves, np.maximum(highest, edge), highest)
            last = (across, along, distance)
            self._doubt(np.abs(distance / cut.reach - 1.0), np.abs(distance / far - 1.0))
        return np.minimum(highest, 1.0)

    def _sample(self, cut: _Slice, away: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of the pixel so many pixels away: place across and along the sight line, and distance: metres."""
        place = self.grid + 0.5 + away[..., None] * cut.step
        self._doubt(np.abs(place - np.round(place)).min(axis=-1))
        height, width = self.seen.depth.shape
        at = np.floor(place).astype(int)
        inside = ((at >= 0) & (at < (width, height))).all(axis=-1)
        column, row = np.clip(at[..., 0], 0, width - 1), np.clip(at[..., 1], 0, height - 1)
        d = self.positions[row, column] - self.positions
        distance = np.where(inside & (self.seen.depth[row, column] > 0.0), np.linalg.norm(d, axis=-1), 1e30)
        ahead, g = _dot(d, cut.u), self.seen.geometric
        slope = np.where(self.seen.depth > 0.0, _dot(g, cut.eye), 1.0)
        return ahead, (_dot(d, g) - ahead * _dot(g, cut.u)) / slope, distance

    def _doubt(self, *distances: np.ndarray) -> None:
        for distance in distances:
            self.margin = np.minimum(self.margin, distance)


def _cosine(across: np.ndarray, along: np.ndarray) -> np.ndarray:
    length = np.hypot(across, along)
    return along / np.where(length > 0.0, length, 1.0)


def ambient_visibility(
    seen: Seen, radius: Any, slices: int, steps: int, falloff: float = FALLOFF, noise: bool = True, resolution: int = 1
) -> tuple[np.ndarray, np.ndarray]:
    """Ambient visibility of every pixel, and how sure it is: float64 (height, width) twice.

    radius: metres, a number or (height, width).  noise: as `tile_noise`, else all pixels alike; resolution: how many
    pixels along an edge share their noise.  The second array is the least distance, in pixels, of a sample from the
    edge of its pixel, or of a sample from the radius in lengths of it: where it is small, rounding may take another
    sample. Needs two rows and columns.
    """
    rows, columns = np.indices(seen.depth.shape) // resolution
    noises = tile_noise(rows, columns) if noise else np.full((*seen.depth.shape, 3), 0.5)
    (right, down), eye = seen.pixel_extent(), -_unit(seen.rays()[1])
    normal = np.where((_dot(seen.normal, eye) > 0.0)[..., None], seen.normal, seen.geometric)
    across = _unit(right - eye * _dot(right, eye)[..., None])
    whole, visible, horizons = np.zeros_like(seen.depth), np.zeros_like(seen.depth), _Horizons(seen, steps)
    for i in range(slices):
        turn = ((i + noises[..., 0]) * np.pi / slices)[..., None]
        u = np.cos(turn) * across + np.sin(turn) * np.cross(eye, across)
        step = pixel_step(u, np.cross(eye, u), right, down)
        reach = radius * (1.0 - falloff * ((noises[..., 2] + i / slices) % 1.0))
        pixels = reach / _dot(step[..., :1] * right + step[..., 1:] * down, u)
        cut = _Slice(u, eye, step, pixels, reach, _angle(seen.geometric, u, eye)[0])
        n, weight = _angle(normal, u, eye)
        for number, sign in enumerate((1, -1)):
            limit = 0.5 * np.pi + np.minimum(sign * cut.lean, sign * n)
            offset = (noises[..., 1] + (2 * i + number) * GOLDEN) % 1.0
            highest = horizons.cosine(cut, sign, offset, np.cos(limit))
            whole += weight * arc(limit, sign * n)
            visible += weight * arc(np.arccos(highest), sign * n)
    return np.where(seen.depth > 0.0, visible / np.where(whole > 0.0, whole, 1.0), 1.0), horizons.margin


def pixel_step(u, side, right, down) -> np.ndarray:
    """The step of one pixel's length, (..., 2) columns and rows, that moves along the slice of normal `side` towards u.

    Perspectives stretch angles away from the picture's centre: turns are even about the sight line, not in the picture.
    """
    crossing = _unit(np.stack([_dot(down, side), -_dot(right, side)], axis=-1))
    towards = _dot(crossing[..., :1] * right + crossing[..., 1:] * down, u)
    return np.where((towards > 0.0)[..., None], crossing, -crossing)


def _angle(normal, u, eye) -> tuple[np.ndarray, np.ndarray]:
    """Angle of the normal's part in the slice from the sight line, towards u, and its length."""
    along, ahead = _dot(normal, u), _dot(normal, eye)
    return np.arctan2(along, ahead), np.maximum(np.hypot(along, ahead), 1e-6)


def taken(size: int, resolution: int) -> np.ndarray:
    """Rows (or columns) of the picture that a raw one holds which has each `resolution`-th of them."""
    return np.minimum(np.arange(-(-size // resolution)) * resolution + resolution // 2, size - 1)


def filtered(seen: Seen, raw: np.ndarray, resolution: int = 1) -> np.ndarray:
    """The mean of each pixel's window of TILE x TILE, of neighbours near its tangent plane: float64 (height, width).

    raw: visibility of the pixels in rows and columns `taken`.  The weight falls linearly with the height over that
    plane, to LEAST_WEIGHT at the width of a pixel of `raw` at the pixel's depth.
    """
    height, width = seen.depth.shape
    rows, columns = taken(height, resolution), taken(width, resolution)
    y0, x0 = ((i + resolution // 2) // resolution - TILE // 2 for i in np.indices(seen.depth.shape))
    positions = seen.positions()
    wide = resolution * np.linalg.norm(seen.pixel_extent()[0], axis=-1)
    total, weights = np.zeros((height, width)), np.zeros((height, width))
    for dy, dx in np.ndindex(TILE, TILE):
        y, x = np.clip(y0 + dy, 0, len(rows) - 1), np.clip(x0 + dx, 0, len(columns) - 1)
        there = (y == y0 + dy) & (x == x0 + dx) & (seen.depth[rows[y], columns[x]] > 0.0)
        off = np.abs(_dot(positions[rows[y], columns[x]] - positions, seen.geometric))
        near = np.where(there, np.maximum(1.0 - off / wide, LEAST_WEIGHT), 0.0)
        total, weights = total + near * raw[y, x], weights + near
    return np.where((seen.depth > 0.0) & (weights > 0.0), total / np.where(weights > 0.0, weights, 1.0), 1.0)
