"""`python -m benchmarks.olpv_table1`: OLPV's table 1 on this machine, or with --sweep how cost and memory grow."""

from __future__ import annotations

import argparse
import statistics
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict

from octolux.scene.errors import OctoluxError

from . import olpv_sweep, written_tables
from .lab import device
from .olpv_parts import CLEAR_TO_MERGE, PARTS, part_of
from .olpv_scene import SCENES, base_scene, lit, renderer
from .part_profiler import PartProfiler, Times
from .registry import at_most, figure

SIZE, WARM_UP = (1280, 720), 2
UNIFORM = "uniform-lpv:thesis"
OCTREES = ("octree-lpv:thesis", "octree-lpv:steps", "octree-lpv")

# Olovsson 2012, table 1: count, octree average and total, uniform average and total, milliseconds on a GTX 480.
THESIS: dict[str, tuple[int, int, int, int | None, int | None]] = {
    "Frame": (500, 106, 53193, 115, 57994), "RSMCreate": (9000, 0, 3053, 0, 2737), "GVClear": (500, 1, 671, 1, 721),
    "GVInject": (1500, 10, 15593, 10, 15703), "GVDownsample": (500, 0, 55, None, None),
    "IXClear": (500, 5, 2923, None, None), "LPVClear": (500, 8, 4461, 8, 4191),
    "LPVInject": (1500, 13, 19929, 15, 22813), "LPVDownsample": (500, 0, 142, None, None),
    "LPVPropagate": (500, 7, 3788, 18, 9403), "LPVMerge": (500, 0, 39, None, None),
}  # fmt: skip
_TOGETHER = "Clear to merge"


def measured(
    scene: str, techniques: Sequence[str], frames: int, size: tuple[int, int] = SIZE
) -> dict[str, dict[str, Times]]:
    """Times of the parts by technique; frames of all take turns, so that the machine disturbs them alike.

    Raises NeedsData when the scene is not there, OctoluxError for an unknown technique.
    """
    profilers = {text: PartProfiler(device(), part_of) for text in techniques}
    renderers = {text: renderer(scene, text, size, profilers[text]) for text in techniques}
    for number in range(-WARM_UP, frames):
        for text, one in renderers.items():
            if number == 0:
                profilers[text].clear()
            one.scene = lit(base_scene(scene), number)
            one.render(SCENES[scene])
    return {text: {**p.times(), _TOGETHER: together(p)} for text, p in profilers.items()}


def together(profiler: PartProfiler) -> Times:
    """All parts from clearing to merge as one."""
    times = profiler.frames_of(CLEAR_TO_MERGE)
    return Times(len(times), statistics.fmean(times), statistics.median(times), sum(times))


def _thesis_together() -> tuple[int, int, int, int | None, int | None]:
    octree, uniform = (sum(THESIS[part][column] or 0 for part in CLEAR_TO_MERGE) for column in (2, 4))
    return 500, round(octree / 500), octree, round(uniform / 500), uniform


def _number(value: float | None, form: str = ".2f") -> str:
    return "–" if value is None else format(value, form)


def rows(octree: Mapping[str, Times], uniform: Mapping[str, Times], thesis: bool) -> list[tuple[str, ...]]:
    """Cells of the table, titles first: ours in milliseconds, then with `thesis` the printed figures.

    Average is of an execution, as in the thesis; median is of a frame, and its ratio what is least disturbed.
    """
    titles = ("part", "count", "average", "median", "total", "difference", "uniform: count", "average", "median",
              "total", "median / median")  # fmt: skip
    printed = ("thesis: count", "average", "total", "difference", "uniform: average", "total")
    lines = [titles + printed if thesis else titles]
    for part in (*PARTS, _TOGETHER):
        a, b = octree.get(part), uniform.get(part)
        if a is None and b is None and not thesis:
            continue
        line = (part, *_ours(a, b))
        lines.append(line + _theirs(_thesis_together() if part == _TOGETHER else THESIS[part]) if thesis else line)
    return lines


def _ours(a: Times | None, b: Times | None) -> tuple[str, ...]:
    difference = (a.total if a else 0.0) - (b.total if b else 0.0)
    ratio = a.median / b.median if a and b else None
    return (*_cells(a)[:3], _cells(a)[3], _number(difference, "+.0f"), *_cells(b), _number(ratio))


def _cells(one: Times | None) -> tuple[str, str, str, str]:
    if one is None:
        return ("–",) * 4
    return str(one.count), _number(one.average), _number(one.median), _number(one.total, ".0f")


