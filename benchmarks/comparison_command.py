"""`python -m benchmarks comparison [VIEW ...] [--technique T ...]`: the comparison set as one table."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path

from octolux.compare.choices import choices
from octolux.compare.report import figure
from octolux.output.atomic import replacing
from octolux.scene.errors import OctoluxError

from .comparison import Score, scores
from .comparison_set import LIGHTS, TECHNIQUES, View, views
from .lab import device
from .registry import NeedsData
from .tables import aligned, markdown

TITLES = ("view", "technique", "ratio", "rel. RMSE", "trimmed", "of all bounces", "leak")


def _arguments(words: Sequence[str]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks comparison", formatter_class=argparse.RawDescriptionHelpFormatter,
        description="Diffuse indirect light against the path-traced first bounce, or all bounces: ratio of the means,\n"
        "relative RMSE, the same without the worst 3 % of pixels; the mean over that of all bounces; the share of\n"
        "dark pixels that are lit. docs/compare.md tells more.",
    )  # fmt: skip
    parser.add_argument("names", nargs="*", metavar="VIEW", help="views of the set; all by default")
    parser.add_argument(
        "--technique", action="append", metavar="NAME[:PRESET][,KEY=VALUE...]",
        help=f"repeat for more; by default {', '.join(TECHNIQUES)}. constant and black are always measured",
    )  # fmt: skip
    parser.add_argument(
        "--light", choices=LIGHTS, default=LIGHTS[0], help="what of the references it is measured against: %(default)s"
    )
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures as JSON too")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the table as Markdown too")
    return parser.parse_args(words)


def rows(found: Sequence[Score]) -> list[tuple[str, ...]]:
    """The table's cells, titles first; each view is named once."""
    lines = [TITLES]
    for number, one in enumerate(found):
        new = number == 0 or found[number - 1].view != one.view
        values = (one.ratio, one.rmse, one.trimmed, one.energy, one.leak)
        lines.append((one.view if new else "", one.technique, *map(figure, values)))
    return lines


def measure(wanted: Sequence[View], techniques: Sequence[str], light: str = LIGHTS[0]) -> list[Score]:
    """The scores of all views whose data is there; the others are named on stderr."""
    found: list[Score] = []
    for number, view in enumerate(wanted, 1):
        print(f"[{number}/{len(wanted)}] {view.name}", file=sys.stderr, flush=True)
        try:
            found += scores(view, techniques, light)
        except NeedsData as missing:
            print(f"{view.name}: left out, needs OCTOLUX_DATA ({missing})", file=sys.stderr)
    return found


def _write(path: Path | None, text: str) -> None:
    if path:
        with replacing(path) as temporary:
            temporary.write_text(text, encoding="utf-8")


def main(words: Sequence[str]) -> int:
    """Exit code 0, or 2 for an unknown view, technique or setting, or a file that cannot be written."""
    arguments = _arguments(words)
    try:
        wanted, techniques = views(arguments.names), arguments.technique or list(TECHNIQUES)
        choices(techniques)
        for path in filter(None, (arguments.json, arguments.markdown)):
            if not path.resolve().parent.is_dir():
                raise OctoluxError(f"{path}: there is no folder '{path.parent}'. Make it first.")
        adapter, found = device().adapter_name, measure(wanted, techniques, arguments.light)
        lines = rows(found)
        print(f"adapter: {adapter}\n\n{aligned(lines)}")
        data = {"adapter": adapter, "scores": [asdict(one) for one in found]}
        _write(arguments.json, json.dumps(data, indent=1, ensure_ascii=False) + "\n")
        _write(arguments.markdown, markdown(lines) + "\n")
    except OctoluxError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0
