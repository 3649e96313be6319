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
    grids: nested ones, the finest first, each of n^3 cells. A VPL goes into each that holds it: what a grid has
    does not depend on where the others lie.
    moments: besides, where in its cells the light's surfaces lie: `moments`, vec4f [grid][z][y][x], the sum over all
    VPLs of band 0 of all channels times the place of the surface, in cells from the cell's middle.
    small_objects: of those below the size of a cell, "keep" all light; "fade" it, or that of those that move: "fade
    moving" (CLPV 4.1, 4.2; simulator/lpv/injection.py).
    """

    def __init__(
        self, device: Device, n: int, cells: int | None = None, *, grids: int = 1,
        small_objects: str = "keep", moments: bool = False,
    ):  # fmt: skip
        self.device, self.n, self._fades = device, n, small_objects != "keep"
        self._cells, self._layers = grids * n**3, grids
        self.injected = device.buffer("LPV injected light", size=(cells or self._cells) * 48)
        self.peak = device.buffer("LPV peak", size=4)
        self.moments = device.buffer("LPV injected moments", size=self._cells * 16) if moments else None
        self._sums = device.buffer("LPV fixed-point sums", size=self._cells * (64 if moments else 48))
        self._sources: list[Any] = []
        source = uniform("source", SOURCE)
        self._inject = ComputePass(
            device, "inject", "techniques/lpv/inject.wgsl",
            [source, grids_binding(grids), records("vpls", VPL), atomic_words("sums", "i32"),
             *([words("surfaces")] if self._fades else [])],
            structs=[SOURCE, GRID, VPL, *([INSTANCE] if self._fades else [])], workgroup=(64, 1, 1), run=RUN,
            grids=grids, small_objects=small_objects, moments=moments, **SH_CONSTANTS, **TRAIT_VALUES,
        )  # fmt: skip
        self._collect = ComputePass(
            device, "collect", "techniques/lpv/collect.wgsl",
            [source, storage_rw("sums", "vec4i"), storage_rw("injected", "vec4f"), atomic_words("peak", "u32"),
             *([storage_rw("moments", "vec4f")] if moments else [])],
            structs=[SOURCE], workgroup=(64, 1, 1), moments=moments,
        )  # fmt: skip

    def run(self, stage: Any, grids: Any, vpls: Any, sources: Sequence[VplSource], surfaces: Any = None) -> None:
        """Inject every source into cleared cells. grids: uniform buffer of GRID, one for each. surfaces: texture of the
        traits of each VPL's surface (frame/traits.py), where small objects fade."""
        traits = {"surfaces": surfaces} if self._fades else {}
        stage.encoder.clear_buffer(self.injected, 0, self._cells * 48)  # coarser levels are written over
        stage.encoder.clear_buffer(self.peak)
        placed = {}
        if self.moments is not None:
            stage.encoder.clear_buffer(self.moments)
            placed["moments"] = self.moments
        used = 0
        for group in group_sources(sources):
            for packed in group.pack():
                buffer = self._source_buffer(used, packed)
                used += 1
                threads = (walks(int(packed["count"][0]), int(packed["width"][0])), self._layers)
                self._inject.run(stage, threads, source=buffer, grids=grids, vpls=vpls, sums=self._sums, **traits)
            self._collect.run(
                stage, (self._cells,), source=buffer, sums=self._sums, injected=self.injected, peak=self.peak, **placed
            )

    def _source_buffer(self, number: int, packed: Any) -> Any:
        """A uniform buffer for each dispatch of a frame: all are written before the first of them runs."""
        if number == len(self._sources):
            self._sources.append(self.device.uniform("LPV sources", SOURCE.array(1)))
        self.device.write(self._sources[number], packed)
        return self._sources[number]