def _theirs(found: tuple[int, int, int, int | None, int | None]) -> tuple[str, ...]:
    count, average, total, uniform_average, uniform_total = found
    plain = (_number(v, "d") for v in (uniform_average, uniform_total))
    return str(count), str(average), str(total), _number(total - (uniform_total or 0), "+d"), *plain


def tables(found: Mapping[str, Mapping[str, Times]]) -> list[tuple[str, list[tuple[str, ...]]]]:
    """A title and the cells of each octree beside the uniform volume; the thesis's figures stand beside its preset."""
    uniform = found[UNIFORM]
    return [
        (f"{text} beside {UNIFORM}, milliseconds", rows(found[text], uniform, thesis=text == OCTREES[0]))
        for text in OCTREES
    ]


def _figure(scene: str) -> dict[str, float]:
    found = measured(scene, (OCTREES[0], UNIFORM), frames=9)
    octree, uniform = found[OCTREES[0]], found[UNIFORM]
    ratios = {"clear_to_merge": octree[_TOGETHER].median / uniform[_TOGETHER].median,
              "propagate": octree["LPVPropagate"].median / uniform["LPVPropagate"].median}  # fmt: skip
    parts = {f"{text}.{part.replace(' ', '_')}_ms": t.median for text in found for part, t in found[text].items()}
    return {**ratios, **parts}


@figure("olpv_table1_atrium", group="olpv", unit={"clear_to_merge": "x", "propagate": "x"},
        bound={"clear_to_merge": at_most(0.8)})  # fmt: skip
def olpv_table1_atrium() -> dict[str, float]:
    """Table 1 of OLPV in the atrium from a few frames: medians; python -m benchmarks.olpv_table1 has all of it."""
    return _figure("atrium")


@figure("olpv_table1_crytek", group="olpv", unit={"clear_to_merge": "x", "propagate": "x"},
        bound={"clear_to_merge": at_most(0.8)})  # fmt: skip
def olpv_table1_crytek() -> dict[str, float]:
    """The same in Crytek Sponza."""
    return _figure("crytek")


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.olpv_table1", description=__doc__)
    parser.add_argument("--scene", choices=tuple(SCENES), default="atrium")
    parser.add_argument("--frames", type=int, default=500, help="frames of each technique (default 500)")
    parser.add_argument("--size", default="x".join(map(str, SIZE)), metavar="WxH", help="pixels (default %(default)s)")
    parser.add_argument("--sweep", action="store_true", help="cost and memory by n and by k instead")
    written_tables.add_options(parser)
    return parser.parse_args(words)


def _checked(arguments: argparse.Namespace) -> tuple[int, int]:
    if arguments.frames < 1:
        raise OctoluxError(f"--frames must be at least 1, not {arguments.frames}.")
    written_tables.check(arguments)
    width, _, height = arguments.size.partition("x")
    if not (width.isdigit() and height.isdigit()):
        raise OctoluxError(f"--size is WIDTHxHEIGHT, such as 1280x720, not '{arguments.size}'.")
    return int(width), int(height)


def _table(arguments: argparse.Namespace, size: tuple[int, int]) -> tuple[dict, list[written_tables.Table]]:
    found = measured(arguments.scene, (*OCTREES, UNIFORM), arguments.frames, size)
    data = {text: {part: asdict(t) for part, t in times.items()} for text, times in found.items()}
    thesis = {part: dict(zip(("count", "octree_average", "octree_total", "uniform_average", "uniform_total"), line,
                             strict=True)) for part, line in THESIS.items()}  # fmt: skip
    return {"frames": arguments.frames, "size": size, "techniques": data, "thesis": thesis}, tables(found)


def _sweep(arguments: argparse.Namespace) -> tuple[dict, list[written_tables.Table]]:
    both = {"by n": olpv_sweep.BY_CELLS, "by k": olpv_sweep.BY_STEPS}
    costs = {title: olpv_sweep.swept(arguments.scene, techniques) for title, techniques in both.items()}
    data = {title: [asdict(cost) for cost in found] for title, found in costs.items()}
    return data, [(f"Cost and memory {title}", olpv_sweep.rows(found)) for title, found in costs.items()]


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a wrong option, a scene that is not there, or a file that cannot be written."""
    arguments = _arguments(words)

    def work() -> None:
        size = _checked(arguments)
        data, made = _sweep(arguments) if arguments.sweep else _table(arguments, size)
        written_tables.give_out(arguments, made, {"scene": arguments.scene, **data})

    return written_tables.exit_code(work, arguments.scene)


if __name__ == "__main__":
    sys.exit(main())
