"""Where in a geometry volume's cells surfaces block: planes, and strips of them (geometry.py says why)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

STEPS = 32
"""Of a packed density and of a strip's ends, which are rounded, and of a plane's place, which lies in the middle of its
step. Halves, quarters and eighths are whole steps: walls end there often, and what is rounded must not depend on how
places have been."""


class Strips(NamedTuple):
    """What of a cell's three planes blocks, float64 [z][y][x][3] for those across x, y and z. density: share of light
    that the strip blocks.  offsets: where along its axis the plane lies, from 0 to 1 in the cell.  low, high: between
    these the strip lies, in the cell; along the axis after its own (y for x, z for y, x for z), or where `last` along
    the one after that, and all through the cell along the other."""

    density: np.ndarray
    offsets: np.ndarray
    low: np.ndarray
    high: np.ndarray
    last: np.ndarray

    @property
    def shares(self) -> np.ndarray:
        """Of the cell's cross section, what is blocked along x, y and z."""
        return self.density * (self.high - self.low)

    @property
    def strips(self) -> Strips:
        return self

    def cover(self, places: np.ndarray, which: Any = ...) -> np.ndarray:
        """How much of the strips `which` is at `places` (..., 3), in the cell, along their axes: (..., 3).

        Ends within the cell are soft, as nothing says that what is there is a strip, and as light would jump where ways
        pass them: over as much on either side as there is room, to the strip's middle and to the cell's side, at least
        half a step of what is kept. All of it together is as large as with hard ends."""
        low, high = self.low[which], self.high[which]
        half, least = 0.5 * (high - low), 0.5 / STEPS
        from_low = np.clip(0.5 + 0.5 * (places - low) / np.maximum(np.minimum(low, half), least), 0.0, 1.0)
        to_high = np.clip(0.5 + 0.5 * (high - places) / np.maximum(np.minimum(1.0 - high, half), least), 0.0, 1.0)
        return np.where(low == 0.0, 1.0, from_low) * np.where(high == 1.0, 1.0, to_high)


class Planes(NamedTuple):
    """Float64 [z][y][x][3] each. fronts, backs: of the cell's cross section along x, y and z, what surfaces fill whose
    normals point along the axis, and against it, at most 1 each. offsets: where along the axis its plane lies, from 0
    to 1 in the cell; nexts, lasts: where in it their middle does, along the axis after that (y for x, z for y, x for z)
    and the one after both. Of no meaning without a share."""

    fronts: np.ndarray
    backs: np.ndarray
    offsets: np.ndarray
    nexts: np.ndarray
    lasts: np.ndarray

    @classmethod
    def sheets(cls, shares: np.ndarray, offsets: np.ndarray, nexts=0.5, lasts=0.5) -> Planes:
        """Of surfaces that all face along the axes; in the middle of their planes, if nothing else is said."""
        aside = (np.broadcast_to(np.asarray(v, dtype=np.float64), shares.shape) for v in (nexts, lasts))
        return cls(shares, np.zeros_like(shares), offsets, *aside)

    @property
    def shares(self) -> np.ndarray:
        """Of the cell's cross section, what is blocked along x, y and z."""
        return np.maximum(self.fronts, self.backs)

    @property
    def strips(self) -> Strips:
        """The widest ones with the surfaces' middles, along the axis on which they are narrower; the surfaces' share of
        the cross section is spread over them evenly. If that is more than they are, as where surfels are few and their
        mean is not well known, strips as wide as the share, the nearest to it in the cell: a whole wall always fills
        its plane."""
        next_aside, last_aside = np.abs(self.nexts - 0.5), np.abs(self.lasts - 0.5)
        last = last_aside > next_aside + 0.5 / STEPS  # at corners both are as narrow, but for rounding
        middle, share = np.where(last, self.lasts, self.nexts), self.shares
        width = 1.0 - 2.0 * np.where(last, last_aside, next_aside)
        width = np.maximum(width, np.maximum(share, 1.0 / STEPS))
        low = np.clip(middle - 0.5 * width, 0.0, 1.0 - width)
        return Strips(np.minimum(1.0, share / width), self.offsets, low, low + width, last)


Blockers = Planes | Strips


BITS = 0, 6, 11, 17, 23
"""Where in a word the density, the plane's place, the low and the high end, and the axis begin."""


def pack_planes(planes: Planes) -> np.ndarray:
    """Four words for each cell, uint32 [z][y][x][4]: of x, y and z the strip's density, its plane's place, its low and
    its high end, and whether these are along the last axis, or nothing if there is no share; and nothing. The density
    is that of strips with the ends that are kept."""
    of = planes.strips
    low, high = (np.floor(STEPS * end + 0.5) for end in (of.low, of.high))
    density = np.rint(STEPS * np.minimum(1.0, STEPS * planes.shares / np.maximum(high - low, 1.0)))
    place = np.minimum(STEPS * of.offsets, STEPS - 1)
    fields = zip((density, place, low, high, of.last), BITS, strict=True)
    words = np.bitwise_or.reduce([each.astype(np.uint32) << np.uint32(bit) for each, bit in fields])
    words[planes.shares <= 0.0] = 0
    return np.pad(words, [(0, 0)] * 3 + [(0, 1)])


def unpack_planes(words) -> Strips:
    """What `pack_planes` has kept: ends, places and densities to 1/64; of a strip as wide as its share, whose density
    is 1, a share to 1/32."""
    found = np.asarray(words)[..., :3]
    density, place, low, high, last = (
        found >> np.uint32(bit) & ((1 << end - bit) - 1) for bit, end in zip(BITS, (*BITS[1:], 24), strict=True)
    )
    ends = low / STEPS, high / STEPS
    return Strips(density / STEPS, (place + 0.5) / STEPS, *ends, last.astype(bool))
