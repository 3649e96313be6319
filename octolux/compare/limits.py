"""`--fail-above`: figures that must not be exceeded, for use in continuous integration."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..scene.errors import OctoluxError
from ..techniques.settings import suggest
from .reference import COMPARED
from .report import Entry, Report

_OF_LAYERS = ("relative_rmse", "trimmed_relative_rmse", "flip", "ratio_error", "ssim_error")
_OF_ALL = ("energy_error", "leak", "frame_ms")
METRICS = (*_OF_LAYERS, *_OF_ALL)
"""What can be limited. ratio_error and energy_error are |ratio - 1|, ssim_error is 1 - SSIM: smaller is better."""


@dataclass(frozen=True)
class Limit:
    """text: as given.  label: a technique or a label, or empty for all but `constant` and `black`."""

    text: str
    label: str
    layer: str
    metric: str
    most: float

    def concerns(self, entry: Entry) -> bool:
        return self.label in (entry.label, entry.choice.technique) if self.label else not entry.baseline


def limit(text: str) -> Limit:
    """`flip=0.2`, `indirect.relative_rmse=0.5`, `uniform-lpv:paper:leak=0.01`. Raises OctoluxError."""
    left, equals, number = text.rpartition("=")
    label, _, name = left.rpartition(":")
    layer, _, metric = name.strip().rpartition(".")
    try:
        most = float(number)
    except ValueError:
        most = math.nan
    if not equals or not math.isfinite(most):
        raise OctoluxError(f"--fail-above takes METRIC=NUMBER, such as relative_rmse=0.5, not '{text}'.")
    if metric not in METRICS:
        raise OctoluxError(f"--fail-above {text}: there is no metric '{metric}'. {suggest(metric, METRICS)}")
    if layer not in ("", *COMPARED) or (layer and metric in _OF_ALL):
        raise OctoluxError(f"--fail-above {text}: '{layer}' is not a layer of {metric}. Layers: {', '.join(COMPARED)}.")
    return Limit(text, label.strip(), layer or "final", metric, most)


def check_labels(limits: list[Limit], known: list[str]) -> None:
    """Raise OctoluxError where a limit names what is not compared."""
    for one in limits:
        if one.label and one.label not in known:
            raise OctoluxError(f"--fail-above {one.text}: '{one.label}' is not compared. {suggest(one.label, known)}")


def value(entry: Entry, one: Limit) -> float | None:
    """What `entry` has of the limited figure; None where it could not be told."""
    if one.metric == "frame_ms":
        return float(entry.statistics["frame_ms"]["median"])
    if one.metric == "leak":
        return entry.leak.score
    layer = entry.metrics["indirect" if one.metric == "energy_error" else one.layer]
    if not one.metric.endswith("_error"):
        return layer[one.metric]
    found = layer["ssim" if one.metric == "ssim_error" else "ratio"]
    return None if found is None else abs(found - 1.0)


def exceeded(report: Report, limits: list[Limit]) -> list[str]:
    """A phrase for each figure above its limit, or that could not be told: then nothing shows that it holds."""
    phrases = []
    for one in limits:
        for entry in filter(one.concerns, report.entries):
            found = value(entry, one)
            if found is None:
                phrases.append(f"{entry.label}: {one.metric} cannot be told here ({one.text})")
            elif not found <= one.most:
                phrases.append(f"{entry.label}: {one.metric} is {found:.4g} ({one.text})")
    return phrases
