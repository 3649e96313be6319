"""Particle lights as one list to choose from, by Walker's alias table over their intensities."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...gpu.device import Device
from ...gpu.layout import Struct
from ...scene.lights import ParticleLights
from ...scene.scene import Scene
from ...simulator.environment import LUMINANCE
from .emitters import alias_table

# Number i is taken as often as all others, and then kept with probability `keep`, else exchanged for number `instead`.
PARTICLE = Struct("Particle", position="vec3f", keep="f32", intensity="vec3f", instead="u32")


def particle_list(groups: tuple[ParticleLights, ...]) -> tuple[np.ndarray, float]:
    """All particles as an array of PARTICLE, one element at least; the sum of their luminances, candela."""
    intensities = np.concatenate([np.zeros((0, 3)), *(group.intensities for group in groups)])
    power = intensities @ LUMINANCE
    if not power.sum() > 0:
        return PARTICLE.array(1), 0.0
    rows = PARTICLE.array(len(power))
    rows["position"] = np.concatenate([group.positions for group in groups])
    rows["intensity"] = intensities
    rows["keep"], rows["instead"] = alias_table(power)
    return rows, float(power.sum())


class ParticleTable:
    """The scene's particles on the device. buffer: PARTICLE, `count` of them.  power: sum of luminances, candela."""

    def __init__(self, device: Device):
        self.device = device
        self.buffer: Any = None
        self.count, self.power = 0, 0.0
        self._of: tuple[ParticleLights, ...] | None = None

    def sync(self, scene: Scene) -> None:
        groups = tuple(light for light in scene.lights if isinstance(light, ParticleLights))
        if self._of != groups:
            rows, self.power = particle_list(groups)
            self._of, self.count = groups, len(rows)
            self.buffer = self.device.buffer("path tracer particles", rows)

    @property
    def settings(self) -> dict[str, Any]:
        """Their part of the path tracer's uniforms."""
        return {"particles": self.count, "inverse_particles": 1.0 / self.power if self.power else 0.0}
