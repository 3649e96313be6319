"""What cascades cost beside one grid and one large grid, and how much nearer they are to the truth near the camera."""

from __future__ import annotations

import statistics
from collections.abc import Sequence
from typing import Any

import numpy as np

from octolux.compare.choices import choice
from octolux.compare.metrics import relative_errors
from octolux.simulator.grid import Grid
from octolux.simulator.lpv.cascades import grids_of, place_windows, weights
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings

from .clpv_table1 import base_scene, measured
from .comparison import diffuse_indirect, picture
from .comparison_set import VIEWS, View, reference, scene_of
from .olpv_scene import SCENES
from .registry import NeedsData, aim, at_most, figure

NEAR = ("atrium", "crytek_sun", "sponza_sunpoint")
FRAMES = 9
_CACHE = ("injection", "scene surfels", "geometry volume", "reflectors", "propagation", "volumes")
"""Stages of the whole light cache, by steps: all between the RSMs and the lookup."""

KINDS = {"open": "occlusion=false,bounces=1", "blocked": "occlusion=true,bounces=2"}
_STEPS = "cascaded-lpv:steps,ambient_occlusion=false"


def _one(kind: str) -> str:
    return f"{_STEPS},iterations=8,cascades=1,{KINDS[kind]}"


def _three(kind: str) -> str:
    return f"{_STEPS},iterations=8,cascades=3,{KINDS[kind]}"


def _large(kind: str) -> str:
    return f"{_STEPS},iterations=16,n=64,cascades=1,{KINDS[kind]}"


def _ratio(first: Sequence[dict[str, float]], second: Sequence[dict[str, float]]) -> float:
    """Median of the light cache's time over the other's, frame by frame."""
    a, b = ([sum(frame.get(stage, 0.0) for stage in _CACHE) for frame in frames] for frames in (first, second))
    return statistics.median(x / y for x, y in zip(a, b, strict=True))


@figure("clpv_cascades_whole", group="clpv", unit="x", bound={
    f"{kind}.{name}": at_most(bound)
    for kind in KINDS for name, bound in (("three", 3.2), ("large", 0.5), ("three_anew", 3.2), ("large_anew", 0.5))
})  # fmt: skip
def clpv_cascades_whole() -> dict[str, float]:
    """The whole light cache by 8 steps, from injection to the volumes that are looked up: three cascades of 32^3 over
    one, and (large) over one of 64^3 with 16 steps; blocked: with occlusion and bounces. In frames that keep what
    blocks and reflects light, as nothing moves, and in those in which it is made anew."""
    found = {}
    for kind in KINDS:
        texts = [_one(kind), _three(kind), _large(kind)]
        for word, anew in (("", False), ("_anew", True)):
            frames = measured(base_scene("atrium"), SCENES["atrium"], texts, FRAMES, (160, 90), anew=anew)
            one, three, large = frames.values()
            found[f"{kind}.three{word}"], found[f"{kind}.large{word}"] = _ratio(three, one), _ratio(three, large)
    return found


def near_camera(view: View, places: np.ndarray, settings: Any) -> np.ndarray:
    """Which `places` (height, width, 3) lie where the view's camera has the finest cascade read alone: bool (height,
    width)."""
    scene, n = scene_of(view), settings.n
    camera = next(c for c in scene.cameras if c.name == view.camera)
    volume = Grid.around(*scene.bounds(), n)
    windows = place_windows(n, settings.cascades, volume, camera.position, camera.forward)
    cells = [grid.to_cells(places.reshape(-1, 3)) for grid in grids_of(windows, volume)]
    return (weights(cells, windows, n)[0] == 1.0).reshape(places.shape[:2])


def near_error(view: View, text: str) -> float:
    """Trimmed relative RMSE against the first bounce (metrics.relative_errors) near the camera: in the default's finest
    cascade. nan where the reference is black there."""
    first, rendering = reference(view, "first_bounce"), picture(view, choice(text))
    mask = first.mask & rendering.mask & near_camera(view, rendering.position, CascadedLpvSettings())
    halves = first.halves["indirect"]
    found = relative_errors(diffuse_indirect(rendering), *halves, mask, first.pictures["indirect"])["trimmed"]
    return float("nan") if found is None else found


@figure("clpv_near_camera", group="clpv", unit="relative", bound={
    f"{name}.{preset}": bound for name in NEAR for preset, bound in (("default", at_most(1.0)), ("steps", aim("<= 1")))
})  # fmt: skip
def clpv_near_camera() -> dict[str, float]:
    """Error of three cascades where the finest is read, over that of one grid of 32^3 over the scene there: trimmed
    relative RMSE of the first bounce. One bounce, as the reference has, and nothing in screen space. By steps light
    goes as many cells as there are steps, which is a quarter as far in the finest cascade."""
    found = {}
    for name in NEAR:
        for preset in ("default", "steps"):
            texts = [f"cascaded-lpv:{preset},bounces=1,ambient_occlusion=false,cascades={n}" for n in (3, 1)]
            try:
                cascades, one = (near_error(VIEWS[name], text) for text in texts)
            except NeedsData:
                continue
            found[f"{name}.{preset}"] = cascades / one
            found[f"{name}.{preset}_error"] = cascades
    return found
