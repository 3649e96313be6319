"""The corridor: two parallel limbs with a thin wall between them, joined by a bend; light in one limb only."""

from __future__ import annotations

from math import radians

import numpy as np

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import Light, SpotLight
from ..materials import Material
from ..meshes import Mesh
from ..motion.tracks import Track
from ..scene import Scene
from .furniture import door, pendant, picture, skirting, spotlight, vase
from .lamps import WARM_BULB, WARM_WHITE, spot_intensity
from .placing import Parts, aimed, placed, plain, textured
from .round_shapes import cylinder, sphere, tube
from .shapes import box, quad
from .textures import plaster, tiles

LIT, FAR, BEND, WHITE, FLOOR, OAK, STEEL, BRASS, RED, CANVAS, BULB = range(11)

THIN = 0.05
"""Thickness of the wall between the limbs, metres."""
SIDE, END, TURN, HEIGHT = 1.825, 2.6, 4.2, 2.5
"""Half the width of the whole, where the limbs end at +z, where the bend ends at -z; the ceiling."""
EDGE = -2.4
"""z of the thin wall's free edge."""

RAIL_LUMEN, BEND_LUMEN = 1200.0, 1500.0
"""A bulb of 10 W (LED), and a spotlight of 15 W."""
RAIL_CONE, BEND_CONE = (radians(30.0), radians(75.0)), (radians(12.0), radians(45.0))
"""Inner and outer half-angles."""
DROP = 0.38
"""How far the lamps hang from the ceiling; their light starts 2 cm below the shade's edge."""
RAIL_LAMP = (-0.93, HEIGHT - DROP - 0.02, 1.0)
BEND_LAMP, BEND_AIM = (-1.45, 2.25, -1.5), (2.4, -1.1, -2.7)
"""The second lamp and where it shines to: past the thin wall's edge on the back of the bend."""

METERED_LUMINANCE = 3.0
"""Nits: between what a path tracer shows to the camera "lit" (16 on average) and the middle of what "far" sees (0.9),
as one would meter both and choose the shade."""


