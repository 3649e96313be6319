"""The geometry volume's octree on the device (simulator/lpv/geometry.py): surfels of RSMs and of the G-buffer."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...frame.frame import Frame
from ...frame.peeling import LampLayer
from ...frame.scene_surfels import SceneSurfels
from ...frame.structs import VIEW, VPL, views_binding
from ...frame.traits import PIXEL_STRUCTS, TRAIT_VALUES, pixel_bindings, pixel_resources
from ...gpu.bindings import Binding, atomic_words, storage, storage_rw, texture, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.limits import DEFAULT_LIMITS
from ...gpu.passes import ComputePass
from ...gpu.records import records, words
from ...gpu_scene.structs import INSTANCE
from ...simulator.lpv.geometry import BEHIND
from ...simulator.rsm import MIN_COSINE
from .constants import GRID, STRIP_VALUES, grids_binding
from .downsampling import Downsampling
from .injection import RUN, walks
from .keeping import KeptCells
from .levels import ROW, Levels
from .surfels import SurfelBuffer, surfel_buffers

# Surfels from number `first` on, in rows of `width`. block: pixels along each side of one's block of the G-buffer.
# sums: number of the first cell of this buffer's sums.  one: a wall in fixed point.
SURFELS = Struct("Surfels", first="u32", count="u32", width="u32", block="u32", sums="u32", one="f32")
# Shares are summed in fixed point, so that they have the same bits in any order. A cell that has as much as a wall
# takes no more, so that no sum comes near 2^32. Where planes are summed besides, whose mean needs all, sums go on
# beyond 32 bits (surfel.wgsl): as far as 2^_BITS. So a wall has more bits, which small texels near a lamp need.
_ONE, _FINER_ONE, _BITS = 1 << 16, 1 << 24, 42
_PLACES = "offsets", "nexts", "lasts"
_AT_ONCE = 4  # buffers that have sums of their own, if they fit in one binding


def fixed_point_wall(surfels: int, planes: bool) -> int:
    """A wall in fixed point, where a buffer has so many surfels: with planes all of them together, each a wall at most,
    stay below 2^_BITS."""
    return min(_FINER_ONE, 1 << max(0, _BITS - max(1, surfels).bit_length())) if planes else _ONE


class GeometryVolume:
    """`volume`: buffers of vec4f [level][z][y][x], by name. "shares": of the cell's cross section, what is blocked
    along x, y and z. With `planes` instead "fronts" and "backs", the larger of which is blocked, and where both lie in
    the cell, from 0 to 1: "offsets", and "nexts" and "lasts" along the two axes after it; and `packed`: what is
    blocked, and where, in four words, for those who read many, after `pack`.

    coarsest level as in `levels`. camera: the G-buffer's surfaces count besides those that lights see. Each surfel is
    in every window that holds it: what they hold does not depend on where the others lie.
    """

    def __init__(self, device: Device, levels: Levels, camera: bool = True, *, planes: bool = True):
        self.device, self.levels, self.n, self._camera, self.planes = device, levels, levels.sizes[0], camera, planes
        self._cells = levels.windows * self.n**3
        self._windows = levels.windows
        bytes_of_sums = self._cells * (48 if planes else 12)  # more than those beside have
        self._at_once = max(1, min(_AT_ONCE, DEFAULT_LIMITS["max-storage-buffer-binding-size"] // bytes_of_sums))
        self._sides = ("fronts", "backs") if planes else ("shares",)
        self.volume = {
            name: device.buffer("LPV geometry volume", size=levels.cells * 16)
            for name in (*self._sides, *(_PLACES if planes else ()))
        }  # fmt: skip
        self._sums = {"sums": device.buffer("LPV surfel sums", size=self._at_once * bytes_of_sums)}
        if planes:
            beside = self._at_once * self._cells * 32
            self._sums["sums_beside"] = device.buffer("LPV surfel sums", size=beside)
        self._surfels: list[Any] = []
        self._passes: dict[tuple[bool, bool], ComputePass] = {}
        self._values: dict[str, Any] = {
            "cells": self._cells, "min_cosine": MIN_COSINE, "run": RUN, "behind": BEHIND, "grids": levels.windows,
            "planes": planes,
        }  # fmt: skip
        self._merges = {  # by the number of buffers: one is all that the whole scene has, and cheaper
            at_once: ComputePass(
                device, "merge surfels", "techniques/lpv/surfels_merge.wgsl",
                [uniform("surfels", SURFELS), *(storage_rw(name, "u32") for name in self._sums),
                 *self._volume_bindings()],
                structs=[SURFELS], workgroup=(64, 1, 1), at_once=at_once, **self._values,
            ) for at_once in {1, self._at_once}
        }  # fmt: skip
        self._downsampling = None
        self._coarser: list[tuple[int, ComputePass]] = []
        if planes:
            self.packed = device.buffer("LPV geometry volume", size=levels.cells * 16)
            self._make_plane_passes()
        elif levels.windows == 1:
            self._downsampling = Downsampling(device, levels, per_cell=1, factor=0.25, limit=1.0)

    @property
    def shares(self) -> Any:
        """Without planes."""
        return self.volume["shares"]

    def _surfel_pass(self, camera: bool, static_only: bool) -> ComputePass:
        """Surfels of the G-buffer or an RSM. static_only: of what does not move."""
        if (camera, static_only) not in self._passes:
            common = [uniform("surfels", SURFELS), grids_binding(self.levels.windows)]
            common += [atomic_words(name, "u32") for name in self._sums]
            bindings, structs = [*common, records("vpls", VPL)], [SURFELS, GRID, VPL]
            if camera:
                own = pixel_bindings() if static_only else [texture("surface_map", "uint")]
                bindings = [*common, views_binding(), texture("depth_map"), *own]
                structs = [SURFELS, GRID, VIEW, *(PIXEL_STRUCTS if static_only else ())]
            elif static_only:
                bindings, structs = [*bindings, words("surfaces")], [*structs, INSTANCE]
            self._passes[camera, static_only] = ComputePass(
                self.device, f"surfels of {'the G-buffer' if camera else 'an RSM'}",
                f"techniques/lpv/surfels_{'gbuffer' if camera else 'rsm'}.wgsl", bindings, structs=structs,
                workgroup=(64, 1, 1), static_only=static_only, **self._values, **(TRAIT_VALUES if static_only else {}),
            )  # fmt: skip
        return self._passes[camera, static_only]

    def _volume_bindings(self) -> list[Binding]:
        return [storage_rw(name, "vec4f") for name in self.volume]

    def _make_plane_passes(self) -> None:
        levels, device = self.levels, self.device
        for level, n in list(enumerate(levels.sizes[:-1]))[levels.windows - 1 :]:
            made = ComputePass(
                device, "downsample", "techniques/lpv/coarser_planes.wgsl", self._volume_bindings(),
                workgroup=(4, 4, 4), child_n=n, child_first=levels.first(level), parent_first=levels.first(level + 1),
            )  # fmt: skip
            self._coarser.append((n // 2, made))
        self._pack = ComputePass(
            device, "pack strips", "techniques/lpv/pack_strips.wgsl",
            [*(storage(name, "vec4f") for name in self.volume), storage_rw("packed", "vec4u", "write")],
            workgroup=(64, 1, 1), row=ROW, cells=levels.cells, **STRIP_VALUES,
        )  # fmt: skip

    def run(
        self, stage: Any, frame: Frame, grids: Any, scene: SceneSurfels | None = None, kept: KeptCells | None = None
    ) -> None:
        """From the RSM of each lamp, each merged by maximum (CLPV 3.2), and the G-buffer; or from the whole `scene`.
        grids: uniform buffer of GRID, one for each window.  kept: of `keeping`, which has followed the windows: what
        static surfaces have filled in earlier frames, as one buffer more. It takes what they fill in this one."""
        buffers = list(surfel_buffers(frame, self._camera, scene))
        if kept is None:
            for name in self._sides:
                stage.encoder.clear_buffer(self.volume[name], 0, self._cells * 16)  # coarser levels are written over
            self._fill(stage, frame, grids, buffers, self.volume)
        else:
            moving = bool(frame.gpu_scene.is_moving.any())
            self._fill(stage, frame, grids, buffers, kept.volume, static_only=moving)
            kept.copy_to(stage, self.volume)
            if moving:
                self._fill(stage, frame, grids, buffers, self.volume)
        if self._downsampling:
            self._downsampling.run(stage, self.shares)
        for half, each in self._coarser:
            each.run(stage, (half,) * 3, **self.volume)

    def keeping(self) -> KeptCells:
        """For `run`."""
        return KeptCells(self.device, self.levels, dict.fromkeys(self.volume, 1), BEHIND)

    def _fill(
        self, stage: Any, frame: Frame, grids: Any, buffers: Sequence[SurfelBuffer], volume: dict[str, Any],
        static_only: bool = False,
    ) -> None:  # fmt: skip
        """Merge what the buffers have into `volume`, by maximum."""
        one = fixed_point_wall(max((buffer.total for buffer in buffers), default=0), self.planes)
        for number, buffer in enumerate(buffers):
            surfels = self._surfels_buffer(number, one, buffer.where)
            common = {"surfels": surfels, "grids": grids, **self._sums}
            threads = (walks(buffer.count, buffer.width), self._windows)
            for layer in buffer.layers:
                if isinstance(layer, LampLayer):
                    own = {"vpls": layer.vpls, **({"surfaces": layer.surfaces} if static_only else {})}
                else:
                    seen = pixel_resources(frame, layer) if static_only else {"surface_map": layer.surface}
                    own = {"views": frame.buffers["views"], "depth_map": layer.depth, **seen}
                made = self._surfel_pass(not isinstance(layer, LampLayer), static_only)
                made.run(stage, threads, **common, **own)
            last = number % self._at_once
            if last == self._at_once - 1 or number == len(buffers) - 1:
                merge = self._merges[self._at_once if last else 1]
                merge.run(stage, (self._cells,), surfels=surfels, **self._sums, **volume)

    def pack(self, stage: Any) -> None:
        """Make `packed` of the shares and their planes."""
        self._pack.run(stage, self.levels.rows, **self.volume, packed=self.packed)

    def blocked(self) -> list[np.ndarray]:
        """For debug views: float32 [z][y][x][3] of each level, shares of the cross section that are blocked."""
        sides = [self.device.queue.read_buffer(self.volume[name]) for name in self._sides]
        return self.levels.split(np.max([np.frombuffer(s, np.float32).reshape(-1, 4)[:, :3] for s in sides], axis=0))

    def _surfels_buffer(self, number: int, one: int, where: dict[str, int]) -> Any:
        """A uniform buffer for each buffer of a frame: all are written before the first pass runs."""
        if number == len(self._surfels):
            self._surfels.append(self.device.uniform("LPV surfels", SURFELS.array(1)))
        sums = number % self._at_once * self._cells
        self.device.write(self._surfels[number], SURFELS.pack(sums=sums, one=one, **where))
        return self._surfels[number]
