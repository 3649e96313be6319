"""Stability of CLPV 4.2 while a lamp, or something smaller than a cell, moves: indirect light at the pixels of a camera
that stays, out of line with the frames before and after.

What is smooth has small second differences. Light that comes from a distance d, as its inverse square at the quickest,
has 6 (s / d)^2 of itself after steps of s: 0.02 % for a tenth of a cell and d of 17 cells, 0.17 % for 6. A jump by a
share J between two frames has J in both second differences that hold it, light that is off for one frame 2 J.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from octolux.compare.choices import choice
from octolux.frame.frame import FrameSettings
from octolux.renderer import Renderer
from octolux.scene.builtin.round_shapes import sphere
from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import PointLight
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.grid import Grid
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings

from .clpv_stability import STEP, TEXTS, VISIBLE, atrium
from .lab import device
from .olpv_rooms import room
from .registry import at_most, figure

SIZE = (160, 90)
BALL_SIZE = (320, 180)
"""Pixels a twelfth of a cell wide: ambient occlusion is filtered over 4 x 4 of them, which must not be as wide as the
way from the ball to what is counted. In 160 x 90, where they are 2/3 of a cell, its own shadow reaches there."""

FRAMES = 41
"""Four cells, so that the lamp crosses cells of the two finest cascades."""

MAPS = FrameSettings(shadow_resolution=1024, rsm_resolution=256, sky_lights=0, emitter_lights=0)
_DEFAULT = CascadedLpvSettings()


def cell_sizes(scene: Scene) -> list[float]:
    """Metres, of each cascade of the default, the finest first."""
    coarsest = Grid.around(*scene.bounds(), _DEFAULT.n).cell_size
    return [coarsest / 2 ** (_DEFAULT.cascades - 1 - i) for i in range(_DEFAULT.cascades)]


def moving_lamp() -> Iterator[Scene]:
    """The atrium by night; a lamp goes along its middle, 1 m and more away from all that it lights."""
    step = STEP * cell_sizes(atrium())[0]
    for k in range(FRAMES):
        lamp = PointLight(position=(-6.0 + k * step, 2.4, 0.3), intensity=(1000.0,) * 3)
        yield replace(atrium(), lights=[lamp], environment=Environment((0.0, 0.0, 0.0)))


def table_top(cascade: int) -> list[Scene]:
    """A room with a table, a lamp above it, and a ball half as large as a cell of that cascade, which rolls along the
    table by tenths of a cell. The camera is so far away that it sees the table in that cascade."""
    table = box((4.6, 1.0, 4.6), (6.6, 1.1, 6.6), material=0)
    lamp = PointLight(position=(5.2, 3.0, 5.8), intensity=(100.0,) * 3)
    target, back = np.array([5.6, 1.1, 5.6]), (0.9, 6.4)[cascade > 0]
    away = np.array([-0.62, 0.48, -0.62])
    eye = Camera.look_at(target + back * away / np.linalg.norm(away), target, vertical_fov=0.9 / back, near=0.05)
    bare = room(lamp, [eye], table)
    size = cell_sizes(bare)[cascade]
    ball = sphere(0.25 * size, material=0, name="ball")
    frames = []
    for k in range(FRAMES // 2):
        transform, along = np.eye(4), (k - FRAMES / 4) * STEP * size
        transform[:3, 3] = target + np.array([along, 0.25 * size, 0.1])
        instance = Instance(len(bare.meshes), transform=transform, name="ball")
        frames.append(replace(bare, meshes=[*bare.meshes, ball], instances=[*bare.instances, instance]))
    return frames


def second_differences(light: Sequence[np.ndarray], counted: np.ndarray) -> np.ndarray:
    """|a - 2 b + c| over the mean of the three, of each three frames: (frames - 2, points). light: (height, width)
    each. counted: bool (height, width); of these, points with more than VISIBLE of their mean are taken."""
    series = np.array([frame[counted] for frame in light], np.float64)
    lit = series.min(axis=0) > VISIBLE * series.mean()
    a, b, c = series[:-2, lit], series[1:-1, lit], series[2:, lit]
    return 3.0 * np.abs(a - 2.0 * b + c) / (a + b + c)


def rendered(
    text: str, frames: Sequence[Scene], camera: Any, size: tuple[int, int] = SIZE
) -> tuple[list[np.ndarray], list[Any]]:
    """Indirect irradiance of each frame, mean of the channels, lx (height, width), and the pictures."""
    one = choice(text)
    renderer = Renderer(
        frames[0], one.technique, settings=one.settings, size=size, exposure=0.0, device=device(), frame_settings=MAPS
    )
    light, pictures = [], []
    for scene in frames:
        renderer.scene = scene
        pictures.append(renderer.render(camera))
        light.append(pictures[-1].layers["irradiance"].mean(axis=-1))
    return light, pictures


def lamp_jumps(text: str) -> dict[str, float]:
    light, pictures = rendered(text, list(moving_lamp()), "hall")
    return _summary(second_differences(light, pictures[0].mask))


def ball_flicker(text: str, cascade: int) -> dict[str, float]:
    """Of what is a cell and more away from the ball's middle in all frames: nearer, its own shadow and light move.

    What the ball does there is smooth: seen from a cell away, a ball of a quarter of a cell's radius covers 1/16 of the
    irradiance at most, which changes with the inverse square of the distance, 6 (1/10)^2 / 16 = 0.4 %.
    """
    frames = table_top(cascade)
    light, pictures = rendered(text, frames, 0, BALL_SIZE)
    size = cell_sizes(frames[0])[cascade]
    counted = pictures[0].mask.copy()
    for scene, picture in zip(frames, pictures, strict=True):
        away = picture.layers["position"] - scene.instances[-1].transform[:3, 3]
        counted &= np.linalg.norm(away, axis=-1) >= size
    return _summary(second_differences(light, counted))


def _summary(found: np.ndarray) -> dict[str, float]:
    p50, p99, largest = np.percentile(found, (50.0, 99.0, 100.0))
    return {"p50": float(p50), "p99": float(p99), "max": float(largest), "points": float(found.shape[1])}


def _named(name: str, values: dict[str, float]) -> dict[str, float]:
    return {f"{name}.{key}": value for key, value in values.items()}


@figure("clpv_stability_lamp", group="clpv", bound=dict.fromkeys(("default.max", "volumes.max"), at_most(0.05)))
def clpv_stability_lamp() -> dict[str, float]:
    """A lamp moves through the atrium by a tenth of a cell a frame: second differences of the indirect irradiance."""
    found: dict[str, float] = {}
    for name, text in TEXTS.items():
        found |= _named(name, lamp_jumps(text))
    return found


@figure("clpv_stability_object", group="clpv", bound=dict.fromkeys(
    [f"{name}.{where}.max" for name in ("default", "volumes") for where in ("finest", "coarsest")], at_most(0.02)
))  # fmt: skip
def clpv_stability_object() -> dict[str, float]:
    """A ball half as large as a cell rolls along a table by a tenth of a cell a frame, seen in the finest cascade and
    in the coarsest: second differences around it."""
    found: dict[str, float] = {}
    for name, text in TEXTS.items():
        for where, cascade in (("finest", 0), ("coarsest", _DEFAULT.cascades - 1)):
            found |= _named(f"{name}.{where}", ball_flicker(text, cascade))
    return found
