"""Techniques to compare with: no indirect light, and the same irradiance everywhere."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..frame.frame import COPY, STORAGE, TEXTURE, Frame
from ..gpu.bindings import storage_texture, uniform
from ..gpu.device import Device
from ..gpu.layout import Struct
from ..gpu.passes import ComputePass
from .settings import Settings, setting
from .technique import Technique


class NoTechnique(Technique):
    """Direct light only: what a picture looks like without global illumination."""

    name, summary, settings_class = "none", "no indirect light", Settings
    supports = frozenset({"dynamic geometry", "dynamic lights"})

    def prepare(self, frame: Frame) -> None:
        frame.irradiance = None

    def update(self, frame: Frame) -> None:
        """There is no cache."""

    def shade(self, frame: Frame) -> None:
        """Leaves the irradiance black."""


_RANGE = [0.0, 1e9]
_SOURCE = "the baseline of any irradiance technique"
_CHANNEL: dict[str, Any] = {"unit": "lx", "allowed": _RANGE, "cost": "none", "source": _SOURCE}


@dataclass(frozen=True)
class ConstantSettings(Settings):
    """Irradiance of the `constant` technique, per channel."""

    red: float = setting(1.0, meaning="red irradiance everywhere", **_CHANNEL)
    green: float = setting(1.0, meaning="green irradiance everywhere", **_CHANNEL)
    blue: float = setting(1.0, meaning="blue irradiance everywhere", **_CHANNEL)


CONSTANT = Struct("Constant", irradiance="vec3f")


class Constant(Technique):
    """The same irradiance on every surface: ambient light, the baseline any technique must beat."""

    label = "constant"
    name, summary, settings_class = "constant", "the same irradiance everywhere (ambient light)", ConstantSettings
    supports = frozenset({"dynamic geometry", "dynamic lights"})

    def __init__(self, device: Device, settings: ConstantSettings):
        super().__init__(device, settings)
        value = (settings.red, settings.green, settings.blue)
        self._value = device.uniform("constant irradiance", CONSTANT.pack(irradiance=value))
        bindings = [uniform("constant", CONSTANT), storage_texture("irradiance_out", "rgba32float")]
        self._pass = ComputePass(device, "constant", "techniques/constant.wgsl", bindings, structs=[CONSTANT])
        self._irradiance: Any = None

    def prepare(self, frame: Frame) -> None:
        if self._irradiance is None or self._irradiance.size[:2] != frame.pixels:
            usage = STORAGE | TEXTURE | COPY
            self._irradiance = self.device.texture("constant irradiance", frame.pixels, "rgba32float", usage=usage)
        frame.irradiance = self._irradiance

    def update(self, frame: Frame) -> None:
        """There is no cache."""

    def shade(self, frame: Frame) -> None:
        with frame.profiler.stage("constant") as stage:
            self._pass.run(stage, frame.pixels, constant=self._value, irradiance_out=self._irradiance)
