"""`python -m benchmarks.vct_tables [TABLE ...]`: tables 6.4 to 6.13 of VCT (Drinovsky 2013) on this machine.

Its milliseconds are those of another adapter. What can be compared stands in brackets: how many times the scene's first
row, or the share of the total.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

from octolux.scene.errors import OctoluxError
from octolux.techniques.settings import suggest

from . import vct_thesis as thesis
from . import written_tables
from .registry import figure
from .vct_frames import COPIES, DEPTH, OCTREE, PLACES, Built, Case, built, frames_of

FRAMES = 3
DEPTHS, MEMORY_DEPTHS = (6, 7, 8), (7, 8, 9)
_FEW = 64
"""Texels, or pixels, of what a table is not about."""

_COPIED = (thesis.INSIDE, thesis.EDGES)
BUILDING = (thesis.FRAGMENTS, thesis.BUILD)
FILLING = (thesis.RESET, thesis.LEAVES, thesis.CHILDREN, COPIES)
INJECTION = (thesis.RENDER, thesis.TRAVERSE, thesis.INSERT, thesis.LIST, thesis.CHILDREN, COPIES)
HELD, BRICKS = "rest, MB", "bricks"

Row = dict[str, float]
Measured = dict[str, dict[str, Row]]
"""As vct_thesis.Rows; by our names of scenes."""


@cache
def _built(scene: str, count: int) -> list[Built]:
    return built(scene, [(thesis.AXIAL, depth) for depth in DEPTHS], count)


@cache
def _by_depth(scene: str, count: int) -> list[Row]:
    return frames_of(scene, [Case(f"depth={depth}") for depth in DEPTHS], count)


def _sum(parts: Mapping[str, float], names: Sequence[str]) -> float:
    return sum(parts.get(name, 0.0) for name in names)


def _octree(parts: Row) -> Row:
    """Of building one: the parts that are so, and their total."""
    found = {part: parts[OCTREE + part] for part in (*BUILDING, *FILLING)}
    return {**found, thesis.TOTAL: sum(found.values())}


def _steps(frame: Row, static: Built) -> Row:
    """The columns of tables 6.4, 6.5 and 6.9. The total is that of a frame, in which only what moves is built."""
    once, moving = _octree(static.parts), _octree(frame)
    found = {
        thesis.MOVING_BUILD: _sum(moving, BUILDING), thesis.MOVING_FILL: _sum(moving, FILLING),
        thesis.INJECT: _sum(frame, INJECTION), thesis.DIFFUSE: frame[thesis.DIFFUSE],
        thesis.SPECULAR: frame[thesis.SPECULAR],
    }  # fmt: skip
    return {
        thesis.BUILD: _sum(once, BUILDING), thesis.FILL: _sum(once, FILLING), **found,
        thesis.TOTAL: sum(found.values()),
    }  # fmt: skip


def depth(scene: str, count: int) -> dict[str, Row]:
    """Table 6.9."""
    pairs = zip(DEPTHS, _by_depth(scene, count), _built(scene, count), strict=True)
    return {str(levels): _steps(frame, octree) for levels, frame, octree in pairs}


def steps(scene: str, count: int) -> dict[str, Row]:
    """Table 6.4."""
    return {"8": depth(scene, count)["8"]}


def representations(scene: str, count: int) -> dict[str, Row]:
    """Table 6.5."""
    kinds = (thesis.AXIAL, thesis.LOBES)
    frames = frames_of(scene, [Case(f"representation={kind}") for kind in kinds], count)
    octrees = built(scene, [(kind, DEPTH) for kind in kinds], count)
    return {kind: _steps(*pair) for kind, *pair in zip(kinds, frames, octrees, strict=True)}


def memory(scene: str, count: int) -> dict[str, Row]:
    """Table 6.6: of the texture that holds the bricks, and all else of the octree."""
    kinds = [(kind, depth) for kind in (thesis.AXIAL, thesis.LOBES) for depth in MEMORY_DEPTHS]
    octrees = zip(kinds, built(scene, kinds, 1), strict=True)
    return {
        f"{kind} {depth}": {"MB": one.megabytes, HELD: one.other_megabytes, BRICKS: one.bricks}
        for (kind, depth), one in octrees
    }


def resolution(scene: str, count: int) -> dict[str, Row]:
    """Table 6.7."""
    cases = [Case(size=size, shadows=_FEW) for size in thesis.SIZES]
    names = [f"{w}x{h}" for w, h in thesis.SIZES]
    return _columns(names, frames_of(scene, cases, count), (thesis.DIFFUSE, thesis.SPECULAR))


def shadow_maps(scene: str, count: int) -> dict[str, Row]:
    """Table 6.8, but of one shadow map, as the texels of six that are so large are more VPLs than there can be."""
    cases = [Case(size=(_FEW, _FEW), shadows=texels, faces=1) for texels in thesis.SHADOWS]
    names = [str(texels) for texels in thesis.SHADOWS]
    return _columns(names, frames_of(scene, cases, count), (thesis.RENDER, thesis.TRAVERSE))


def cones(scene: str, count: int) -> dict[str, Row]:
    """Table 6.10."""
    cases = [Case(f"cones={number}", shadows=_FEW) for number in thesis.CONES]
    return _columns([str(n) for n in thesis.CONES], frames_of(scene, cases, count), (thesis.DIFFUSE,))


def static(scene: str, count: int) -> dict[str, Row]:
    """Table 6.11."""
    octrees = zip(DEPTHS, _built(scene, count), strict=True)
    return {str(levels): {**_octree(one.parts), thesis.NODES: one.nodes} for levels, one in octrees}


def moving(scene: str, count: int) -> dict[str, Row]:
    """Table 6.12. Here no update list is made: all bricks of what moves are made anew."""
    return {str(levels): _octree(frame) for levels, frame in zip(DEPTHS, _by_depth(scene, count), strict=True)}


def injection(scene: str, count: int) -> dict[str, Row]:
    """Table 6.13."""
    frames = [{**frame, thesis.TOTAL: _sum(frame, INJECTION)} for frame in _by_depth(scene, count)]
    return _columns([str(levels) for levels in DEPTHS], frames, (*INJECTION, thesis.TOTAL))


def _columns(keys: Sequence[str], frames: Sequence[Row], columns: Sequence[str]) -> dict[str, Row]:
    return {key: {c: frame[c] for c in columns if c in frame} for key, frame in zip(keys, frames, strict=True)}


Measure = Callable[[str, int], dict[str, Row]]
TABLES: dict[str, tuple[str, str, Measure, thesis.Rows]] = {
    "6.4": ("Steps of a frame, and their share of it", "depth", steps, thesis.BY_DEPTH),
    "6.5": ("Steps of a frame by what voxels keep of light", "light", representations, thesis.BY_REPRESENTATION),
    "6.6": ("Memory of bricks", "light, depth", memory, thesis.MEMORY),
    "6.7": ("Cones by the picture's pixels", "pixels", resolution, thesis.BY_SIZE),
    "6.8": ("One shadow map by its texels, all injected; six in VCT", "texels", shadow_maps, thesis.BY_SHADOWS),
    "6.9": ("Steps of a frame by depth", "depth", depth, thesis.BY_DEPTH),
    "6.10": ("Diffuse cones by their number", "cones", cones, thesis.BY_CONES),
    "6.11": ("Voxelisation of what is static", "depth", static, thesis.STATIC_PARTS),
    "6.12": ("Voxelisation of what moves", "depth", moving, thesis.MOVING_PARTS),
    "6.13": ("Injection of light", "depth", injection, thesis.INJECTION_PARTS),
}  # fmt: skip
"""Title, what rows vary, ours, the thesis's."""


