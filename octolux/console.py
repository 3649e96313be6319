"""What the program prints: tables, notes, and how far a sequence is."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import typer.core
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from .scene.errors import one_line

out = Console(highlight=False, emoji=False)
notes = Console(stderr=True, highlight=False, soft_wrap=True, emoji=False)

_LINE_EVERY = 10.0  # seconds
_LONGEST = 2000  # characters of a note; far more than ours have


class GroupedCommand(typer.core.TyperCommand):
    """A command whose --help lists its options under the headings of their `rich_help_panel`."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        groups: dict[str, list[tuple[str, str]]] = {}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record:
                is_argument = parameter.param_type_name == "argument"
                heading = getattr(parameter, "rich_help_panel", None) or ("Scene" if is_argument else "Options")
                groups.setdefault(heading, []).append(record)
        for heading, records in groups.items():
            with formatter.section(heading):
                formatter.write_dl(records)


def warn(text: str, kind: str = "warning") -> None:
    """One line on stderr, whatever the names in `text` hold."""
    notes.print(f"{kind}: {one_line(text, _LONGEST)}", markup=False)


def track(frames: Sequence[int]) -> Iterable[int]:
    """Hand on the frames; on a terminal with a bar and the time left, else with a line every ten seconds at most."""
    if len(frames) == 1:
        return frames
    return _bar(frames) if notes.is_terminal else _lines(frames)


def _bar(frames: Sequence[int]) -> Iterator[int]:
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    with Progress(*columns, console=notes, transient=True) as progress:
        yield from progress.track(frames, description="rendering")


def _lines(frames: Sequence[int]) -> Iterator[int]:
    start = said = time.monotonic()
    for done, frame in enumerate(frames):
        now = time.monotonic()
        if now - said >= _LINE_EVERY:
            said = now
            left = (now - start) / done * (len(frames) - done)
            notes.print(f"{done} of {len(frames)} frames, {left:.0f} s left")
        yield frame


@contextmanager
def rounds() -> Iterator[Callable[[int, int], bool]]:
    """How far a frame is that takes many rounds: a bar with the time left on a terminal, else a line now and then."""
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn(), TimeRemainingColumn())
    bar = Progress(*columns, console=notes, transient=True, disable=not notes.is_terminal)
    task = bar.add_task("paths", total=None, visible=False)
    start = said = time.monotonic()

    def tell(done: int, total: int) -> bool:
        nonlocal start, said
        now = time.monotonic()
        if done == 1:
            start = said = now
        bar.update(task, completed=done, total=total, visible=done < total)
        if not notes.is_terminal and now - said >= _LINE_EVERY:
            said = now
            notes.print(f"{done} of {total} paths, {(now - start) / max(done - 1, 1) * (total - done):.0f} s left")
        return True

    with bar:
        yield tell


def print_statistics(statistics: dict[str, Any]) -> None:
    """The table of what each stage cost."""
    from .gpu.memory import readable

    width, height = statistics["size"]
    frame = statistics["frame_ms"]
    title = f"{statistics['technique']}, {width}x{height}, {statistics['adapter']}"
    out.print(title, markup=False, soft_wrap=True)
    table = Table()
    table.add_column("stage")
    for column in ("count", "mean ms", "median ms", "total ms"):
        table.add_column(column, justify="right")
    for row in statistics["stages"]:
        times = (f"{row[key]:.1f}" for key in ("mean_ms", "median_ms", "total_ms"))
        table.add_row(row["name"], str(row["count"]), *times)
    table.add_section()
    total = frame["mean"] * statistics["frames"]
    table.add_row("frame", str(statistics["frames"]), f"{frame['mean']:.1f}", f"{frame['median']:.1f}", f"{total:.1f}")
    out.print(table)
    out.print(f"memory on the device: {readable(statistics['memory_bytes']['total'])}")
    if statistics["frames"] == 1:
        out.print("the first frame also builds the shaders; --frames 10 shows what a frame costs")
    if statistics["timing_note"]:
        warn(statistics["timing_note"], "note")
