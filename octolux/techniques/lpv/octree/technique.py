"""`octree-lpv`: a full octree of cells around the scene (OLPV 4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.scene_surfels import SceneSurfels
from ....gpu.device import Device
from ....simulator.lpv.octree import level_sizes
from ...debug_views import DebugViews
from ...technique import Technique
from ..constants import GRID, pack_grid
from ..downsampling import Downsampling
from ..gathering.gathering import Gathering
from ..geometry import GeometryVolume
from ..injection import Injection
from ..levels import Levels
from ..surfels import SAMPLES
from ..volume import injected_sources, scene_grid
from .settings import OctreeLpvSettings
from .sparse import SparseStepping
from .stepping import Stepping


class OctreeLpv(Technique):
    """One bounce of diffuse light, everything made anew each frame."""

    name, summary = "octree-lpv", "one bounce of diffuse light through an octree of cells, with occlusion"
    settings_class = OctreeLpvSettings
    label = "LPV"
    needs = frozenset({"rsm"})
    supports = frozenset({"dynamic geometry", "dynamic lights", "diffuse", "occlusion"})
    settings: OctreeLpvSettings

    def __init__(self, device: Device, settings: OctreeLpvSettings):
        super().__init__(device, settings)
        s = settings
        self.levels = Levels(level_sizes(s.n, s.coarsest))
        self.injection = Injection(device, s.n, cells=self.levels.cells)
        factor = 1.0 if s.combine == "sum" else 0.125
        self.downsampling = Downsampling(device, self.levels, per_cell=3, factor=factor)
        self._grid_buffer = device.uniform("LPV grid", GRID.array(1))
        gathers = s.propagation == "gather"
        camera = s.surfels == "lamps and camera"
        self.geometry = GeometryVolume(device, self.levels, camera, planes=gathers) if s.occlusion else None
        self.scene_surfels = SceneSurfels(device) if s.occlusion and s.surfels == "scene" else None
        self._blocker_grid_buffer = device.uniform("LPV grid", GRID.array(1))
        self.stepping: Stepping | SparseStepping
        if s.propagation == "gather":
            self.gathering = Gathering(
                device, self.levels, occlusion=s.occlusion, lookup_offset=s.lookup_offset, everywhere=s.cells == "all"
            )
        elif s.propagation == "sparse":
            self.stepping = SparseStepping(device, s)
        else:
            self.stepping = Stepping(device, self.levels, s)
        self._irradiance: Any = None

    def prepare(self, frame: Frame) -> None:
        self.grid = scene_grid(frame, self.settings.n)
        self.device.write(self._grid_buffer, pack_grid(self.grid))
        # Steps pass cells' faces, in whose corners the geometry volume's cells then lie (CLPV 3.2); gathering marches.
        aside = 0.5 if self.settings.propagation == "steps" else 0.0
        self.device.write(self._blocker_grid_buffer, pack_grid(self.grid.moved(aside)))
        if self.settings.propagation != "gather":
            self.stepping.lookup.prepare(frame.pixels)
            frame.irradiance = self.stepping.lookup.irradiance
            return
        if self._irradiance is None or self._irradiance.size[:2] != frame.pixels:
            usage = STORAGE | TEXTURE | COPY
            self._irradiance = self.device.texture("LPV irradiance", frame.pixels, "rgba32float", usage=usage)
        frame.irradiance = self._irradiance

    def update(self, frame: Frame) -> None:
        profiler = frame.profiler
        with profiler.stage("injection") as stage:
            sources = injected_sources(frame, self.grid, self.settings.injection)
            self.injection.run(stage, self._grid_buffer, frame.vpls, sources)
        if self.scene_surfels:
            self.scene_surfels.run(frame, np.array(self.grid.origin), self.grid.cell_size / SAMPLES)
        if self.geometry:
            with profiler.stage("geometry volume") as stage:
                self.geometry.run(stage, frame, self._blocker_grid_buffer, scene=self.scene_surfels)
                if self.settings.propagation == "gather":
                    self.geometry.pack(stage)
        with profiler.stage("downsampling") as stage:
            if self.settings.propagation == "gather":
                self.gathering.forget(stage)
                self.gathering.update(stage, self.injection.injected)
            else:
                self.downsampling.run(stage, self.injection.injected)
        if self.settings.propagation != "gather":
            shares = [self.geometry.shares] if self.geometry else []
            self.stepping.run(profiler, self.injection.injected, self.injection.peak, *shares)

    def shade(self, frame: Frame) -> None:
        peak = self.injection.peak
        if self.settings.propagation != "gather":
            with frame.profiler.stage("lookup") as stage:
                self.stepping.lookup.read(stage, frame, self._grid_buffer, peak)
            return
        with frame.profiler.stage("propagation") as stage:
            shares = self.geometry.packed if self.geometry else None
            self.gathering.mark(stage, frame, self._grid_buffer)
            self.gathering.gather(stage, peak, shares)
        with frame.profiler.stage("lookup") as stage:
            self.gathering.read(stage, frame, self._grid_buffer, peak, self._irradiance)

    def debug_views(self) -> DebugViews:
        """"injected", and after steps "accumulated": a list of float32 [z][y][x][rgb][4], W/sr, one for each level;
        "blocked": the same of [z][y][x][3], shares of the cross section."""
        views: dict[str, Any] = {"injected": lambda: self._read(self.injection.injected, (3, 4))}
        if self.settings.propagation != "gather":
            views["accumulated"] = self._accumulated
        if self.geometry:
            views["blocked"] = self.geometry.blocked
        return DebugViews(views)

    def _accumulated(self) -> list[np.ndarray]:
        peak = np.frombuffer(self.device.queue.read_buffer(self.injection.peak), np.float32)[0]
        return self.stepping.accumulated(peak)

    def _read(self, buffer: Any, cell: tuple[int, ...]) -> list[np.ndarray]:
        return self.levels.split(np.frombuffer(self.device.queue.read_buffer(buffer), np.float32).reshape(-1, *cell))