@figure("vct_table_6_9", group="vct", unit="ms")
def vct_table_6_9() -> dict[str, float]:
    """Table 6.9 of VCT in the Cornell box from a few frames; python -m benchmarks.vct_tables has all tables."""
    found = depth("cornell-box", FRAMES)
    return {f"{key}.{column.replace(' ', '_')}": ms for key, row in found.items() for column, ms in row.items()}


def lines(found: Measured, printed: thesis.Rows, varied: str, shares: bool = False) -> list[tuple[str, ...]]:
    """Cells of a table, titles first: each row of ours above the thesis's. In brackets how many times the first row of
    the scene it is, or with `shares` its share of the total."""
    columns = list(next(iter(next(iter(found.values())).values())))
    made: list[tuple[str, ...]] = [("scene", varied, "", *columns)]
    for scene, rows in found.items():
        theirs = printed.get(PLACES[scene].thesis, {})
        first = next(iter(rows))
        for key, row in rows.items():
            names = (scene if key == first else "", key, "ours")
            made.append((*names, *_cells(row, None if key == first else rows[first], columns, shares)))
            if key in theirs:
                base = None if key == first else _merged(theirs[first])
                made.append(("", "", thesis.ADAPTER, *_cells(_merged(theirs[key]), base, columns, shares)))
    return made


