"""The Cornell box, 2 m wide, lit by one lamp below the ceiling."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import PointLight
from ..materials import Material
from ..meshes import Instance, Mesh
from ..motion.tracks import Track
from ..scene import Scene
from .shapes import box, quads

WHITE, RED, GREEN = range(3)
LAMP = (0.0, 1.75, 0.2)
CANDELA = 60.0
"""As a household lamp of 750 lumen (4 pi times as much)."""

METERED_LUMINANCE = 4.0
"""Nits, what a meter at the camera shows without the spot on the ceiling just above the lamp."""


def cornell_box() -> Scene:
    """The classic box with a red and a green wall and two blocks, all Lambertian, lit by a lamp that travels around.

    x from -1 to 1, y from 0 to 2, z from -1 to 1, open towards +z. A point light "lamp" of 60 cd, once around in 8 s;
    a camera "front".
    """
    blocks = [_block((0.33, 0.0, 0.35), 0.58, 0.60, -17.0), _block((-0.34, 0.0, -0.30), 0.60, 1.20, 16.5)]
    return Scene(
        name="cornell-box",
        meshes=[*_walls(), box((-0.5, 0.0, -0.5), (0.5, 1.0, 0.5), material=WHITE, name="block")],
        instances=[
            *(Instance(i, name=name) for i, name in enumerate(("shell", "left wall", "right wall"))),
            Instance(3, blocks[0], name="short block"),
            Instance(3, blocks[1], name="tall block"),
        ],
        materials=[_lambert("white", 0.725, 0.71, 0.68), _lambert("red", 0.63, 0.065, 0.05),
                   _lambert("green", 0.14, 0.45, 0.091)],
        lights=[PointLight(position=LAMP, intensity=(CANDELA,) * 3, name="lamp")],
        cameras=[Camera.look_at((0.0, 1.0, 3.9), (0.0, 1.0, 0.0), vertical_fov=radians(39.0), name="front")],
        tracks=[_lamp_track()],
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _lambert(name: str, red: float, green: float, blue: float) -> Material:
    return Material(name=name, base_color=(red, green, blue), specular=0.0)


def _walls() -> list[Mesh]:
    floor = [(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)]
    ceiling = [(-1, 2, -1), (1, 2, -1), (1, 2, 1), (-1, 2, 1)]
    back = [(-1, 0, -1), (1, 0, -1), (1, 2, -1), (-1, 2, -1)]
    left = [(-1, 0, 1), (-1, 0, -1), (-1, 2, -1), (-1, 2, 1)]
    right = [(1, 0, -1), (1, 0, 1), (1, 2, 1), (1, 2, -1)]
    return [
        quads([floor, ceiling, back], material=WHITE, name="shell"),
        quads([left], material=RED, name="left wall"),
        quads([right], material=GREEN, name="right wall"),
    ]


def _block(position: tuple[float, float, float], width: float, height: float, degrees: float) -> np.ndarray:
    """Object to world for the unit block: scaled, turned about y, put at `position`."""
    c, s = cos(radians(degrees)), sin(radians(degrees))
    transform = np.eye(4)
    transform[:3, :3] = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ np.diag([width, height, width])
    transform[:3, 3] = position
    return transform


def _lamp_track() -> Track:
    """Once around the ceiling in 8 s, starting and ending at the lamp's own position."""
    stops = [LAMP, (0.6, 1.75, 0.5), (0.6, 1.75, -0.6), (-0.6, 1.75, -0.6), (-0.6, 1.75, 0.5), LAMP]
    return Track(target="light", name="lamp", property="position", times=np.array([0.0, 1.0, 3.0, 5.0, 7.0, 8.0]),
                 values=np.array(stops))
