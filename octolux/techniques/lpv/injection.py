"""Injection of VPLs into level 0: fixed point per light, then W/sr."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from ...frame.structs import VPL
from ...gpu.bindings import Binding, storage, storage_rw, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.passes import ComputePass
from ...simulator.lpv.injection import fixed_point_scale
from .constants import GRID, SH_CONSTANTS

# count VPLs from number `first` on, dispatched in rows of `row` threads. scale: to fixed point; to_intensity: back.
SOURCE = Struct("Source", scale="vec3f", first="u32", to_intensity="vec3f", count="u32", row="u32")
_ROW = 1 << 14


@dataclass(frozen=True, eq=False)
class VplSource:
    """The VPLs of one light. total_flux: (3,), at least the sum of their flux, lm or W. intensity_per_flux: 1/pi keeps
    the flux (simulator/lpv/injection.py)."""

    first: int
    count: int
    total_flux: np.ndarray
    intensity_per_flux: float = 1.0 / pi

    def pack(self) -> np.ndarray:
        scale = fixed_point_scale(self.total_flux, self.count, self.intensity_per_flux)
        return SOURCE.pack(
            scale=scale * self.intensity_per_flux, first=self.first, to_intensity=1.0 / scale, count=self.count,
            row=min(_ROW, max(1, self.count)),
        )  # fmt: skip


class Injection:
    """Adds lights' VPLs to `injected`: vec4f [z][y][x][rgb], W/sr. `peak` holds its largest band-0 coefficient.

    cells: how many `injected` has room for, if more than n^3 (the coarser levels of an octree follow the finest).
    """

    def __init__(self, device: Device, n: int, cells: int | None = None):
        self.device, self.n = device, n
        cells = n**3 if cells is None else cells
        self.injected = device.buffer("LPV injected light", size=cells * 48)
        self.peak = device.buffer("LPV peak", size=4)
        self._sums = device.buffer("LPV fixed-point sums", size=n**3 * 48)
        self._sources: list[Any] = []
        source, grid = uniform("source", SOURCE), uniform("grid", GRID)
        sums = Binding("sums", "var<storage, read_write> sums: array<atomic<i32>>;", "read_write",
                       {"buffer": {"type": "storage"}})  # fmt: skip
        self._inject = ComputePass(
            device, "inject", "techniques/lpv/inject.wgsl", [source, grid, storage("vpls", VPL), sums],
            structs=[SOURCE, GRID, VPL], workgroup=(64, 1, 1), **SH_CONSTANTS,
        )  # fmt: skip
        peak = Binding("peak", "var<storage, read_write> peak: array<atomic<u32>>;", "read_write",
                       {"buffer": {"type": "storage"}})  # fmt: skip
        self._collect = ComputePass(
            device, "collect", "techniques/lpv/collect.wgsl",
            [source, storage_rw("sums", "i32"), storage_rw("injected", "vec4f"), peak],
            structs=[SOURCE], workgroup=(64, 1, 1),
        )  # fmt: skip

    def run(self, stage: Any, grid: Any, vpls: Any, sources: Sequence[VplSource]) -> None:
        """Inject every source in turn into cleared cells. grid: uniform buffer of GRID."""
        stage.encoder.clear_buffer(self.injected)
        stage.encoder.clear_buffer(self.peak)
        while len(self._sources) < len(sources):
            self._sources.append(self.device.uniform("LPV sources", SOURCE.array(1)))
        for source, buffer in zip(sources, self._sources, strict=False):
            self.device.write(buffer, source.pack())
            rows = -(-source.count // _ROW)
            threads = (min(_ROW, source.count), rows)
            self._inject.run(stage, threads, source=buffer, grid=grid, vpls=vpls, sums=self._sums)
            self._collect.run(
                stage, (self.n**3,), source=buffer, sums=self._sums, injected=self.injected, peak=self.peak
            )
