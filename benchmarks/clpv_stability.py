"""Stability of CLPV 4.2 while the viewer moves: indirect light at fixed points of the atrium, frame to frame."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import cos, sin
from typing import Any

import numpy as np

import octolux
from octolux.compare.choices import choice
from octolux.frame.frame import FrameSettings
from octolux.scene.cameras import Camera
from octolux.scene.scene import Scene
from octolux.simulator.grid import Grid
from octolux.simulator.lpv.cascades import Window, grids_of, place_windows, weights
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings

from .onlooker import Onlooker, Points
from .registry import at_most, figure

TEXTS = {
    "default": "cascaded-lpv", "volumes": "cascaded-lpv:default,ambient_occlusion=false",
    **{preset: f"cascaded-lpv:{preset}" for preset in CascadedLpvSettings.PRESETS},
}  # fmt: skip
"""What is measured; `volumes` is the default's light without what is done in screen space."""

UNMOVED = "uniform-lpv"
"""Its light does not depend on the viewer: what it changes by is the measurement's own error."""

STEP = 0.1
"""Cells of the finest cascade, from frame to frame."""

VISIBLE = 0.02
"""Light below this share of the mean is not counted."""

# The lights stay, so that coarser maps do not touch the stability; they leave time for the frames.
MAPS = FrameSettings(shadow_resolution=512, sky_lights=8, coarse_resolution=256)
_SLIDE, _TURN = 88, 90  # steps: each cascade but the last, which stays, moves once at least
_FROM, _TOWARDS = (-6.5, 1.7, -0.8), (2.0, 2.6, 0.4)
_DISTANCE = 3.0  # metres: a turn's step moves what is seen so far away by STEP cells
_EVERY = 11  # steps in which no window moves differ little; so many pass from one that is measured to the next


@cache
def atrium() -> Scene:
    return octolux.load("atrium").at(0.0)


@dataclass(frozen=True)
class Path:
    """A viewer's cameras, one for each frame, and the camera at whose pixels the light is read."""

    viewers: tuple[Camera, ...]
    eye: Camera

    def windows(self, settings: Any) -> list[list[Window]]:
        """Of each frame, the finest first."""
        volume = _volume(settings)
        return [place_windows(settings.n, settings.cascades, volume, c.position, c.forward) for c in self.viewers]


def _volume(settings: Any) -> Grid:
    return Grid.around(*atrium().bounds(), settings.n)


def _stride(settings: Any) -> float:
    """Metres."""
    return STEP * _volume(settings).cell_size / 2 ** (settings.cascades - 1)


def slide(settings: Any) -> Path:
    """Forwards through the atrium; the onlooker stands where it begins."""
    towards = np.subtract(_TOWARDS, _FROM) / np.linalg.norm(np.subtract(_TOWARDS, _FROM))
    places = [np.array(_FROM) + k * _stride(settings) * towards for k in range(_SLIDE + 1)]
    viewers = [Camera.look_at(place, place + towards, vertical_fov=1.0, near=0.05) for place in places]
    return Path(tuple(viewers), viewers[0])


