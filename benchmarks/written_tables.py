"""What commands that print tables of their own share: --json, --markdown and their exit code."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from octolux.output.atomic import replacing
from octolux.scene.errors import OctoluxError

from .lab import device
from .registry import NeedsData
from .tables import aligned, markdown

Table = tuple[str, Sequence[Sequence[str]]]
"""A title, and rows of cells, the first of which are the columns' titles."""


def exit_code(work: Callable[[], None], scene: str = "the scene") -> int:
    """Do the work of a command: 0, or 2 with one line for a mistake or for data that is not there."""
    try:
        work()
    except NeedsData as missing:
        print(f"error: {scene} needs OCTOLUX_DATA ({missing})", file=sys.stderr)
        return 2
    except OctoluxError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


def add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures as JSON too")
    parser.add_argument("--markdown", type=Path, metavar="FILE", help="write the tables as Markdown too")


def check(arguments: argparse.Namespace) -> None:
    """Before anything is measured. Raises OctoluxError for a folder that is not there."""
    for path in filter(None, (arguments.json, arguments.markdown)):
        if not path.resolve().parent.is_dir():
            raise OctoluxError(f"{path}: there is no folder '{path.parent}'. Make it first.")


def give_out(arguments: argparse.Namespace, tables: Sequence[Table], data: Mapping[str, Any]) -> None:
    """Print the tables, and write what is asked for."""
    adapter = device().adapter_name
    print(f"adapter: {adapter}")
    for title, lines in tables:
        print(f"\n{title}\n\n{aligned(lines)}")
    text = "\n\n".join(f"{title}\n\n{markdown(lines)}" for title, lines in tables)
    _write(arguments.json, json.dumps({"adapter": adapter, **data}, indent=1))
    _write(arguments.markdown, text)


def _write(path: Path | None, text: str) -> None:
    if path:
        with replacing(path) as temporary:
            temporary.write_text(text + "\n", encoding="utf-8")
