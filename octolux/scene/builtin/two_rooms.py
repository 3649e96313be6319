"""Two rooms that share a thin wall: one with a lamp, the other sealed and dark."""

from __future__ import annotations

from math import radians

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import PointLight
from ..materials import Material
from ..meshes import Mesh
from ..scene import Scene
from .furniture import books, chair, door, mug, picture, shelf, skirting, table, vase
from .lamps import WARM_BULB, WARM_WHITE, pendulum, point_intensity
from .placing import Parts, placed, plain, textured, transformed
from .round_shapes import plate, rounded_rectangle, sphere, tube
from .shapes import merge, quad, quads
from .textures import carpet, planks, plaster

LIT_WALLS, DARK_WALLS, FLOOR, OAK, WHITE, STEEL, RED, BLUE, GREEN, RUG, CLAY, CANVAS, BULB = range(13)

THICK = 0.10
"""Of the wall between the rooms, metres."""
WIDTH, DEPTH, HEIGHT = 4.2, 4.0, 2.6
"""Of each room in x and z, and its height."""
MIDDLE = (WIDTH + THICK) / 2.0
"""How far the rooms' middles are from x = 0."""
CORD = 0.75
"""From the ceiling to the light. The bulb of 3 cm ends 6 cm above it, so that it shades only the cord's surroundings: a
cone of asin(3 / 9) = 19.5 degrees."""
LUMEN = 800.0
"""An incandescent lamp of 60 W: 64 cd all around."""

METERED_LUMINANCE = 2.5
"""Nits: a little below the geometric mean of what a path tracer shows to the cameras of the lit room (2.9)."""


