"""The conference room: a long table with what lies on and under it, lamps in the ceiling, a low sun in the windows."""

from __future__ import annotations

from math import radians

import numpy as np

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import DirectionalLight, Light, SpotLight
from ..materials import Material
from ..meshes import Mesh
from ..motion.tracks import Track
from ..scene import Environment, Scene
from .furniture import basket, chair, door, laptop, mug, picture, skirting
from .lamps import NEUTRAL_WHITE, spot_intensity
from .placing import Parts, placed, plain, textured, transformed
from .round_shapes import cylinder, plate, rounded_path, rounded_rectangle, tube
from .shapes import box, merge, quad
from .textures import carpet, plaster, tiles

WALL, ACCENT, CARPET, CEILING, TABLE, CLOTH, STEEL, BLACK = range(8)
WHITE, PAPER, PANEL, SCREEN, OAK, CANVAS, ORANGE, GREY = range(8, 16)

X, Z, HEIGHT, WALL_THICK = 4.5, 3.0, 2.8, 0.25
"""The room reaches from -X to X and from -Z to Z; walls and slabs stand outside of that."""
SILL, HEAD = 0.85, 2.45
"""Heights of the windows, which are in the wall at -Z."""
WINDOWS = (-3.2, -1.07, 1.07, 3.2)
WINDOW = 1.7
TABLE_LENGTH, TABLE_WIDTH, TABLE_HEIGHT = 4.8, 1.4, 0.74

LAMPS = [(x, z) for z in (-1.2, 1.2) for x in (-2.7, 0.0, 2.7)]
LUMEN = 4000.0
"""Each luminaire: an LED panel of 36 W. All six give 24,000 lumen, about 300 lux on the table."""
INNER, OUTER = radians(40.0), radians(80.0)

SUN_DIRECTION = (0.55, -0.26, 0.85)
SUN = (3_400.0, 1_900.0, 800.0)
"""Lux: a sun 14 degrees high behind thick haze, reddened."""
SKY = (150.0, 170.0, 220.0)
"""Nits: the hazy sky of an evening."""

ROBOT = (0.85, 0.0, 0.0)
"""Where the vacuum cleaner starts, metres."""

METERED_LUMINANCE = 28.0
"""Nits: the mean of what a path tracer shows to the camera "below" (27); the room above it is at 67 and stays below
white but for windows and lamps."""