def turn(settings: Any) -> Path:
    """About the upright, halfway along the atrium's side; the onlooker sees the middle of the turn."""
    place, step = np.array([-2.8, 2.0, -1.1]), _stride(settings) / _DISTANCE
    viewers = []
    for k in range(_TURN + 1):
        forward = np.array([sin(0.35 + k * step), 0.05, -cos(0.35 + k * step)])
        viewers.append(Camera.look_at(place, place + forward, vertical_fov=1.0, near=0.05))
    return Path(tuple(viewers), replace(viewers[len(viewers) // 2], vertical_fov=1.2))


def measured_steps(windows: Sequence[Sequence[Window]]) -> list[int]:
    """Frames k whose change to k + 1 is measured: all in which a window moves, and every _EVERYth."""
    origins = [[w.origin for w in frame] for frame in windows]
    return [k for k in range(len(origins) - 1) if origins[k] != origins[k + 1] or k % _EVERY == 0]


def shares(points: Points, windows: Sequence[Window], settings: Any) -> np.ndarray:
    """Share of each cascade in the light at each point: (cascades, count)."""
    aside = settings.lookup_offset * points.geometric
    places = [grid.to_cells(points.places) + aside for grid in grids_of(windows, _volume(settings))]
    return weights(places, windows, settings.n)


@dataclass(frozen=True, eq=False)
class Change:
    """From one frame to the next, at the points that are counted. moved: numbers of the windows that moved; across:
    whether more than one cascade is read in one of the two frames, or another one."""

    relative: np.ndarray
    across: np.ndarray
    moved: tuple[int, ...]


def changes(text: str, path_of: Callable[[Any], Path]) -> Iterator[Change]:
    """Relative changes |b - a| / (a + b) * 2 of the measured steps. Points are counted that the viewer sees in both
    frames, and that have more than VISIBLE of their mean light in both."""
    one: Any = choice(text).settings
    settings = one if isinstance(one, CascadedLpvSettings) else CascadedLpvSettings()
    path = path_of(settings)
    windows, onlooker = path.windows(settings), Onlooker(atrium(), text, path.eye, maps=MAPS)
    for k in measured_steps(windows):
        (a, seen_a), (b, seen_b) = (onlooker.light(path.viewers[i]) for i in (k, k + 1))
        seen = seen_a & seen_b
        counted = seen & (np.minimum(a, b) > VISIBLE * a[seen].mean())
        before, after = (shares(onlooker.points, windows[i], settings) for i in (k, k + 1))
        settled = np.minimum(before, after).max(axis=0) == 1.0
        moved = tuple(n for n, w in enumerate(windows[k]) if w.origin != windows[k + 1][n].origin)
        relative = 2.0 * np.abs(b - a) / np.maximum(a + b, 1e-30)
        yield Change(relative[counted], ~settled[counted], moved)


def summary(found: Sequence[Change]) -> dict[str, float]:
    """Within a cascade and across a transition: median and 99th percentile of the step in which it is largest, and
    maximum over all; how many points were counted and how many times windows moved."""
    result = {}
    for name, across in (("within", False), ("across", True)):
        parts = [c.relative[c.across == across] for c in found]
        for word, share in (("p50", 50.0), ("p99", 99.0), ("max", 100.0)):
            result[f"{name}_{word}"] = max(float(np.percentile(p, share)) for p in parts if len(p))
        result[f"{name}_points"] = float(np.median([len(p) for p in parts]))
    result["steps"] = float(len(found))
    result["windows_moved"] = float(sum(len(c.moved) for c in found))
    return result


def _both(path_of: Callable[[Any], Path]) -> dict[str, float]:
    found = {name: summary(list(changes(text, path_of))) for name, text in TEXTS.items()}
    return {f"{name}.{key}": value for name, values in found.items() for key, value in values.items()}


_BOUNDS = {
    f"{name}.{where}_max": at_most(bound)
    for name in ("default", "volumes") for where, bound in (("within", 0.01), ("across", 0.03))
}  # fmt: skip


@figure("clpv_stability_slide", group="clpv", bound=_BOUNDS)
def clpv_stability_slide() -> dict[str, float]:
    """Camera slides through the atrium by a tenth of a cell a frame: relative change of the indirect irradiance at
    points that stay, within a cascade and across a transition (CLPV 4.2)."""
    return _both(slide)


@figure("clpv_stability_turn", group="clpv", bound=_BOUNDS)
def clpv_stability_turn() -> dict[str, float]:
    """Camera turns by a tenth of a cell, 3 m away, a frame."""
    return _both(turn)


@figure("clpv_stability_own", group="clpv", bound={"within_max": at_most(0.0)})
def clpv_stability_own() -> dict[str, float]:
    """The measurement's own error, along the slide: light that does not depend on the viewer. Its bits are the same."""
    found = summary(list(changes(UNMOVED, slide))[:4])
    return {"within_max": max(found["within_max"], found["across_max"])}
