"""Furniture and fittings of rooms, each standing at the origin (what hangs on a wall: at z = 0, facing +z)."""

from __future__ import annotations

from itertools import pairwise
from math import cos, pi, sin

import numpy as np

from ..meshes import Mesh
from .placing import tilted, transformed
from .round_shapes import plate, polygon, rounded_path, rounded_rectangle, sphere, tube
from .shapes import box, merge, quads, revolve


def table(length: float, width: float, height: float, *, top: int, legs: int) -> list[Mesh]:
    """A table with four square legs, `length` along x; `top` and `legs` are materials."""
    x, z, leg = length / 2.0 - 0.08, width / 2.0 - 0.08, 0.03
    board = plate(rounded_rectangle(length, width, 0.03), height - 0.03, height, material=top, name="top")
    posts = [box((a - leg, 0.0, b - leg), (a + leg, height - 0.03, b + leg), material=legs)
             for a in (-x, x) for b in (-z, z)]
    rails = [box((-x + leg, height - 0.1, b - 0.012), (x - leg, height - 0.03, b + 0.012), material=legs)
             for b in (-z, z)]
    rails += [box((a - 0.012, height - 0.1, -z + leg), (a + 0.012, height - 0.03, z - leg), material=legs)
              for a in (-x, x)]
    return [board, merge(posts + rails, "legs")]


def chair(*, seat: int, frame: int) -> list[Mesh]:
    """A cantilever chair that faces +z: one bent steel tube, a cushion and a leaning back; `seat` and `frame` are
    materials."""
    side = [(0.24, 0.86, -0.29), (0.24, 0.47, -0.20), (0.24, 0.44, 0.24), (0.24, 0.012, 0.26), (0.24, 0.012, -0.26)]
    path = np.array([*side, *[(-x, y, z) for x, y, z in side[::-1]]])
    # Each leg is cut in three first, so that corners are rounded on short arcs and the legs stay straight.
    thirds = np.concatenate([*[[a + (b - a) * t for t in (0.0, 0.12, 0.88)] for a, b in pairwise(path)], path[-1:]])
    steel = tube(rounded_path(thirds, 2), 0.012, material=frame, name="frame")
    cushion = plate(rounded_rectangle(0.46, 0.46, 0.05), 0.455, 0.51, tile=0.3, material=seat)
    leaning = plate(rounded_rectangle(0.46, 0.40, 0.05), -0.02, 0.02, tile=0.3, material=seat)
    back = transformed(leaning, tilted(-77.0, y=0.70, z=-0.245))
    return [steel, merge([cushion, back], "cushions")]


def shelf(width: float, height: float, depth: float, boards: int, *, material: int, name: str = "shelf") -> Mesh:
    """An open shelf against the wall z = 0, with `boards` compartments one above the other."""
    half, t = width / 2.0, 0.025
    parts = [box((a, 0.0, 0.0), (a + t, height, depth), material=material) for a in (-half, half - t)]
    parts += [box((-half + t, y, 0.012), (half - t, y + t, depth), material=material)
              for y in np.linspace(0.06, height - t, boards + 1)]
    parts.append(box((-half + t, 0.06, 0.0), (half - t, height, 0.012), material=material))
    return merge(parts, name)


def books(width: float, seed: int, *, materials: list[int]) -> list[Mesh]:
    """A row of upright books `width` long in x, on y = 0 and against z = 0; one mesh for each material."""
    rng = np.random.default_rng(seed)
    rows: dict[int, list[Mesh]] = {material: [] for material in materials}
    x = -width / 2.0
    while x < width / 2.0 - 0.06:
        thick, tall, deep = rng.uniform((0.018, 0.18, 0.13), (0.05, 0.27, 0.19))
        material = materials[int(rng.integers(len(materials)))]
        rows[material].append(box((x, 0.0, 0.005), (x + thick - 0.001, tall, deep), material=material))
        x += thick
    return [merge(parts, f"books {material}") for material, parts in rows.items() if parts]


