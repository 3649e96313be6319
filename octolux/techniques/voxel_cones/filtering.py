"""Filtering of light: from the voxels of level 0 up, and into bricks (VCT 5.4.2, 5.4.3, 5.5)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...gpu.bindings import Binding, atomic_words, storage, storage_rw, storage_texture, texture
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from ...gpu.records import records_out, words
from .bricks import NODE, PARAMETERS_OF, Bricks
from .octree import LABEL, directory_binding
from .pools import OWN, Pool, parameters, threads

_OF_LIGHT = ("average_light", "bricks", "surfaces")
"""Shaders that know how light is kept (representation.py)."""
_DARK = float(np.finfo(np.float32).tiny)


class Filtering:
    """Brings `light` that voxels of level 0 send (bricks.py) to all levels and into the bricks that shaders read.

    `everything` does so for all nodes, `touched` for those of level 0 that `bricks.touched` names, and what depends on
    them: the same result where nothing else has changed, and neither has the unit. unit: of `light`, nits. An octree of
    what moves is small: all of it is filtered, after that of what is static, whose light it borrows.
    """

    def __init__(self, device: Device, bricks: Bricks):
        self.device, self.bricks = device, bricks
        self._updates = Pool("bricks", lambda count: device.buffer(LABEL, size=4 * count), limit=bricks.light.limit)
        self.update_count = device.buffer(LABEL, size=4)
        """u32: how many bricks the last `touched` made anew."""
        self._listed = False
        nodes = [PARAMETERS_OF, storage("codes", "u32"), directory_binding()]
        facing, light = storage("facing", "vec2u"), storage("light", "u32")
        ways, owners, scales = (storage(name, "u32") for name in ("ways", "owners", "scales"))
        touched, count = storage("touched", "u32"), storage("update_count", "u32")
        brick_out = [storage_rw("scales", "u32", "write"), storage_texture("bricks", "rgba8unorm", "3d")]
        light_out = [*nodes, facing, ways, owners, storage_rw("light", "u32")]
        copied = [*nodes, storage("facing", "u32"), ways, owners, light, *brick_out]  # one word of the two
        self._average = self._made("average_light", light_out, listed=False)
        self._average_touched = self._made("average_light", [*light_out, touched], listed=True)
        self._copy = self._made("bricks", copied, listed=False)
        self._copy_listed = self._made("bricks", [*copied, count, storage("update_list", "u32")], listed=True)
        self._surfaces = None
        if bricks.representation.directed:
            self._surfaces = self._made("surfaces", [*nodes, facing, owners, brick_out[1]])
        shown = [*nodes[1:], texture("shown_directory", "uint")] if bricks.static else []
        self._records = self._made(
            "records", [PARAMETERS_OF, ways, scales, records_out("nodes", NODE), *shown], shown=bool(shown),
            parts=("", "shown_"),
        )  # fmt: skip
        self._borrow: ComputePass | None = None
        if bricks.static:
            theirs = [texture("static_directory", "uint"),
                      *(storage(f"static_{name}", "u32") for name in ("ways", "light"))]  # fmt: skip
            self._borrow = self._made(
                "borrow_light", [*nodes, owners, words("leaves"), storage_rw("light", "u32", "write"), *theirs],
                parts=bricks.parts,
            )  # fmt: skip
        self._touch = self._made("touch", [*nodes, storage_rw("touched", "u32")])
        self._list = self._made(
            "update_list",
            [*nodes, touched, ways, atomic_words("update_count", "u32"), storage_rw("update_list", "u32", "write")],
        )

    def _made(self, file: str, bindings: list[Binding], **values: Any) -> ComputePass:
        reads = [binding.name for binding in bindings if binding.name == "ways"]
        given = {**self.bricks.pass_values, "reads": reads, **values}
        folder = self.bricks.representation.folder if file in _OF_LIGHT else "techniques/voxel_cones"
        return ComputePass(self.device, file, f"{folder}/{file}.wgsl", bindings, **given)

    def surfaces(self, stage: Any) -> None:
        """Write, after a build, what of bricks no light changes."""
        if self._surfaces:
            bricks, given = self.bricks, self._given(1.0)
            self._surfaces.run(stage, threads(bricks.bricks.used), parameters=given, **bricks.of_nodes(),
                               facing=bricks.facing.resource, owners=bricks.owners.resource,
                               bricks=bricks.bricks.resource)  # fmt: skip

    def everything(self, stage: Any, unit: float = 1.0) -> None:
        bricks, self._listed = self.bricks, False
        if self._borrow:
            octree, count = bricks.octree, bricks.bricks.used
            self._borrow.run(
                stage, threads(OWN * count), parameters=parameters(self.device, count, octree.counts.levels[0][0]),
                owners=bricks.owners.resource, leaves=octree.leaves.resource, light=bricks.light.resource,
                **bricks.of_nodes(), **bricks.of_static("ways", "light"),
            )  # fmt: skip
        for first, count in bricks.levels[1:]:
            self._average.run(stage, threads(OWN * count), parameters=parameters(self.device, count, first),
                              **self._of_light())  # fmt: skip
        self._copy.run(stage, threads(bricks.bricks.used), parameters=self._given(unit), **self._of_bricks())
        self._record(stage)

    def touched(self, stage: Any, unit: float = 1.0) -> None:
        """What is touched is then forgotten."""
        device, bricks, counts = self.device, self.bricks, self.bricks.octree.counts
        marks, self._listed = {"touched": bricks.touched.resource}, True
        self._updates.need(bricks.bricks.used)
        for (node, nodes), (first, count) in zip(counts.levels[1:], bricks.levels[1:], strict=True):
            self._touch.run(stage, threads(nodes), parameters=parameters(device, nodes, node), **bricks.of_nodes(),
                            **marks)  # fmt: skip
            self._average_touched.run(stage, threads(OWN * count), parameters=parameters(device, count, first), **marks,
                                      **self._of_light())  # fmt: skip
        stage.encoder.clear_buffer(self.update_count)
        listed = {"update_count": self.update_count, "update_list": self._updates.resource}
        self._list.run(
            stage, threads(counts.nodes), parameters=parameters(device, counts.nodes, third=max(counts.nodes, 1) - 1),
            ways=bricks.ways.resource, **bricks.of_nodes(), **marks, **listed,
        )  # fmt: skip
        self._copy_listed.run(stage, threads(bricks.bricks.used), parameters=self._given(unit), **self._of_bricks(),
                              **listed)  # fmt: skip
        self._record(stage)
        stage.encoder.clear_buffer(bricks.touched.resource)

    def updated_nodes(self) -> np.ndarray:
        """Numbers of the nodes with bricks that were made anew the last time, for debug views."""
        read, bricks = self.device.queue.read_buffer, self.bricks
        made = np.arange(bricks.bricks.used, dtype=np.uint32)
        if self._listed:
            count = int(np.frombuffer(read(self.update_count), np.uint32)[0])
            made = np.frombuffer(read(self._updates.resource), np.uint32)[:count]
        return np.unique(np.frombuffer(read(bricks.owners.resource), np.uint32)[made] >> 3)

    def _record(self, stage: Any) -> None:
        bricks, count = self.bricks, self.bricks.octree.counts.nodes
        shown = {**bricks.of_nodes(), "shown_directory": bricks.octree.shown} if bricks.static else {}
        self._records.run(stage, threads(count), parameters=parameters(self.device, count), ways=bricks.ways.resource,
                          scales=bricks.scales.resource, nodes=bricks.nodes.resource, **shown)  # fmt: skip

    def _given(self, unit: float) -> Any:
        word = int(np.float32(max(unit, _DARK)).view(np.uint32))
        return parameters(self.device, self.bricks.bricks.used, second=word)

    def _of_light(self) -> dict[str, Any]:
        bricks = self.bricks
        return {
            **bricks.of_nodes(), "facing": bricks.facing.resource, "ways": bricks.ways.resource,
            "owners": bricks.owners.resource, "light": bricks.light.resource,
        }  # fmt: skip

    def _of_bricks(self) -> dict[str, Any]:
        return {**self._of_light(), "scales": self.bricks.scales.resource, "bricks": self.bricks.bricks.resource}
