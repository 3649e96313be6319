"""The stones and cloths of the atrium: where everything stands.

The courtyard is 20 m long (x) and 6 m wide (z), open to the sky; arcades on both long sides carry galleries 2.4 m
deep. Everything of the side at negative z is made first and turned about the centre for the other side.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..meshes import Mesh
from .architecture import arched_wall, archivolt, balustrade, column, curtain, moved
from .shapes import box, extrude, merge, quad, revolve

MASONRY, FLOOR, STONE, PLASTER, WOOD, CLAY, RED, GREEN, BLUE, WATER, LEAF, IRON = range(12)

HALF_LENGTH, HALF_WIDTH, OUTER = 10.0, 3.0, 5.4
BAYS, BAY = 8, 2.5
WALL = 0.6
"""Thickness of all walls, metres."""
GALLERY, ROOF = 4.5, 8.5
"""Heights of the upper floor and of the top of the walls."""
SPRING, UPPER_SPRING = 2.5, 6.75
"""Heights at which the arches of the two storeys begin."""
ARCH = 0.93

# Colour of the curtain in each bay of the lower storey, from -x to +x; None leaves the bay open.
CURTAINS_SHADE = (None, None, RED, None, GREEN, None, BLUE, None)
CURTAINS_SUN = (BLUE, None, RED, None, GREEN, None, RED, None)
# Colour of the banner in front of each column, at the upper floor.
BANNERS_SHADE = (None, BLUE, None, RED, None, GREEN, None)
BANNERS_SUN = (None, GREEN, None, BLUE, None, RED, None)


def courtyard() -> Iterator[Mesh]:
    """All meshes of the atrium in world space, metres; material indices are this module's constants."""
    for side, turns in (("shade", 0), ("sun", 2)):
        for part in [*_side(), *_cloths(side == "sun")]:
            yield moved(part, quarter_turns=turns, name=f"{part.name} ({side})")
    for turns, end in ((1, "west"), (3, "east")):
        for part in _end():
            yield moved(part, quarter_turns=turns, name=f"{part.name} ({end})")
    yield _floor()
    yield _fountain()


def _bay_centres() -> np.ndarray:
    return (np.arange(BAYS) + 0.5) * BAY - HALF_LENGTH


def _column_places() -> np.ndarray:
    return np.arange(1, BAYS) * BAY - HALF_LENGTH


def _side() -> list[Mesh]:
    return [_arcades(), _mouldings(), _columns(), _balustrades(), _outer_wall(), _gallery()]


def _arcades() -> Mesh:
    """The arched walls of both storeys, and the half piers at their ends."""
    storeys = ((0.0, SPRING, GALLERY), (GALLERY, UPPER_SPRING, ROOF))
    parts = []
    for base, spring, top in storeys:
        bay = arched_wall(BAY, ARCH, spring, spring, top, WALL, material=MASONRY)
        parts += [moved(bay, (x, 0.0, -HALF_WIDTH)) for x in _bay_centres()]
        for x in (-HALF_LENGTH, HALF_LENGTH - 0.32):
            low, high = (x, base, -HALF_WIDTH - WALL / 2), (x + 0.32, spring, -HALF_WIDTH + WALL / 2)
            parts.append(box(low, high, tile=2.0, material=MASONRY))
    return merge(parts, "arcade")


def _mouldings() -> Mesh:
    """Archivolts, the string course between the storeys and the cornice."""
    front = -HALF_WIDTH + WALL / 2
    parts = []
    for spring in (SPRING, UPPER_SPRING):
        arch = archivolt(ARCH, spring, WALL, material=STONE)
        parts += [moved(arch, (x, 0.0, -HALF_WIDTH)) for x in _bay_centres()]
    course = [(-0.02, 4.08), (0.05, 4.10), (0.05, 4.18), (0.12, 4.24), (0.12, 4.40), (0.17, 4.42), (0.17, GALLERY),
              (-0.02, GALLERY)]
    cornice = [(-0.02, 8.05), (0.06, 8.08), (0.06, 8.18), (0.12, 8.22), (0.22, 8.36), (0.22, 8.44), (0.34, 8.48),
               (0.34, 8.64), (-0.7, 8.70)]
    ends = (-HALF_LENGTH, 0.0, front), (HALF_LENGTH, 0.0, front)
    parts += [extrude(profile, *ends, material=STONE) for profile in (course, cornice)]
    return merge(parts, "mouldings")


def _columns() -> Mesh:
    lower = column(SPRING, 0.24, material=STONE)
    upper = column(UPPER_SPRING - GALLERY, 0.20, material=STONE)
    places = [(x, -HALF_WIDTH) for x in _column_places()]
    parts = [moved(lower, (x, 0.0, z)) for x, z in places] + [moved(upper, (x, GALLERY, z)) for x, z in places]
    return merge(parts, "columns")


def _balustrades() -> Mesh:
    rail = balustrade(BAY - 0.42, 0.95, 8, material=STONE)
    return merge([moved(rail, (x, GALLERY, -HALF_WIDTH)) for x in _bay_centres()], "balustrade")


def _outer_wall() -> Mesh:
    low, high = (-HALF_LENGTH - WALL, 0.0, -OUTER - WALL), (HALF_LENGTH + WALL, ROOF, -OUTER)
    return box(low, high, tile=2.0, material=MASONRY, name="outer wall")


