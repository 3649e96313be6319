"""`python -m benchmarks.clpv_table1`: CLPV's table 1 on this machine, and what glossy lookups and fog cost apart."""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, replace
from functools import cache

import octolux
from octolux.compare.choices import choice
from octolux.frame.frame import FrameSettings
from octolux.gpu.profiler import Profiler
from octolux.renderer import Renderer
from octolux.scene.environment import Environment
from octolux.scene.lights import DirectionalLight, Light
from octolux.scene.medium import Medium
from octolux.scene.scene import Scene
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings
from octolux.techniques.lpv.cascaded.technique import CascadedLpv

from . import scenes_on_disk, written_tables
from .lab import device
from .olpv_scene import SCENES
from .registry import figure

SIZE, WARM_UP = (1280, 720), 2

# CLPV 6 and table 1: one RSM of 256^2 texels, each a VPL. No light but the sun, so that there is no other RSM.
MAPS = FrameSettings(shadow_resolution=256, rsm_resolution=256, sky_lights=0, emitter_lights=0)

ROWS = {
    "RSM rendering": ("RSM rendering", "RSM surfaces"), "VPL injection": ("injection",),
    "GV injection": ("scene surfels", "geometry volume", "reflectors"),
    "Propagation": ("moments", "bounces", "downsampling", "propagation", "volumes"), "LPV lookup": ("lookup",),
}  # fmt: skip
"""The table's rows, and the stages of a frame that each is made of. Surfaces that have not moved are kept: the scene's
surfels are not in all frames, and GV injection is made anew for the table (`measured`)."""

APART = {"Ambient occlusion": ("ambient occlusion",)}
TOTAL, FRAME = "Total", "Whole frame"

# Kaplanyan & Dachsbacher 2010, table 1, GTX285, milliseconds: without occlusion, with it, with bounces too.
PAPER: dict[str, tuple[float, float, float]] = {
    "RSM rendering": (0.16,) * 3, "VPL injection": (0.05,) * 3, "GV injection": (0.02,) * 3,
    "Propagation": (0.8, 1.1, 1.4), "LPV lookup": (2.4,) * 3, TOTAL: (3.4, 3.7, 4.0),
}  # fmt: skip

_KINDS = {"no occlusion": "occlusion=false,bounces=1", "occlusion": "bounces=1", "bounces": "bounces=2"}
COLUMNS = {
    f"{preset}, {grids} x 32^3, {kind}": f"cascaded-lpv:{preset},cascades={grids},{changes}"
    for preset in ("paper", "default") for grids in (1, 3) for kind, changes in _KINDS.items()
}  # fmt: skip
"""The table's columns, and the technique of each. Bounces of the default are two: one more."""

_FOG = Medium(scattering=(0.03,) * 3)


@cache
def base_scene(name: str) -> Scene:
    """The atrium or Crytek Sponza with its sun alone. Raises NeedsData when the model is not there."""
    scene = octolux.load("atrium") if name == "atrium" else scenes_on_disk.load("crytek_sponza")
    suns: list[Light] = [light for light in scene.lights if isinstance(light, DirectionalLight)]
    return replace(scene.at(0.0), lights=suns, environment=Environment((0.0, 0.0, 0.0)))


def measured(
    scene: Scene, camera: str, techniques: Sequence[str], frames: int, size: tuple[int, int] = SIZE, *,
    anew: bool = True,
) -> dict[str, list[dict[str, float]]]:  # fmt: skip
    """Milliseconds by stage of each frame, and FRAME, by technique; each stage is submitted alone and waited for.
    Frames of all techniques take turns, so that the machine disturbs them alike. anew: what blocks and reflects light
    is made in each frame, as if a window had moved, and not kept; RSMs always are. Raises OctoluxError for an
    unknown technique."""
    renderers: dict[str, Renderer] = {}
    found: dict[str, list[dict[str, float]]] = {text: [] for text in techniques}
    for text in techniques:
        one = choice(text)
        renderers[text] = Renderer(
            scene, one.technique, settings=one.settings, size=size, device=device(), frame_settings=MAPS
        )
        renderers[text].profiler = Profiler(device(), "fenced")
    for number in range(-WARM_UP, frames):
        for text, renderer in renderers.items():
            renderer.profiler.clear()
            if anew and isinstance(renderer.technique, CascadedLpv):
                renderer.technique.way.surfaces.forget()
            renderer.forget()
            renderer.render(camera)
            if number >= 0:
                whole = renderer.profiler.frame_ms()["median"]
                found[text].append({**renderer.profiler.last_frame(), FRAME: whole})
    return found


