"""What a comparison found: as data, as JSON, and as a page."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..output import write_json
from ..output.atomic import remove_leftovers, replacing
from ..scene.errors import OctoluxError
from .choices import Choice
from .metrics import Leak
from .reference import Reference

FILES = ("report.json", "report.html")


@dataclass(frozen=True)
class Entry:
    """One technique beside the reference.

    metrics: by layer (`final`, `indirect`): ratio, relative_rmse, trimmed_relative_rmse, flip, ssim; None where it
    cannot be told.  pictures: `final`, `indirect`, `direct` (height, width, 3), nits.  mask: where errors count.
    flips: FLIP's maps (height, width) by layer.  statistics: as Renderer.statistics.
    """

    choice: Choice
    metrics: dict[str, dict[str, float | None]]
    leak: Leak
    pictures: dict[str, np.ndarray]
    mask: np.ndarray
    flips: dict[str, np.ndarray | None]
    statistics: dict[str, Any]

    @property
    def label(self) -> str:
        return self.choice.label

    @property
    def energy(self) -> float | None:
        """Mean indirect light over the reference's."""
        return self.metrics["indirect"]["ratio"]

    @property
    def baseline(self) -> bool:
        """Whether it is one of the two that every report has."""
        return self.label in ("constant", "black")

    def data(self) -> dict[str, Any]:
        """Plain data, as report.json has it."""
        kept = ("samples", "frames", "frame_ms", "stages", "timing", "timing_note", "memory_bytes", "technique_bytes")
        return {
            "label": self.label,
            "technique": self.choice.technique,
            "preset": self.choice.preset,
            "settings": self.choice.settings.as_dict(),
            **self.metrics,
            "energy": self.energy,
            "leak": self.leak._asdict(),
            **{key: self.statistics[key] for key in kept},
        }


@dataclass(frozen=True)
class Report:
    """facts: what was compared and where.  entries: as asked for, then `constant` and `black`.
    displayed: radiance (height, width, 3), nits, to the sRGB signal in [0, 1]."""

    facts: dict[str, Any]
    entries: list[Entry]
    reference: Reference
    displayed: Callable[[np.ndarray], np.ndarray]

    def __getitem__(self, label: str) -> Entry:
        """The entry of that label. Raises KeyError."""
        return {entry.label: entry for entry in self.entries}[label]

    @property
    def data(self) -> dict[str, Any]:
        """Plain data: what report.json holds."""
        return {**self.facts, "techniques": [entry.data() for entry in self.entries]}

    def write(self, folder: str | Path) -> list[Path]:
        """Write report.json and report.html to `folder`, made if need be. Raises OctoluxError."""
        from .page import page

        html = page(self)
        folder = Path(folder)
        check_folder(folder)
        folder.mkdir(exist_ok=True)
        remove_leftovers(folder)
        write_json(self.data, folder / FILES[0])
        with replacing(folder / FILES[1]) as temporary:
            temporary.write_text(html, encoding="utf-8")
        return [folder / name for name in FILES]


def figure(value: float | None) -> str:
    """A figure for people: three decimals, fewer digits where it is large, a dash where there is none."""
    if value is None:
        return "–"
    return f"{value:.3f}" if abs(value) < 100.0 else f"{value:.3g}"


def check_folder(folder: Path) -> None:
    """Raise OctoluxError unless the folder, or one in its parent, can be written to."""
    parent = folder if folder.exists() else folder.absolute().parent
    if folder.exists() and not folder.is_dir():
        raise OctoluxError(f"{folder}: is a file. Choose a folder for the report.")
    if not parent.is_dir():
        raise OctoluxError(f"{folder}: there is no folder '{parent}'. Make it first: mkdir -p '{parent}'.")
    if not os.access(parent, os.W_OK):
        raise OctoluxError(f"{folder}: cannot be written. Check the permissions of '{parent}'.")
