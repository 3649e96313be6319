"""Settings of the octree light propagation volume."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...settings import SettingsError, setting
from ..settings import LpvSettings, surfels_setting


@dataclass(frozen=True)
class OctreeLpvSettings(LpvSettings):
    """The default sends light straight from cell to cell; `steps` is OLPV made physical, `thesis` OLPV by the
    letter."""

    n: int = setting(
        32, meaning="cells along each side of the finest level", unit="cells", allowed=(16, 32, 64, 128),
        cost="memory and steps grow with n^3, gathering about with n^2 log n; more resolves smaller bounces",
        source="OLPV 4.2, 5.2",
    )  # fmt: skip
    propagation: str = setting(
        "gather", meaning="how light spreads: straight, each way on the level that suits its length; by steps on "
        "every level, merged; or by steps through each region on one level alone", unit="",
        allowed=("gather", "steps", "sparse"),
        cost="gather takes more time on a CPU and is much nearer to the truth; sparse needs the least memory",
        source="OLPV 4.2 and 7.1",
    )  # fmt: skip
    occlusion: bool = setting(
        True, meaning="surfaces between block light, through the geometry volume; not with sparse", unit="",
        allowed=(False, True),
        cost="some half of the gathering; without it light goes through walls", source="CLPV 3.2, OLPV 5.2",
    )  # fmt: skip
    surfels: str = surfels_setting()
    cells: str = setting(
        "seen", meaning="which cells gather light: those that seen surfaces look up, or all", unit="",
        allowed=("seen", "all"), cost="all: several times the time, for looking into the volume", source="ours",
    )  # fmt: skip
    iterations: int = setting(
        4, meaning="propagation steps k on every level", unit="steps", allowed=[0, 256],
        cost="time is proportional; more makes finer levels reach farther", source="OLPV 4.2, 6",
    )  # fmt: skip
    coarsest: int = setting(
        1, meaning="cells along each side of the coarsest level", unit="cells", allowed=(1, 2),
        cost="none; the thesis had no texture of one texel", source="OLPV 5.2",
    )  # fmt: skip
    margin: int = setting(
        1, meaning="sparse: cells of each level, at least, around what is finer", unit="cells", allowed=(1, 2, 3),
        cost="more keeps larger parts of the volume fine: memory, and time", source="OLPV 7.1",
    )  # fmt: skip
    combine: str = setting(
        "sum", meaning="a parent from its eight children: their sum keeps flux, read with the parent's cell size",
        unit="", allowed=("sum", "average"), cost="none", source="OLPV eq. 11; ours: simulator/lpv/octree.py",
    )  # fmt: skip
    merge: str = setting(
        "arrival", meaning="which level a cell reads: what has arrived, blended, or the finest that has been touched",
        unit="", allowed=("arrival", "index"), cost="arrival: eight times the reads of the merge",
        source="OLPV 4.2, 6.1, 7.1",
    )  # fmt: skip
    threshold: float = setting(
        2.0**-20, meaning="share of the largest injected light up to which a contribution counts as zero", unit="",
        allowed=[0.0, 1.0], cost="none; more keeps the index volume coarser", source="OLPV 4.2",
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.propagation == "sparse" and self.occlusion:
            raise SettingsError("Sparse propagation has no occlusion. Set occlusion=false, or use the preset 'sparse'.")
        if self.propagation != "steps" and self.combine != "sum":
            raise SettingsError(f"'{self.propagation}' keeps flux: parents are sums of children. Set combine=sum.")
        if self.propagation == "steps" and self.combine == "sum" and self.cell_format == "snorm8":
            raise SettingsError("Sums of children outgrow cells in snorm8. Set cell_format=f16, or combine=average.")
        if self.propagation == "gather" and self.injection != "flux":
            raise SettingsError("'gather' reads cells as flux: VPLs inject theirs. Set injection=flux.")

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "steps": {"propagation": "steps", "occlusion": False},
        "sparse": {"propagation": "sparse", "occlusion": False, "iterations": 16},
        "thesis": {
            "propagation": "steps", "occlusion": False, "coarsest": 2, "combine": "average", "merge": "index",
            "evaluation": "clamped", "reprojection": "face", "gain": 0.75, "injection": "thesis", "reading": "thesis",
            "lookup_offset": 0.0, "surfels": "lamps and camera",
        },
    }  # fmt: skip
