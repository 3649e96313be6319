"""The report as one page that needs nothing else: pictures, styles and program are inside."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import jinja2

from ..gpu.memory import readable
from . import colour_maps
from .metrics import LEAK_SHARE, LEAST_DARK_SHARE, TRIMMED_SHARE
from .page_pictures import VIEWS, Gallery, series
from .plot import plot
from .rendering import LAYERS
from .report import Entry, Report, figure

# Title, key and digits; the key's first part is the layer. A click sorts by it.
_OF_LAYER = (
    ("Energy", "ratio", "Mean over the reference's mean; 1 is right"),
    ("Rel. RMSE", "relative_rmse", "Root of the mean squared error over the reference's mean"),
    ("Trimmed", "trimmed_relative_rmse", f"The same without the worst {TRIMMED_SHARE:.0%} of pixels"),
    ("FLIP", "flip", "How different it looks: 0 the same, 1 as different as can be"),
    ("SSIM", "ssim", "Structural similarity: 1 the same"),
)
_SMALLER_IS_BETTER = ("relative_rmse", "trimmed_relative_rmse", "flip")


def page(report: Report) -> str:
    """The page's HTML."""
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("octolux", "compare"), autoescape=True, undefined=jinja2.StrictUndefined,
        trim_blocks=True, lstrip_blocks=True,
    )  # fmt: skip
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False}  # views in their order
    environment.filters["readable"] = readable
    gallery = Gallery()
    found = series(report, gallery)
    views = {k: v for k, v in VIEWS.items() if k in found[-1]["layers"]["final"]}
    return environment.get_template("page.html").render(
        facts=report.facts,
        entries=report.entries,
        rows=[_row(report, entry) for entry in report.entries],
        columns=_OF_LAYER,
        layers=list(LAYERS),
        views={name: _view(about) for name, about in views.items()},
        plots={layer: plot(report, layer) for layer in ("indirect", "final")},
        leak_share=LEAK_SHARE,
        least_dark_share=LEAST_DARK_SHARE,
        trimmed_share=TRIMMED_SHARE,
        viewer={
            "series": found, "pictures": gallery.uris, "size": report.facts["size"],
            "views": {name: _view(about) for name, about in views.items()},
        },
    )  # fmt: skip


def _view(about: dict[str, Any]) -> dict[str, Any]:
    """A view without its colours: their gradient."""
    plain = {key: about[key] for key in ("title", "text", "ticks") if key in about}
    return plain | ({"gradient": colour_maps.gradient(about["colours"])} if "colours" in about else {})


def _row(report: Report, entry: Entry) -> dict[str, Any]:
    """A row of the table: cells of text, the value to sort by, and whether a constant does better."""
    cells = [_cell(float(entry.statistics["frame_ms"]["median"]), "{:.1f}".format)]
    cells += [_cell(entry.statistics["technique_bytes"], readable)]
    for layer in ("indirect", "final"):
        for _, key, _ in _OF_LAYER:
            cells.append(_cell(entry.metrics[layer][key], figure) | {"worse": _worse(report, entry, layer, key)})
    cells.append(_cell(entry.leak.score, "{:.1%}".format))
    return {"label": entry.label, "baseline": entry.baseline, "cells": cells}


def _cell(value: float | None, text: Callable[[float], str]) -> dict[str, Any]:
    return {"text": figure(None) if value is None else text(value), "value": value, "worse": False}


def _worse(report: Report, entry: Entry, layer: str, key: str) -> bool:
    """Whether one irradiance everywhere does better than the technique."""
    ours, constant = entry.metrics[layer][key], report["constant"].metrics[layer][key]
    if entry.baseline or ours is None or constant is None or key == "ratio":
        return False
    return ours > constant if key in _SMALLER_IS_BETTER else ours < constant
