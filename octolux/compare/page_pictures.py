"""The pictures of a report's page, as data URIs."""

from __future__ import annotations

import base64
import io
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from PIL import Image

from . import colour_maps
from .metrics import brightness_map, error_map
from .rendering import LAYERS
from .report import Entry, Report

SCALE = 1.0
"""Where the colours of errors end: an error as large as the reference's mean."""

VIEWS: dict[str, dict[str, Any]] = {
    "picture": {"title": "Picture"},
    "error": {
        "title": "Error", "colours": colour_maps.MAGMA, "low": 0.0, "high": SCALE,
        "ticks": ("0", "25 %", "50 %", "75 %", "100 % and more"),
        "text": "Error of the pixel (root mean square of red, green, blue) relative to the reference's mean.",
    },
    "brightness": {
        "title": "Too bright, too dark", "colours": colour_maps.BLUE_RED, "low": -SCALE, "high": SCALE,
        "ticks": ("100 % too dark", "50 %", "right", "50 %", "100 % too bright"),
        "text": "Luminance less the reference's, relative to the reference's mean.",
    },
    "flip": {
        "title": "FLIP", "colours": colour_maps.MAGMA, "low": 0.0, "high": 1.0,
        "ticks": ("0", "0.25", "0.5", "0.75", "1"),
        "text": "How different the pixel looks from the reference when the two are shown in turn.",
    },
}  # fmt: skip
"""What can be shown of each layer: `text` says what a colour means, `ticks` stand under the legend, evenly spaced."""


@dataclass
class Gallery:
    """Pictures as data URIs, each once: `uris` by number."""

    uris: list[str] = field(default_factory=list)
    _numbers: dict[str, int] = field(default_factory=dict)

    def add(self, image: Image.Image, **options: Any) -> int:
        """The picture's number."""
        file = io.BytesIO()
        image.save(file, **options)
        uri = f"data:image/{options['format'].lower()};base64,{base64.b64encode(file.getvalue()).decode('ascii')}"
        if uri not in self._numbers:
            self._numbers[uri] = len(self.uris)
            self.uris.append(uri)
        return self._numbers[uri]

    def shown(self, signal: np.ndarray) -> int:
        """Of an sRGB signal (height, width, 3) in [0, 1]: lossless, as reports are looked at closely."""
        pixels = np.floor(np.clip(signal, 0.0, 1.0) * 255.0 + 0.5).astype(np.uint8)
        return self.add(Image.fromarray(pixels), format="WEBP", lossless=True, quality=40, method=2)

    def mapped(self, values: np.ndarray, view: str) -> int:
        """Of numbers (height, width) in the colours of VIEWS[view]."""
        about = VIEWS[view]
        image = Image.fromarray(colour_maps.levels(values, about["low"], about["high"]), mode="P")
        image.putpalette(colour_maps.palette(about["colours"]).tobytes())
        return self.add(image, format="PNG", optimize=False)


def series(report: Report, gallery: Gallery) -> list[dict[str, Any]]:
    """For the reference and every entry its label, and by layer and view the number of the picture."""
    known = report.reference
    shown = {layer: gallery.shown(report.displayed(known.pictures[layer])) for layer in LAYERS}
    plain = {layer: dict.fromkeys(VIEWS, number) for layer, number in shown.items()}
    first = {"label": "reference", "name": known.name, "reference": True, "layers": plain}
    rest = ({"label": e.label, "name": e.label, "layers": _layers(report, e, gallery)} for e in report.entries)
    return [first, *rest]


def _layers(report: Report, entry: Entry, gallery: Gallery) -> dict[str, dict[str, int]]:
    found = {}
    for layer in LAYERS:
        ours, known = entry.pictures[layer], report.reference.pictures[layer]
        found[layer] = {
            "picture": gallery.shown(report.displayed(ours)),
            "error": gallery.mapped(error_map(ours, known, entry.mask), "error"),
            "brightness": gallery.mapped(brightness_map(ours, known, entry.mask), "brightness"),
        }
        flips = entry.flips.get(layer)
        if flips is not None:
            found[layer]["flip"] = gallery.mapped(flips, "flip")
    return found
