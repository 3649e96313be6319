"""Low-frequency direct light in cascades (CLPV 3.1): particles, and if asked for area lights, glow and the sky."""

from __future__ import annotations

from typing import Any

from ....frame.frame import Frame
from ....gpu.device import Device
from ....scene.lights import ParticleLights
from ..emitted import KINDS, EmittedInjection, EmittedLights
from ..injection import Injection
from .cascades import Cascades


class EmittedLight:
    """Nothing is made before there is such light. everything: not particles alone."""

    def __init__(self, device: Device, cascades: Cascades, everything: bool):
        self.device, self.cascades, self._everything = device, cascades, everything
        self._lights: EmittedLights | None = None
        self._injection: EmittedInjection | None = None

    def run(self, stage: Any, frame: Frame, injection: Injection) -> None:
        """Add the light to what `injection` has injected."""
        particles = any(isinstance(light, ParticleLights) for light in frame.scene.lights)
        if not (particles or self._everything):
            return
        if self._lights is None or self._injection is None:
            self._lights = EmittedLights(self.device, KINDS if self._everything else ("particles",))
            self._injection = EmittedInjection(
                self.device, self.cascades.n, grids=self.cascades.count,
                moments=injection.moments is not None,
            )
        self._lights.sync(frame, self.cascades.grids)
        self._injection.run(
            stage, self.cascades.grids_buffer, self._lights, injection.injected, injection.peak, injection.moments
        )
