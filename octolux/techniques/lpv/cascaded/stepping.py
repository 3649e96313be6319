"""Light by steps in every cascade alone, all cascades in the same dispatches (CLPV 3 and 4.1)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....frame.frame import Frame
from ....gpu.device import Device
from ....simulator.lpv.geometry import BEHIND
from ...debug_views import DebugViews
from ..constants import GRID, pack_grids, storage_scale
from ..geometry import GeometryVolume
from ..glossy.glossy import PAPER_CELLS, PaperGlossy
from ..injection import Injection
from ..levels import Levels
from ..lookup import Lookup
from ..propagation import Propagation
from ..reflectors import Reflectors
from ..volume import injected_sources
from .cascades import Cascades
from .emitted_light import EmittedLight
from .settings import CascadedLpvSettings
from .surfaces import Surfaces

# Cells by which the geometry volume lies aside, so that its cells lie in the corners of the faces that light passes
# (CLPV 3.2).
_ASIDE = 0.5


class CascadedStepping:
    """VPLs and surfels go into every cascade that holds them; cascades share one storage scale, that of the largest
    light in any. `irradiance` holds what the camera sees lit after `shade`."""

    def __init__(self, device: Device, cascades: Cascades, settings: CascadedLpvSettings):
        self.device, self.cascades, self.settings = device, cascades, settings
        s, camera = settings, settings.surfels == "lamps and camera"
        self.levels = Levels([s.n] * s.cascades, s.cascades)
        self.injection = Injection(device, s.n, grids=s.cascades, small_objects=s.small_objects)
        self.emitted = EmittedLight(device, cascades, s.soft_light == "cells")
        blocks, reflects = s.occlusion, s.bounces > 1
        self.geometry = GeometryVolume(device, self.levels, camera, planes=False) if blocks else None
        self.reflectors = Reflectors(device, self.levels, -BEHIND, camera) if reflects else None
        self.surfaces = Surfaces(
            device, s.surfels, self.geometry, self.reflectors, keep=s.keep_surfels, aside=_ASIDE
        )
        self.propagation = Propagation(
            device, self.levels.sizes, evaluation=s.evaluation, reprojection=s.reprojection, gain=s.gain,
            cell_format=s.cell_format, occlusion=blocks, bounces=s.reflection if reflects else "none",
        )  # fmt: skip
        self.lookup = Lookup(
            device, s.n, reading=s.reading, damping=s.damping, lookup_offset=s.lookup_offset, windows=s.cascades,
            visibility=s.ambient_occlusion,
        )  # fmt: skip
        self.ambient = cascades.ambient_occlusion(s.lookup_offset) if s.ambient_occlusion else None
        self.glossy = PaperGlossy(
            device, self.levels, lookup_offset=s.lookup_offset, cells=s.glossy_cells or PAPER_CELLS
        ) if s.glossy else None
        self._aside_buffer = device.uniform("LPV grids", GRID.array(s.cascades))

    @property
    def irradiance(self) -> Any:
        return self.lookup.irradiance

    def prepare(self, frame: Frame) -> None:
        if self.glossy:
            self.glossy.prepare(frame)
        self.lookup.prepare(frame.pixels)
        self.device.write(self._aside_buffer, pack_grids([grid.moved(_ASIDE) for grid in self.cascades.grids]))

    def update(self, frame: Frame) -> None:
        profiler, grids = frame.profiler, self.cascades.grids
        with profiler.stage("injection") as stage:
            sources = injected_sources(frame, grids[-1], self.settings.injection)
            self.injection.run(stage, self.cascades.grids_buffer, frame.vpls, sources, frame.vpl_surfaces)
            self.emitted.run(stage, frame, self.injection)
        self.surfaces.update(frame, grids, self._aside_buffer)
        with profiler.stage("propagation") as stage:
            self.propagation.run(
                stage, self.injection.injected, self.injection.peak, self.settings.iterations,
                self.geometry.shares if self.geometry else None,
                self.reflectors.reflectors if self.reflectors else None,
            )  # fmt: skip
        with profiler.stage("volumes") as stage:
            self.lookup.write_volumes(stage, self.propagation.light)
        if frame.medium:
            frame.volume_light = self.lookup.volume_light(*self._placed)

    def shade(self, frame: Frame) -> None:
        visibility = None
        if self.ambient:
            with frame.profiler.stage("ambient occlusion") as stage:
                grids, _, windows = self._placed
                visibility = self.ambient.run(stage, frame, grids=grids, windows=windows)
        with frame.profiler.stage("lookup") as stage:
            self.lookup.read(stage, frame, *self._placed, visibility)
        if self.glossy:
            with frame.profiler.stage("glossy") as stage:
                grids, peak, windows = self._placed
                self.glossy.run(stage, frame, grids, peak, self.lookup.volumes, windows)

    @property
    def specular(self) -> Any:
        """What glossy surfaces reflect, or None."""
        return self.glossy.specular if self.glossy else None

    @property
    def _placed(self) -> tuple[Any, Any, Any]:
        return self.cascades.grids_buffer, self.injection.peak, self.cascades.windows_buffer

    def debug_views(self) -> DebugViews:
        """"injected" and "accumulated": a list of float32 [z][y][x][rgb][4], W/sr, one for each cascade; "blocked": the
        same of [z][y][x][3], shares of the cross section, half a cell aside."""
        views: dict[str, Any] = {
            "injected": lambda: self._read(self.injection.injected, (3, 4)), "accumulated": self._accumulated,
        }  # fmt: skip
        if self.geometry:
            views["blocked"] = self.geometry.blocked
        return DebugViews(views)

    def _accumulated(self) -> list[np.ndarray]:
        scale = storage_scale(np.frombuffer(self.device.queue.read_buffer(self.injection.peak), np.float32)[0])
        return [level / scale for level in self._read(self.propagation.light, (3, 4))]

    def _read(self, buffer: Any, cell: tuple[int, ...]) -> list[np.ndarray]:
        return self.levels.split(np.frombuffer(self.device.queue.read_buffer(buffer), np.float32).reshape(-1, *cell))