def _gallery() -> Mesh:
    """The upper floor, the roof over it, and the beams under both."""
    inner, outer = -HALF_WIDTH - WALL / 2, -OUTER
    slabs = [(GALLERY - 0.25, GALLERY), (ROOF - 0.2, ROOF + 0.1)]
    parts = [box((-HALF_LENGTH, a, outer), (HALF_LENGTH, b, inner), tile=2.0, material=PLASTER) for a, b in slabs]
    for x in _column_places():
        for bottom, _ in slabs:
            beam = (x - 0.15, bottom - 0.3, outer), (x + 0.15, bottom, inner)
            parts.append(box(*beam, tile=2.0, material=PLASTER))
    return merge(parts, "gallery")


def _cloths(sun: bool) -> Iterator[Mesh]:
    """Curtains from the spring of their arch to just above the floor, banners over the string course, their rods."""
    # The sun side is turned about the centre afterwards, which swaps the ends.
    curtains, banners = (CURTAINS_SUN[::-1], BANNERS_SUN[::-1]) if sun else (CURTAINS_SHADE, BANNERS_SHADE)
    rods = []
    for number, (x, color) in enumerate(zip(_bay_centres(), curtains, strict=True)):
        if color is not None:
            cloth = curtain(2.0 * ARCH, SPRING - 0.12, 6.5, seed=number + 10 * sun, repeats=2.0, gather=0.12,
                            material=color)
            yield moved(cloth, (x, SPRING, -HALF_WIDTH - 0.1), name=f"curtain {number + 1}")
            rods.append(_beam((x, SPRING, -HALF_WIDTH - 0.1), (BAY / 2 - 0.2, 0.02, 0.02)))
    for number, (x, color) in enumerate(zip(_column_places(), banners, strict=True)):
        if color is not None:
            cloth = curtain(0.85, 2.1, 2.5, seed=number + 50, gather=0.08, material=color)
            y, z = GALLERY + 0.9, -HALF_WIDTH + WALL / 2 + 0.28
            yield moved(cloth, (x, y, z), name=f"banner {number + 1}")
            rods.append(_beam((x, y, z), (0.5, 0.02, 0.02)))
            # Two brackets carry it, let into the handrail.
            rods += [_beam((x + side, y, z - 0.21), (0.02, 0.02, 0.23)) for side in (-0.46, 0.46)]
    yield merge(rods, "rods")


def _beam(centre: tuple[float, float, float], half_size: tuple[float, float, float]) -> Mesh:
    middle, half = np.array(centre), np.array(half_size)
    return box(middle - half, middle + half, material=WOOD)


def _end() -> list[Mesh]:
    """An end wall, seen from +z when it stands at z = -HALF_LENGTH: a portal with a door, a blind arch above it."""
    z = -HALF_LENGTH - WALL / 2
    width = 2.0 * HALF_WIDTH
    sill = (-HALF_WIDTH, GALLERY, z - WALL / 2), (HALF_WIDTH, GALLERY + 0.6, z + WALL / 2)
    walls = [
        moved(arched_wall(width, 1.3, 2.3, 0.0, GALLERY, WALL, material=MASONRY), (0.0, 0.0, z)),
        moved(arched_wall(width, 1.3, 6.4, GALLERY + 0.6, ROOF, WALL, material=MASONRY), (0.0, 0.0, z)),
        box(*sill, tile=2.0, material=MASONRY),
    ]
    for low, high in ((-OUTER, -HALF_WIDTH), (HALF_WIDTH, OUTER)):
        walls.append(box((low, 0.0, z - WALL / 2), (high, ROOF, z + WALL / 2), tile=2.0, material=MASONRY))
    trims = [moved(archivolt(1.3, spring, WALL, width=0.25, material=STONE), (0.0, 0.0, z)) for spring in (2.3, 6.4)]
    for bottom, top, out in ((4.24, GALLERY, 0.12), (8.22, 8.64, 0.22)):
        profile = [(-0.02, bottom), (out, bottom + 0.06), (out, top), (-0.3, top + 0.02)]
        ends = (-HALF_WIDTH, 0.0, z + WALL / 2), (HALF_WIDTH, 0.0, z + WALL / 2)
        trims.append(extrude(profile, *ends, material=STONE))
    back = z - 0.1
    door = box((-1.4, 0.0, back - 0.1), (1.4, 3.7, back), tile=1.0, material=WOOD, name="door")
    niche = box((-1.4, GALLERY + 0.5, back - 0.1), (1.4, 7.8, back), tile=2.0, material=CLAY, name="niche")
    return [merge(walls, "end wall"), merge(trims, "end mouldings"), door, niche]


def _floor() -> Mesh:
    x, z = HALF_LENGTH + WALL, OUTER + WALL
    return quad([(-x, 0, z), (x, 0, z), (x, 0, -z), (-x, 0, -z)], tile=2.4, material=FLOOR, name="floor")


def _fountain() -> Mesh:
    """A round basin with a bowl on a stem in the middle of the courtyard."""
    basin = [(1.25, 0.0), (1.25, 0.12), (1.25, 0.12), (1.10, 0.16), (1.10, 0.42), (1.10, 0.42), (1.18, 0.46),
             (1.18, 0.55), (1.18, 0.55), (0.98, 0.55), (0.98, 0.55), (0.98, 0.25), (0.98, 0.25), (0.01, 0.25)]
    stem = [(0.24, 0.25), (0.24, 0.35), (0.24, 0.35), (0.12, 0.42), (0.10, 0.70), (0.14, 0.95), (0.14, 0.95),
            (0.34, 1.00), (0.50, 1.10), (0.56, 1.22), (0.56, 1.22), (0.52, 1.22), (0.52, 1.22), (0.40, 1.12),
            (0.01, 1.08)]
    return merge([revolve(p, segments=40, tile=1.0, material=STONE) for p in (basin, stem)], "fountain")