def corridor() -> Scene:
    """A U-shaped corridor with a 5 cm wall between a lit and an unlit limb and a glossy floor: shows leaks.

    x from -1.825 to 1.825, z from -4.2 to 2.6, 2.5 m high. The lit limb is at negative x, the bend at negative z; no
    lamp's light reaches the far limb straight. The lamp "rail lamp" travels along its rail in 8 s. Cameras "lit",
    "bend" and "far".
    """
    parts = Parts()
    parts.add(*_walls())
    _fittings(parts)
    _lamps(parts)
    return Scene(
        name="corridor",
        meshes=parts.meshes,
        instances=parts.instances,
        materials=_materials(),
        lights=_lights(),
        cameras=[
            Camera.look_at((-1.2, 1.6, 2.45), (-0.70, 1.1, -2.4), vertical_fov=radians(60), name="lit"),
            Camera.look_at((-0.35, 1.6, -4.05), (0.28, 1.15, -1.0), vertical_fov=radians(75), name="bend"),
            Camera.look_at((1.2, 1.6, 2.45), (0.70, 1.1, -2.4), vertical_fov=radians(60), name="far"),
        ],
        tracks=_tracks(),
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _materials() -> list[Material]:
    """In the order of this module's constants. Linear albedos."""
    return [
        textured("lit wall", plaster(11, (0.62, 0.36, 0.20), strength=0.6), 0.9),
        textured("far wall", plaster(12, (0.34, 0.58, 0.62), strength=0.6), 0.9),
        textured("bend wall", plaster(13, (0.70, 0.64, 0.42), strength=0.6), 0.9),
        plain("white paint", (0.78, 0.77, 0.74), 0.8),
        textured("polished floor", tiles(14, (0.34, 0.32, 0.29), (0.09, 0.085, 0.08)), 0.18, normal_scale=0.25),
        plain("oak", (0.36, 0.21, 0.10), 0.5),
        plain("brushed steel", (0.56, 0.57, 0.58), 0.35, metallic=1.0),
        plain("brass", (0.91, 0.78, 0.42), 0.35, metallic=1.0),
        plain("signal red", (0.55, 0.025, 0.02), 0.35),
        textured("canvas", plaster(15, (0.45, 0.38, 0.22), strength=0.5), 0.9),
        WARM_BULB,
    ]


def _walls() -> list[Mesh]:
    """Floor, ceiling and walls, all facing inwards; both faces and the end of the thin wall."""
    half, turn = THIN / 2.0, EDGE

    def upright(x: float, z: float, far_x: float, far_z: float, material: int, name: str) -> Mesh:
        corners = [(x, 0, z), (far_x, 0, far_z), (far_x, HEIGHT, far_z), (x, HEIGHT, z)]
        return quad(corners, tile=2.0, material=material, name=name)

    level = [(-SIDE, END), (SIDE, END), (SIDE, -TURN), (-SIDE, -TURN)]
    return [
        quad([(x, 0, z) for x, z in level], tile=1.8, material=FLOOR, name="floor"),
        quad([(x, HEIGHT, z) for x, z in level[::-1]], tile=2.0, material=WHITE, name="ceiling"),
        upright(-SIDE, END, -SIDE, turn, LIT, "lit limb: outer wall"),
        upright(-half, turn, -half, END, LIT, "thin wall: lit side"),
        upright(-half, END, -SIDE, END, LIT, "lit limb: end"),
        upright(half, END, half, turn, FAR, "thin wall: far side"),
        upright(SIDE, turn, SIDE, END, FAR, "far limb: outer wall"),
        upright(SIDE, END, half, END, FAR, "far limb: end"),
        upright(half, turn, -half, turn, BEND, "thin wall: edge"),
        upright(-SIDE, turn, -SIDE, -TURN, BEND, "bend: left"),
        upright(-SIDE, -TURN, SIDE, -TURN, BEND, "bend: back"),
        upright(SIDE, -TURN, SIDE, turn, BEND, "bend: right"),
    ]


def _fittings(parts: Parts) -> None:
    """Doors, pictures, boards along the walls, a bench, and things that stand about."""
    doors = {"lit door 1": placed(-SIDE, 0, 0.9, 90), "lit door 2": placed(-SIDE, 0, -1.7, 90),
             "lit end door": placed(-0.925, 0, END, 180), "far door 1": placed(SIDE, 0, 0.9, -90),
             "far door 2": placed(SIDE, 0, -1.7, -90), "far end door": placed(0.925, 0, END, 180)}
    parts.place(door(0.86, 2.03, leaf=OAK, casing=WHITE, metal=STEEL), doors)
    pictures = {f"picture {i + 1}": placed(side * THIN / 2, 0, z, 90 * side)
                for i, (side, z) in enumerate(((-1, 0.9), (-1, -1.3), (1, 0.9), (1, -1.3)))}
    parts.place(picture(0.9, 0.6, 1.5, frame=OAK, canvas=CANVAS), pictures)
    half, turn = THIN / 2.0, EDGE
    around = [(-SIDE, END), (-SIDE, -TURN), (SIDE, -TURN), (SIDE, END), (half, END), (half, turn), (-half, turn),
              (-half, END)]
    # Only where no door is: the boards would stand before the leaves.
    parts.add(skirting([(around[4], around[5]), (around[6], around[7]), (around[1], around[2])], material=WHITE))
    stand = [box((-0.16, 0.0, -0.16), (0.16, 0.9, 0.16), material=WHITE, name="plinth")]
    parts.place(stand, {"bend": placed(1.35, 0, -3.75), "far": placed(0.33, 0, 0.1), "lit": placed(-0.33, 0, -0.2)})
    parts.place([vase(0.42, material=BRASS)], {"far": placed(0.33, 0.9, 0.1), "lit": placed(-0.33, 0.9, -0.2)})
    parts.place([sphere(0.16, material=RED, name="ball")], {"bend": placed(1.35, 1.06, -3.75)})
    bench = [box((-0.6, 0.42, 0.02), (0.6, 0.46, 0.40), material=OAK, name="seat"),
             box((-0.52, 0.0, 0.06), (-0.48, 0.42, 0.36), material=STEEL, name="left foot"),
             box((0.48, 0.0, 0.06), (0.52, 0.42, 0.36), material=STEEL, name="right foot")]
    parts.place(bench, {"far bench": placed(SIDE, 0, -0.4, -90), "lit bench": placed(-SIDE, 0, -0.4, 90)})
    parts.place([cylinder(0.075, 0.48, material=RED, name="extinguisher")], {"bend": placed(-1.72, 0.25, -3.2)})


def _lamps(parts: Parts) -> None:
    """A pendant on a rail below the ceiling of the lit limb, and a can on an arm beside it."""
    x, _, z = RAIL_LAMP
    parts.add(box((x - 0.015, HEIGHT - 0.02, -2.2), (x + 0.015, HEIGHT, 2.3), material=STEEL, name="rail"))
    parts.place(pendant(DROP, shade=WHITE, rod=STEEL, bulb=BULB), {"rail lamp": placed(x, HEIGHT, z)})
    parts.place(spotlight(can=STEEL, bulb=BULB), {"bend lamp": aimed(BEND_LAMP, BEND_AIM)})
    back = np.array(BEND_LAMP) - 0.16 * np.array(BEND_AIM) / np.linalg.norm(BEND_AIM)
    parts.add(tube([back, (back[0], HEIGHT, back[2])], 0.008, material=STEEL, name="bend lamp arm"))


def _lights() -> list[Light]:
    lamps = {"rail lamp": (RAIL_LAMP, (0.0, -1.0, 0.0), RAIL_LUMEN, RAIL_CONE),
             "bend lamp": (BEND_LAMP, BEND_AIM, BEND_LUMEN, BEND_CONE)}
    return [
        SpotLight(position=place, direction=direction, intensity=spot_intensity(lumen, *cone, WARM_WHITE),
                  inner_angle=cone[0], outer_angle=cone[1], name=name)
        for name, (place, direction, lumen, cone) in lamps.items()
    ]  # fmt: skip


def _tracks() -> list[Track]:
    """The rail lamp and all that belongs to it go along the rail and back."""
    times, z = np.array([0.0, 1.5, 5.5, 8.0]), np.array([0.0, 1.0, -1.8, 0.0])
    way = np.stack([0.0 * z, 0.0 * z, z], axis=1)
    hung = [f"rail lamp {part}" for part in ("shade", "rod", "bulb")]
    return [Track(target="light", name="rail lamp", property="position", times=times, values=RAIL_LAMP + way),
            *(Track(target="instance", name=name, property="translation", times=times, values=way) for name in hung)]
