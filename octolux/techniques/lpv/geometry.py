"""The geometry volume's octree on the device (simulator/lpv/geometry.py): surfels of RSMs and of the G-buffer."""

from __future__ import annotations

from typing import Any

from ...frame.frame import Frame
from ...frame.structs import VIEW, VPL, views_binding
from ...gpu.bindings import storage, storage_rw, texture, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.limits import DEFAULT_LIMITS
from ...gpu.passes import ComputePass
from ...gpu.records import records
from ...simulator.lpv.geometry import BEHIND
from ...simulator.rsm import MIN_COSINE
from .constants import GRID, grids_binding
from .downsampling import Downsampling
from .injection import RUN, atomic_words, walks
from .levels import ROW, Levels

# Surfels from number `first` on, in rows of `width`. block: pixels along each side of one's block of the G-buffer.
# sums: number of the first cell of this buffer's sums.
SURFELS = Struct("Surfels", first="u32", count="u32", width="u32", block="u32", sums="u32")
# Shares are summed in fixed point, so that they have the same bits in any order: 2^16 is a wall. A cell that has as
# much takes no more, so that no sum comes near 2^32.
_ONE = 1 << 16
_AT_ONCE = 4  # buffers that have sums of their own, if they fit in one binding
_GBUFFER_SAMPLES = 256  # surfels along the longer side of the picture: as many as an RSM has


class GeometryVolume:
    """`shares`: vec4f [level][z][y][x]: of the cell's cross section, what is blocked along x, y and z. `packed`: the
    same in the bytes of a word, for those who read many, after `pack`.

    coarsest level as in `levels`. camera: the G-buffer's surfaces count besides those that lights see. `every`: each
    surfel is in every grid that holds it, not in the finest alone, of which the coarser ones are then made.
    """

    def __init__(self, device: Device, levels: Levels, camera: bool = True, *, every: bool = False):
        self.device, self.n, self._camera = device, levels.sizes[0], camera
        self._cells = levels.windows * self.n**3
        self._layers = levels.windows if every else 1
        self._at_once = max(1, min(_AT_ONCE, DEFAULT_LIMITS["max-storage-buffer-binding-size"] // (self._cells * 12)))
        self.shares = device.buffer("LPV geometry volume", size=levels.cells * 16)
        self.packed = device.buffer("LPV geometry volume", size=levels.cells * 4)
        self._sums = device.buffer("LPV surfel sums", size=self._at_once * self._cells * 12)
        self._surfels: list[Any] = []
        grids, sums = grids_binding(levels.windows), atomic_words("sums", "u32")
        values: dict[str, Any] = {
            "one": _ONE, "cells": self._cells, "min_cosine": MIN_COSINE, "run": RUN, "behind": BEHIND,
            "grids": levels.windows, "every": every,
        }  # fmt: skip
        self._from_vpls = ComputePass(
            device, "surfels of an RSM", "techniques/lpv/surfels_rsm.wgsl",
            [uniform("surfels", SURFELS), grids, records("vpls", VPL), sums],
            structs=[SURFELS, GRID, VPL], workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        self._from_gbuffer = ComputePass(
            device, "surfels of the G-buffer", "techniques/lpv/surfels_gbuffer.wgsl",
            [views_binding(), texture("surface_map", "uint"), texture("depth_map"), uniform("surfels", SURFELS), grids,
             sums],
            structs=[VIEW, SURFELS, GRID], workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        self._merge = ComputePass(
            device, "merge surfels", "techniques/lpv/surfels_merge.wgsl",
            [storage_rw("sums", "u32"), storage_rw("shares", "vec4f")], workgroup=(64, 1, 1), at_once=self._at_once,
            **values,
        )  # fmt: skip
        self._pack = ComputePass(
            device, "pack shares", "techniques/lpv/pack_shares.wgsl",
            [storage("shares", "vec4f"), storage_rw("packed", "u32", "write")], workgroup=(64, 1, 1), row=ROW,
            cells=levels.cells,
        )  # fmt: skip
        self._rows = levels.rows
        self._downsampling = None if every else Downsampling(device, levels, per_cell=1, factor=0.25, limit=1.0)

    def run(self, stage: Any, frame: Frame, grids: Any, windows: Any = None) -> None:
        """From the RSM of each lamp, each merged by maximum (CLPV 3.2), and the G-buffer. The many coarse maps of the
        sky and of glowing surfaces are left out: they would cost more than they add. grids: uniform buffer of GRID, one
        for each window; windows: of WINDOW, where there are several."""
        stage.encoder.clear_buffer(self.shares, 0, self._cells * 16)  # coarser levels are written over
        lamps = list(zip(frame.vpl_ranges, frame.vpl_widths, strict=True))[: frame.lights.lamps]
        buffers = [*lamps, None] if self._camera else lamps
        for number, buffer in enumerate(buffers):
            if buffer is None:
                self._camera_surfels(stage, frame, grids, number)
            else:
                (first, count), width = buffer
                surfels = self._surfels_buffer(number, first=first, count=count, width=width, block=1)
                threads = (walks(count, width), self._layers)
                self._from_vpls.run(stage, threads, surfels=surfels, grids=grids, vpls=frame.vpls, sums=self._sums)
            if number % self._at_once == self._at_once - 1 or number == len(buffers) - 1:
                self._merge.run(stage, (self._cells,), sums=self._sums, shares=self.shares)
        if self._downsampling:
            self._downsampling.run(stage, self.shares, windows)

    def pack(self, stage: Any) -> None:
        """Make `packed` of the shares."""
        self._pack.run(stage, self._rows, shares=self.shares, packed=self.packed)

    def _surfels_buffer(self, number: int, **values: int) -> Any:
        """A uniform buffer for each buffer of a frame: all are written before the first pass runs."""
        if number == len(self._surfels):
            self._surfels.append(self.device.uniform("LPV surfels", SURFELS.array(1)))
        self.device.write(self._surfels[number], SURFELS.pack(sums=number % self._at_once * self._cells, **values))
        return self._surfels[number]

    def _camera_surfels(self, stage: Any, frame: Frame, grids: Any, number: int) -> None:
        block = max(1, -(-max(frame.pixels) // _GBUFFER_SAMPLES))
        width, height = (-(-side // block) for side in frame.pixels)
        surfels = self._surfels_buffer(number, first=0, count=width * height, width=width, block=block)
        self._from_gbuffer.run(
            stage, (walks(width * height, width), self._layers), views=frame.buffers["views"],
            surface_map=frame.targets.surface, depth_map=frame.targets.depth, surfels=surfels, grids=grids,
            sums=self._sums,
        )  # fmt: skip
