"""What stands and hangs in the atrium: water, plants in pots, lanterns, doors and shutters."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..meshes import Mesh
from .architecture import moved
from .courtyard import (
    ARCH,
    BAY,
    CLAY,
    CURTAINS_SHADE,
    GALLERY,
    HALF_LENGTH,
    HALF_WIDTH,
    IRON,
    LEAF,
    OUTER,
    SPRING,
    STONE,
    WALL,
    WATER,
    WOOD,
)
from .placing import placed, transformed
from .plants import shrub
from .round_shapes import polygon, tube
from .shapes import box, merge, revolve


def courtyard_details() -> Iterator[Mesh]:
    """All of them in world space, metres; material indices are those of `courtyard`."""
    yield _water()
    pot, wood, leaves = _potted_shrub()
    for part in (pot, wood, leaves):
        copies = [transformed(part, placed(x, 0.0, z, 70.0 * i)) for i, (x, z) in enumerate(_pot_places())]
        yield merge(copies, part.name)
    for side, turns in (("shade", 0), ("sun", 2)):
        for part in (_lanterns(), *_doors()):
            yield moved(part, quarter_turns=turns, name=f"{part.name} ({side})")


def _water() -> Mesh:
    """In the basin and in the bowl of the fountain."""
    angle = np.arange(40) * 2.0 * np.pi / 40
    ring = np.stack([np.sin(angle), np.zeros(40), np.cos(angle)], axis=1)
    levels = ((0.98, 0.47), (0.46, 1.16))
    return merge([polygon(ring * r + np.array([0.0, y, 0.0]), material=WATER) for r, y in levels], "water")


def _pot_places() -> list[tuple[float, float]]:
    """In front of every other column, alternating between the sides, and at the four corners."""
    front = HALF_WIDTH - WALL / 2.0 - 0.42
    alternating = [(x, front * (-1.0) ** i) for i, x in enumerate((-5.0, -2.5, 2.5, 5.0))]
    return alternating + [(x, z) for x in (-9.4, 9.4) for z in (-front, front)]


def _potted_shrub() -> list[Mesh]:
    pot = revolve([(0.01, 0.0), (0.19, 0.0), (0.19, 0.0), (0.29, 0.46), (0.33, 0.46), (0.33, 0.46), (0.34, 0.56),
                   (0.34, 0.56), (0.30, 0.56), (0.30, 0.56), (0.27, 0.48), (0.01, 0.48)],
                  segments=32, material=CLAY, name="pots")  # fmt: skip
    wood, leaves = (transformed(part, placed(0.0, 0.45, 0.0)) for part in shrub(71, 420, 0.42, bark=WOOD, leaf=LEAF))
    return [pot, replace(wood, name="stems"), replace(leaves, name="leaves")]


def _lanterns() -> Mesh:
    """One on a rod from the crown of each open arch of the lower storey (every other one)."""
    parts = []
    for number, curtain in enumerate(CURTAINS_SHADE):
        if curtain is None and number % 2:
            x, z, low = (number + 0.5) * BAY - HALF_LENGTH, -HALF_WIDTH, SPRING + 0.12
            top = SPRING + ARCH
            parts.append(tube([(x, low + 0.32, z), (x, top, z)], 0.008, sides=6, material=IRON))
            cage = [(0.01, 0.0), (0.07, 0.0), (0.07, 0.0), (0.10, 0.24), (0.10, 0.24), (0.13, 0.25), (0.13, 0.25),
                    (0.01, 0.34)]
            parts.append(moved(revolve(cage, segments=6, material=IRON), (x, low, z)))
    return merge(parts, "lanterns")


def _doors() -> list[Mesh]:
    """Doors below and shuttered windows above in the outer wall, with stone around them; at z = -OUTER, facing +z."""
    stone, wood = [], []
    for number in (1, 3, 5, 7):
        x = (number + 0.5) * BAY - HALF_LENGTH
        for low, high, half in ((0.0, 2.2, 0.55), (GALLERY + 0.9, GALLERY + 2.3, 0.5)):
            stone += _surround(x, half, low, high)
            for side in (-1, 1):
                a, b = sorted((x + side * 0.012, x + side * half))
                wood.append(box((a, low, -OUTER), (b, high, -OUTER + 0.04), tile=0.8, material=WOOD))
                for y in np.linspace(low + 0.25, high - 0.25, 3):
                    wood.append(box((a + 0.05, y - 0.06, -OUTER), (b - 0.05, y + 0.06, -OUTER + 0.07), material=WOOD))
    return [merge(stone, "door stones"), merge(wood, "doors")]


def _surround(x: float, half: float, low: float, high: float) -> list[Mesh]:
    z, out = -OUTER, -OUTER + 0.12
    bars = [((x - half - 0.2, low, z), (x - half, high, out)), ((x + half, low, z), (x + half + 0.2, high, out)),
            ((x - half - 0.28, high, z), (x + half + 0.28, high + 0.24, out + 0.05))]
    if low > 0.0:  # a window, which has a sill
        bars.append(((x - half - 0.28, low - 0.14, z), (x + half + 0.28, low, out + 0.06)))
    return [box(a, b, tile=1.0, material=STONE) for a, b in bars]
