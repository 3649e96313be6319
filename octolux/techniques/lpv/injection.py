"""Injection of VPLs into level 0: fixed point per group of lights, then W/sr."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...frame.structs import VPL
from ...frame.traits import TRAIT_VALUES
from ...frame.vpl_sources import SOURCE, VplSource, group_sources
from ...gpu.bindings import atomic_words, storage_rw, uniform
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from ...gpu.records import records, words
from ...gpu_scene.structs import INSTANCE
from .constants import GRID, SH_CONSTANTS, grids_binding

__all__ = ["Injection", "VplSource"]

RUN = 16  # VPLs that a thread walks over: 262,144 are still 256 workgroups


def walks(count: int, width: int) -> int:
    """Threads that walk over `count` texels of maps that are `width` wide, each down RUN texels of a column."""
    return -(-count // (RUN * width)) * width


class Injection:
    """Adds lights' VPLs to `injected`: vec4f [z][y][x][rgb], W/sr. `peak` holds its largest band-0 coefficient.

    cells: how many `injected` has room for, if more than those of the grids (coarser levels of an octree follow them).
    grids: nested ones, the finest first, each of n^3 cells. A VPL goes into the finest that holds it, or into `every`.
    small_objects: of those below the size of a cell, "keep" all light; "fade" it, or that of those that move: "fade
    moving" (CLPV 4.1, 4.2; simulator/lpv/injection.py).
    """

    def __init__(
        self, device: Device, n: int, cells: int | None = None, *, grids: int = 1, every: bool = False,
        small_objects: str = "keep",
    ):  # fmt: skip
        self.device, self.n, self._fades = device, n, small_objects != "keep"
        self._cells, self._layers = grids * n**3, grids if every else 1
        self.injected = device.buffer("LPV injected light", size=(cells or self._cells) * 48)
        self.peak = device.buffer("LPV peak", size=4)
        self._sums = device.buffer("LPV fixed-point sums", size=self._cells * 48)
        self._sources: list[Any] = []
        source = uniform("source", SOURCE)
        self._inject = ComputePass(
            device, "inject", "techniques/lpv/inject.wgsl",
            [source, grids_binding(grids), records("vpls", VPL), atomic_words("sums", "i32"),
             *([words("surfaces")] if self._fades else [])],
            structs=[SOURCE, GRID, VPL, *([INSTANCE] if self._fades else [])], workgroup=(64, 1, 1), run=RUN,
            grids=grids, every=every, small_objects=small_objects, **SH_CONSTANTS, **TRAIT_VALUES,
        )  # fmt: skip
        self._collect = ComputePass(
            device, "collect", "techniques/lpv/collect.wgsl",
            [source, storage_rw("sums", "vec4i"), storage_rw("injected", "vec4f"), atomic_words("peak", "u32")],
            structs=[SOURCE], workgroup=(64, 1, 1),
        )  # fmt: skip

    def run(self, stage: Any, grids: Any, vpls: Any, sources: Sequence[VplSource], surfaces: Any = None) -> None:
        """Inject every source into cleared cells. grids: uniform buffer of GRID, one for each. surfaces: texture of the
        traits of each VPL's surface (frame/traits.py), where small objects fade."""
        traits = {"surfaces": surfaces} if self._fades else {}
        stage.encoder.clear_buffer(self.injected, 0, self._cells * 48)  # coarser levels are written over
        stage.encoder.clear_buffer(self.peak)
        used = 0
        for group in group_sources(sources):
            for packed in group.pack():
                buffer = self._source_buffer(used, packed)
                used += 1
                threads = (walks(int(packed["count"][0]), int(packed["width"][0])), self._layers)
                self._inject.run(stage, threads, source=buffer, grids=grids, vpls=vpls, sums=self._sums, **traits)
            self._collect.run(
                stage, (self._cells,), source=buffer, sums=self._sums, injected=self.injected, peak=self.peak
            )

    def _source_buffer(self, number: int, packed: Any) -> Any:
        """A uniform buffer for each dispatch of a frame: all are written before the first of them runs."""
        if number == len(self._sources):
            self._sources.append(self.device.uniform("LPV sources", SOURCE.array(1)))
        self.device.write(self._sources[number], packed)
        return self._sources[number]
