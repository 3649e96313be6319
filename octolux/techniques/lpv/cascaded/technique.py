"""`cascaded-lpv`: nested volumes around the camera (Kaplanyan & Dachsbacher 2010)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....gpu.device import Device
from ....simulator.lpv.cascades import grids_of, place_windows
from ....simulator.lpv.octree import level_sizes
from ...technique import Technique
from ..constants import GRID, pack_grids
from ..gathering.gathering import Gathering
from ..geometry import GeometryVolume
from ..injection import Injection
from ..levels import Levels
from ..volume import scene_grid, vpl_sources
from ..windows import WINDOW, pack_windows
from .settings import CascadedLpvSettings


class CascadedLpv(Technique):
    """Light in nested grids, the finest around the camera."""

    name, summary = "cascaded-lpv", "light through nested volumes around the camera, with occlusion"
    settings_class = CascadedLpvSettings
    label = "LPV"
    needs = frozenset({"rsm"})
    supports = frozenset({"dynamic geometry", "dynamic lights", "diffuse", "occlusion"})
    settings: CascadedLpvSettings

    def __init__(self, device: Device, settings: CascadedLpvSettings):
        super().__init__(device, settings)
        s = settings
        self.levels = Levels([s.n] * (s.cascades - 1) + level_sizes(s.n), s.cascades)
        self.injection = Injection(device, s.n, cells=self.levels.cells, grids=s.cascades)
        self.geometry = GeometryVolume(device, self.levels, s.camera_surfels) if s.occlusion else None
        self.gathering = Gathering(
            device, self.levels, occlusion=s.occlusion, lookup_offset=s.lookup_offset, everywhere=False
        )
        self._grids_buffer = device.uniform("LPV grids", GRID.array(s.cascades))
        self._windows_buffer = device.uniform("LPV windows", WINDOW.array(s.cascades))
        self._irradiance: Any = None

    def prepare(self, frame: Frame) -> None:
        s, view = self.settings, frame.views[0]
        volume = scene_grid(frame, s.n)
        self.windows = place_windows(s.n, s.cascades, volume, view.position, view.forward)
        self.grids = grids_of(self.windows, volume)
        self.device.write(self._grids_buffer, pack_grids(self.grids))
        self.device.write(self._windows_buffer, pack_windows(self.windows))
        if self._irradiance is None or self._irradiance.size[:2] != frame.pixels:
            usage = STORAGE | TEXTURE | COPY
            self._irradiance = self.device.texture("LPV irradiance", frame.pixels, "rgba32float", usage=usage)
        frame.irradiance = self._irradiance

    def update(self, frame: Frame) -> None:
        profiler = frame.profiler
        with profiler.stage("injection") as stage:
            sources = vpl_sources(frame, self.grids[-1], self.settings.injection)
            self.injection.run(stage, self._grids_buffer, frame.vpls, sources)
        if self.geometry:
            with profiler.stage("geometry volume") as stage:
                self.geometry.run(stage, frame, self._grids_buffer, self._windows_buffer)
                self.geometry.pack(stage)
        with profiler.stage("downsampling") as stage:
            self.gathering.forget(stage)
            self.gathering.update(stage, self.injection.injected, self._windows_buffer)

    def shade(self, frame: Frame) -> None:
        peak, windows = self.injection.peak, self._windows_buffer
        with frame.profiler.stage("propagation") as stage:
            shares = self.geometry.packed if self.geometry else None
            self.gathering.mark(stage, frame, self._grids_buffer, windows)
            self.gathering.gather(stage, peak, shares, windows)
        with frame.profiler.stage("lookup") as stage:
            self.gathering.read(stage, frame, self._grids_buffer, peak, self._irradiance, windows)

    def debug_views(self) -> dict[str, Any]:
        """"injected": a list of float32 [z][y][x][rgb][4], W/sr, one for each level; "blocked": the same of
        [z][y][x][3], shares of the cross section."""
        views = {"injected": self._read(self.injection.injected, (3, 4))}
        if self.geometry:
            views["blocked"] = [level[..., :3] for level in self._read(self.geometry.shares, (4,))]
        return views

    def _read(self, buffer: Any, cell: tuple[int, ...]) -> list[np.ndarray]:
        return self.levels.split(np.frombuffer(self.device.queue.read_buffer(buffer), np.float32).reshape(-1, *cell))
