"""How much of what blocks light is found by lamps and the camera (CLPV 3.2, figure 11): by depth-peeled layers of what
they see, and by keeping it from frame to frame."""

from __future__ import annotations

import statistics
from collections.abc import Iterator, Sequence
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
from .registry import at_least, at_most, figure

LAYERS = (1, 2, 3, 4)
SIZE = (256, 144)  # a surfel a pixel
FRAMES, STEPS_OF_A_TURN = 9, 12
MAPS = FrameSettings(shadow_resolution=512, rsm_resolution=256, sky_lights=0, emitter_lights=0)

# Of the geometry volume alone: cells of the default's, which count a closed object once, and the paper's view of them.
_VOLUME = "cascaded-lpv:default,bounces=1,ambient_occlusion=false,glossy=false"
_SEEN = "surfels=lamps and camera"
_WAYS = {"paper": "cascaded-lpv:paper", "default": "cascaded-lpv:default,bounces=1"}
_DRAWING = ("RSM rendering", "RSM surfaces", "peeled RSMs", "peeled G-buffer", "geometry volume")


def blocked(changes: str, cameras: Sequence[Camera]) -> list[np.ndarray]:
    """Shares [z][y][x][3] of each cascade, the finest first, after a frame of the atrium by day from each camera."""
    one = choice(f"{_VOLUME},{changes}")
    made = Renderer(
        atrium(), one.technique, settings=one.settings, size=SIZE, exposure=0.0, device=device(), frame_settings=MAPS
    )
    for camera in cameras:
        made.render(camera)
    return made.technique.debug_views()["blocked"][: one.settings.cascades]


def found_and_more(found: np.ndarray, every: np.ndarray) -> tuple[float, float]:
    """Of all that `every` blocks, which share `found` does too, and how much it blocks besides, by errors of sampling.
    Both [z][y][x][3]."""
    whole = float(every.sum())
    return float(np.minimum(found, every).sum()) / whole, float(np.maximum(found - every, 0.0).sum()) / whole


def turn(camera: Camera) -> Iterator[Camera]:
    """Once around about the vertical: the last looks where `camera` does."""
    x, y, z = camera.forward
    for k in range(1, STEPS_OF_A_TURN + 1):
        c, s = np.cos(2 * np.pi * k / STEPS_OF_A_TURN), np.sin(2 * np.pi * k / STEPS_OF_A_TURN)
        ahead = camera.position + np.array([c * x + s * z, y, c * z - s * x])
        yield Camera.look_at(camera.position, ahead, vertical_fov=camera.vertical_fov, near=camera.near)


def _eye() -> Camera:
    return next(camera for camera in atrium().cameras if camera.name == SCENES["atrium"])


@figure("clpv_peeling", group="clpv", bound={
    f"{where}.gain_{word}": at_least(1.0) for where in ("finest", "coarsest") for word in ("2", "3", "4", "kept")
})  # fmt: skip
def clpv_peeling() -> dict[str, float]:
    """Of what the scene's surfels block in the atrium with the sun, the share that the G-buffer's and the RSM's do: of
    1 to 4 layers; kept: after a turn of the camera, of 1 and 3. gain: over one layer less, or one that is not kept.
    more: what is blocked besides."""
    ways: dict[str, tuple[str, Sequence[Camera]]] = {
        str(k): (f"{_SEEN},layers={k}", [_eye()]) for k in LAYERS
    } | {f"{k}_kept": (f"{_SEEN},layers={k},keep_surfels=true", list(turn(_eye()))) for k in (1, 3)}  # fmt: skip
    every, shares = blocked("surfels=scene", [_eye()]), {}
    found: dict[str, float] = {}
    for name, way in ways.items():
        cells = blocked(*way)
        for where, level in (("finest", 0), ("coarsest", -1)):
            share, more = found_and_more(cells[level], every[level])
            found |= {f"{where}.layers_{name}": share, f"{where}.more_{name}": more}
            shares[where, name] = share
    for where in ("finest", "coarsest"):
        pairs = [(str(k), str(k), str(k - 1)) for k in LAYERS[1:]] + [("kept", "1_kept", "1")]
        found |= {f"{where}.gain_{word}": shares[where, a] / shares[where, b] for word, a, b in pairs}
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
