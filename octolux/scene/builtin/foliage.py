"""A garden in the sun, whose alpha-masked leaves and laths throw patterns of shade."""

from __future__ import annotations

from itertools import pairwise
from math import radians

import numpy as np

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import DirectionalLight
from ..materials import Color, Material
from ..meshes import Mesh
from ..scene import Environment, Scene
from .lamps import pendulum
from .placing import Parts, placed, plain, textured
from .plant_textures import lattice, twig
from .plants import hedge, shrub, tree
from .round_shapes import plate, rounded_rectangle, tube
from .shapes import box, merge, quad, quads
from .textures import masonry, plaster

LAWN, PAVING, RENDER, COPING, BARK, LEAF, HEDGE, LATTICE, PAINT, WOOD, ROPE, SHADE = range(12)

X, BACK, FRONT = 5.0, -3.2, 5.0
"""The garden reaches from -X to X and from BACK to FRONT in z; walls and hedges stand on its edges."""
TREE = (-0.6, 0.0, -0.4)

PIVOT = (TREE[0] + 1.25, 2.44, TREE[2] + 0.045)
"""Where the swing hangs: on the level bough of the tree."""
SWING = 2.0
"""From the pivot to the seat, metres."""

SUN_DIRECTION = (0.55, -1.0, -0.62)
SUN: Color = (66_000.0, 60_000.0, 50_000.0)
"""Lux: a clear sun, a little warm."""
SKY: Color = (2_600.0, 3_600.0, 5_400.0)
"""Nits: a clear blue sky."""

METERED_LUMINANCE = 1300.0
"""Nits: between the geometric mean (1000) and the median (1700) of what a path tracer shows to the camera "wall"."""


