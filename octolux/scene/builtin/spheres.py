"""Spheres of plastic and metal, from glossy to rough, between coloured walls in the sun."""

from __future__ import annotations

from dataclasses import replace
from math import radians

import numpy as np

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import DirectionalLight
from ..materials import Color, Material
from ..meshes import Mesh
from ..motion.tracks import Track
from ..scene import Environment, Scene
from .placing import Parts, plain, textured
from .round_shapes import sphere
from .shapes import box, quad
from .textures import plaster, tiles

FLOOR, STEPS, RED, GREEN, WHITE, BALLS = range(6)

ROUGHNESS = (0.05, 0.2, 0.35, 0.5, 0.65, 0.8, 1.0)

PLASTIC: Color = (0.20, 0.33, 0.52)
METALS: dict[str, Color] = {
    "gold": (1.000, 0.782, 0.344),
    "copper": (0.955, 0.638, 0.538),
    "aluminium": (0.913, 0.922, 0.924),
}
"""Reflectance at normal incidence, linear Rec. 709: Akenine-Moeller et al., Real-Time Rendering, 4th edition (2018),
table 9.2."""
ROWS = ["plastic", *METALS]
"""From the front to the back."""

RADIUS, SPACING, RISE = 0.2, 0.52, 0.16
"""Of the spheres; between their centres; from step to step, metres."""
FRONT = 0.9
"""z of the front row."""
SIDE, WALL_HEIGHT, THICK = 2.5, 0.9, 0.12
"""Where the side walls stand, their height and thickness."""

SUN_ELEVATION, SUN_AZIMUTH = radians(44.0), radians(-40.0)
"""The azimuth is counted from +z towards +x: at first the sun stands at the left behind the camera."""
SUN: Color = (66_000.0, 60_000.0, 50_000.0)
"""Lux: a clear sun, a little warm."""
SKY: Color = (2_600.0, 3_600.0, 5_400.0)
"""Nits: a clear blue sky."""

METERED_LUMINANCE = 1600.0
"""Nits: a stop and a half below the geometric mean of what a path tracer shows to the camera "front" (4600), for the
shaded sides of the metals; the sunlit white wall, about 9000, stays below white at 1.2 * 8 * 1600."""


def spheres() -> Scene:
    """Rows of plastic, gold, copper and aluminium spheres, glossy to rough, in the sun between a red and a green wall.

    The instances are named "MATERIAL ROUGHNESS", with roughness from 0.05 to 1. The floor is chequered. The light
    "sun" goes once around in 12 s. Cameras "front", "side" and "close".
    """
    parts = Parts()
    parts.add(*_court(), *_balls())
    return Scene(
        name="spheres",
        meshes=parts.meshes,
        instances=parts.instances,
        materials=_materials(),
        lights=[DirectionalLight(direction=_sun(SUN_AZIMUTH), illuminance=SUN, name="sun")],
        cameras=[
            Camera.look_at((0.0, 2.3, 3.7), (0.0, 0.42, 0.1), vertical_fov=radians(42), name="front"),
            Camera.look_at((-2.1, 1.45, 2.9), (0.25, 0.4, 0.0), vertical_fov=radians(42), name="side"),
            Camera.look_at((1.5, 1.25, 2.7), (0.62, 0.42, 0.3), vertical_fov=radians(30), name="close"),
        ],
        environment=Environment(SKY),
        tracks=[_sun_track()],
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _materials() -> list[Material]:
    """In the order of this module's constants, then those of the spheres, row after row. Linear albedos."""
    stage = [
        textured("chequered floor", tiles(31, (0.62, 0.60, 0.56), (0.11, 0.10, 0.095)), 0.5, normal_scale=0.4),
        textured("steps", plaster(32, (0.52, 0.51, 0.49), strength=0.5), 0.9),
        textured("red wall", plaster(33, (0.60, 0.07, 0.045), strength=0.8), 0.9),
        textured("green wall", plaster(34, (0.10, 0.42, 0.09), strength=0.8), 0.9),
        textured("white wall", plaster(35, (0.70, 0.69, 0.66), strength=0.8), 0.9),
    ]
    balls = [
        plain(f"{kind} {roughness}", METALS.get(kind, PLASTIC), roughness, metallic=1.0 if kind in METALS else 0.0)
        for kind in ROWS for roughness in ROUGHNESS
    ]  # fmt: skip
    return stage + balls


def _court() -> list[Mesh]:
    """The floor, four broad steps and three low walls."""
    back = FRONT - (len(ROWS) - 0.5) * SPACING
    half = SPACING * len(ROUGHNESS) / 2.0
    near = back + 4.6
    steps = [box((-half, 0.0, back), (half, row * RISE, FRONT - (row - 0.5) * SPACING), tile=1.0, material=STEPS,
                 name=f"step {row}") for row in range(1, len(ROWS))]
    ground = [(-SIDE, 0, near), (SIDE, 0, near), (SIDE, 0, back), (-SIDE, 0, back)]
    return [
        quad(ground, tile=1.6, material=FLOOR, name="floor"),
        *steps,
        box((-SIDE - THICK, 0.0, back), (-SIDE, WALL_HEIGHT, near), tile=1.5, material=RED, name="red wall"),
        box((SIDE, 0.0, back), (SIDE + THICK, WALL_HEIGHT, near), tile=1.5, material=GREEN, name="green wall"),
        box((-SIDE - THICK, 0.0, back - THICK), (SIDE + THICK, 1.5, back), tile=1.5, material=WHITE, name="white wall"),
    ]


def _balls() -> list[Mesh]:
    ball = sphere(RADIUS)
    meshes: list[Mesh] = []
    for row, kind in enumerate(ROWS):
        for column, roughness in enumerate(ROUGHNESS):
            x, y = (column - (len(ROUGHNESS) - 1) / 2.0) * SPACING, row * RISE + RADIUS
            place = np.array([x, y, FRONT - row * SPACING], dtype=np.float32)
            meshes.append(replace(ball, positions=ball.positions + place, material=BALLS + len(meshes),
                                  name=f"{kind} {roughness}"))
    return meshes


def _sun(azimuth: float) -> tuple[float, float, float]:
    """The direction in which its light travels."""
    level = np.cos(SUN_ELEVATION)
    x, y, z = -level * np.sin(azimuth), -np.sin(SUN_ELEVATION), -level * np.cos(azimuth)
    return float(x), float(y), float(z)


def _sun_track() -> Track:
    """Once around, a key every 10 degrees."""
    keys = np.linspace(0.0, 2.0 * np.pi, 37)
    values = np.array([_sun(SUN_AZIMUTH + turn) for turn in keys])
    values[-1] = values[0]
    return Track(target="light", name="sun", property="direction", times=keys / keys[-1] * 12.0, values=values)
