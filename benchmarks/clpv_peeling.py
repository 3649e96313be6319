"""How much of what blocks light is found by lamps and the camera (CLPV 3.2, figure 11): by depth-peeled layers of what
they see, and by keeping it from frame to frame."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from octolux.compare.choices import choice
from octolux.compare.metrics import relative_errors
from octolux.frame.frame import FrameSettings
from octolux.renderer import Renderer
from octolux.scene.cameras import Camera

from .clpv_stability import atrium
from .clpv_table1 import base_scene, measured
from .comparison import diffuse_indirect, picture
from .comparison_set import VIEWS, reference
from .lab import device
from .olpv_scene import SCENES
from .registry import at_most, figure

LAYERS = (1, 2, 3, 4)
WINDOWS = {"finest": 0, "coarsest": -1}
SIZE, MAPS = (256, 144), FrameSettings(shadow_resolution=512, rsm_resolution=256, sky_lights=0, emitter_lights=0)
"""A surfel a pixel, and a texel of four of the shadow map."""

HALF = (128, 72), replace(MAPS, shadow_resolution=256, rsm_resolution=128)
FRAMES, STEPS_OF_A_TURN, STEPS_OF_A_WALK = 9, 12, 96
WALK = 8.0  # metres: at 20 frames a second a walk

SPACING = 1 / 8
"""Of the scene's surfels, in cells of the coarsest cascade: in the atrium two along an edge of a finest cell, as there
are no more than frame/scene_surfels.py has at most.

Such a surfel lies in one cell, though it reaches into others: SPACING along the two axes across the one that it faces,
up to twice that along it. A side of a cell cuts off of it less than half, a quarter on average, so that of what the
scene's surfels block SPACING (1 + 1 + 2) / 4 at most lies in cells where it should not. Edges of surfaces err alike."""

# Of the geometry volume alone: cells of the default's, which count a closed object once, and the paper's view of them.
_VOLUME = "cascaded-lpv:default,bounces=1,ambient_occlusion=false,glossy=false"
_SEEN = "surfels=lamps and camera"
_WAYS = {"paper": "cascaded-lpv:paper", "default": "cascaded-lpv:default,bounces=1"}
_DRAWING = ("RSM rendering", "RSM surfaces", "peeled RSMs", "peeled G-buffer", "geometry volume")


def blocked(
    changes: str, cameras: Sequence[Camera], size: tuple[int, int] = SIZE, maps: FrameSettings = MAPS
) -> list[np.ndarray]:
    """Shares [z][y][x][3] of each cascade, the finest first, after a frame of the atrium by day from each camera."""
    one = choice(f"{_VOLUME},{changes}")
    made = Renderer(
        atrium(), one.technique, settings=one.settings, size=size, exposure=0.0, device=device(), frame_settings=maps
    )
    for camera in cameras:
        made.render(camera)
    return made.technique.debug_views()["blocked"][: one.settings.cascades]


def found_and_more(found: np.ndarray, every: np.ndarray) -> tuple[float, float]:
    """Of all that `every` blocks, which share `found` does too, and how much it blocks besides, by errors of sampling.
    Both [z][y][x][3]."""
    whole = float(every.sum())
    return float(np.minimum(found, every).sum()) / whole, float(np.maximum(found - every, 0.0).sum()) / whole


def turn(camera: Camera, steps: int = STEPS_OF_A_TURN, length: float = 0.0) -> Iterator[Camera]:
    """Once around about the vertical, over `length` metres forwards: the last looks where `camera` does."""
    x, y, z = camera.forward
    for k in range(1, steps + 1):
        c, s = np.cos(2 * np.pi * k / steps), np.sin(2 * np.pi * k / steps)
        place = camera.position + k / steps * length * np.array([x, 0.0, z])
        ahead = place + np.array([c * x + s * z, y, c * z - s * x])
        yield Camera.look_at(place, ahead, vertical_fov=camera.vertical_fov, near=camera.near)


def _eye() -> Camera:
    return next(camera for camera in atrium().cameras if camera.name == SCENES["atrium"])


