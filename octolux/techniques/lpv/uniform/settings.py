"""Settings of the uniform light propagation volume."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...settings import setting
from ..settings import LpvSettings


@dataclass(frozen=True)
class UniformLpvSettings(LpvSettings):
    """The default is ours and physical; `paper` is CLPV by the letter, `thesis` OLPV's uniform baseline."""

    n: int = setting(
        32, meaning="cells along each side of the volume", unit="cells", allowed=(16, 32, 64),
        cost="memory and propagation grow with n^3; more resolves smaller bounces but needs more iterations",
        source="CLPV 6, OLPV 5.2",
    )  # fmt: skip
    iterations: int = setting(
        16, meaning="propagation steps k", unit="steps", allowed=[0, 256],
        cost="time is proportional; light travels at most a cell a step, so fewer leave far surfaces dark",
        source="CLPV 3.3 (Iterations), OLPV 6.3",
    )  # fmt: skip
    damping: bool = setting(
        False, meaning="derivative damping against bleeding", unit="", allowed=(False, True),
        cost="two more lookups a channel", source="CLPV 3.4",
    )  # fmt: skip

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "paper": {
            "iterations": 8, "evaluation": "clamped", "reprojection": "face", "reading": "paper", "damping": True,
            "lookup_offset": 0.0, "cell_format": "f16",
        },
        "thesis": {
            "iterations": 16, "evaluation": "clamped", "reprojection": "face", "gain": 0.75, "injection": "thesis",
            "reading": "thesis", "lookup_offset": 0.0,
        },
    }  # fmt: skip
