"""Settings of the path tracer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from ..settings import Settings, setting

PATHS = ("all", "direct", "first-bounce", "indirect")


@dataclass(frozen=True)
class PathTracerSettings(Settings):
    """The default shows everything; `reference` is what rasterised techniques are compared with."""

    samples: int = setting(
        64, meaning="paths through each pixel", unit="", allowed=[1, 1 << 20],
        cost="time is proportional; noise falls with the square root", source="Kajiya 1986",
    )  # fmt: skip
    noise: float = setting(
        0.0, meaning="stop when the pixels' standard error (root mean square) is this share of the picture's mean; "
        "0 takes all samples", unit="", allowed=[0.0, 1.0], cost="less is slower, with the inverse square",
        source="Monte Carlo standard error",
    )  # fmt: skip
    paths: str = setting(
        "all", meaning="which light is shown: all; emitted and direct; what was reflected once before it lit the seen "
        "surface; all that was reflected before", unit="", allowed=PATHS, cost="fewer bounces are quicker",
        source="Heckbert 1990, light path sets",
    )  # fmt: skip
    bounces: int = setting(
        32, meaning="most surfaces on a path after the seen one", unit="", allowed=[0, 256],
        cost="little: long paths end by roulette; fewer lose energy", source="Arvo and Kirk 1990",
    )  # fmt: skip
    materials: str = setting(
        "all", meaning="materials as they are, or their diffuse part alone", unit="", allowed=("all", "diffuse"),
        cost="none", source="what diffuse techniques are compared with",
    )  # fmt: skip
    pixel: str = setting(
        "area", meaning="paths through the whole pixel, or through its centre as the other techniques see it", unit="",
        allowed=("area", "centre"), cost="none", source="box reconstruction filter",
    )  # fmt: skip
    seed: int = setting(
        0, meaning="another seed gives an independent picture", unit="", allowed=[0, (1 << 31) - 1], cost="none",
        source="Burley 2020",
    )  # fmt: skip

    PRESETS: ClassVar[dict] = {"reference": {"pixel": "centre", "samples": 1024}}
