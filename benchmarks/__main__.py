"""`python -m benchmarks [NAME ...]`: measure figures and print them beside their bounds.

`--list` names them; `--json FILE` and `--markdown FILE` write them, too. `python -m benchmarks comparison` has options
of its own and prints a table by views and techniques.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from octolux.scene.errors import OctoluxError

from . import comparison_command, written_tables
from .lab import device
from .registry import Bound, Figure, Row, load_all, select
from .tables import aligned, markdown

_VERDICT = {True: "holds", False: "FAILS", None: "-"}


def _arguments(words: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="NAME", help="figures or groups; all by default")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the rows as JSON too")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the table as Markdown too")
    parser.add_argument("--list", action="store_true", help="name the figures and measure nothing")
    return parser.parse_args(words)


def _bound_text(figure: Figure) -> str:
    bounds = [figure.bounds] if isinstance(figure.bounds, Bound) else figure.bounds.values()
    return ", ".join(dict.fromkeys(b.text for b in bounds if b.text)) or "-"


def listing(figures: Sequence[Figure]) -> str:
    """Names, groups, bounds and what is measured."""
    lines = [(f.name, f.group, _bound_text(f), f.summary) for f in figures]
    return aligned([("figure", "group", "bound", "what"), *lines])


def table(rows: Sequence[Row]) -> str:
    """The rows as text: name, value, unit, bound, holds."""
    return aligned(_cells(rows))


def _cells(rows: Sequence[Row]) -> list[tuple[str, ...]]:
    lines = [(r.name, _value(r), r.unit, r.bound or "-", _VERDICT[r.holds]) for r in rows]
    return [("figure", "value", "unit", "bound", "holds"), *lines]


def _value(row: Row) -> str:
    return row.problem if row.value is None else f"{row.value:.4g}"


def write_json(rows: Sequence[Row], adapter: str, path: Path) -> None:
    """{"adapter": ..., "figures": [{name, group, value, unit, bound, holds, problem}]}."""
    data = {"adapter": adapter, "figures": [asdict(row) for row in rows]}
    path.write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def measure(figures: Sequence[Figure]) -> list[Row]:
    """The rows of all figures, naming each on stderr while it is measured."""
    rows: list[Row] = []
    for number, figure in enumerate(figures, 1):
        print(f"[{number}/{len(figures)}] {figure.name}", file=sys.stderr, flush=True)
        rows += figure.rows()
    return rows


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, 1 when a bound does not hold, 2 when something asked for does not exist or cannot be written."""
    given = sys.argv[1:] if words is None else list(words)
    if given[:1] == ["comparison"]:
        return comparison_command.main(given[1:])
    arguments = _arguments(given)
    load_all()
    try:
        figures = select(arguments.names)
        if arguments.list:
            print(listing(figures))
            return 0
        written_tables.check(arguments)
        adapter = device().adapter_name
    except OctoluxError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    rows = measure(figures)
    print(f"adapter: {adapter}\n\n{table(rows)}")
    if arguments.json:
        write_json(rows, adapter, arguments.json)
    if arguments.markdown:
        arguments.markdown.write_text(markdown(_cells(rows)) + "\n", encoding="utf-8")
    failed = [row.name for row in rows if row.holds is False]
    print(f"\n{len(failed)} bounds do not hold: {', '.join(failed)}" if failed else "\nall bounds hold")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