def door(width: float, height: float, *, leaf: int, casing: int, metal: int) -> list[Mesh]:
    """A closed panelled door on the wall z = 0: the leaf, its casing and a handle; materials by name."""
    half, rim = width / 2.0, 0.10
    panels = [box((-half, 0.0, 0.0), (half, height, 0.02), material=leaf)]
    middle = 0.95
    for low, high in ((0.22, middle - 0.08), (middle + 0.08, height - 0.16)):
        panels.append(_panel(-half + 0.13, half - 0.13, low, high, 0.02, leaf))
    frame = [box((-half - rim, 0.0, 0.0), (-half, height + rim, 0.05), material=casing),
             box((half, 0.0, 0.0), (half + rim, height + rim, 0.05), material=casing),
             box((-half, height, 0.0), (half, height + rim, 0.05), material=casing)]
    grip = rounded_path([(half - 0.07, middle, 0.02), (half - 0.07, middle, 0.08), (half - 0.19, middle, 0.08)])
    return [merge(panels, "leaf"), merge(frame, "casing"), tube(grip, 0.011, material=metal, name="handle")]


def picture(width: float, height: float, y: float, *, frame: int, canvas: int) -> list[Mesh]:
    """A framed picture on the wall z = 0, its middle at the height `y`."""
    a, b, rim = width / 2.0, height / 2.0, 0.035
    bars = [box((-a, y - b, 0.0), (-a + rim, y + b, 0.03), material=frame),
            box((a - rim, y - b, 0.0), (a, y + b, 0.03), material=frame),
            box((-a + rim, y - b, 0.0), (a - rim, y - b + rim, 0.03), material=frame),
            box((-a + rim, y + b - rim, 0.0), (a - rim, y + b, 0.03), material=frame)]
    low, high = (-a + rim, y - b + rim), (a - rim, y + b - rim)
    corners = [(low[0], low[1], 0.012), (high[0], low[1], 0.012), (high[0], high[1], 0.012), (low[0], high[1], 0.012)]
    whole = [[(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)]]
    return [merge(bars, "frame"), quads([corners], whole, material=canvas, name="canvas")]


def vase(height: float, *, material: int, name: str = "vase") -> Mesh:
    """A turned vase with an inside."""
    r = height / 2.6
    outside = [(0.01, 0.0), (0.55 * r, 0.0), (0.55 * r, 0.0), (0.8 * r, 0.16 * height), (r, 0.42 * height),
               (0.86 * r, 0.66 * height), (0.42 * r, 0.88 * height), (0.52 * r, height)]
    inside = [(0.52 * r, height), (0.48 * r, height), (0.48 * r, height), (0.38 * r, 0.88 * height),
              (0.82 * r, 0.66 * height), (0.94 * r, 0.42 * height), (0.5 * r, 0.05 * height), (0.01, 0.05 * height)]
    return revolve([*outside, *inside], segments=32, material=material, name=name)


def basket(height: float, *, material: int, name: str = "waste basket") -> Mesh:
    """A waste basket that widens upwards, with an inside."""
    low, high, t = 0.36 * height, 0.46 * height, 0.006
    return revolve([(0.01, 0.0), (low, 0.0), (low, 0.0), (high, height), (high, height), (high - t, height),
                    (high - t, height), (low - t, t), (low - t, t), (0.01, t)],
                   segments=32, material=material, name=name)  # fmt: skip


def pendant(drop: float, *, shade: int, rod: int, bulb: int) -> list[Mesh]:
    """A lamp that hangs from the origin by a rod, its conical shade, open below, ending `drop` below; a bulb in it."""
    t, top = 0.004, drop - 0.22
    outer = [(0.17, -drop), (0.05, -top), (0.05, -top), (0.022, -top + 0.03)]
    inner = [(0.022 - t, -top + 0.03 - t), (0.05 - t, -top - t), (0.05 - t, -top - t), (0.17 - t, -drop)]
    cone = revolve([*inner, inner[-1], outer[0], outer[0], *outer[1:]], segments=32, material=shade, name="shade")
    globe = transformed(sphere(0.05, rows=6, material=bulb, name="bulb"), tilted(0.0, y=-drop + 0.06))
    return [cone, tube([(0.0, -top, 0.0), (0.0, 0.0, 0.0)], 0.006, material=rod, name="rod"), globe]


