"""What CLPV's propagation costs, on light and surfaces of the atrium: occlusion, bounces, cascades; and small cells."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from itertools import product
from typing import Any

import numpy as np

import octolux
from octolux.compare.choices import choice
from octolux.frame.frame import Frame, FrameSettings
from octolux.renderer import Renderer
from octolux.scene.scene import Scene
from octolux.simulator.grid import Grid
from octolux.simulator.lpv.geometry import BEHIND
from octolux.techniques.lpv.constants import GRID, pack_grid
from octolux.techniques.lpv.geometry import GeometryVolume
from octolux.techniques.lpv.injection import Injection
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.propagation import CELL_BYTES, Propagation
from octolux.techniques.lpv.reflectors import Reflectors
from octolux.techniques.lpv.uniform.settings import UniformLpvSettings
from octolux.techniques.lpv.uniform.technique import UniformLpv
from octolux.techniques.lpv.volume import injected_sources, scene_grid

from .lab import device, interleaved, read_buffer, submitted
from .olpv_scene import MAPS, SCENES, base_scene, lit
from .registry import at_least, at_most, figure

N, ITERATIONS = 32, 8
NESTED = (0.25, 0.5, 1.0)
PAIRS = 31
_AT_ONCE = 4  # runs in a submission, as what it costs to submit belongs to the frame


class _Seen(UniformLpv):
    """Keeps the frame it saw, whose RSMs have the traits of their surfaces."""

    needs = UniformLpv.needs | {"surfaces"}
    frame: Frame

    def update(self, frame: Frame) -> None:
        self.frame = frame
        super().update(frame)


@cache
def _seen() -> _Seen:
    made = Renderer(lit(base_scene("atrium"), 0), "none", size=(256, 144), device=device(), frame_settings=MAPS)
    technique = _Seen(device(), UniformLpvSettings())
    made.technique = technique
    made.render(SCENES["atrium"])
    return technique


@dataclass(frozen=True, eq=False)
class Volumes:
    """Injected light, and the geometry volume half a cell aside with what it reflects, of several grids."""

    sizes: list[int]
    light: dict[str, Any]  # injected, peak
    blockers: dict[str, Any]  # shares, reflectors


def _filled(grid: Grid) -> list[np.ndarray]:
    """Injected light, shares and reflectors of one grid, flat."""
    frame, aside = _seen().frame, np.array(grid.origin) + 0.5 * grid.cell_size
    own, shifted = (device().uniform("LPV grid", GRID.array(1)) for _ in range(2))
    device().write(own, pack_grid(grid))
    device().write(shifted, pack_grid(Grid(tuple(aside), grid.cell_size, grid.n)))
    injection, levels = Injection(device(), grid.n), Levels([grid.n])
    geometry, reflectors = GeometryVolume(device(), levels, planes=False), Reflectors(device(), levels, -BEHIND)
    with submitted() as stage:
        injection.run(stage, own, frame.vpls, injected_sources(frame, grid, "flux"))
        geometry.run(stage, frame, shifted)
        reflectors.run(stage, frame, shifted)
    return [read_buffer(x) for x in (injection.injected, geometry.shares, reflectors.reflectors)]


@cache
def volumes(*scales: float, n: int = N) -> Volumes:
    """Of grids around the middle of the scene that are so many times as large as its box."""
    whole, parts = scene_grid(_seen().frame, n), []
    middle = np.array(whole.origin) + 0.5 * n * whole.cell_size
    for scale in scales:
        size = scale * whole.cell_size
        parts.append(_filled(Grid(tuple(middle - 0.5 * n * size), size, n)))
    injected, shares, reflectors = (np.concatenate(part) for part in zip(*parts, strict=True))
    peak = np.array([injected.reshape(-1, 4)[:, 0].max()], np.float32)
    light = {"injected": device().buffer("light", injected), "peak": device().buffer("peak", peak)}
    blockers = {"shares": device().buffer("shares", shares), "reflectors": device().buffer("reflectors", reflectors)}
    return Volumes([n] * len(scales), light, blockers)


def work(
    made_of: Volumes, preset: str = "default", iterations: int = ITERATIONS, bounces: str = ""
) -> Callable[[], None]:
    """Propagation of injected light, with what it makes of the geometry volume first. bounces: "" is no occlusion."""
    s = UniformLpvSettings.from_strings(preset)
    made = Propagation(
        device(), made_of.sizes, evaluation=s.evaluation, reprojection=s.reprojection, gain=s.gain,
        cell_format=s.cell_format, occlusion=bool(bounces), bounces=bounces or "none",
    )  # fmt: skip
    blockers = made_of.blockers if bounces else {}

    def run() -> None:
        with submitted() as stage:
            for _ in range(_AT_ONCE):
                made.run(stage, **made_of.light, iterations=iterations, **blockers)

    return run


def _ratio(first: Callable[[], None], second: Callable[[], None], pairs: int = PAIRS) -> dict[str, float]:
    found = interleaved(first, second, pairs)
    return {"ratio": found["ratio"], **{k: found[k] / _AT_ONCE for k in ("first", "second")}}


_COSTS = {
    f"{name}{which}": at_most(bound)
    for name, bound in (("occlusion", 1.40), ("bounces", 1.30)) for which in ("", "_paper")
}  # fmt: skip
_COST_UNITS = dict.fromkeys([*_COSTS, "spectral", "spectral_paper"], "x") | {"plain_ms": "ms", "plain_paper_ms": "ms"}


@figure("clpv_propagation", group="clpv", unit=_COST_UNITS, bound=_COSTS)
def clpv_propagation() -> dict[str, float]:
    """8 steps at 32^3: with occlusion over without (CLPV table 1: 1.38), with bounces over with occlusion (1.27);
    spectral ones too. Scheme and cells of the default and of `paper`."""
    found = {}
    for preset, end in (("default", ""), ("paper", "_paper")):
        kinds = ("", "none", "mono", "spectral")
        plain, occluded, mono, spectral = (work(volumes(1.0), preset, bounces=kind) for kind in kinds)
        first = _ratio(occluded, plain)
        found[f"occlusion{end}"] = first["ratio"]
        found[f"bounces{end}"] = _ratio(mono, occluded)["ratio"]
        found[f"spectral{end}"] = _ratio(spectral, occluded)["ratio"]
        found[f"plain{end}_ms"] = first["second"]
    return found


_CASCADES = {
    f"{name}{which}": at_most(bound) for name, bound in (("three", 3.2), ("large", 0.5)) for which in ("", "_blocked")
}


@figure("clpv_cascades", group="clpv", unit="x", bound=_CASCADES)
def clpv_cascades() -> dict[str, float]:
    """Three cascades of 32^3, 8 steps, over one, and (large) over one of 64^3 with 16 steps; cells of `paper`, also
    with occlusion and bounces (blocked). f32: three over one with the default's cells, which a cache may not hold."""
    found = {}

    def three_over_one(preset: str, bounces: str) -> float:
        three, one = (work(volumes(*scales), preset, bounces=bounces) for scales in (NESTED, (1.0,)))
        return _ratio(three, one)["ratio"]

    for end, bounces in (("", ""), ("_blocked", "mono")):
        found[f"three{end}"] = three_over_one("paper", bounces)
        large = work(volumes(1.0, n=64), "paper", 2 * ITERATIONS, bounces)
        found[f"large{end}"] = _ratio(work(volumes(*NESTED), "paper", bounces=bounces), large, pairs=5)["ratio"]
    return found | {"three_f32": three_over_one("default", "")}


