"""Settings of the uniform light propagation volume."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...settings import Settings, setting


@dataclass(frozen=True)
class UniformLpvSettings(Settings):
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
    evaluation: str = setting(
        "dominant_lobe", meaning="how a cell's intensity is read when it sends light on", unit="",
        allowed=("dominant_lobe", "clamped", "signed"),
        cost="dominant_lobe some 10 % more time; never negative and keeps flux",
        source="CLPV 3.3; ours: simulator/lpv/propagation.py",
    )  # fmt: skip
    reprojection: str = setting(
        "travel", meaning="direction of the lobe that a face's flux becomes", unit="", allowed=("travel", "face"),
        cost="none; face forgets direction sooner", source="CLPV 3.3; ours: simulator/lpv/propagation.py",
    )  # fmt: skip
    gain: float = setting(
        1.0, meaning="flux after a step over flux before, signed evaluation", unit="", allowed=[0.0, 2.0],
        cost="none; 1 conserves energy", source="simulator/lpv/propagation.py",
    )  # fmt: skip
    injection: str = setting(
        "flux", meaning="what a VPL injects: its flux / pi, or the thesis's lobe without 1/pi and with texel weight",
        unit="", allowed=("flux", "thesis"), cost="none", source="CLPV 3.1, OLPV 3.2.2 and 3.3",
    )  # fmt: skip
    reading: str = setting(
        "dominant_lobe", meaning="from intensity to irradiance", unit="", allowed=("dominant_lobe", "paper", "thesis"),
        cost="none", source="CLPV 3.4; ours: simulator/lpv/lookup.py",
    )  # fmt: skip
    damping: bool = setting(
        False, meaning="derivative damping against bleeding", unit="", allowed=(False, True),
        cost="two more lookups a channel", source="CLPV 3.4",
    )  # fmt: skip
    lookup_offset: float = setting(
        0.5, meaning="cells by which the point of lookup is moved along the normal, as VPLs are when injected",
        unit="cells", allowed=[0.0, 2.0], cost="none; 0 reads half of what lies behind a wall", source="CLPV 3.1",
    )  # fmt: skip
    scale: float = setting(
        1.0, meaning="free scale of the thesis reading; no other reading has one", unit="1/m^2", allowed=[0.0, 1e6],
        cost="none", source="OLPV 3.2.4",
    )  # fmt: skip
    cell_format: str = setting(
        "f32", meaning="numbers of a cell while light travels", unit="", allowed=("f32", "f16"),
        cost="f16: half the memory and traffic of a step; a software adapter spends as much on converting",
        source="OLPV 5.2 (f32), CLPV 6 (f16)",
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
