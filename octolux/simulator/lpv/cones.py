"""Cones through the geometry volume: what of a way its strips let through (strips.py).

A cone is marched from a point to a node, on the level whose cells are half as wide as the cone is there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from octolux.simulator.lpv.strips import Blockers, Strips

CONE_LENGTH = 5.0
"""Length over cell size at which the march along a cone goes on to the next level. A node is read from 1.5 to 3.5 of
its sizes away (gathering.py), 2.5 on average: the cone to it is 1/2.5 as wide as it is long, and cells of half its
width resolve what lies in it. Nodes of the coarsest level that is read stand beyond 3.5 of their sizes for nodes twice
as large, and are twice as many of their own sizes away: cones to them are half as wide, and this is twice as much."""

LEFT_OUT = 0.5
"""Cells before a node's light that do not block it at least: as far as the cell that has it goes on from its middle."""

SHORT = 0.9999
"""Points are read a little before where they lie, so that rounding decides nothing where a way passes through edges."""

FADE = 2.0
"""Cells of a level over which two of its steps give way to one of the next level, before it ends. Fewer would make
light change faster when the end moves. With more, two such pairs would give way at once; and as many cells of the next
level lie between the ends of both at least, in windows of 16^3 (2 1/4) and where cones get too wide (1 + 5 / sqrt(3)),
so that the next level's steps do not give way already where they take over."""

WHOLE = np.array([[-np.inf] * 3, [np.inf] * 3])
"""`ends` (2, 3) of a level that a way does not leave."""

TOUCHES = 1e-6
"""Of a unit vector's components those that no way ever leaves a level by."""


@dataclass(frozen=True)
class _Level:
    """What blocks in cells that are `width` of those of level 0 wide, the first of them number `origin` (3,).
    ends: (2, 3), in its cells, where ways leave it."""

    blockers: Strips
    width: float
    origin: np.ndarray
    ends: np.ndarray

    @classmethod
    def of(cls, levels: Sequence[Blockers], origins, ends) -> list[_Level]:
        origins = np.zeros((len(levels), 3), dtype=int) if origins is None else np.asarray(origins)
        ends = np.full((len(levels), 2, 3), WHOLE) if ends is None else np.asarray(ends)
        each = enumerate(zip(levels, origins, ends, strict=False))
        return [cls(blockers.strips, 2.0**i, origin, where) for i, (blockers, origin, where) in each]

    @property
    def gives_way(self) -> bool:
        return bool(np.isfinite(self.ends).any())


@dataclass(frozen=True)
class _Ways:
    """M ways from points `start` in cells of level 0, the unit vectors `towards` their ends. How far a way has
    travelled is counted along its axis, that of its longest component, on which it goes by `sense` (1 or -1) from
    `along`. longest: that component's size. whole: the way's length, so counted. last: before which layers begin that
    count. step: of one cell along the axis, (M, 3), signed. cone_length: CONE_LENGTH, or more for narrower cones."""

    start: np.ndarray
    towards: np.ndarray
    along: np.ndarray
    sense: np.ndarray
    longest: np.ndarray
    whole: np.ndarray
    last: np.ndarray
    step: np.ndarray
    cone_length: float

    @classmethod
    def between(cls, cone_length: float, start, end, node_size, room) -> _Ways:
        distance = np.linalg.norm(end - start, axis=-1)
        towards = (end - start) / np.where(distance > 0.0, distance, 1.0)[:, None]
        axis = np.abs(towards).argmax(axis=-1)[:, None]
        along, signed = (np.take_along_axis(a, axis, axis=-1)[:, 0] for a in (start, towards))
        longest = np.maximum(np.abs(signed), 1e-6)
        whole = distance * longest
        own = np.minimum(0.5 * node_size, room * longest)
        last = whole - np.maximum(LEFT_OUT, own) - 0.25  # never half-way by rounding
        last = np.where(last > 0.5, last, -np.inf)  # nothing but the start's own cell
        sense = np.where(signed > 0.0, 1.0, -1.0)
        return cls(start, towards, along, sense, longest, whole, last, SHORT * towards / longest[:, None], cone_length)

    def into(self, travelled: np.ndarray, width: float) -> np.ndarray:
        """How far in its layer of cells so wide each way is."""
        return self.sense * (self.along + self.sense * travelled) % width

    def end_of_steps(self, travelled: np.ndarray, width: float) -> np.ndarray:
        """How far steps of so wide a level count, if one of them ends after `travelled`: as long as their layers begin
        before `last`."""
        return self.last + self.into(travelled, width)

    def leaves(self, ends: np.ndarray, width: float) -> np.ndarray:
        """How far ways stay on a level: between its `ends` (2, 3), in its cells, and until FADE cells beyond the length
        from which their cones are too wide."""
        bound = width * np.where(self.towards > 0.0, ends[1], ends[0])
        with np.errstate(divide="ignore", invalid="ignore"):
            room = (bound - self.start) / self.step
        room = np.where(np.abs(self.towards) > TOUCHES, room, np.inf)
        return np.minimum(2.0 * self.cone_length * width * self.longest + FADE * width, room.min(axis=-1))

    def passed(self, here, level: _Level, travelled: np.ndarray) -> np.ndarray:
        """What a level's cells let through where the steps of ways `here` (M,) bool end after `travelled`, 1 elsewhere.
        Of the start's own cell on coarser levels, what lies behind its cell of level 0 belongs to a step that ends at
        the start, or would before it."""
        result, width = np.ones(len(self.start)), level.width
        ends = np.clip(travelled, 0.0, self.whole)
        at = (self.start + self.step * ends[:, None])[here] / width - level.origin
        ahead = np.minimum((self.whole - ends) / width, 1.0)
        back = np.minimum((ends - 0.5) / width, 1.0) if width > 1.0 else np.ones_like(ends)
        result[here] = _let_through(level.blockers, at, self.step[here], back[here, None], ahead[here, None])
        return result


