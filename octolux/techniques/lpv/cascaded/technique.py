"""`cascaded-lpv`: nested volumes around the camera (Kaplanyan & Dachsbacher 2010)."""

from __future__ import annotations

from ....frame.frame import Frame
from ....gpu.device import Device
from ...debug_views import DebugViews
from ...technique import Technique
from .cascades import Cascades
from .gathering import CascadedGathering
from .settings import CascadedLpvSettings
from .stepping import CascadedStepping


class CascadedLpv(Technique):
    """Light in nested grids, the finest around the camera."""

    name, summary = "cascaded-lpv", "light through nested volumes around the camera, with occlusion"
    settings_class = CascadedLpvSettings
    label = "LPV"
    needs = frozenset({"rsm", "surfaces"})
    supports = frozenset({"dynamic geometry", "dynamic lights", "diffuse", "glossy", "occlusion", "particles"})
    settings: CascadedLpvSettings

    def __init__(self, device: Device, settings: CascadedLpvSettings):
        super().__init__(device, settings)
        self.soft_light = settings.soft_light == "shadow maps"
        self.cascades = Cascades(device, settings.n, settings.cascades, settings.spacing)
        way = CascadedGathering if settings.propagation == "gather" else CascadedStepping
        self.way: CascadedGathering | CascadedStepping = way(device, self.cascades, settings)
        self.lamp_layers = settings.layers
        self.camera_layers = settings.layers if settings.surfels == "lamps and camera" else 1

    def prepare(self, frame: Frame) -> None:
        self.cascades.place(frame)
        self.way.prepare(frame)
        frame.irradiance, frame.specular = self.way.irradiance, self.way.specular

    def update(self, frame: Frame) -> None:
        self.way.update(frame)

    def shade(self, frame: Frame) -> None:
        self.way.shade(frame)

    def debug_views(self) -> DebugViews:
        return self.way.debug_views()
