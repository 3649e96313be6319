"""Artefacts of OLPV 6.1 and 6.2 in pictures of bare rooms: jumps while a lamp moves, and light behind a closed wall."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import pairwise

import numpy as np

from octolux.compare.choices import choice
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.lights import Light, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene

from .lab import device
from .olpv_jumps import OCTREES, THESIS, UNIFORMS, VISIBLE, N
from .olpv_scene import MAPS
from .registry import figure

CELL = 0.25
SIDE = (N - 2) * CELL
"""Metres: a cube as large as this has cells of CELL, and one of them around it."""

MOVES = 16
"""Steps in which the lamp goes one cell."""

SIZE = (160, 90)
OCCLUDED = (f"{THESIS},occlusion=true", "octree-lpv:steps,occlusion=true")
OPEN = "octree-lpv,occlusion=false"


def room(light: Light, cameras: list[Camera], inner: Mesh | None = None) -> Scene:
    """A closed cube from the origin on, white inside, and what else is in it."""
    meshes = [box((0, 0, 0), (SIDE, SIDE, SIDE), inward=True), *([inner] if inner else [])]
    return Scene(
        meshes=meshes, instances=[Instance(i) for i in range(len(meshes))], cameras=cameras, lights=[light],
        materials=[Material(base_color=(0.8, 0.8, 0.8), specular=0.0)], exposure=0.0,
    )  # fmt: skip


def irradiance(text: str, frames: list[Scene], camera: int = 0) -> Iterator[np.ndarray]:
    """Mean indirect irradiance of the channels at every pixel, for one scene after the other: (height, width), lx."""
    one = choice(text)
    renderer = Renderer(
        frames[0], one.technique, settings=one.settings, size=SIZE, device=device(), frame_settings=MAPS
    )
    for scene in frames:
        renderer.scene = scene
        yield renderer.render(camera).layers["irradiance"].mean(axis=-1)


def moving_spot() -> list[Scene]:
    """A spot light below the ceiling whose pool of light goes one cell along the floor."""
    eye = Camera.look_at((0.4, 4.5, 0.4), (4.5, 1.5, 4.5), vertical_fov=1.3)
    lamp = SpotLight(position=(3.0, 7.0, 3.4), direction=(0.0, -1.0, 0.0), intensity=(100.0,) * 3, inner_angle=0.15,
                     outer_angle=0.2)  # fmt: skip
    places = [(lamp.position[0] + CELL * i / MOVES, *lamp.position[1:]) for i in range(MOVES + 1)]
    scene = room(lamp, [eye])
    return [replace(scene, lights=[replace(lamp, position=place)]) for place in places]


def temporal_jump(text: str) -> float:
    """Largest change of a visible pixel from one frame to the next, in stops. A pixel is visible while it has more than
    VISIBLE of the brightest in either frame; one that comes from there or goes there counts from VISIBLE on."""
    pictures = list(irradiance(text, moving_spot()))
    floor = VISIBLE * max(p.max() for p in pictures)
    stops = [np.log2(np.maximum(p, floor)) for p in pictures]
    return float(max(np.abs(b - a).max() for a, b in pairwise(stops)))


def divided_room(cells: float) -> Scene:
    """A closed wall so many cells thick between a half with a lamp and a dark one; a camera in each."""
    half, middle = 0.5 * cells * CELL, 0.5 * SIDE + 0.3 * CELL  # no border of cells, and so none of levels, is in it
    wall = box((middle - half, 0, 0), (middle + half, SIDE, SIDE))
    height = 0.5 * SIDE
    eyes = [Camera.look_at((x, height, 0.3), (x, height, SIDE), vertical_fov=1.6) for x in (1.5, SIDE - 1.5)]
    return room(PointLight(position=(1.8, 4.0, 3.5), intensity=(100.0,) * 3), eyes, wall)


def bleeding(text: str, cells: float) -> float:
    """Mean indirect irradiance of what is seen in the dark half over that in the lit half: 0 in truth."""
    lit, dark = (next(irradiance(text, [divided_room(cells)], camera)).mean() for camera in (0, 1))
    return float(dark / lit)


@figure("olpv_temporal_jumps", group="olpv", unit="stops")
def olpv_temporal_jumps() -> dict[str, float]:
    """Largest change of a pixel from frame to frame while a spot light goes one cell in 16 steps (OLPV 6.1)."""
    return {text: temporal_jump(text) for text in (*OCTREES, *UNIFORMS)}


@figure("olpv_wall_bleeding", group="olpv", unit="share")
def olpv_wall_bleeding() -> dict[str, float]:
    """Light behind a closed wall over that before it, for walls of 0.4 and of 2 cells (OLPV 6.2), with and without
    occlusion."""
    texts = (*OCTREES, *OCCLUDED, OPEN, *UNIFORMS)
    return {f"{text}.{cells:g}_cells": bleeding(text, cells) for text in texts for cells in (0.4, 2.0)}