def two_rooms() -> Scene:
    """A room with a swinging lamp beside a sealed, dark one, with 10 cm of wall between: the dark one stays black.

    The lit room is at negative x, the dark one at positive x, both closed on all sides and furnished alike. The light
    "lamp" swings once in 1.7 s. Cameras "lit", "table" and "dark".
    """
    parts = Parts()
    for room, x, walls in (("lit", -MIDDLE, LIT_WALLS), ("dark", MIDDLE, DARK_WALLS)):
        parts.add(*_room(room, x, walls))
    _furniture(parts)
    parts.place(_lamp(), {"lamp": placed(-MIDDLE, HEIGHT, 0.0)})
    lamp = (-MIDDLE, HEIGHT - CORD, 0.0)
    return Scene(
        name="two-rooms",
        meshes=parts.meshes,
        instances=parts.instances,
        materials=_materials(),
        lights=[PointLight(position=lamp, intensity=point_intensity(LUMEN, WARM_WHITE), name="lamp")],
        cameras=[
            Camera.look_at((-4.05, 1.6, 1.75), (-1.4, 0.8, -0.9), vertical_fov=radians(62), name="lit"),
            Camera.look_at((-0.4, 1.5, 1.6), (-2.9, 0.7, -0.7), vertical_fov=radians(62), name="table"),
            Camera.look_at((4.05, 1.6, 1.75), (1.4, 0.8, -0.9), vertical_fov=radians(62), name="dark"),
        ],
        tracks=pendulum((-MIDDLE, HEIGHT, 0.0), CORD, 20.0, lamps={"lamp": lamp}, instances=("lamp cord", "lamp bulb")),
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _materials() -> list[Material]:
    """In the order of this module's constants. Linear albedos."""
    return [
        textured("cream wall", plaster(21, (0.66, 0.60, 0.48), strength=0.5), 0.9),
        textured("white wall", plaster(22, (0.74, 0.74, 0.72), strength=0.5), 0.9),
        textured("parquet", planks(23, (0.33, 0.19, 0.095)), 0.45),
        plain("oak", (0.40, 0.25, 0.13), 0.5),
        plain("white paint", (0.78, 0.77, 0.74), 0.6),
        plain("steel", (0.56, 0.57, 0.58), 0.3, metallic=1.0),
        plain("red cloth", (0.50, 0.06, 0.045), 0.9),
        plain("blue cloth", (0.06, 0.12, 0.34), 0.9),
        plain("green cloth", (0.08, 0.24, 0.10), 0.9),
        textured("rug", carpet(24, (0.36, 0.10, 0.075)), 1.0),
        plain("glazed clay", (0.16, 0.36, 0.40), 0.25),
        textured("canvas", plaster(25, (0.28, 0.36, 0.42), strength=0.5), 0.9),
        WARM_BULB,
    ]


def _room(room: str, x: float, walls: int) -> list[Mesh]:
    """The closed shell of a room about (x, 0), seen from inside: walls, floor and ceiling; and its skirting."""
    a, b, z = x - WIDTH / 2.0, x + WIDTH / 2.0, DEPTH / 2.0
    around = [(a, z), (a, -z), (b, -z), (b, z)]  # clockwise seen from above: the room is on the right
    sides = list(zip(around, [*around[1:], around[0]], strict=True))
    upright = [[(p[0], 0, p[1]), (q[0], 0, q[1]), (q[0], HEIGHT, q[1]), (p[0], HEIGHT, p[1])] for p, q in sides]
    return [
        quads(upright, tile=2.0, material=walls, name=f"{room} room: walls"),
        quad([(p, 0, q) for p, q in around[::-1]], tile=1.2, material=FLOOR, name=f"{room} room: floor"),
        quad([(p, HEIGHT, q) for p, q in around], material=WHITE, name=f"{room} room: ceiling"),
        # None along the end wall at +z, where the door is.
        skirting(sides[:3], material=WHITE, name=f"{room} room: skirting"),
    ]


def _furniture(parts: Parts) -> None:
    """The same in both rooms, the dark room's turned by half a turn about the middle of the wall."""
    rooms = {"lit": placed(-MIDDLE, 0, 0), "dark": placed(MIDDLE, 0, 0)}

    def both(meshes: list[Mesh], what: str, x: float, y: float, z: float, degrees: float = 0.0) -> None:
        """In each room at (x, y, z) from its middle; x counts towards the shared wall."""
        turned = {"lit": placed(x, y, z, degrees), "dark": placed(-x, y, z, -degrees)}
        parts.place(meshes, {f"{room} {what}".strip(): rooms[room] @ turned[room] for room in rooms})

    both(table(1.5, 0.8, 0.75, top=OAK, legs=OAK), "table", 0.0, 0.0, -0.35)
    for number, (x, z, degrees) in enumerate(((-0.35, -0.98, 4.0), (0.4, 0.3, 168.0))):
        both(chair(seat=(RED, BLUE)[number], frame=STEEL), f"chair {number + 1}", x, 0.0, z, degrees)
    rug = plate(rounded_rectangle(2.6, 2.0, 0.04), 0.0, 0.012, tile=0.5, material=RUG, name="rug")
    both([rug], "", 0.0, 0.0, -0.3)
    both(_bookshelf(), "bookshelf", WIDTH / 2.0, 0.0, -0.9, -90.0)
    both([vase(0.34, material=CLAY)], "", 0.35, 0.75, -0.42)
    both([mug(material=WHITE)], "", -0.25, 0.75, -0.2, 30.0)
    both(picture(1.1, 0.75, 1.55, frame=OAK, canvas=CANVAS), "picture", 0.0, 0.0, -DEPTH / 2.0)
    both(picture(0.6, 0.8, 1.55, frame=STEEL, canvas=CANVAS), "small picture", WIDTH / 2.0, 0.0, 0.75, -90.0)
    both(door(0.86, 2.03, leaf=WHITE, casing=OAK, metal=STEEL), "door", -0.9, 0.0, DEPTH / 2.0, 180.0)
    both(_sofa(), "sofa", -WIDTH / 2.0 + 0.02, 0.0, -0.3, 90.0)


def _bookshelf() -> list[Mesh]:
    """A shelf with a row of books in each compartment; one mesh for each colour."""
    height, boards = 1.75, 5
    parts: dict[int, list[Mesh]] = {}
    spacing = (height - 0.025 - 0.06) / boards
    for number in range(boards):
        for row in books(1.0 - 0.35 * (number % 2), number, materials=[RED, BLUE, GREEN, WHITE]):
            parts.setdefault(row.material, []).append(transformed(row, placed(0, 0.085 + number * spacing, 0.012)))
    rows = [merge(rows, f"books {material}") for material, rows in parts.items()]
    return [shelf(1.1, height, 0.26, boards, material=OAK), *rows]


def _sofa() -> list[Mesh]:
    """A sofa for two with its back at z = 0."""
    frame = [plate(rounded_rectangle(1.7, 0.8, 0.06, centre=(0.0, 0.42)), 0.06, 0.30, material=BLUE),
             plate(rounded_rectangle(1.7, 0.2, 0.06, centre=(0.0, 0.12)), 0.30, 0.78, material=BLUE)]
    frame += [plate(rounded_rectangle(0.16, 0.8, 0.05, centre=(x, 0.42)), 0.30, 0.58, material=BLUE)
              for x in (-0.77, 0.77)]
    cushions = [plate(rounded_rectangle(0.68, 0.58, 0.06, centre=(x, 0.53)), 0.30, 0.43, material=BLUE)
                for x in (-0.345, 0.345)]
    feet = [plate(rounded_rectangle(0.05, 0.05, 0.01, centre=(x, z)), 0.0, 0.06, material=OAK)
            for x in (-0.78, 0.78) for z in (0.08, 0.76)]
    return [merge(frame + cushions, "body"), merge(feet, "feet")]


def _lamp() -> list[Mesh]:
    """A bare bulb on its cord, hanging from the origin."""
    cord = tube([(0.0, -CORD + 0.11, 0.0), (0.0, 0.0, 0.0)], 0.004, material=STEEL, name="cord")
    return [cord, transformed(sphere(0.03, rows=8, material=BULB, name="bulb"), placed(0.0, -CORD + 0.09, 0.0))]
