"""Settings of cascaded light propagation volumes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

from ...settings import setting
from ..settings import LpvSettings


@dataclass(frozen=True)
class CascadedLpvSettings(LpvSettings):
    """The default sends light straight from cell to cell; `paper` is CLPV by its numbers."""

    n: int = setting(
        32, meaning="cells along each side of each cascade", unit="cells", allowed=(16, 32, 64),
        cost="memory and steps grow with n^3, gathering about with n^2; more resolves smaller bounces",
        source="CLPV 4, 6",
    )  # fmt: skip
    cascades: int = setting(
        3, meaning="nested grids, each with cells half as large as the next; the last is around the scene", unit="",
        allowed=(1, 2, 3, 4, 5), cost="memory and steps are proportional; more is finer near the camera",
        source="CLPV 4, 6",
    )  # fmt: skip
    propagation: str = setting(
        "gather", meaning="how light spreads: straight, each way in cells that suit its length, or by steps in every "
        "cascade alone", unit="", allowed=("gather", "steps"),
        cost="gather takes more time on a CPU and is much nearer to the truth", source="CLPV 3.3; OLPV 7.1",
    )  # fmt: skip
    iterations: int = setting(
        8, meaning="propagation steps", unit="steps", allowed=[0, 256],
        cost="time is proportional; light travels at most a cell a step", source="CLPV 3.3, 6",
    )  # fmt: skip
    occlusion: bool = setting(
        True, meaning="surfaces between block light, through the geometry volume", unit="", allowed=(False, True),
        cost="some half of the gathering; a third more for steps; without it light goes through walls",
        source="CLPV 3.2",
    )  # fmt: skip
    surfels: str = setting(
        "scene", meaning="which surfaces block and reflect light: all of the scene's, or those that lamps, or lamps "
        "and the camera, see", unit="", allowed=("scene", "lamps", "lamps and camera"),
        cost="scene: up to a million samples of triangles, some 40 MB", source="CLPV 3.2; Ritschel et al. 2008",
    )  # fmt: skip

    bounces: int = setting(
        3, meaning="times that light is reflected before it reaches what is seen; gathering alone", unit="bounces",
        allowed=[1, 8], cost="each more than one: another gathering of all surfaces' cells", source="CLPV 7",
    )  # fmt: skip

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {}