def medians(frames: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Of the rows, their total and what is apart; rows that a technique has not are left out."""

    def median(stages: Sequence[str]) -> float:
        return statistics.median(sum(frame.get(stage, 0.0) for stage in stages) for frame in frames)

    seen = {stage for frame in frames for stage in frame}
    found = {row: median(stages) for row, stages in (ROWS | APART).items() if seen & set(stages)}
    found[TOTAL] = median([stage for stages in ROWS.values() for stage in stages])
    return found | {FRAME: median([FRAME])}


def rows(found: Mapping[str, Mapping[str, float]]) -> list[tuple[str, ...]]:
    """Cells of the table, titles first: milliseconds of each of our columns, and then the paper's for one grid, a line
    each; the paper's stages are the columns here, which are fewer."""
    stages = (*ROWS, TOTAL, *APART, FRAME)
    printed = {f"CLPV on a GTX285: {kind}": {row: ms[i] for row, ms in PAPER.items()} for i, kind in enumerate(_KINDS)}
    lines: list[tuple[str, ...]] = [("", *stages)]
    for name, times in (*found.items(), *printed.items()):
        lines.append((name, *(f"{times[s]:.2f}" if s in times else "–" for s in stages)))
    return lines


def glossy_cost(scene: str, frames: int, size: tuple[int, int] = SIZE) -> dict[str, float]:
    """Milliseconds that glossy lookups add to a frame, median of frame by frame; empty while no preset has them."""
    if "glossy" not in {f.name for f in fields(CascadedLpvSettings)}:
        return {}
    return _added(lambda preset, on: f"cascaded-lpv:{preset},glossy={str(on).lower()}", scene, frames, size)


def _added(text: Callable[[str, bool], str], scene: str, frames: int, size: tuple[int, int]) -> dict[str, float]:
    found = {}
    for preset in ("paper", "default"):
        words = [text(preset, on) for on in (False, True)]
        without, having = measured(base_scene(scene), SCENES[scene], words, frames, size).values()
        pairs = zip(without, having, strict=True)
        found[preset] = statistics.median(b[FRAME] - a[FRAME] for a, b in pairs)
    return found


def fog_cost(scene: str, frames: int, size: tuple[int, int] = SIZE) -> dict[str, float]:
    """Milliseconds of fog in each frame, half resolution, a step a cell."""
    foggy = replace(base_scene(scene), medium=_FOG)
    words = {preset: f"cascaded-lpv:{preset}" for preset in ("paper", "default")}
    found = measured(foggy, SCENES[scene], list(words.values()), frames, size)
    return {preset: statistics.median(f["fog"] for f in found[text]) for preset, text in words.items()}


def table(scene: str, frames: int, size: tuple[int, int] = SIZE) -> dict[str, dict[str, float]]:
    """Medians by column."""
    times = measured(base_scene(scene), SCENES[scene], list(COLUMNS.values()), frames, size)
    return {column: medians(times[text]) for column, text in COLUMNS.items()}


@figure("clpv_table1", group="clpv", unit="ms")
def clpv_table1() -> dict[str, float]:
    """Table 1 of CLPV in the atrium from a few frames: totals; python -m benchmarks.clpv_table1 has all of it."""
    return {column: times[TOTAL] for column, times in table("atrium", frames=5).items()}


def _work(arguments: argparse.Namespace) -> None:
    written_tables.check(arguments)
    found = table(arguments.scene, arguments.frames)
    costs = {"glossy": glossy_cost, "fog": fog_cost}
    apart = {name: cost(arguments.scene, arguments.frames) for name, cost in costs.items()}
    titles = ("apart", "paper", "default", "CLPV: GTX285")
    lines = [(name, *(f"{ms[p]:.2f}" if p in ms else "–" for p in ("paper", "default")), "18" if name == "fog" else "–")
             for name, ms in apart.items()]  # fmt: skip
    title = f"Table 1 in {arguments.scene}, milliseconds; the geometry volume made anew in each frame, as if all moved"
    made: list[written_tables.Table] = [(title, rows(found))]
    made.append(("What glossy lookups add to a frame, and fog's stage, milliseconds", [titles, *lines]))
    data = {"scene": arguments.scene, "frames": arguments.frames, "size": SIZE, "techniques": COLUMNS,
            "milliseconds": found, "apart": apart, "paper": PAPER}  # fmt: skip
    written_tables.give_out(arguments, made, data)


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a wrong option, a scene that is not there, or a file that cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.clpv_table1", description=__doc__)
    parser.add_argument("--scene", choices=tuple(SCENES), default="atrium")
    parser.add_argument("--frames", type=int, default=25, help="frames of each technique (default 25)")
    written_tables.add_options(parser)
    arguments = parser.parse_args(words)
    if arguments.frames < 1:
        parser.error(f"--frames must be at least 1, not {arguments.frames}")
    return written_tables.exit_code(lambda: _work(arguments), arguments.scene)


if __name__ == "__main__":
    sys.exit(main())
