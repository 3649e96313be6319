"""What a picture's file holds besides its pixels, and how it is written."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..scene.errors import OctoluxError
from ..techniques.settings import suggest

_RGB, _XYZ, _XY = ("R", "G", "B"), ("X", "Y", "Z"), ("X", "Y")

# Every layer of a Picture with the suffixes of its EXR channels; docs/conventions.md lists them with their units.
LAYERS: dict[str, tuple[str, ...]] = {
    "radiance": _RGB, "direct": _RGB, "indirect": _RGB, "irradiance": _RGB, "specular": _RGB, "emissive": _RGB,
    "albedo": _RGB, "normal": _XYZ, "position": _XYZ, "motion": _XY, "depth": (), "alpha": (), "object_id": (),
    "noise": (), "fog": _RGB, "transmittance": _RGB,
}  # fmt: skip


@dataclass(frozen=True)
class FileOptions:
    """How pictures are written.

    bits: of a PNG's channel, 8 or 16.  alpha: PNG with a transparent background.
    layers: names of LAYERS to write to EXR and NPZ; None for all.
    metadata: written into EXR headers; texts, whole numbers, floats and fractions.
    paths, noise: a traced EXR of fewer paths a pixel is not complete, unless its relative error is at most `noise`.

    Raises OctoluxError for other bits or an unknown layer.
    """

    bits: int = 8
    alpha: bool = False
    layers: tuple[str, ...] | None = None
    metadata: dict[str, Any] = field(default_factory=dict)
    paths: int = 0
    noise: float = 0.0

    def __post_init__(self) -> None:
        if self.bits not in (8, 16):
            raise OctoluxError(f"A PNG has 8 or 16 bits a channel, not {self.bits}.")
        for name in self.layers or ():
            if name not in LAYERS:
                raise OctoluxError(f"There is no layer '{name}'. {suggest(name, LAYERS)}")

    def wants(self, layer: str) -> bool:
        return self.layers is None or layer in self.layers


def channel_names(layer: str) -> list[str]:
    """The EXR channels of a layer: radiance is the picture itself, R G B, and alpha is A."""
    if layer in ("radiance", "alpha"):
        return list(LAYERS[layer] or "A")
    return [f"{layer}.{suffix}" for suffix in LAYERS[layer]] or [layer]


def layer_names(text: str | None) -> tuple[str, ...] | None:
    """The layers that `depth,normal` names, each once, in their order; None for None. Raises OctoluxError for none."""
    if text is None:
        return None
    found = tuple(dict.fromkeys(name.strip() for name in text.split(",") if name.strip()))
    if not found:
        known = ", ".join(LAYERS)
        raise OctoluxError(f"--layers takes names with commas between them, such as depth,normal. There are: {known}.")
    return found
