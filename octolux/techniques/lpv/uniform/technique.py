"""`uniform-lpv`: one volume of n^3 cells around the scene (CLPV 3; the baseline of OLPV)."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ....frame.frame import Frame
from ....gpu.device import Device
from ....scene.lights import DirectionalLight
from ....simulator.grid import Grid
from ...technique import Technique
from ..constants import GRID, pack_grid, storage_scale
from ..injection import Injection, VplSource
from ..lookup import Lookup
from ..propagation import Propagation
from .settings import UniformLpvSettings


class UniformLpv(Technique):
    """One bounce of diffuse light, everything made anew each frame."""

    name, summary = "uniform-lpv", "one bounce of diffuse light through a uniform light propagation volume"
    settings_class = UniformLpvSettings
    label = "LPV"
    needs = frozenset({"rsm"})
    supports = frozenset({"dynamic geometry", "dynamic lights", "diffuse"})
    settings: UniformLpvSettings

    def __init__(self, device: Device, settings: UniformLpvSettings):
        super().__init__(device, settings)
        s = settings
        self.injection = Injection(device, s.n)
        self.propagation = Propagation(
            device, [s.n], evaluation=s.evaluation, reprojection=s.reprojection, gain=s.gain, cell_format=s.cell_format
        )
        self.lookup = Lookup(
            device, s.n, reading=s.reading, damping=s.damping, lookup_offset=s.lookup_offset, scale=s.scale
        )
        self._grid_buffer = device.uniform("LPV grid", GRID.array(1))
        self.grid: Grid | None = None

    def prepare(self, frame: Frame) -> None:
        self.lookup.prepare(frame.pixels)
        low, high = frame.world_box
        if not np.any(high > low):  # an empty scene: any box will do
            high = low + 1.0
        self.grid = Grid.around(low, high, self.settings.n)
        self.device.write(self._grid_buffer, pack_grid(self.grid))
        frame.irradiance = self.lookup.irradiance

    def update(self, frame: Frame) -> None:
        with frame.profiler.stage("injection") as stage:
            self.injection.run(stage, self._grid_buffer, frame.vpls, self._sources(frame))
        with frame.profiler.stage("propagation") as stage:
            self.propagation.run(stage, self.injection.injected, self.injection.peak, self.settings.iterations)
        with frame.profiler.stage("volumes") as stage:
            self.lookup.write_volumes(stage, self.propagation.light)

    def _sources(self, frame: Frame) -> list[VplSource]:
        ranges = zip(frame.vpl_ranges, frame.lights.total_flux, strict=True)
        return [
            VplSource(first, count, flux, self._intensity_per_flux(frame, index))
            for index, ((first, count), flux) in enumerate(ranges)
        ]

    def _intensity_per_flux(self, frame: Frame, index: int) -> float:
        """1/pi; in the thesis 1. There a directional light's flux is I A w with the texel weight w = texel area over
        cell area (OLPV 3.2.2): ours holds I A times the texel's area, so 1 / cell area is left."""
        if self.settings.injection == "flux":
            return 1.0 / pi
        assert self.grid is not None
        directional = isinstance(frame.lights.lights[index], DirectionalLight)
        return 1.0 / self.grid.cell_size**2 if directional else 1.0

    def shade(self, frame: Frame) -> None:
        with frame.profiler.stage("lookup") as stage:
            self.lookup.read(stage, frame, self._grid_buffer, self.injection.peak)

    def debug_views(self) -> dict[str, Any]:
        """"injected" and "accumulated": float32 [z][y][x][rgb][4], W/sr."""
        n = self.settings.n

        def read(buffer: Any) -> np.ndarray:
            return np.frombuffer(self.device.queue.read_buffer(buffer), np.float32).reshape(n, n, n, 3, 4)

        scale = storage_scale(np.frombuffer(self.device.queue.read_buffer(self.injection.peak), np.float32)[0])
        return {"injected": read(self.injection.injected), "accumulated": read(self.propagation.light) / scale}
