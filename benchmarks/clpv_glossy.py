"""Glossy reflections of cascaded-lpv: their cost, and their error on the corridor's polished floor."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import numpy as np

import octolux
from octolux.compare.metrics import relative_errors
from octolux.frame.frame import Frame
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.techniques.lpv.cascaded.gathering import CascadedGathering
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings
from octolux.techniques.lpv.cascaded.stepping import CascadedStepping
from octolux.techniques.lpv.cascaded.technique import CascadedLpv
from octolux.techniques.lpv.glossy.glossy import Glossy, PaperGlossy

from .lab import device, milliseconds, submitted
from .registry import aim, at_least, figure

SIZE, SMALL = (640, 360), (160, 90)
"""Pixels of what is timed, and of what is compared."""
VIEWS = {"corridor": "lit", "atrium": "hall"}
KINDS: dict[str, dict[str, Any]] = {
    "": {}, "half": {"resolution": 2}, "unblocked": {"occlusion": False}, "fine": {"step": 0.5},
}  # fmt: skip
ROUNDS, PATHS, BLOCK = 9, 64, 5
"""Paths through each pixel in each of two halves; pixels along each side of the blocks that are compared."""


class _Watched(CascadedLpv):
    """Keeps its frame, with all that passes read."""

    frame: Frame

    def shade(self, frame: Frame) -> None:
        self.frame = frame
        super().shade(frame)


def rendered(name: str, size: tuple[int, int], preset: str = "default") -> tuple[Picture, _Watched]:
    made = Renderer(octolux.load(name), "none", size=size, device=device())
    made.technique = technique = _Watched(device(), CascadedLpvSettings.make(preset))
    return made.render(VIEWS[name]), technique


def run(made: Glossy, of: _Watched) -> None:
    """Volumes and rays, of the light of the last frame."""
    way, cascades = of.way, of.cascades
    assert isinstance(way, CascadedGathering) and way.reflectors and way.geometry
    injection, windows = way.injection, cascades.windows_buffer
    made.prepare(of.frame)
    with submitted() as stage:
        made.update(stage, injection.injected, injection.peak, way.reflectors.reflectors, windows)
        made.run(stage, of.frame, cascades.grids_buffer, injection.peak, way.geometry.packed, windows)


def run_paper(made: PaperGlossy, of: _Watched) -> None:
    way, cascades = of.way, of.cascades
    assert isinstance(way, CascadedStepping)
    made.prepare(of.frame)
    with submitted() as stage:
        made.run(
            stage, of.frame, cascades.grids_buffer, way.injection.peak, way.lookup.volumes, cascades.windows_buffer
        )


@figure("clpv_glossy_cost", group="clpv", unit="ms")
def clpv_glossy_cost() -> dict[str, float]:
    """Volumes and rays at 640 x 360 on the corridor and the atrium; with a ray for 2 x 2 pixels (half), without planes
    (unblocked), in half steps (fine), and the paper's 4 cells; medians of interleaved rounds."""
    found = {}
    for name in VIEWS:
        _, default = rendered(name, SIZE)
        _, paper = rendered(name, SIZE, "paper")
        works: dict[str, Callable[[], None]] = {
            kind: partial(run, Glossy(device(), default.way.levels, **options), default)
            for kind, options in KINDS.items()
        }
        works["paper"] = partial(run_paper, PaperGlossy(device(), paper.way.levels), paper)
        times: dict[str, list[float]] = {kind: [] for kind in works}
        for _ in range(ROUNDS + 2):
            for kind, work in works.items():
                times[kind].append(milliseconds(work))
        for kind, each in times.items():
            found[f"{name}_{kind}" if kind else name] = statistics.median(each[2:])
    return found


@cache
def reference() -> tuple[np.ndarray, np.ndarray]:
    """Two independent halves of the corridor's indirect light by path tracing, less that of materials' diffuse part:
    what is reflected glossily, and what more light that makes elsewhere, which is little on a floor."""
    halves = []
    for seed in range(2):
        light = []
        for materials in ("all", "diffuse"):
            settings = {"samples": PATHS, "pixel": "centre", "paths": "indirect", "materials": materials, "seed": seed}
            made = Renderer(octolux.load("corridor"), "path-tracer", size=SMALL, device=device(), settings=settings)
            light.append(made.render(VIEWS["corridor"]).radiance.astype(np.float64))
        halves.append(light[0] - light[1])
    return halves[0], halves[1]


def floor_blocks(picture: Picture) -> np.ndarray:
    """bool: blocks of pixels that show nothing but the floor."""
    names = {number for number, name in picture.object_names.items() if name == "floor"}
    return blocks(np.isin(picture.layers["object_id"], list(names))[..., None].astype(float))[..., 0] == 1.0


def blocks(layer: np.ndarray) -> np.ndarray:
    """Means over blocks of BLOCK^2 pixels: (height, width, channels)."""
    height, width = (side // BLOCK for side in layer.shape[:2])
    cut = layer[: height * BLOCK, : width * BLOCK]
    return cut.reshape(height, BLOCK, width, BLOCK, -1).mean(axis=(1, 3))


@figure(
    "clpv_glossy_error", group="clpv", unit="",
    bound={"ratio": aim("0.8 to 1.25"), "better": at_least(2.0)},
)  # fmt: skip
def clpv_glossy_error() -> dict[str, float]:
    """The corridor's floor beside the path tracer: mean over its mean, and relative RMSE of 5 x 5 pixels; without
    reflections (black), with the paper's, and how often the error without is that with them (better)."""
    picture, technique = rendered("corridor", SMALL)
    _, paper = rendered("corridor", SMALL, "paper")
    made, by_letter = Glossy(device(), technique.way.levels), PaperGlossy(device(), paper.way.levels)
    run(made, technique)
    run_paper(by_letter, paper)
    layers = {"": read(made), "paper_": read(by_letter), "black_": np.zeros((*SMALL[::-1], 3))}
    first, second = (blocks(half) for half in reference())
    found: dict[str, float] = {}
    for kind, layer in layers.items():
        errors = relative_errors(blocks(layer), first, second, floor_blocks(picture), 0.5 * (first + second))
        found |= {f"{kind}ratio": errors["ratio"] or 0.0, f"{kind}error": errors["rmse"] or 0.0}
    return {**found, "better": found["black_error"] / max(found["error"], 1e-6)}


def read(made: Glossy | PaperGlossy) -> np.ndarray:
    return device().read_texture(made.specular, np.float32, 4)[..., :3].astype(np.float64)
