"""Filtering of light: from the voxels of level 0 up, and into bricks (VCT 5.4.2, 5.4.3, 5.5)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....gpu.bindings import Binding, storage, storage_rw, storage_texture, texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....gpu.records import records_out, words
from ..octree.octree import directory_binding
from ..octree.pools import OWN, parameters, threads
from .bricks import NODE, PARAMETERS_OF, Bricks
from .update_list import UpdateList

_FOLDER = "techniques/voxel_cones/bricks"
_DARK = float(np.finfo(np.float32).tiny)


class Filtering:
    """Brings `light` that voxels of level 0 send (bricks.py) to all levels and into the bricks that shaders read.

    `everything` does so for all nodes, `touched` for those of level 0 that `updates` names, and what depends on them:
    the same result where nothing else has changed, and neither has the unit. unit: of `light`, nits. An octree of what
    moves is small: all of it is filtered, after that of what is static, whose light it borrows.
    """

    def __init__(self, device: Device, bricks: Bricks):
        self.device, self.bricks, self.updates = device, bricks, UpdateList(device, bricks)
        self._listed = False
        nodes = [PARAMETERS_OF, storage("codes", "u32"), directory_binding()]
        facing, light, light_out = storage("facing", "vec2u"), storage("light", "u32"), storage_rw("light", "u32")
        ways, owners, scales = (storage(name, "u32") for name in ("ways", "owners", "scales"))
        brick_out = [storage_rw("scales", "u32", "write"), storage_texture("bricks", "rgba8unorm", "3d")]
        copied = [*nodes, storage("facing", "u32"), ways, owners, light, *brick_out]  # one word of the two
        record = [PARAMETERS_OF, ways, scales, records_out("nodes", NODE)]
        self._average = self._made("average_light", [*nodes, facing, ways, owners, light_out])
        self._copy = self._made("bricks", copied, listed=False)
        self._surfaces = None
        if bricks.representation.directed:
            self._surfaces = self._made(
                "surfaces", [*nodes, facing, owners, brick_out[1]], folder=bricks.representation.folder
            )
        if bricks.static:
            theirs, their_ways = texture("static_directory", "uint"), storage("static_ways", "u32")
            self._borrow = self._made(
                "borrow_light", [*nodes, owners, words("leaves"), storage_rw("light", "u32", "write"), theirs,
                                 their_ways, storage("static_light", "u32")], parts=bricks.parts,
            )  # fmt: skip
            self._merge = self._made(
                "merge_records", [*record, directory_binding(), storage("shown", "u32"), theirs, their_ways,
                                  storage("static_scales", "u32"), texture("merged_directory", "uint")],
                parts=bricks.parts,
            )  # fmt: skip
        else:
            self._records = self._made("records", record, listed=False)
            listed = [storage("lists", "u32"), storage("update_list", "u32")]
            self._climb = self._made(
                "climb", [*nodes, facing, ways, light_out, *UpdateList.touching, storage_rw("update_list", "u32")]
            )
            self._copy_listed = self._made("bricks", [*copied, *listed], listed=True)
            self._record_listed = self._made("records", [*record, owners, *listed], listed=True)

    def _made(self, file: str, bindings: list[Binding], folder: str = _FOLDER, **values: Any) -> ComputePass:
        reads = [binding.name for binding in bindings if binding.name == "ways"]
        kept = self.bricks.representation
        light = {**{name: kept.file(name) for name in ("coarser_light", "texels")}, "together": kept.together}
        given = {**self.bricks.pass_values, **light, "reads": reads, **values}
        return ComputePass(self.device, file, f"{folder}/{file}.wgsl", bindings, **given)

    def surfaces(self, stage: Any) -> None:
        """Write, after a build, what of bricks no light changes."""
        if self._surfaces:
            bricks, given = self.bricks, self._given(1.0)
            self._surfaces.run(stage, threads(bricks.count), parameters=given, **bricks.of_nodes(),
                               facing=bricks.facing.resource, owners=bricks.owners.resource,
                               bricks=bricks.bricks.resource)  # fmt: skip

    def everything(self, stage: Any, unit: float = 1.0) -> None:
        bricks, self._listed = self.bricks, False
        if bricks.static:
            self._borrow_light(stage)
        for first, count in bricks.levels[1:]:
            self._average.run(
                stage, threads(OWN * count), parameters=parameters(self.device, count, first),
                owners=bricks.owners.resource, **self._of_light(),
            )  # fmt: skip
        self._copy.run(stage, threads(bricks.count), parameters=self._given(unit), **self._of_bricks())
        if bricks.static:
            self._merge_records(stage)
        else:
            count = bricks.octree.counts.nodes
            self._records.run(stage, threads(count), parameters=parameters(self.device, count), **self._of_records())
        self.updates.forget(stage)

    def touched(self, stage: Any, unit: float = 1.0) -> None:
        """What is touched is then forgotten. Not for an octree of what moves."""
        bricks, updates, self._listed = self.bricks, self.updates, True
        for level, given in enumerate(updates.levels):
            self._climb.run_indirect(
                stage, updates.arguments(stage, level), parameters=given, update_list=updates.listed["update_list"],
                **self._of_light(), **updates.resources,
            )  # fmt: skip
        arguments, owners = updates.arguments(stage, bricks.octree.depth), bricks.owners.resource
        given = self._given(unit)
        self._copy_listed.run_indirect(stage, arguments, parameters=given, **self._of_bricks(), **updates.listed)
        self._record_listed.run_indirect(stage, arguments, parameters=given, owners=owners, **self._of_records(),
                                         **updates.listed)  # fmt: skip
        updates.note(stage)
        updates.forget(stage)

    def nothing(self) -> None:
        """Nothing is made anew."""
        self._listed = True
        self.device.write(self.updates.count, np.zeros(1, np.uint32))

    def updated_nodes(self) -> np.ndarray:
        """Numbers of the nodes with bricks that were made anew the last time, for debug views."""
        bricks = self.bricks
        made = self.updates.read() if self._listed else np.arange(bricks.count, dtype=np.uint32)
        return np.unique(np.frombuffer(self.device.queue.read_buffer(bricks.owners.resource), np.uint32)[made] >> 3)

    def _borrow_light(self, stage: Any) -> None:
        bricks, count = self.bricks, self.bricks.count
        first_leaf = bricks.octree.counts.levels[0][0]
        self._borrow.run(
            stage, threads(OWN * count), parameters=parameters(self.device, count, first_leaf),
            owners=bricks.owners.resource, leaves=bricks.octree.leaves.resource, light=bricks.light.resource,
            **bricks.of_nodes(), **bricks.of_static("ways", "light"),
        )  # fmt: skip

    def _merge_records(self, stage: Any) -> None:
        bricks, octree = self.bricks, self.bricks.octree
        self._merge.run(
            stage, threads(octree.words), parameters=parameters(self.device, octree.words, bricks.first),
            directory=octree.directory, merged_directory=octree.merged, shown=octree.shown, **self._of_records(),
            **bricks.of_static("ways", "scales"),
        )  # fmt: skip

    def _given(self, unit: float) -> Any:
        word = int(np.float32(max(unit, _DARK)).view(np.uint32))
        return parameters(self.device, self.bricks.count, second=word, third=self.bricks.first)

    def _of_light(self) -> dict[str, Any]:
        bricks = self.bricks
        return {
            **bricks.of_nodes(), "facing": bricks.facing.resource, "ways": bricks.ways.resource,
            "light": bricks.light.resource,
        }  # fmt: skip

    def _of_bricks(self) -> dict[str, Any]:
        bricks = self.bricks
        return {
            **self._of_light(), "owners": bricks.owners.resource, "scales": bricks.scales.resource,
            "bricks": bricks.bricks.resource,
        }  # fmt: skip

    def _of_records(self) -> dict[str, Any]:
        bricks = self.bricks
        return {"ways": bricks.ways.resource, "scales": bricks.scales.resource, "nodes": bricks.nodes.resource}