def foliage() -> Scene:
    """A garden with a tree, shrubs, a hedge and a lattice fence, alpha-masked, whose shadows fall on lawn and wall.

    10 x 8.2 m; the fence stands at negative x, the wall at negative z, the hedge at positive x. The light "sun" shines
    from the left behind the camera "garden". A swing below the tree moves for 2.8 s. Cameras "garden", "wall" and
    "fence".
    """
    parts = Parts()
    parts.add(*_ground(), *_wall(), *_fence(), *_pickets())
    _plants(parts)
    parts.place(_swing(), {"swing": placed(*PIVOT)})
    swings = tuple(f"swing {part}" for part in ("seat", "ropes"))
    return Scene(
        name="foliage",
        meshes=parts.meshes,
        instances=parts.instances,
        materials=_materials(),
        lights=[DirectionalLight(direction=SUN_DIRECTION, illuminance=SUN, name="sun")],
        cameras=[
            Camera.look_at((-2.2, 1.7, 6.4), (0.1, 1.95, -1.0), vertical_fov=radians(52), name="garden"),
            Camera.look_at((2.9, 1.6, 2.2), (0.7, 1.15, -3.0), vertical_fov=radians(50), name="wall"),
            Camera.look_at((-1.5, 1.45, 4.6), (-4.3, 0.7, -0.4), vertical_fov=radians(52), name="fence"),
        ],
        environment=Environment(SKY),
        tracks=pendulum(PIVOT, SWING, 18.0, instances=swings),
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _materials() -> list[Material]:
    """In the order of this module's constants. Linear albedos; those of leaves are of green leaves in visible light."""
    return [
        textured("lawn", plaster(51, (0.075, 0.125, 0.03), strength=6.0), 1.0),
        textured("paving", masonry(52, (0.40, 0.36, 0.30), courses=4, blocks=4), 0.9),
        textured("render", plaster(53, (0.68, 0.62, 0.52), strength=1.2), 0.95),
        textured("coping", plaster(54, (0.42, 0.20, 0.12), strength=0.8), 0.9),
        textured("bark", plaster(55, (0.13, 0.095, 0.065), strength=8.0), 1.0),
        _leaves("leaves", twig(56, (0.10, 0.20, 0.035))),
        _leaves("hedge leaves", twig(57, (0.055, 0.125, 0.03))),
        Material(name="lattice", base_color_texture=lattice(58, (0.46, 0.33, 0.20)), roughness=0.9, alpha_mode="mask",
                 double_sided=True),
        plain("white paint", (0.74, 0.73, 0.70), 0.6),
        plain("weathered wood", (0.34, 0.24, 0.15), 0.8),
        plain("rope", (0.48, 0.39, 0.25), 1.0),
        plain("inside of the hedge", (0.02, 0.035, 0.012), 1.0),
    ]


def _leaves(name: str, texture) -> Material:
    return Material(name=name, base_color_texture=texture, roughness=0.6, alpha_mode="mask", double_sided=True)


def _ground() -> list[Mesh]:
    """The lawn, and a path of slabs along the wall and towards the viewer, 2 cm proud of it."""
    x, near, far = X + 2.2, FRONT + 2.5, BACK - 0.6
    lawn = [(-x, 0, near), (x, 0, near), (x, 0, far), (-x, 0, far)]
    path = [box((-X, -0.05, BACK + 0.55), (X, 0.02, BACK + 1.55), tile=1.6, material=PAVING),
            box((1.7, -0.05, BACK + 1.55), (2.8, 0.02, FRONT + 2.5), tile=1.6, material=PAVING)]
    return [quad(lawn, tile=1.7, material=LAWN, name="lawn"), merge(path, "path")]


def _wall() -> list[Mesh]:
    """A rendered wall with a coping, along the back."""
    z, t, high = BACK, 0.25, 2.5
    body = box((-X - t, 0.0, z - t), (X + t, high, z), tile=1.8, material=RENDER, name="wall")
    x, a, b = X + t + 0.02, z - t - 0.05, z + 0.05
    roof = [[(-x, high, b), (x, high, b), (x, high + 0.14, z - t / 2), (-x, high + 0.14, z - t / 2)],
            [(x, high, a), (-x, high, a), (-x, high + 0.14, z - t / 2), (x, high + 0.14, z - t / 2)],
            [(-x, high, a), (x, high, a), (x, high, b), (-x, high, b)]]
    return [body, quads(roof, tile=1.0, material=COPING, name="coping")]


def _fence() -> list[Mesh]:
    """Panels of lattice between posts along -X: each panel one alpha-masked quadrilateral, seen from both sides."""
    posts, panels = [], []
    edges = np.linspace(BACK + 0.15, FRONT, 6)
    for z in edges:
        posts.append(box((-X - 0.05, 0.0, z - 0.05), (-X + 0.05, 2.0, z + 0.05), material=WOOD))
        posts.append(box((-X - 0.065, 2.0, z - 0.065), (-X + 0.065, 2.03, z + 0.065), material=WOOD))
    for a, b in pairwise(edges):
        low, high = 0.12, 1.85
        panels.append([(-X, low, b - 0.05), (-X, low, a + 0.05), (-X, high, a + 0.05), (-X, high, b - 0.05)])
        for y in (low, high):
            posts.append(box((-X - 0.025, y - 0.03, a + 0.05), (-X + 0.025, y + 0.03, b - 0.05), material=WOOD))
    return [merge(posts, "fence posts"), quads(panels, tile=0.22, material=LATTICE, name="fence lattice")]


def _pickets() -> list[Mesh]:
    """A picket fence of boards in front of the hedge at +X."""
    x, boards = X - 0.55, []
    for z in np.arange(BACK + 0.12, FRONT, 0.14):
        outline = [(x + 0.012, z + 0.045), (x + 0.012, z - 0.045), (x - 0.012, z - 0.045), (x - 0.012, z + 0.045)]
        boards.append(plate(outline, 0.06, 0.95, material=PAINT))
    rails = [box((x + 0.012, y, BACK), (x + 0.045, y + 0.07, FRONT), material=PAINT) for y in (0.25, 0.70)]
    posts = [box((x + 0.045, 0.0, z - 0.04), (x + 0.125, 0.9, z + 0.04), material=PAINT)
             for z in np.linspace(BACK + 0.3, FRONT - 0.3, 5)]
    return [merge(boards, "pickets"), merge(rails + posts, "picket rails")]


def _plants(parts: Parts) -> None:
    parts.place(tree(59, bark=BARK, leaf=LEAF), {"tree": placed(*TREE)})
    places = {"shrub 1": placed(3.6, 0, -2.4, 40, 0.95), "shrub 2": placed(-3.9, 0, -2.2, 160, 1.15),
              "shrub 3": placed(-4.1, 0, 2.6, 250, 0.85), "shrub 4": placed(3.7, 0, 1.2, 10, 0.8),
              "shrub 5": placed(-2.9, 0, -2.75, 300, 0.7)}
    parts.place(shrub(60, 700, 0.62, bark=BARK, leaf=LEAF), places)
    parts.place(hedge(61, 8.2, 0.7, 2.0, 90.0, core=SHADE, leaf=HEDGE), {"hedge": placed(X, 0, 0.9, 90)})
    parts.place(hedge(62, 8.6, 0.7, 1.2, 90.0, core=SHADE, leaf=HEDGE), {"low hedge": placed(-X - 1.7, 0, 1.1, 90)})


def _swing() -> list[Mesh]:
    """A seat on two ropes, each slung over the bough, with the pivot at the origin."""
    half, d = 0.24, 0.10
    seat = plate(rounded_rectangle(0.62, 0.2, 0.03), -SWING - 0.025, -SWING, material=WOOD, name="seat")
    ropes = []
    for x in (-half, half):
        ropes.append(tube([(x, -SWING - 0.05, 0.0), (x, -0.25, 0.0), (x, 0.02, d), (x, 0.16, d), (x, 0.2, 0.0),
                           (x, 0.16, -d), (x, 0.02, -d), (x, -0.25, 0.0)], 0.011, sides=6, material=ROPE))
    return [seat, merge(ropes, "ropes")]