def conference() -> Scene:
    """A conference room with ten chairs, cables and a waste basket below the table, ceiling lamps and an evening sun.

    9 x 6 x 2.8 m (x, z, y) inside; four windows in the wall at negative z. Six spot lights "lamp 1" to "lamp 6" and
    the directional light "sun". A robot vacuum cleaner drives around under the table in 12 s. Cameras "door",
    "windows" and "below".
    """
    parts = Parts()
    parts.add(*_shell(), *_windows(), *_ceiling(), *_table())
    _chairs(parts)
    _on_the_table(parts)
    _under_the_table(parts)
    _on_the_walls(parts)
    return Scene(
        name="conference",
        meshes=parts.meshes,
        instances=parts.instances,
        materials=_materials(),
        lights=_lights(),
        cameras=[
            Camera.look_at((-4.2, 1.65, 2.6), (0.4, 0.75, -0.4), vertical_fov=radians(56), name="door"),
            Camera.look_at((3.9, 1.6, -2.6), (-0.8, 0.75, 0.5), vertical_fov=radians(56), name="windows"),
            Camera.look_at((-0.05, 0.36, 1.45), (0.28, 0.2, -0.4), vertical_fov=radians(66), name="below"),
        ],
        environment=Environment(SKY),
        tracks=_robot_track(),
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _materials() -> list[Material]:
    """In the order of this module's constants. Linear albedos."""
    return [
        textured("wall", plaster(41, (0.70, 0.68, 0.63), strength=0.4), 0.9),
        textured("accent wall", plaster(42, (0.10, 0.26, 0.27), strength=0.4), 0.9),
        textured("carpet", carpet(43, (0.15, 0.155, 0.17)), 1.0),
        textured("ceiling tiles", tiles(44, (0.76, 0.76, 0.74), (0.74, 0.74, 0.72), count=2), 0.95, normal_scale=0.5),
        plain("walnut", (0.17, 0.085, 0.042), 0.25),
        plain("orange cloth", (0.52, 0.17, 0.035), 0.95),
        plain("chrome", (0.549, 0.556, 0.554), 0.2, metallic=1.0),
        plain("black plastic", (0.03, 0.03, 0.032), 0.4),
        plain("white lacquer", (0.76, 0.76, 0.75), 0.5),
        plain("paper", (0.80, 0.79, 0.76), 0.9),
        plain("lamp panel", (0.8, 0.8, 0.8), 0.9, emissive=(242.0, 192.0, 153.0)),
        plain("screen", (0.02, 0.02, 0.022), 0.15, emissive=(20.0, 45.0, 80.0)),
        plain("oak", (0.40, 0.25, 0.13), 0.5),
        textured("canvas", plaster(45, (0.55, 0.42, 0.25), strength=0.5), 0.9),
        plain("orange plastic", (0.60, 0.20, 0.03), 0.4),
        plain("grey lacquer", (0.36, 0.37, 0.38), 0.5),
    ]


def _shell() -> list[Mesh]:
    """Slabs and walls with their thickness outside of the room, so that the sun enters through the windows alone."""
    t, x, z = WALL_THICK, X + WALL_THICK, Z + WALL_THICK

    def wall(low, high, name: str = "", material: int = WALL) -> Mesh:
        return box(low, high, tile=2.0, material=material, name=name)

    edges = [-x, *[w + side * WINDOW / 2.0 for w in WINDOWS for side in (-1, 1)], x]
    front = [wall((a, SILL, -z), (b, HEAD, -Z)) for a, b in zip(edges[::2], edges[1::2], strict=True)]
    front += [wall((-x, 0.0, -z), (x, SILL, -Z)), wall((-x, HEAD, -z), (x, HEIGHT, -Z))]
    boards = [((-X, Z), (-X, -Z)), ((-X, -Z), (X, -Z)), ((X, -Z), (X, Z)), ((X, Z), (-2.65, Z))]
    return [
        box((-x, -t, -z), (x, 0.0, z), tile=0.5, material=CARPET, name="floor"),
        box((-x, HEIGHT, -z), (x, HEIGHT + t, z), tile=1.2, material=CEILING, name="ceiling"),
        merge(front, "window wall"),
        wall((-x, 0.0, Z), (x, HEIGHT, z), "door wall"),
        wall((-x, 0.0, -Z), (-X, HEIGHT, Z), "west wall"),
        wall((X, 0.0, -Z), (x, HEIGHT, Z), "screen wall", ACCENT),
        skirting(boards, material=WHITE),
    ]


def _windows() -> list[Mesh]:
    """Frames with a mullion, sills, and a half-drawn blind in the last window."""
    frames, sills, slats = [], [], []
    z, half = -Z - 0.14, WINDOW / 2.0
    for x in WINDOWS:
        bars = [(x - half, x - half + 0.05, SILL, HEAD), (x + half - 0.05, x + half, SILL, HEAD),
                (x - half + 0.05, x + half - 0.05, SILL, SILL + 0.05),
                (x - half + 0.05, x + half - 0.05, HEAD - 0.05, HEAD), (x - 0.03, x + 0.03, SILL + 0.05, HEAD - 0.05)]
        frames += [box((a, low, z - 0.03), (b, high, z + 0.03), material=WHITE) for a, b, low, high in bars]
        sills.append(box((x - half - 0.05, SILL, -Z - 0.1), (x + half + 0.05, SILL + 0.025, -Z + 0.12), material=WHITE))
    x = WINDOWS[-1]
    for y in np.arange(HEAD - 0.10, 1.45, -0.045):
        slats.append(box((x - half + 0.06, y, z + 0.05), (x + half - 0.06, y + 0.003, z + 0.09), material=WHITE))
    slats.append(box((x - half + 0.06, HEAD - 0.05, z + 0.04), (x + half - 0.06, HEAD, z + 0.10), material=WHITE))
    return [merge(frames, "window frames"), merge(sills, "window sills"), merge(slats, "blind")]


def _ceiling() -> list[Mesh]:
    """A panel for each lamp, hung just below the ceiling. Its own light, 0.36 m^2 * pi * 200 nits = 226 lm, only shows
    that it is on; the spot light is the lamp."""
    frames = [box((x - 0.32, HEIGHT - 0.04, z - 0.32), (x + 0.32, HEIGHT, z + 0.32), material=WHITE) for x, z in LAMPS]
    y = HEIGHT - 0.041
    panels = [quad([(x - 0.3, y, z - 0.3), (x + 0.3, y, z - 0.3), (x + 0.3, y, z + 0.3), (x - 0.3, y, z + 0.3)],
                   material=PANEL) for x, z in LAMPS]
    return [merge(frames, "lamp frames"), merge(panels, "lamp panels")]


def _lights() -> list[Light]:
    candela = spot_intensity(LUMEN, INNER, OUTER, NEUTRAL_WHITE)
    spots: list[Light] = [
        SpotLight(position=(x, HEIGHT - 0.06, z), direction=(0.0, -1.0, 0.0), intensity=candela, inner_angle=INNER,
                  outer_angle=OUTER, name=f"lamp {number + 1}")
        for number, (x, z) in enumerate(LAMPS)
    ]  # fmt: skip
    return [*spots, DirectionalLight(direction=SUN_DIRECTION, illuminance=SUN, name="sun")]


def _table() -> list[Mesh]:
    """The top with rounded ends, two pedestals with broad feet, and a cable tray between them."""
    top = plate(rounded_rectangle(TABLE_LENGTH, TABLE_WIDTH, 0.45, 10), TABLE_HEIGHT - 0.035, TABLE_HEIGHT,
                material=TABLE, name="table top")
    pedestals = []
    for x in (-1.55, 1.55):
        foot = plate(rounded_rectangle(0.5, 0.9, 0.08, centre=(x, 0.0)), 0.0, 0.025, material=GREY)
        pedestals += [foot, box((x - 0.09, 0.025, -0.25), (x + 0.09, TABLE_HEIGHT - 0.035, 0.25), material=GREY)]
    tray = [box((-1.46, 0.56, -0.1), (1.46, 0.565, 0.1), material=BLACK),
            box((-1.46, 0.565, -0.1), (1.46, 0.61, -0.095), material=BLACK),
            box((-1.46, 0.565, 0.095), (1.46, 0.61, 0.1), material=BLACK)]
    hatch = box((-0.3, TABLE_HEIGHT, -0.07), (0.3, TABLE_HEIGHT + 0.008, 0.07), material=STEEL, name="cable hatch")
    return [top, merge(pedestals, "table pedestals"), merge(tray, "cable tray"), hatch]


def _chairs(parts: Parts) -> None:
    """Four on either side and one at each end, none quite in line."""
    wobble = np.random.default_rng(46).uniform(-1.0, 1.0, (10, 3)) * (0.05, 0.06, 9.0)
    places = [(x, side * 1.0, 180.0 if side > 0 else 0.0) for side in (-1, 1) for x in (-1.65, -0.55, 0.55, 1.65)]
    places += [(-2.75, 0.0, 90.0), (2.75, 0.0, -90.0)]
    transforms = {f"chair {number + 1}": placed(x + dx, 0.0, z + dz, degrees + turn)
                  for number, ((x, z, degrees), (dx, dz, turn)) in enumerate(zip(places, wobble, strict=True))}
    parts.place(chair(seat=CLOTH, frame=STEEL), transforms)


def _on_the_table(parts: Parts) -> None:
    y = TABLE_HEIGHT
    spots = [(-1.6, -0.38, 178.0), (0.55, 0.40, 5.0), (1.7, -0.40, 186.0)]
    parts.place(laptop(body=GREY, screen=SCREEN), {f"laptop {i + 1}": placed(x, y, z, turn)
                                                    for i, (x, z, turn) in enumerate(spots)})
    sheets = [(-0.6, -0.42, 12.0), (-0.55, 0.42, -8.0), (-1.7, 0.40, 4.0), (1.65, 0.42, -14.0), (0.6, -0.45, 6.0)]
    stack = [box((-0.105, 0.0, -0.1485), (0.105, 0.006, 0.1485), material=PAPER, name="sheets")]
    parts.place(stack, {f"papers {i + 1}": placed(x, y, z, turn) for i, (x, z, turn) in enumerate(sheets)})
    cups = [(-1.2, -0.48, 20.0), (-0.2, 0.44, 140.0), (1.25, 0.48, 250.0), (0.95, -0.5, 300.0)]
    parts.place([mug(material=WHITE)], {f"cup {i + 1}": placed(x, y, z, turn) for i, (x, z, turn) in enumerate(cups)})
    phone = [plate(rounded_rectangle(0.3, 0.3, 0.1), 0.0, 0.03, material=BLACK, name="base"),
             cylinder(0.07, 0.055, material=BLACK, name="speaker")]
    parts.place(phone, {"telephone": placed(-0.9, y, 0.0, 45.0)})


def _under_the_table(parts: Parts) -> None:
    """Cables from the tray to a socket in the floor, a power strip, a waste basket, a bag, and the robot."""
    parts.add(box((-0.09, 0.0, -0.09), (0.09, 0.035, 0.09), material=STEEL, name="floor socket"))
    cables = []
    for i, (x, z) in enumerate(((-0.05, -0.04), (-0.03, 0.05), (0.05, -0.02), (0.03, 0.03))):
        end = (x * 9.0, 0.572, z)
        path = [(x, 0.03, z), (x * 1.2, 0.16 + 0.03 * i, z * 1.8), (x * 2.0, 0.40, z * 1.2), (x * 5.0, 0.60, z), end]
        cables.append(tube(rounded_path(path, 3), 0.006, sides=6, material=BLACK))
    loose = [(1.47, 0.575, 0.05), (1.38, 0.52, 0.16), (1.25, 0.10, 0.30), (1.10, 0.006, 0.42), (0.72, 0.006, 0.52),
             (0.50, 0.006, 0.60), (0.30, 0.006, 0.585)]
    cables.append(tube(rounded_path(loose, 3), 0.006, sides=6, material=WHITE))
    parts.add(merge(cables[:-1], "cables"), merge(cables[-1:], "loose cable"))
    outline = rounded_rectangle(0.36, 0.06, 0.015, centre=(0.13, 0.585))
    strip = plate(outline, 0.0, 0.04, material=WHITE, name="power strip")
    sockets = [box((x - 0.02, 0.04, 0.565), (x + 0.02, 0.043, 0.605), material=BLACK) for x in (0.02, 0.09, 0.16, 0.23)]
    parts.add(strip, merge(sockets, "power strip sockets"))
    parts.place([basket(0.34, material=BLACK)], {"table": placed(-1.0, 0.0, 0.42), "corner": placed(4.15, 0.0, 2.65)})
    parts.place(_robot(), {"robot": placed(*ROBOT)})


def _robot() -> list[Mesh]:
    """A round vacuum cleaner, 32 cm across and 10 cm high."""
    lid = transformed(cylinder(0.16, 0.06, segments=40, material=ORANGE, name="body"), placed(0.0, 0.018, 0.0))
    black = [cylinder(0.145, 0.02, segments=40, material=BLACK),
             transformed(cylinder(0.045, 0.02, material=BLACK), placed(0.0, 0.078, -0.05))]
    return [lid, merge(black, "base")]


def _robot_track() -> list[Track]:
    """An ellipse around the floor socket, between the pedestals; it starts and ends at the robot's place."""
    turn = np.linspace(0.0, 2.0 * np.pi, 49)
    x, _, z = ROBOT
    way = np.stack([x * np.cos(turn) - x, 0.0 * turn, 0.30 * np.sin(turn) - z], axis=1)
    way[-1] = way[0]
    return [Track(target="instance", name=f"robot {part}", property="translation", times=turn / turn[-1] * 12.0,
                  values=way) for part in ("body", "base")]


def _on_the_walls(parts: Parts) -> None:
    """A screen, a whiteboard, a picture, and the door."""
    glass = [(-0.98, 0.92, 0.051), (0.98, 0.92, 0.051), (0.98, 2.02, 0.051), (-0.98, 2.02, 0.051)]
    display = [box((-1.0, 0.9, 0.0), (1.0, 2.04, 0.05), material=BLACK, name="case"),
               quad(glass, material=SCREEN, name="picture")]
    parts.place(display, {"display": placed(X, 0.0, 0.0, -90.0)})
    board = [box((-1.2, 0.9, 0.0), (1.2, 2.1, 0.02), material=WHITE, name="board"),
             box((-1.2, 0.86, 0.0), (1.2, 0.9, 0.07), material=STEEL, name="tray")]
    parts.place(board, {"whiteboard": placed(1.2, 0.0, Z, 180.0)})
    parts.place(picture(1.6, 1.1, 1.55, frame=OAK, canvas=CANVAS), {"picture": placed(-X, 0.0, 0.0, 90.0)})
    parts.place(door(0.9, 2.05, leaf=OAK, casing=WHITE, metal=STEEL), {"door": placed(-3.2, 0.0, Z, 180.0)})
