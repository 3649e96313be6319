"""Injection of light into voxels of level 0: VPLs of all lights, in fixed point (VCT 5.5)."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ....frame.frame import Frame
from ....frame.structs import VPL
from ....frame.vpl_sources import NO_SOURCES, SOURCE, SourceGroup, group_sources, vpl_sources
from ....gpu.bindings import atomic_words, storage, storage_rw, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.limits import DEFAULT_LIMITS
from ....gpu.passes import ComputePass
from ....gpu.records import records
from ..bricks.update_list import UpdateList
from ..octree.pools import OWN, ROW, WORKGROUP, Pool, threads
from ..voxels.structure import VoxelOctree
from ..voxels.voxeliser import CUBE

# Of level 0 the first brick and how many. group: of lights, its number; last: 1 for the last.  to_light: from its sums
# to `light`; to_moment: and to its moments.  before: bricks of level 0 before the first.
INJECTED = Struct(
    "Injected", to_light="vec3f", first="u32", count="u32", group="u32", last="u32", before="u32", to_moment="f32"
)
_SUMS = 12 * OWN  # bytes of a brick
_BUFFER = DEFAULT_LIMITS["max-storage-buffer-binding-size"]
_ROUND = (64 << 20) // _SUMS  # bricks at a time
_LABEL = "voxel light"


class Injection:
    """Writes what voxels of level 0 send (bricks.py, `light`), and touches the nodes where that is other than before.

    other: the octree of what moves beside that of what is static, or the latter beside the former. A VPL's light lands
    in the one that has the voxel: that of what moves where it has all of it (structure.py).

    Light is deterministic: the same VPLs bring the same bits, in whatever order they are added. Where there are too
    many voxels for one buffer of sums, these are made in rounds.

    fresh: u32 of the voxels of level 0, what the VPLs bring them.
    """

    def __init__(self, device: Device, octree: VoxelOctree, other: VoxelOctree | None = None):
        self.device, self.octree, self._other = device, octree, other
        self._part = "static_" if octree.static else "moving_"
        self.unit = 0.0
        """Nits: what `light` is a share of; a power of two, so that it stays the same while lights move."""
        self._sums = Pool("bricks of level 0", lambda count: device.buffer(_LABEL, size=_SUMS * count), limit=_ROUND)
        self.fresh = Pool(
            "bricks of level 0", lambda count: device.buffer(_LABEL, size=4 * OWN * count), limit=_BUFFER // (4 * OWN)
        )
        group = uniform("injected", INJECTED)
        fixed: dict[str, Any] = {"workgroup": WORKGROUP, "row": ROW, "pi": pi}
        kept = octree.bricks.representation
        leaves = [*octree.leaf_bindings, *(octree.other_leaf_bindings(self._part) if other else ())]
        self._inject = ComputePass(
            device, "inject", kept.file("inject"),
            [uniform("source", SOURCE), group, *leaves, records("vpls", VPL), storage("facing", "vec2u"),
             storage("ways", "u32"), atomic_words("sums", "u32"), *kept.bindings],
            structs=[SOURCE, INJECTED, CUBE, VPL, *kept.structs],
            **{**fixed, **octree.leaf_values, "parts": ("", self._part) if other else ("",)},
        )  # fmt: skip
        self._collect = ComputePass(
            device, "collect", kept.file("collect"),
            [group, storage_rw("sums", "u32"), storage_rw("fresh", "u32"), storage("owners", "u32"),
             storage_rw("light", "u32"), *UpdateList.touching],
            structs=[INJECTED], **fixed,
        )  # fmt: skip

    def run(self, stage: Any, frame: Frame) -> bool:
        """Inject the VPLs of the frame's lights. Returns whether all light is to be filtered anew, as the unit has
        changed; else what is touched."""
        groups = group_sources(vpl_sources(frame)) or [NO_SOURCES]
        changed = self._choose_unit(frame.lights.total_flux)
        first, count = self.octree.bricks.levels[0]
        self.fresh.need(count)
        if self._sums.need(min(count, _ROUND)):
            stage.encoder.clear_buffer(self._sums.resource)
        for before in range(0, count, _ROUND):
            where = {"first": first + before, "count": min(_ROUND, count - before), "before": before}
            for number, lights in enumerate(groups):
                self._inject_group(stage, frame, lights, group=number, last=number == len(groups) - 1, **where)
        return changed

    def _choose_unit(self, total_flux: np.ndarray) -> bool:
        """What a voxel would send that all flux, (lights, 3), fell into; returns whether it is other than before."""
        sent = self.octree.bricks.representation.most * float(total_flux.sum(axis=0).max(initial=0.0))
        most = sent / (pi * self.octree.grid.cell_size**2)
        unit = float(2.0 ** np.ceil(np.log2(most))) if most > 0.0 else 1.0
        changed, self.unit = unit != self.unit, unit
        return changed

    def _inject_group(self, stage: Any, frame: Frame, lights: SourceGroup, **values: int) -> None:
        packed, scale = lights.pack(), 1.0 / (self.octree.grid.cell_size**2 * self.unit)
        to_light = packed[0]["to_intensity"][0] * scale if packed else (0.0,) * 3
        to_moment = 2.0 / 3.0 / packed[0]["moment_scale"][0] * scale if packed else 0.0  # 2, 3: lobes/inject.wgsl
        injected = self.device.uniform(_LABEL, INJECTED.pack(to_light=to_light, to_moment=to_moment, **values))
        kept = self.octree.bricks.representation
        leaves = {
            **self.octree.leaf_resources(), **(self._other.leaf_resources(self._part) if self._other else {})
        }  # fmt: skip
        for source in packed:
            self._inject.run(
                stage, threads(int(source["count"][0])), source=self.device.uniform(_LABEL, source),
                injected=injected, vpls=frame.vpls, sums=self._sums.resource, **leaves,
                **self._of_bricks("facing", "ways"),
                **kept.resources(self.device, frame, int(source["first"][0])),
            )  # fmt: skip
        self._collect.run(
            stage, threads(OWN * values["count"]), injected=injected, sums=self._sums.resource,
            fresh=self.fresh.resource, **self._of_bricks("owners", "light"),
            **self.octree.filtering.updates.resources,
        )  # fmt: skip

    def _of_bricks(self, *names: str) -> dict[str, Any]:
        return {name: getattr(self.octree.bricks, name).resource for name in names}
