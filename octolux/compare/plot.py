"""Time against error, as the geometry of an SVG that the page's template draws."""

from __future__ import annotations

import math
from typing import Any

from .report import Report

WIDTH, HEIGHT = 560.0, 330.0
LEFT, RIGHT, TOP, BOTTOM = 52.0, 34.0, 14.0, 44.0
_LINE = 15.0
"""Height of a label, in the SVG's units."""


def plot(report: Report, layer: str) -> dict[str, Any] | None:
    """Points (x, y, label, kind), ticks and axes for the relative RMSE of `layer`; None where no error can be told."""
    points: list[dict[str, Any]] = [
        {"label": e.label, "ms": _median(e.statistics), "error": e.metrics[layer]["relative_rmse"],
         "kind": "baseline" if e.baseline else "technique"}
        for e in report.entries
    ]  # fmt: skip
    noise, time = report.facts["reference"]["noise"][layer], report.facts["reference"].get("frame_ms")
    if noise is not None and time:
        points.append({"label": "reference (its noise)", "ms": time, "error": noise, "kind": "reference"})
    points = [p for p in points if p["error"] is not None and p["ms"] > 0]
    if not points:
        return None
    times = [p["ms"] for p in points]
    low, high = _decades(min(times), max(times))
    step = _step(max(p["error"] for p in points))
    top = step * max(1, math.ceil(1.05 * max(p["error"] for p in points) / step))

    def x(ms: float) -> float:
        return LEFT + (math.log10(ms) - low) / (high - low) * (WIDTH - LEFT - RIGHT)

    def y(error: float) -> float:
        return TOP + (1.0 - error / top) * (HEIGHT - TOP - BOTTOM)

    for p in points:
        p["x"], p["y"] = x(p["ms"]), y(p["error"])
    _place_labels(points)
    return {
        "points": points, "width": WIDTH, "height": HEIGHT, "left": LEFT, "right": WIDTH - RIGHT, "top": TOP,
        "bottom": HEIGHT - BOTTOM,
        "x_ticks": [(x(t), _text(t)) for t in _time_ticks(low, high)],
        "y_ticks": [(y(k * step), f"{k * step:.3g}") for k in range(round(top / step) + 1)],
    }  # fmt: skip


def _median(statistics: dict[str, Any]) -> float:
    return float(statistics["frame_ms"]["median"])


def _decades(least: float, most: float) -> tuple[float, float]:
    """The ends of the time axis, log10 ms: at 1, 2 or 5 times a power of ten, with room around the points."""
    ticks = _time_ticks(math.log10(least) - 2, math.log10(most) + 2)
    below = max(t for t in ticks if t < 0.9 * least)
    above = min(t for t in ticks if t > 1.1 * most)
    return math.log10(below), math.log10(above)


def _time_ticks(low: float, high: float) -> list[float]:
    powers = range(math.floor(low) - 1, math.ceil(high) + 1)
    ticks = [m * 10.0**p for p in powers for m in (1, 2, 5)]
    inside = [t for t in ticks if low - 1e-9 <= math.log10(t) <= high + 1e-9]
    return inside if len(inside) <= 8 else [t for t in inside if math.log10(t) % 1 < 1e-9] or inside


def _text(ms: float) -> str:
    return f"{ms:g} ms" if ms < 1000 else f"{ms / 1000:g} s"


def _step(most: float) -> float:
    """Between lines, so that there are three to eight up to `most`."""
    power = 10.0 ** math.floor(math.log10(max(most, 1e-3)))
    return next(m * power for m in (0.2, 0.5, 1.0, 2.0) if most / (m * power) <= 6)


def _place_labels(points: list[dict[str, Any]]) -> None:
    """Labels beside their points, on the side with more room, and below one another where they would overlap."""
    taken: list[tuple[float, float, float]] = []
    for p in sorted(points, key=lambda p: p["y"]):
        p["anchor"] = "start" if p["x"] < (LEFT + WIDTH) / 2 else "end"
        width = 7.0 * len(p["label"])  # of a letter at 13 units, generously
        p["label_x"] = p["x"] + (10.0 if p["anchor"] == "start" else -10.0)
        begin = p["label_x"] if p["anchor"] == "start" else p["label_x"] - width
        p["label_y"] = p["y"] + 4.0
        for a, b, other in taken:
            if a < begin + width and begin < b and abs(p["label_y"] - other) < _LINE:
                p["label_y"] = other + _LINE
        taken.append((begin, begin + width, p["label_y"]))
