"""Glossy reflections: a ray marched through the cells, as Kaplanyan & Dachsbacher 2010, 7 march the LPV.

Cells hold what surfaces send, I(w) in W/sr, half a cell before them. Surfaces of radiance R and projected area A(w)
send I(w) = R A(w), and cover A(w) / h^2 of the cell's cross section; of a ray that crosses it on a length s they
cover A s / h^3 on average: it brings L = R A s / h^3 = I(-r) / h^2 * s / h. A wall across the way is one layer of
cells, A = h^2 |cos|, each crossed on h / |cos|: L = R, whatever the angle.

A and R are kept apart, R = flux / (pi A): what a ray meets covers it wholly at most, and so brings no more than the
brightest surface has. As lobes around I they would add up where walls meet, to three times a wall's radiance in the
corner of a room. The areas are those of lpv/reflectors.py, by the squares of the normals' components, which add up to
all of it: A n_a^2 towards the ends of the axes. Seen along w a surface covers A |n.w|, A sum(|n_a| |w_a|) where its
normal is against the ray in each component; so what a cell covers along an axis is sqrt(A n_a^2 * A). It is too much
where walls meet in a cell, and a ray is then covered before their corner. Light without any area, from surfaces that no
surfel stands for, counts as a wall's, A = h^2.

The paper averages I(-r) / d^2 over 4 cells d away instead, `paper_light`: no radiance, but an irradiance.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import numpy as np

from octolux.simulator import sh
from octolux.simulator.brdf import alpha_of
from octolux.simulator.lpv.cones import SHORT
from octolux.simulator.reflection import CONE

LEFT = 2.0**-9
"""Share of a ray that is no longer followed: half a step of an 8-bit picture."""

LOOK_AHEAD = 0.5
"""Cells along the longest component of its direction that a ray looks ahead. A wall's light lies in a layer of cells
whose middle is 0 to 1 of them before its plane, and a tent makes it twice as thick: half of it is behind the plane at
worst; of the tent as it is met half a cell ahead, an eighth."""

FORGETS = 0.5
"""What a cell's surfaces still count, a cell further, for the radiance of a plane that is met there. Light lies up to a
cell before its plane, and its tent begins one cell before that: two cells away, a quarter."""

MET = 4.0
"""Planes of surfaces that have been met do not block again: they are cells' whole cross sections, of which the edges
would show, where the surfaces themselves are filtered. At its plane a wall across the way is remembered by a quarter
at least: it was met half a cell ahead, in steps whose middles are up to half a cell from the plane, and its tent's
middle is up to one before; of the tent's two samples x and 1 - x at worst x came two steps before, the other one. Not
within two cells of where the ray began, or changed its level, though, and from there to three less and less: of the
tent of such a wall's light, which begins two cells before the wall, a part lies behind."""

NEAR = 2.0**-6
"""Cover for which what surrounds the ray's start counts as met: the radiance of planes so near that none is."""

LEAST = 1e-3
"""Cover below which nothing is said of a surface's radiance."""


@dataclass(frozen=True)
class Surfaces:
    """The cells of one level [z][y][x]. radiance: (..., 3), surfaces' mean by area, W/(m^2 sr).  areas: (..., 6), by
    the squares of their normals, in h^2, towards +x, -x, +y, -y, +z, -z.  facing: (..., 6), what of the cell's cross
    section they cover, at most 1.  blocked, plane: (..., 3), the geometry volume's shares along x, y and z, and where
    they lie in the cell, from 0 to 1.  origin: of the first cell, counted from the volume's corner.  low, high: (3,),
    where they are read, in cells from the first."""

    radiance: np.ndarray
    areas: np.ndarray
    facing: np.ndarray
    blocked: np.ndarray
    plane: np.ndarray
    origin: tuple[int, int, int]
    low: np.ndarray
    high: np.ndarray


