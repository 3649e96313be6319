"""Light straight from cell to cell, each way in cells that suit its length (octree-lpv's gathering, in cascades)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....gpu.device import Device
from ....simulator.lpv.octree import level_sizes
from ...debug_views import DebugViews
from ..bouncing.bounces import Bounces
from ..gathering.gathering import Gathering
from ..geometry import GeometryVolume
from ..glossy.glossy import Glossy
from ..injection import Injection
from ..levels import Levels
from ..reflectors import Reflectors
from ..volume import injected_sources
from .air import AirLight
from .cascades import Cascades
from .emitted_light import EmittedLight
from .settings import CascadedLpvSettings
from .surfaces import Surfaces


class CascadedGathering:
    """`irradiance` holds what the camera sees lit after `shade`."""

    def __init__(self, device: Device, cascades: Cascades, settings: CascadedLpvSettings):
        self.device, self.cascades, self.settings = device, cascades, settings
        s = settings
        self.levels = Levels([s.n] * (s.cascades - 1) + level_sizes(s.n), s.cascades)
        self.injection = Injection(
            device, s.n, cells=self.levels.cells, grids=s.cascades, small_objects=s.small_objects, moments=True
        )
        self.emitted = EmittedLight(device, cascades, s.soft_light == "cells")
        camera = s.surfels == "lamps and camera"
        self.geometry = GeometryVolume(device, self.levels, camera) if s.occlusion else None
        self.gathering = Gathering(
            device, self.levels, occlusion=s.occlusion, lookup_offset=s.lookup_offset, visibility=s.ambient_occlusion,
            corners=True, placed=True,
        )
        self.reflectors = self.bounces = None
        if s.bounces > 1 or s.glossy:
            self.reflectors = Reflectors(device, self.levels, 0.5, camera, squares=True, places=True)
        self.surfaces = Surfaces(device, s.surfels, self.geometry, self.reflectors, keep=s.keep_surfels)
        if s.bounces > 1:
            self.bounces = Bounces(device, self.levels, s.bounces - 1, occlusion=s.occlusion)
        self.ambient = cascades.ambient_occlusion(s.lookup_offset) if s.ambient_occlusion else None
        self.glossy = None
        if s.glossy:
            self.glossy = Glossy(
                device, self.levels, occlusion=s.occlusion, lookup_offset=s.lookup_offset, cells=s.glossy_cells
            )
        self.air: AirLight | None = None  # made when there is fog
        self.irradiance: Any = None

    def prepare(self, frame: Frame) -> None:
        if self.glossy:
            self.glossy.prepare(frame)
        if self.irradiance is None or self.irradiance.size[:2] != frame.pixels:
            usage = STORAGE | TEXTURE | COPY
            self.irradiance = self.device.texture("LPV irradiance", frame.pixels, "rgba32float", usage=usage)

    def update(self, frame: Frame) -> None:
        profiler, grids = frame.profiler, self.cascades.grids
        grids_buffer, windows = self.cascades.grids_buffer, self.cascades.windows_buffer
        with profiler.stage("injection") as stage:
            sources = injected_sources(frame, grids[-1], self.settings.injection)
            self.injection.run(stage, grids_buffer, frame.vpls, sources, frame.vpl_surfaces)
            self.emitted.run(stage, frame, self.injection)
        self.surfaces.update(frame, grids, grids_buffer)
        with profiler.stage("moments") as stage:
            self.gathering.forget(stage)
            self.gathering.measure(stage, self.injection.injected, windows, self.injection.moments)
        if self.bounces and self.reflectors:
            with profiler.stage("bounces") as stage:
                self.bounces.run(
                    stage, self.injection.injected, self.gathering.moments, self.injection.peak,
                    self.reflectors, self.geometry.packed if self.geometry else None, windows,
                )  # fmt: skip
        with profiler.stage("downsampling") as stage:
            self.gathering.finish(stage, self.injection.injected)
            if self.glossy and self.reflectors:
                self.glossy.update(
                    stage, self.injection.injected, self.injection.peak, self.reflectors.reflectors, windows
                )
        if frame.medium:
            if self.air is None:
                self.air = AirLight(self.device, self.cascades, self.levels, occlusion=self.settings.occlusion)
            with profiler.stage("light in the air") as stage:
                shares = self.geometry.packed if self.geometry else None
                self.air.run(stage, frame, self.injection.injected, self.gathering.moments, self.injection.peak, shares)

    def shade(self, frame: Frame) -> None:
        peak, grids, windows = self.injection.peak, self.cascades.grids_buffer, self.cascades.windows_buffer
        shares = self.geometry.packed if self.geometry else None
        with frame.profiler.stage("propagation") as stage:
            self.gathering.mark(stage, frame, grids, windows, shares)
            self.gathering.gather(stage, peak, shares, windows)
        visibility = None
        if self.ambient:
            with frame.profiler.stage("ambient occlusion") as stage:
                visibility = self.ambient.run(stage, frame, grids=grids, windows=windows)
        with frame.profiler.stage("lookup") as stage:
            self.gathering.read(stage, frame, grids, peak, self.irradiance, windows, visibility, shares)
        if self.glossy:
            with frame.profiler.stage("glossy") as stage:
                self.glossy.run(stage, frame, grids, peak, shares, windows)

    @property
    def specular(self) -> Any:
        """What glossy surfaces reflect, or None."""
        return self.glossy.specular if self.glossy else None

    def debug_views(self) -> DebugViews:
        """"injected": a list of float32 [z][y][x][rgb][4], W/sr, one for each level; "blocked": the same of
        [z][y][x][3], shares of the cross section."""
        views: dict[str, Any] = {"injected": lambda: self._read(self.injection.injected, (3, 4))}
        if self.geometry:
            views["blocked"] = self.geometry.blocked
        return DebugViews(views)

    def _read(self, buffer: Any, cell: tuple[int, ...]) -> list[np.ndarray]:
        return self.levels.split(np.frombuffer(self.device.queue.read_buffer(buffer), np.float32).reshape(-1, *cell))