def _merged(row: Mapping[str, float]) -> dict[str, float]:
    """The thesis's row, with copies inside bricks and between them as one."""
    copies = {COPIES: _sum(row, _COPIED)} if _COPIED[0] in row else {}
    return {**row, **copies}


def _cells(row: Row, first: Row | None, columns: Sequence[str], shares: bool) -> list[str]:
    return [_cell(row, first, column, shares) if column in row else "–" for column in columns]


def _cell(row: Row, first: Row | None, column: str, shares: bool) -> str:
    value = row[column]
    text = f"{value:,.0f}" if value >= 1000.0 else f"{value:.1f}" if value >= 10.0 else f"{value:.2f}"
    if shares:
        return f"{text} ({value / row[thesis.TOTAL]:.0%})"
    if not first or not first.get(column):
        return text
    times = value / first[column]
    return f"{text} (×{times:{'.0f' if times >= 10.0 else '.2g'}})"


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.vct_tables", description=__doc__)
    parser.add_argument("tables", nargs="*", metavar="TABLE", help=f"of {', '.join(TABLES)}; all by default")
    parser.add_argument("--scene", action="append", choices=tuple(PLACES), help="repeat for more; all by default")
    parser.add_argument("--frames", type=int, default=FRAMES, help="that are timed of each row (default %(default)s)")
    written_tables.add_options(parser)
    return parser.parse_args(words)


def _checked(arguments: argparse.Namespace) -> None:
    if arguments.frames < 1:
        raise OctoluxError(f"--frames must be at least 1, not {arguments.frames}.")
    for name in arguments.tables:
        if name not in TABLES:
            raise OctoluxError(f"There is no table '{name}'. {suggest(name, TABLES)}")
    written_tables.check(arguments)


def _work(arguments: argparse.Namespace) -> None:
    _checked(arguments)
    scenes, made, data = arguments.scene or list(PLACES), [], {}
    for name in arguments.tables or TABLES:
        title, varied, measure, printed = TABLES[name]
        found: dict[str, Any] = {}
        for scene in scenes:
            print(f"table {name}: {scene}", file=sys.stderr, flush=True)
            found[scene] = measure(scene, arguments.frames)
        cells = lines(found, printed, varied, shares=name == "6.4")
        made.append((f"Table {name}. {title}", cells))
        data[name] = {"ours": found, "thesis": {s: printed.get(PLACES[s].thesis, {}) for s in scenes}}
    written_tables.give_out(arguments, made, {"frames": arguments.frames, "tables": data})


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a wrong option, a scene that is not there, or a file that cannot be written."""
    arguments = _arguments(words)
    return written_tables.exit_code(lambda: _work(arguments))


if __name__ == "__main__":
    sys.exit(main())
