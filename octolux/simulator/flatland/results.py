"""Flatland as files: the figure, and the errors of all schemes as a table."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

from octolux.simulator.laboratory.results import png

from .figure import flatland_figure

FILES = ("flatland.png", "flatland.csv")


def flatland_files(
    bands: Sequence[int] = (2, 4, 16), size: tuple[int, int] = (12, 9), iterations: int | None = None
) -> tuple[dict[str, bytes], list[dict[str, Any]]]:
    """The contents of `FILES`, and the rows of the second (`Solution.errors`). Raises OctoluxError."""
    figure, rows = flatland_figure(bands, size, iterations)
    buffer = io.StringIO()
    writer = csv.DictWriter(buffer, list(rows[0]), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows)
    return dict(zip(FILES, (png(figure), buffer.getvalue().encode()), strict=True)), rows
