"""Settings that all light propagation volumes share: how light is injected, handed on in steps and read."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..settings import Settings, SettingsError, setting


def surfels_setting() -> Any:
    """Of techniques whose light is blocked: what `surfel_buffers` (surfels.py) are asked for."""
    return setting(
        "scene", meaning="which surfaces block and reflect light: all of the scene's, or those that lamps, or lamps "
        "and the camera, see", unit="", allowed=("scene", "lamps", "lamps and camera"),
        cost="scene: up to a million samples of triangles, some 40 MB; the others may miss what nobody sees",
        source="CLPV 3.2; Ritschel et al. 2008",
    )  # fmt: skip


@dataclass(frozen=True)
class LpvSettings(Settings):
    """n and iterations are each volume's own; they stand here so that they come first."""

    n: int = setting(32, meaning="cells along each side", unit="cells", allowed=(32,), cost="as n^3", source="OLPV 5.2")
    iterations: int = setting(16, meaning="steps", unit="steps", allowed=[0, 256], cost="k times", source="CLPV 3.3")
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
    lookup_offset: float = setting(
        0.5, meaning="cells by which the point of lookup is moved along the normal, as VPLs are when injected",
        unit="cells", allowed=[0.0, 2.0], cost="none; 0 reads half of what lies behind a wall", source="CLPV 3.1",
    )  # fmt: skip
    scale: float = setting(
        1.0, meaning="free scale of the thesis reading; no other reading has one", unit="1/m^2", allowed=[0.0, 1e6],
        cost="none", source="OLPV 3.2.4",
    )  # fmt: skip
    cell_format: str = setting(
        "f32", meaning="numbers of a cell while light travels", unit="", allowed=("f32", "f16", "snorm8"),
        cost="f16: half the memory and traffic of a step; a software adapter spends as much on converting. snorm8: a "
        "quarter, 1 to 3 % of error, not with signed",
        source="OLPV 5.2 (f32), CLPV 6 (f16); ours: simulator/lpv/formats.py",
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.cell_format == "snorm8" and self.evaluation == "signed":
            raise SettingsError("Cells in snorm8 hold no negative flux, which signed evaluation makes. Set "
            "cell_format=f16, or evaluation=dominant_lobe or clamped.")  # fmt: skip
