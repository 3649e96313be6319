"""`uniform-lpv`: one volume of n^3 cells around the scene (CLPV 3; the baseline of OLPV)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....frame.frame import Frame
from ....gpu.device import Device
from ...debug_views import DebugViews
from ...technique import Technique
from ..constants import GRID, pack_grid, storage_scale
from ..injection import Injection
from ..lookup import Lookup
from ..propagation import Propagation
from ..volume import injected_sources, scene_grid
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

    def prepare(self, frame: Frame) -> None:
        self.lookup.prepare(frame.pixels)
        self.grid = scene_grid(frame, self.settings.n)
        self.device.write(self._grid_buffer, pack_grid(self.grid))
        frame.irradiance = self.lookup.irradiance

    def update(self, frame: Frame) -> None:
        with frame.profiler.stage("injection") as stage:
            sources = injected_sources(frame, self.grid, self.settings.injection)
            self.injection.run(stage, self._grid_buffer, frame.vpls, sources)
        with frame.profiler.stage("propagation") as stage:
            self.propagation.run(stage, self.injection.injected, self.injection.peak, self.settings.iterations)
        with frame.profiler.stage("volumes") as stage:
            self.lookup.write_volumes(stage, self.propagation.light)
        if frame.medium and self.settings.reading != "thesis":  # whose light has no unit
            frame.volume_light = self.lookup.volume_light(self._grid_buffer, self.injection.peak)

    def shade(self, frame: Frame) -> None:
        with frame.profiler.stage("lookup") as stage:
            self.lookup.read(stage, frame, self._grid_buffer, self.injection.peak)

    def debug_views(self) -> DebugViews:
        """"injected" and "accumulated": float32 [z][y][x][rgb][4], W/sr."""
        n = self.settings.n

        def read(buffer: Any) -> np.ndarray:
            return np.frombuffer(self.device.queue.read_buffer(buffer), np.float32).reshape(n, n, n, 3, 4)

        def accumulated() -> np.ndarray:
            peak = np.frombuffer(self.device.queue.read_buffer(self.injection.peak), np.float32)[0]
            return read(self.propagation.light) / storage_scale(peak)

        return DebugViews({"injected": lambda: read(self.injection.injected), "accumulated": accumulated})
