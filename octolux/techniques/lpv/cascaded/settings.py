"""Settings of cascaded light propagation volumes."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

from ...settings import SettingsError, setting
from ..settings import LpvSettings, surfels_setting


@dataclass(frozen=True)
class CascadedLpvSettings(LpvSettings):
    """The default sends light straight from cell to cell; `steps` is CLPV made physical, `paper` CLPV by its
    numbers."""

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
    spacing: float = setting(
        0.0, meaning="edge of the last grid, which then moves with the camera; 0 is the scene's, and around it",
        unit="m", allowed=[0.0, 1e6], cost="none; what lies outside of it gives and receives no light",
        source="CLPV 4, figure 12",
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
    surfels: str = surfels_setting()
    layers: int = setting(
        1, meaning="depth-peeled layers of what lamps, and the camera, see that give surfels: each is the nearest "
        "surfaces behind the one before", unit="layers", allowed=[1, 4],
        cost="each more than one: all maps drawn once more, 36 bytes a texel of an RSM and 28 a pixel, its surfels. "
        "All lamps share a map more of 8 bytes a texel, with more than two layers two: 17 MB of 1024^2",
        source="CLPV 3, 3.2; Everitt 2001",
    )  # fmt: skip
    keep_surfels: bool = setting(
        False, meaning="what lamps, and the camera, have seen of static surfaces in earlier frames stays", unit="",
        allowed=(False, True), source="CLPV 3.2",
        cost="a copy of the cells a frame, and 288 bytes a cell of each cascade: 28 MB, or 377 MB for five of 64^3; "
        "steps 32, with bounces 128. While something moves surfels are counted twice. Pictures then depend on the "
        "frames before",
    )  # fmt: skip
    ambient_occlusion: bool = setting(
        True, meaning="what is smaller than a cell shadows in screen space", unit="", allowed=(False, True),
        cost="a pass over all pixels, some 40 ms of a CPU at 640 x 360", source="CLPV 3.2, 7; GTAO",
    )  # fmt: skip
    glossy: bool = setting(
        True, meaning="glossy surfaces reflect the cells: rays go through them; steps: the paper's mean of a few cells",
        unit="", allowed=(False, True), cost="a ray a pixel, some 25 ms of a CPU at 640 x 360", source="CLPV 7",
    )  # fmt: skip
    glossy_cells: int = setting(
        0, meaning="cells that a reflected ray goes through at most; 0 is all, and the paper's 4 for steps",
        unit="cells", allowed=[0, 1024], cost="fewer: darker reflections of what is far, and less time on a GPU",
        source="CLPV 7",
    )  # fmt: skip
    bounces: int = setting(
        4, meaning="times that light is reflected before it reaches what is seen; with steps 1, or more: in every step",
        unit="bounces", allowed=[1, 8],
        cost="each more than one: another gathering of all surfaces' cells; steps: a third of their time, however many",
        source="CLPV 7",
    )  # fmt: skip
    reflection: str = setting(
        "spectral", meaning="what colour reflects in steps: each by itself, or all as the luminance", unit="",
        allowed=("spectral", "mono"), cost="mono: a third of the memory of what is reflected", source="CLPV 6, 7",
    )  # fmt: skip
    soft_light: str = setting(
        "shadow maps", meaning="how area lights, glowing surfaces and the sky shine: past shadow maps, or from cells, "
        "as particles do always", unit="", allowed=("shadow maps", "cells"),
        cost="cells: far less time on a CPU, for shadows no finer than a cell", source="CLPV 3.1",
    )  # fmt: skip
    small_objects: str = setting(
        "keep", meaning="light of objects smaller than a cell (the longest edge of the box): all of it; or fading "
        "from a cell down to none at half of it, for all objects or for those that move", unit="",
        allowed=("keep", "fade moving", "fade"), cost="fading reads a word more of each VPL, and loses light",
        source="CLPV 4.1, 4.2",
    )  # fmt: skip
    damping: bool = setting(
        False, meaning="derivative damping against bleeding; steps alone", unit="", allowed=(False, True),
        cost="two more lookups a channel and cascade", source="CLPV 3.4",
    )  # fmt: skip

    _OF_STEPS: ClassVar[tuple[str, ...]] = (
        "evaluation", "reprojection", "gain", "reading", "cell_format", "reflection", "damping",
    )  # fmt: skip

    def __post_init__(self) -> None:
        super().__post_init__()
        if "thesis" in (self.injection, self.reading):
            raise SettingsError("The thesis's light has no unit, which cells of several sizes need. Set injection=flux "
            "and reading=dominant_lobe or paper.")  # fmt: skip
        if self.propagation == "steps" and self.bounces > 1 and not self.occlusion:
            raise SettingsError("Steps reflect what the geometry volume blocks. Set occlusion=true, or bounces=1.")
        if self.propagation == "gather":
            self._refuse_steps()
        self._refuse_surfels()

    @property
    def takes_surfels(self) -> bool:
        """Whether anything asks where surfaces lie."""
        return self.occlusion or self.bounces > 1 or (self.glossy and self.propagation == "gather")

    def _refuse_surfels(self) -> None:
        if not self.takes_surfels and (self.layers > 1 or self.keep_surfels):
            raise SettingsError("Without occlusion, bounces and glossy rays nothing takes surfels. Set "
            "occlusion=true, or layers=1 and keep_surfels=false.")  # fmt: skip
        if self.surfels == "scene" and self.layers > 1:
            raise SettingsError("The scene's surfels are of all layers already. Set layers=1, or surfels=lamps or "
            "'lamps and camera'.")  # fmt: skip
        if self.surfels == "scene" and self.keep_surfels:
            raise SettingsError("The scene's surfels are all there in each frame. Set keep_surfels=false, or "
            "surfels=lamps or 'lamps and camera'.")  # fmt: skip

    def _refuse_steps(self) -> None:
        defaults = {f.name: f.default for f in dataclasses.fields(self)}
        if others := [name for name in self._OF_STEPS if getattr(self, name) != defaults[name]]:
            raise SettingsError(f"'gather' has no steps, to which these belong: {', '.join(others)}. "
            "Set propagation=steps, or leave them as they are.")  # fmt: skip

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "steps": {"propagation": "steps", "iterations": 16, "bounces": 1, "glossy": False},
        "paper": {
            "propagation": "steps", "iterations": 8, "evaluation": "clamped", "reprojection": "face",
            "reading": "paper", "damping": True, "lookup_offset": 0.0, "cell_format": "f16",
            "surfels": "lamps and camera", "bounces": 1, "reflection": "mono", "small_objects": "fade",
            "glossy": False,
        },
    }  # fmt: skip
