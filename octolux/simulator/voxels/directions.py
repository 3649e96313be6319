"""Directions of diffuse cones (Drinovsky 2013, "VCT", 5.6).

`count` cones have equal shares of the hemisphere's projected area (the unit disc, Nusselt 1928), so that each weighs
pi / count and even light arrives exactly. A cone is as wide as a disc of its share: sin(half) = 1 / sqrt(count), 20.7
degrees for 8. PHASES sets of such cones lie between one another, and pixels of a 4 x 4 tile take one each: their mean
(filtering.py) has 16 times as many directions. In smaller tiles each takes several (`phases_of`).
"""

from __future__ import annotations

from math import asin, pi, sqrt

import numpy as np

PHASES = 16
CONE_TURN = 0.5 * (3.0 - sqrt(5.0))  # of a circle, from cone to cone: the golden angle spreads any number of them
PHASE_TURN = (10.0 + CONE_TURN) / PHASES
"""From one to the next of all cones, by their distance from the middle of the disc: PHASES of them are a turn of
CONE_TURN. So those of a phase lie in a spiral, and those of all phases in a denser one. Of the 16 steps that do so this
one is among the best: a spot with a spread of a tenth of the disc's radius is seen 3 % too bright or too dark by 16 x
16 of them, 7 % by 16 x 8; with phases turned by a step of their own it was 27 % and 38 %."""


def half_angle(count: int) -> float:
    """Of a diffuse cone's axis and its side, radians. Raises ValueError for a count other than 4 to 16."""
    if not 4 <= count <= 16:
        raise ValueError(f"there are 4 to 16 diffuse cones, not {count}")
    return asin(1.0 / sqrt(count))


def phase_shift(phase: int) -> tuple[float, float]:
    """How far a phase's cones are moved: outwards on the disc, in shares of a cone's area, and around, in turns."""
    reversed_bits = int(f"{phase:04b}"[::-1], 2)
    return (reversed_bits + 0.5) / PHASES, (reversed_bits * PHASE_TURN) % 1.0


def phases_of(row: int, column: int, tile: int) -> range:
    """Of a pixel, of a tile with so many along its edge: 1, 2 or 4. Those of one pixel lie far apart."""
    each = PHASES // tile**2
    first = each * (column % tile + tile * (row % tile))
    return range(first, first + each)


def directions(count: int, phase: int) -> np.ndarray:
    """Unit vectors (count, 3) around +z: each in its own ring of the disc, all rings of one area."""
    outwards, around = phase_shift(phase)
    square = (np.arange(count) + outwards) / count
    angle = 2.0 * pi * (np.arange(count) * CONE_TURN + around)
    radius = np.sqrt(square)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1.0 - square)], axis=-1)
