"""`python -m benchmarks.vct_tables [TABLE ...]`: tables 6.4 to 6.13 of VCT (Drinovsky 2013) on this machine.

Its milliseconds are those of another adapter. What can be compared stands in brackets: how many times the scene's first
row, or the share of the total.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from octolux.output.atomic import replacing
from octolux.scene.errors import OctoluxError
from octolux.techniques.settings import suggest

from . import vct_thesis as thesis
from . import written_tables
from .lab import device
from .tables import markdown
from .vct_frames import COPIES, PLACES
from .vct_rows import FRAMES, TABLES, Measured, Row

PAGE = "docs/techniques/voxel-cones-tables.md"
_COPIED = (thesis.INSIDE, thesis.EDGES)


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
    copies = {COPIES: sum(row[part] for part in _COPIED)} if _COPIED[0] in row else {}
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
    parser.add_argument("--page", type=Path, metavar="FILE", help=f"write the tables as a page, such as {PAGE}")
    written_tables.add_options(parser)
    return parser.parse_args(words)


def _checked(arguments: argparse.Namespace) -> None:
    if arguments.frames < 1:
        raise OctoluxError(f"--frames must be at least 1, not {arguments.frames}.")
    for name in arguments.tables:
        if name not in TABLES:
            raise OctoluxError(f"There is no table '{name}'. {suggest(name, TABLES)}")
    written_tables.check(arguments)
    if arguments.page and not arguments.page.resolve().parent.is_dir():
        raise OctoluxError(f"{arguments.page}: there is no folder '{arguments.page.parent}'. Make it first.")


def page(made: Sequence[written_tables.Table], frames: int) -> str:
    """The tables as a page of the documents."""
    head = f"""# voxel-cones: the thesis's tables

Tables of Drinovsky 2013, section 6, by `python -m benchmarks.vct_tables --page {PAGE}`,
which writes this page: medians of {frames} frames on
{device().adapter_name},
in milliseconds where no other unit is said. Below ours are those of the thesis, of its {thesis.ADAPTER} and its model
of such a room; `atrium` is ours alone. Times are those of another adapter: what can be compared stands in brackets, how
many times the scene's first row, or the share of the total.

All but what a table varies is as in the thesis: 512 x 512 pixels, 6 diffuse cones at each and a specular one, 8 levels,
and one lamp that shines all around and moves, every texel of whose six shadow maps of 512 x 512 is injected; a ball
moves, too (`benchmarks/vct_frames.py`).
"""
    return "\n".join([head, *(f"## {title}\n\n{markdown(cells)}\n" for title, cells in made)])


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
    if arguments.page:
        with replacing(arguments.page) as temporary:
            temporary.write_text(page(made, arguments.frames), encoding="utf-8")


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a wrong option, a scene that is not there, or a file that cannot be written."""
    arguments = _arguments(words)
    return written_tables.exit_code(lambda: _work(arguments))


if __name__ == "__main__":
    sys.exit(main())