@figure("clpv_peeling", group="clpv", bound={f"coarsest.rest_{k}": at_most(SPACING) for k in LAYERS})
def clpv_peeling() -> dict[str, float]:
    """Of what the scene's surfels block in the atrium with the sun, the share that the G-buffer's and the RSM's do: of
    1 to 4 layers; kept: after a turn of the camera, of 1 and 3. more: what is blocked besides. rest: of all that is
    blocked, what would be so with endlessly fine maps. Errors of sampling fall with the texels' length, so that is
    twice what it is less what it is with maps half as fine."""
    eye = [_eye()]
    every, found = blocked("surfels=scene", eye), {}
    for k in LAYERS:
        changes = f"{_SEEN},layers={k}"
        here, half = _compared(blocked(changes, eye), every), _compared(blocked(changes, eye, *HALF), every)
        for where, (share, more) in here.items():
            found |= {f"{where}.layers_{k}": share, f"{where}.more_{k}": more}
            found[f"{where}.rest_{k}"] = 2.0 * _besides(share, more) - _besides(*half[where])
    for k in (1, 3):
        cells = blocked(f"{_SEEN},layers={k},keep_surfels=true", list(turn(_eye())))
        for where, (share, more) in _compared(cells, every).items():
            found |= {f"{where}.layers_{k}_kept": share, f"{where}.more_{k}_kept": more}
    return found


def _compared(cells: Sequence[np.ndarray], every: Sequence[np.ndarray]) -> dict[str, tuple[float, float]]:
    return {where: found_and_more(cells[level], every[level]) for where, level in WINDOWS.items()}


def _besides(share: float, more: float) -> float:
    """Of all that is blocked, what the scene's surfels do not block."""
    return more / (share + more)


@figure("clpv_peeling_walk", group="clpv")
def clpv_peeling_walk() -> dict[str, float]:
    """Of all that is blocked in the atrium with the sun, the share that the scene's surfels do not block: after one
    frame, and kept over a walk in which the camera looks around once; surfels of 1 and 3 layers, pictures of
    128 x 72."""
    walk, size = list(turn(_eye(), STEPS_OF_A_WALK, WALK)), HALF[0]
    every, found = blocked("surfels=scene", walk[-1:], size), {}
    for k in (1, 3):
        changes = f"{_SEEN},layers={k}"
        ways = {"one": blocked(changes, walk[-1:], size), "kept": blocked(f"{changes},keep_surfels=true", walk, size)}
        for name, cells in ways.items():
            found |= {f"{where}.{name}_{k}": _besides(*both) for where, both in _compared(cells, every).items()}
    return found


@figure("clpv_peeling_time", group="clpv", unit="x", bound={"kept.volume": at_most(2.0)})
def clpv_peeling_time() -> dict[str, float]:
    """Time of the geometry volume by layers over that of one, and with all that is drawn for it (drawn); kept: the same
    of one layer that is kept, while nothing moves. `paper` in the atrium, one RSM of 256^2 and 256 x 144 pixels."""
    texts = {f"layers_{k}": f"cascaded-lpv:paper,layers={k}" for k in LAYERS}
    texts["kept"] = "cascaded-lpv:paper,keep_surfels=true"
    frames = measured(base_scene("atrium"), SCENES["atrium"], list(texts.values()), FRAMES, SIZE, anew=False)

    def ratio(text: str, stages: Sequence[str]) -> float:
        one, many = ([sum(f.get(s, 0.0) for s in stages) for f in frames[t]] for t in (texts["layers_1"], text))
        return statistics.median(b / a for a, b in zip(one, many, strict=True))

    found = {}
    for name, text in list(texts.items())[1:]:
        found |= {f"{name}.volume": ratio(text, ("geometry volume",)), f"{name}.drawn": ratio(text, _DRAWING)}
    return found


@figure("clpv_peeling_error", group="clpv", unit="relative")
def clpv_peeling_error() -> dict[str, float]:
    """Trimmed relative RMSE of the first bounce in the atrium, surfels of 1 to 4 layers and of the scene."""
    ways = {f"layers_{k}": f"{_SEEN},layers={k}" for k in LAYERS} | {"scene": "surfels=scene"}
    return {
        f"{preset}.{name}": _error(f"{text},ambient_occlusion=false,{changes}")
        for preset, text in _WAYS.items() for name, changes in ways.items()
    }  # fmt: skip


def _error(text: str) -> float:
    first: Any = reference(VIEWS["atrium"], "first_bounce")
    rendering = picture(VIEWS["atrium"], choice(text))
    mask, light = first.mask & rendering.mask, first.pictures["indirect"]
    found = relative_errors(diffuse_indirect(rendering), *first.halves["indirect"], mask, light)["trimmed"]
    return float("nan") if found is None else found
