"""The geometry volume's octree on the device (simulator/lpv/geometry.py): surfels of RSMs and of the G-buffer."""

from __future__ import annotations

from typing import Any

from ...frame.frame import Frame
from ...frame.structs import VIEW, VPL, views_binding
from ...gpu.bindings import storage, storage_rw, texture, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.passes import ComputePass
from ...simulator.lpv.geometry import BEHIND
from ...simulator.rsm import MIN_COSINE
from .constants import GRID
from .downsampling import Downsampling
from .injection import RUN, atomic_words, walks
from .levels import ROW, Levels

# Surfels from number `first` on, in rows of `width`. block: pixels along each side of one's block of the G-buffer.
SURFELS = Struct("Surfels", first="u32", count="u32", width="u32", block="u32")
# Shares are summed in fixed point, so that they have the same bits in any order: 2^16 is a wall. A cell that has as
# much
# takes no more, so that no sum comes near 2^32.
_ONE = 1 << 16
_GBUFFER_SAMPLES = 256  # surfels along the longer side of the picture: as many as an RSM has


class GeometryVolume:
    """`shares`: vec4f [level][z][y][x]: of the cell's cross section, what is blocked along x, y and z. `packed`: the
    same in the bytes of a word, for those who read many, after `pack`.

    coarsest level as in `levels`. camera: the G-buffer's surfaces count besides those that lights see.
    """

    def __init__(self, device: Device, levels: Levels, camera: bool = True):
        self.device, self.n, self._camera = device, levels.sizes[0], camera
        self.shares = device.buffer("LPV geometry volume", size=levels.cells * 16)
        self.packed = device.buffer("LPV geometry volume", size=levels.cells * 4)
        self._sums = device.buffer("LPV surfel sums", size=self.n**3 * 12)
        self._surfels: list[Any] = []
        grid, sums = uniform("grid", GRID), atomic_words("sums", "u32")
        values: dict[str, Any] = {
            "one": _ONE, "cells": self.n**3, "min_cosine": MIN_COSINE, "run": RUN, "behind": BEHIND,
        }  # fmt: skip
        self._from_vpls = ComputePass(
            device, "surfels of an RSM", "techniques/lpv/surfels_rsm.wgsl",
            [uniform("surfels", SURFELS), grid, storage("vpls", VPL), sums],
            structs=[SURFELS, GRID, VPL], workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        self._from_gbuffer = ComputePass(
            device, "surfels of the G-buffer", "techniques/lpv/surfels_gbuffer.wgsl",
            [views_binding(), texture("surface_map", "uint"), texture("depth_map"), uniform("surfels", SURFELS), grid,
             sums],
            structs=[VIEW, SURFELS, GRID], workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        self._merge = ComputePass(
            device, "merge surfels", "techniques/lpv/surfels_merge.wgsl",
            [storage_rw("sums", "u32"), storage_rw("shares", "vec4f")], workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        self._pack = ComputePass(
            device, "pack shares", "techniques/lpv/pack_shares.wgsl",
            [storage("shares", "vec4f"), storage_rw("packed", "u32", "write")], workgroup=(64, 1, 1), row=ROW,
            cells=levels.cells,
        )  # fmt: skip
        self._rows = levels.rows
        self._downsampling = Downsampling(device, levels, per_cell=1, factor=0.25, limit=1.0)

    def run(self, stage: Any, frame: Frame, grid: Any) -> None:
        """From the RSM of each lamp, each merged by maximum (CLPV 3.2), and the G-buffer. The many coarse maps of the
        sky and of glowing surfaces are left out: they would cost more than they add."""
        stage.encoder.clear_buffer(self.shares, 0, self.n**3 * 16)  # coarser levels are written over
        lamps = frame.vpl_ranges[: frame.lights.lamps]
        while len(self._surfels) < len(lamps) + 1:
            self._surfels.append(self.device.uniform("LPV surfels", SURFELS.array(1)))
        for (first, count), width, buffer in zip(lamps, frame.vpl_widths, self._surfels, strict=False):
            self.device.write(buffer, SURFELS.pack(first=first, count=count, width=width, block=1))
            threads = (walks(count, width),)
            self._from_vpls.run(stage, threads, surfels=buffer, grid=grid, vpls=frame.vpls, sums=self._sums)
            self._merged(stage)
        if self._camera:
            self._camera_surfels(stage, frame, grid, self._surfels[-1])
        self._downsampling.run(stage, self.shares)

    def pack(self, stage: Any) -> None:
        """Make `packed` of the shares."""
        self._pack.run(stage, self._rows, shares=self.shares, packed=self.packed)

    def _camera_surfels(self, stage: Any, frame: Frame, grid: Any, buffer: Any) -> None:
        block = max(1, -(-max(frame.pixels) // _GBUFFER_SAMPLES))
        width, height = (-(-side // block) for side in frame.pixels)
        self.device.write(buffer, SURFELS.pack(first=0, count=width * height, width=width, block=block))
        self._from_gbuffer.run(
            stage, (walks(width * height, width),), views=frame.buffers["views"], surface_map=frame.targets.surface,
            depth_map=frame.targets.depth, surfels=buffer, grid=grid, sums=self._sums,
        )  # fmt: skip
        self._merged(stage)

    def _merged(self, stage: Any) -> None:
        self._merge.run(stage, (self.n**3,), sums=self._sums, shares=self.shares)