def spotlight(*, can: int, bulb: int) -> list[Mesh]:
    """A can that shines along -y, 18 cm long, its rim at the origin and its lens 2 cm behind it."""
    profile = [(0.05, 0.02), (0.05, 0.0), (0.05, 0.0), (0.055, 0.0), (0.055, 0.0), (0.055, 0.16), (0.055, 0.16),
               (0.04, 0.18), (0.01, 0.18)]
    lens = [(0.05 * cos(a), 0.02, 0.05 * sin(a)) for a in np.linspace(0.0, 2.0 * pi, 24, endpoint=False)]
    return [revolve(profile, segments=24, material=can, name="can"),
            polygon(lens, material=bulb, name="lens")]


def skirting(walls, height: float = 0.09, thick: float = 0.012, *, material: int, name: str = "skirting") -> Mesh:
    """Boards along the foot of walls. walls: ((x, z), (x, z)) pairs, the room on the right of the way, seen from
    above."""
    faces = []
    for start, end in walls:
        a, b = (np.array([x, 0.0, z]) for x, z in (start, end))
        out = thick * np.cross((b - a) / np.linalg.norm(b - a), [0.0, 1.0, 0.0])
        up = np.array([0.0, height, 0.0])
        faces += [[a + out, b + out, b + out + up, a + out + up], [a + out + up, b + out + up, b + up, a + up]]
    return quads(faces, material=material, name=name)


def mug(*, material: int, name: str = "mug") -> Mesh:
    """A coffee mug with its handle."""
    body = revolve([(0.01, 0.0), (0.036, 0.0), (0.036, 0.0), (0.04, 0.09), (0.04, 0.09), (0.037, 0.09), (0.037, 0.09),
                    (0.034, 0.01), (0.034, 0.01), (0.01, 0.01)], segments=20, material=material)  # fmt: skip
    grip = rounded_path([(0.037, 0.072, 0.0), (0.07, 0.075, 0.0), (0.07, 0.02, 0.0), (0.035, 0.022, 0.0)])
    return merge([body, tube(grip, 0.005, sides=6, material=material)], name)


def laptop(*, body: int, screen: int) -> list[Mesh]:
    """An open laptop, its screen facing +z."""
    base = plate(rounded_rectangle(0.32, 0.22, 0.012), 0.0, 0.014, material=body)
    lid = transformed(plate(rounded_rectangle(0.32, 0.21, 0.012), 0.0, 0.006, material=body),
                      tilted(72.0, y=0.113, z=-0.140))
    glass = [(-0.15, -0.0935, 0.0), (0.15, -0.0935, 0.0), (0.15, 0.0935, 0.0), (-0.15, 0.0935, 0.0)]
    picture_side = transformed(polygon(glass, material=screen), tilted(-18.0, y=0.1155, z=-0.1325), name="screen")
    return [merge([base, lid], "body"), picture_side]


def _panel(x: float, far_x: float, y: float, far_y: float, z: float, material: int) -> Mesh:
    """A raised field with bevelled edges on a door's face at `z`."""
    bevel, rise = 0.03, 0.012
    outer = [(x, y, z), (far_x, y, z), (far_x, far_y, z), (x, far_y, z)]
    inner = [(x + bevel, y + bevel, z + rise), (far_x - bevel, y + bevel, z + rise),
             (far_x - bevel, far_y - bevel, z + rise), (x + bevel, far_y - bevel, z + rise)]
    edges = [[outer[i], outer[(i + 1) % 4], inner[(i + 1) % 4], inner[i]] for i in range(4)]
    return quads([*edges, inner], material=material)