def cone_transmittance(
    levels: Sequence[Blockers], start, end, node_size, origins=None, ends=None, *, room=np.inf,
    cone_length: float = CONE_LENGTH,
) -> np.ndarray:  # fmt: skip
    """Share (M,) of light that passes from points `end` (M, 3) in nodes of `node_size` (M,) to points `start` (M, 3),
    in the middle of cells, in cells of level 0: a cone from a point to the node, marched on the level whose cells are
    half as wide as the cone.

    Each step goes one cell of its level along the direction's longest component and reads the cell where it ends: the
    first of the next level is another of the former, so that there is no gap (`_let_through`), and each layer of cells
    across that component is crossed. What lies on both levels there counts on both: a wall stays closed.
    The start's own cell is left out, as its surfaces are up to half a cell behind its middle, and layers that begin,
    before `end`, within half the node, if it goes on so far (`room` (M,), from `end` towards `start`), which is where
    its own surfaces lie: they are what the light goes to and comes from. cone_length: CONE_LENGTH, or more for nodes
    that look smaller.

    Of a level whose array does not hold all of space, but begins at the cell `origins` (levels, 3), ways are marched
    between its `ends` (levels, 2, 3), in its cells. Before that, or before the cone is too wide, its steps give way to
    the next level's, two to one in the same layer of its cells (`_give_way`).
    """
    ways = _Ways.between(cone_length, *(np.asarray(a, dtype=np.float64) for a in (start, end, node_size, room)))
    made = _Level.of(levels, origins, ends)
    passed, travelled = np.ones(len(ways.whole)), np.ones(len(ways.whole))
    going = np.ones(len(passed), dtype=bool)
    for number, level in enumerate(made):
        until = ways.end_of_steps(travelled, level.width)
        if level.gives_way:
            passed, travelled = _give_way(ways, made[number : number + 2], going, until, passed, travelled)
            continue
        limit = 2.0 * cone_length * level.width * ways.longest if number + 1 < len(made) else np.inf
        here = going & (travelled < until)
        while here.any():
            passed = passed * ways.passed(here, level, travelled)
            travelled = np.where(here, travelled + level.width, travelled)
            here &= (travelled < until) & (travelled < limit)
        going &= travelled < until
    return passed


def _give_way(ways: _Ways, levels: Sequence[_Level], going, until, passed, travelled) -> tuple[np.ndarray, np.ndarray]:
    """Ways through a level that ends, and on: what `passed` then, and where the next level's first step ends.

    Its steps are taken by pairs, the two that end in one layer of the next level's cells: with the second of each ends
    a step of the next level, wherever this one ends. That goes on with the step of the last pair once more, whose cell
    may reach farther aside than those of the pair. So there is a march for each number of pairs, and where a level ends
    between two of them both are mixed: the second pair with the step of the first, by FADE.
    """
    width = levels[0].width
    leaves = ways.leaves(levels[0].ends, width)
    first = travelled - np.where(ways.into(travelled, 2.0 * width) < width, 0.0, width)
    here = going & (first < until + 2.0 * width) & (first + width < leaves)
    while here.any():
        second = first + width
        fine = ways.passed(here & (first >= travelled) & (first < until), levels[0], first)
        fine *= ways.passed(here & (second < until), levels[0], second)
        share = np.clip((leaves - second) / (FADE * width), 0.0, 1.0)
        coarse = ways.passed(here & (share < 1.0), levels[1], first - width)
        passed = passed * np.where(here, share * fine + (1.0 - share) * coarse, 1.0)
        first = np.where(here, first + 2.0 * width, first)
        here &= (first < until + 2.0 * width) & (first + width < leaves)
    return passed, first - width


def _let_through(blockers: Strips, at, step, back, ahead) -> np.ndarray:
    """What one step's cell lets through (M,): the product of 1 - density over the strips that are crossed.

    at: (M, 3), where the step ends, in cells. step: (M, 3), of one cell along its longest component. back, ahead:
    (M, 1), how much of such a step it is from the one before, and on to the next, at most 1.

    Cells are read where steps end, but each plane is crossed by one step: between the end of the one before, or the
    cell's beginning if that lies in another along this axis, and its own, or the cell's end if the way goes on
    beyond. So parts of a way within a cell follow on one another without gaps. Where the way is beside the cell when
    it crosses the plane, the cell's side counts.
    """
    cell = np.clip(np.floor(at).astype(int), 0, blockers.density.shape[0] - 1)
    x, y, z = cell.T
    density, plane = blockers.density[z, y, x], blockers.offsets[z, y, x]
    fraction, size, upwards = at - np.floor(at), np.abs(step), step > 0.0
    within = np.where(upwards, fraction, 1.0 - fraction)  # counted along the way, as all below
    there = np.where(upwards, plane, 1.0 - plane)
    begin = np.where(within > back * size, within - back * size, -1.0)
    end = np.where(within + ahead * size >= 1.0, 2.0, within)
    crossed = (there > begin) & (there <= end)
    further = (there - within) / np.maximum(size, 1e-6)  # steps from where this one ends to the plane
    beside = (np.roll(fraction, -k, axis=-1) + further * np.roll(step, -k, axis=-1) for k in (2, 1))
    covered = blockers.cover(np.clip(np.where(blockers.last[z, y, x], *beside), 0.0, 1.0), (z, y, x))
    return np.prod(1.0 - np.where(crossed, density * covered, 0.0), axis=-1)