def _irradiance(scene: Scene, camera: Any, maps: FrameSettings, text: str) -> np.ndarray:
    made = Renderer(scene, "none", size=(160, 90), device=device(), frame_settings=maps)
    made.technique = UniformLpv(device(), choice(text).settings)
    return made.render(camera).layers["irradiance"].astype(np.float64)


_FORMATS = {
    f"snorm8_{preset}_{scene}_{steps}": at_most(0.03)
    for preset in ("default", "paper") for scene in ("atrium", "cornell") for steps in (ITERATIONS, 2 * ITERATIONS)
}  # fmt: skip


@figure(
    "clpv_cell_format", group="clpv", unit={"f16_bytes": "B", "snorm8_bytes": "B"},
    bound={**_FORMATS, "memory": at_least(2.0)},
)  # fmt: skip
def clpv_cell_format() -> dict[str, float]:
    """Bytes a cell and error of small cells: relative RMSE of the irradiance seen against cells of f32, after 8 and 16
    steps of the default's and of paper's scheme; memory: f16 over snorm8."""
    cornell = octolux.load("cornell-box")
    views = {"atrium": (lit(base_scene("atrium"), 0), SCENES["atrium"], MAPS), "cornell": (cornell, 0, FrameSettings())}
    found = {f"{kind}_bytes": float(CELL_BYTES[kind]) for kind in ("f16", "snorm8")}
    found["memory"] = found["f16_bytes"] / found["snorm8_bytes"]
    for preset, (name, view), steps in product(("default", "paper"), views.items(), (ITERATIONS, 2 * ITERATIONS)):
        text = f"uniform-lpv:{preset},iterations={steps},cell_format="
        exact = _irradiance(*view, f"{text}f32")
        for kind in ("f16", "snorm8"):
            error = _irradiance(*view, f"{text}{kind}") - exact
            found[f"{kind}_{preset}_{name}_{steps}"] = float(np.sqrt(np.mean(error**2)) / exact.mean())
    return found
