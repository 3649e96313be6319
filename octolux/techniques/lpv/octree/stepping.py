"""Light by steps: all levels of the octree are downsampled, propagated and merged into one volume (OLPV 4.2)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....gpu.bindings import Binding, storage, storage_rw, storage_texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.lpv.octree import reading_factor
from ..constants import storage_scale
from ..levels import Levels
from ..lookup import CHANNELS, Lookup
from ..propagation import Propagation
from .settings import OctreeLpvSettings


class Stepping:
    """`lookup` reads the merged volume. Stages are named as the rows of OLPV's table 1."""

    def __init__(self, device: Device, levels: Levels, settings: OctreeLpvSettings):
        s = settings
        self.levels, self._settings, self._device = levels, s, device
        self.propagation = Propagation(
            device, levels.sizes, evaluation=s.evaluation, reprojection=s.reprojection, gain=s.gain,
            cell_format=s.cell_format, threshold=s.threshold if s.merge == "index" else None, occlusion=s.occlusion,
            keeps_last=s.merge == "arrival",
        )  # fmt: skip
        self.lookup = Lookup(
            device, s.n, reading=s.reading, damping=False, lookup_offset=s.lookup_offset, scale=s.scale
        )
        self._ratio = reading_factor(1, s.combine)
        outputs = [storage_texture(f"{c}_out", "rgba16float", "3d") for c in CHANNELS]
        if s.merge == "index":
            self._merge = ComputePass(
                device, "merge", "techniques/lpv/octree/merge.wgsl",
                [storage("light", "vec4f"), storage("touched", "u32"), *outputs], workgroup=(8, 4, 2), n=s.n,
                levels=len(levels.sizes), ratio=self._ratio,
            )  # fmt: skip
        else:
            self._merged = device.buffer("LPV merged light", size=max(48, (levels.cells - s.n**3) * 48))
            self._merges = [self._level_pass(device, i, outputs) for i in range(len(levels.sizes) - 1)]

    def _level_pass(self, device: Device, level: int, outputs: list[Binding]) -> ComputePass:
        last = level == len(self.levels.sizes) - 2
        buffers = [storage("light", "vec4f"), storage("cells_in", self.propagation.kind)]
        if level or not last:
            buffers.append(storage_rw("merged", "vec4f"))
        return ComputePass(
            device, "merge", "techniques/lpv/octree/merge_level.wgsl", buffers + (outputs if level == 0 else []),
            workgroup=(4, 4, 4), level=level, last=last, edge=self.levels.sizes[level], n=self._settings.n,
            factor=self._ratio**level, ratio=self._ratio, **self.propagation.values,
        )  # fmt: skip

    def run(self, profiler: Any, injected: Any, peak: Any, shares: Any = None) -> None:
        """From `injected` (W/sr, all levels) to the volumes that the lookup filters."""
        with profiler.stage("propagation") as stage:
            self.propagation.run(stage, injected, peak, self._settings.iterations, shares)
        with profiler.stage("merge") as stage:
            volumes = {f"{c}_out": self.lookup.volumes[c] for c in CHANNELS}
            if self._settings.merge == "index":
                self._merge.run(
                    stage, (self._settings.n,) * 3, light=self.propagation.light, touched=self.propagation.touched,
                    **volumes,
                )  # fmt: skip
            else:
                self._merge_levels(stage, volumes)

    def _merge_levels(self, stage: Any, volumes: dict[str, Any]) -> None:
        for level in reversed(range(len(self._merges))):
            names = {b.name for b in self._merges[level].own.bindings}
            given = {"light": self.propagation.light, "cells_in": self.propagation.last, "merged": self._merged,
            **volumes}
            edge = self.levels.sizes[level]
            self._merges[level].run(stage, (edge,) * 3, **{k: v for k, v in given.items() if k in names})

    def accumulated(self, peak: float) -> list[np.ndarray]:
        """float32 [z][y][x][rgb][4] on each level, W/sr."""
        flat = np.frombuffer(self._device.queue.read_buffer(self.propagation.light), np.float32)
        return [level / storage_scale(peak) for level in self.levels.split(flat.reshape(-1, 3, 4))]