def surface_light(light, squares, cell_size: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """`radiance`, `areas` and `facing` of `Surfaces`, from `light` [z][y][x][rgb][4], W/sr, and the areas `squares`
    [z][y][x][6] of what sends it, by the squares of the normals, in those of `cell_size` (m)."""
    light, squares = np.asarray(light, dtype=np.float64), np.array(squares, dtype=np.float64)
    area = squares.sum(axis=-1)
    unknown = (area <= 0.0) & (light[..., 0].sum(axis=-1) > 0.0)
    _, fraction, direction = sh.dominant_lobe(light[unknown].sum(axis=-2))
    ends = np.stack([np.maximum(direction, 0.0), np.maximum(-direction, 0.0)], axis=-1).reshape(-1, 6)
    squares[unknown] = fraction[:, None] * ends**2 + (1.0 - fraction[:, None]) / 6.0
    area = np.where(unknown, 1.0, area)[..., None]
    radiance = np.where(area > 0.0, sh.flux(light) / (pi * cell_size**2 * np.where(area > 0.0, area, 1.0)), 0.0)
    return radiance, squares, np.minimum(1.0, np.sqrt(squares * area))


def coarser_squares(squares, steps: int) -> np.ndarray:
    """The areas `squares` [z][y][x][6] in cells 2^steps times as large, in their cross sections, at most 1 each."""
    size, n = 1 << steps, squares.shape[0] >> steps
    return np.minimum(1.0, np.sum(squares.reshape(n, size, n, size, n, size, 6), axis=(1, 3, 5)) / size**2)


@dataclass(frozen=True)
class March:
    """What rays have brought, (M, 3), what share of each is left, (M,), and after how many steps, (M,)."""

    radiance: np.ndarray
    left: np.ndarray
    steps: np.ndarray


def march(
    levels: Sequence[Surfaces], start, towards, roughness, base, *, cells: float = 1e6, step: float = 1.0
) -> March:  # fmt: skip
    """Radiance that comes to points `start` (M, 3), in cells of level 0 from the volume's corner, out of unit
    directions `towards` (M, 3): in cells of level `base` (M,) and, as the lobe of `roughness` (M,) widens or windows
    end, of coarser ones.

    step: of their edge, along the direction's longest component, which is how far `cells` of them go at most.

    A step brings the radiance of what faces it half a cell ahead, as far as that covers what is left of the ray. Then
    the geometry volume's planes that it crosses block, if their surfaces have not just been met: backs of surfaces,
    and those of which no surfel is known on this side; and walls that the ray meets at a slant, of whose tent half is
    still behind them. Of what a plane takes the ray brings the mean radiance of what it has met since one or two cells,
    and nothing if it has met nothing. Steps begin on faces of their level's cells, if need be one
    former step earlier, as those of cones.cone_transmittance.
    """
    start, towards = np.asarray(start, dtype=np.float64), np.asarray(towards, dtype=np.float64)
    count, rows = len(start), np.arange(len(start))
    axis = np.abs(towards).argmax(axis=-1)
    longest = np.maximum(np.abs(towards[rows, axis]), 1e-6)
    along, sense = start[rows, axis], np.where(towards[rows, axis] > 0.0, 1.0, -1.0)
    way = towards / longest[:, None]  # for each cell along the longest component, by which all is counted below
    cone = CONE * np.broadcast_to(alpha_of(roughness), count) / longest
    level = np.array(np.broadcast_to(base, count))
    ray = _Rays(way, np.zeros((count, 3)), np.ones(count), np.ones(count), np.zeros((count, 4)))
    steps, before, reached, since = np.zeros(count, dtype=int), np.zeros(count), np.zeros(count), np.zeros(count)
    for i in np.unique(level):
        r = np.nonzero(level == i)[0]
        around = _radiance(levels[i], start[r] / 2.0**i - levels[i].origin, way[r])
        ray.front[r] = NEAR * np.concatenate([around, np.ones((len(r), 1))], axis=-1)
    travelled = -((sense * along) % (step * 2.0**level))
    here, up = _where(levels, level, start, way, travelled + 0.5 * step * 2.0**level, cone)
    going = np.ones(count, dtype=bool)
    while going.any():
        width, next_level = step * 2.0**level, level + up
        end, middle, begin = travelled + width, travelled + 0.5 * width, np.maximum(travelled, reached)
        coarse = step * 2.0**next_level
        from_face = np.where(here, end, travelled - (sense * along + travelled) % coarse)
        next_here, next_up = _where(levels, next_level, start, way, from_face + 0.5 * coarse, cone)
        for i in np.unique(level[here & going]):
            r = np.nonzero(here & going & (level == i))[0]
            of, size = levels[i], 2.0**i
            place = (start[r] + way[r] * (0.5 * (begin + end)[r, None])) / size + LOOK_AHEAD * way[r] - of.origin
            _cover(ray, of, r, place, (end - begin)[r] / size, step)
            at = (start[r] + way[r] * (SHORT * middle[r, None])) / size - of.origin
            ahead = step * np.where(next_up, 1.5, 1.0)[r]  # the first middle of a coarser level is up to so far away
            met = MET * np.clip((middle - since)[r] / size - 2.0, 0.0, 1.0)
            _block(ray, of, r, at, (middle - before)[r] / size, ahead, met)
        steps += here & going
        before, reached = np.where(here, middle, before), np.where(here, end, reached)
        since = np.where(up, reached, since)
        going &= (here | up) & (ray.left > LEFT) & (steps < round(cells / step))
        travelled, level, here, up = from_face, next_level, next_here, next_up
    return March(ray.radiance, ray.left, steps)


@dataclass
class _Rays:
    """way: (M, 3).  radiance: (M, 3), what has come.  left: (M,), what nothing has covered.  passed: (M,), what planes
    have let through.  front: (M, 4), radiance times cover, and cover, of what has just been passed."""

    way: np.ndarray
    radiance: np.ndarray
    left: np.ndarray
    passed: np.ndarray
    front: np.ndarray


def _where(levels: Sequence[Surfaces], level, start, way, middle, cone) -> tuple[np.ndarray, np.ndarray]:
    """Of steps whose middles are so far away, which are made on their `level` (M,), and which on the next."""
    at = (start + way * (SHORT * middle)[:, None]) / (2.0**level)[:, None]
    low, high = (np.array([np.add(getattr(of, name), of.origin) for of in levels])[level] for name in ("low", "high"))
    held = np.all((at >= low) & (at <= high), axis=-1)
    up = (level < len(levels) - 1) & (~held | (cone * middle >= 2.0 * 2.0**level))
    return held & ~up, up


def _cover(ray: _Rays, of: Surfaces, r, place, length, step: float) -> None:
    seen = np.take_along_axis(_filtered(of.facing, place), _faces(ray.way[r]), axis=-1)
    covers = np.sum(seen * np.abs(ray.way[r]), axis=-1) * length
    radiance, share = _radiance(of, place, ray.way[r]), np.minimum(ray.left[r], covers)
    ray.radiance[r] += share[:, None] * radiance
    ray.left[r] -= share
    met = covers[:, None] * np.concatenate([radiance, np.ones((len(r), 1))], axis=-1)
    ray.front[r] = FORGETS**step * ray.front[r] + met


def _faces(way) -> np.ndarray:
    """Numbers (M, 3) of the ends of the axes that rays along `way` (M, 3) see: going towards +x, what faces -x."""
    return np.array([0, 2, 4]) + (way > 0.0)


def _radiance(of: Surfaces, place, way) -> np.ndarray:
    """(M, 3): the mean of the surfaces around places (M, 3), by the areas that rays see of them; 0 without any. What
    faces away, as the other side of a thin wall does, is not in it, bright as it may be."""
    result, faces = np.zeros((len(place), 3)), _faces(way)
    for seen in np.unique(faces, axis=0):
        r = np.all(faces == seen, axis=-1)
        area = of.areas[..., seen].sum(axis=-1, keepdims=True)
        found = _filtered(np.concatenate([area * of.radiance, area], axis=-1), place[r])
        result[r] = np.where(found[:, 3:] > 0.0, found[:, :3] / np.where(found[:, 3:] > 0.0, found[:, 3:], 1.0), 0.0)
    return result


def _block(ray: _Rays, of: Surfaces, r, at, back, ahead, met) -> None:
    """Planes between the last step's middle, or where the cell begins, and this one's, or the cell's end if the next
    lies beyond."""
    x, y, z = np.clip(np.floor(at).astype(int), 0, of.facing.shape[0] - 1).T
    share, plane = of.blocked[z, y, x], of.plane[z, y, x]
    upwards, rate = ray.way[r] > 0.0, np.abs(ray.way[r])
    within = np.where(upwards, at - np.floor(at), 1.0 - (at - np.floor(at)))
    where = np.where(upwards, plane, 1.0 - plane)
    first = np.where(within > back[:, None] * rate, within - back[:, None] * rate, 0.0)
    last = np.where(within + ahead[:, None] * rate >= 1.0, 1.0, within)
    through = 1.0 - np.where((where > first) & (where <= last), share, 0.0)
    ray.passed[r] *= np.prod(np.minimum(1.0, through + met[:, None] * ray.front[r, 3:]), axis=-1)
    blocked = np.maximum(0.0, ray.left[r] - ray.passed[r])
    ray.radiance[r] += (blocked / np.maximum(ray.front[r, 3], LEAST))[:, None] * ray.front[r, :3]
    ray.left[r] -= blocked


def _filtered(cells: np.ndarray, place: np.ndarray) -> np.ndarray:
    """`cells` [z][y][x][k] between the eight cells around places (M, 3): (M, k). Held at the rim."""
    n = cells.shape[0]
    at = np.clip(place, 0.5, n - 0.5) - 0.5
    low = np.minimum(at.astype(int), n - 2)
    part, result = at - low, np.zeros((len(place), cells.shape[-1]))
    for corner in np.ndindex(2, 2, 2):
        x, y, z = (low + corner).T
        weight = np.prod(np.where(np.array(corner) == 1, part, 1.0 - part), axis=-1)
        result += weight[:, None] * cells[z, y, x]
    return result


def paper_light(light, start, towards, cells: int, cell_size: float) -> np.ndarray:
    """Kaplanyan & Dachsbacher 2010, 7, by the letter: the mean over `cells` cells along unit `towards` (M, 3), from
    `start` (M, 3) in cells of the grid, of I(-r) over the square of the distance: (M, 3), W/m^2. light:
    [z][y][x][rgb][4], W/sr, trilinear."""
    result = np.zeros((len(start), 3))
    flat = np.asarray(light, dtype=np.float64).reshape(*np.shape(light)[:3], 12)
    for k in range(1, cells + 1):
        found = _filtered(flat, start + k * np.asarray(towards)).reshape(-1, 3, 4)
        result += np.maximum(0.0, sh.evaluate(found, -np.asarray(towards)[:, None])) / (k * cell_size) ** 2
    return result / cells
