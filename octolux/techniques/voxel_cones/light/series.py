"""What bounces after the last that is followed bring (simulator/voxels/series.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

from ....gpu.bindings import storage, storage_rw, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.passes import ComputePass
from ....simulator.voxels.series import MOST
from ..octree.pools import OWN, WORKGROUP
from ..voxels.structure import VoxelOctree

# Of what an octree's coarse voxels receive the first word, of how many sides, and the first brick; the first of its
# sums; and whether it is of what moves, 1, whose nodes stand for those of what is static.
SUMMED = Struct("Summed", begin="u32", sides="u32", first_brick="u32", first_sum="u32", moves="u32")
BOUNCED = Struct("Bounced", number="u32")
# sum: of all that is received.  brings: the last bounce, of that.  gain: what further ones bring, over that.
SERIES = Struct("Series", sum="vec3f", brings="vec3f", gain="vec3f")
PARTS = 1 << 10
"""Sums of an octree, each by a thread."""
_LABEL = "voxel light"


class Received(NamedTuple):
    """What the sides of an octree's coarse voxels receive: buffer of u32 (bright.wgsl), the first of these, of how
    many, and the first brick that they are of."""

    words: Any
    begin: int
    sides: int
    first_brick: int


class Series:
    """Follows the bounces of light in `octrees`: one, or that of what is static and that of what moves, as Reading
    reads them. result: buffer of one SERIES."""

    def __init__(self, device: Device, octrees: Sequence[VoxelOctree]):
        self.device, self._octrees = device, octrees
        folder, beside = "techniques/voxel_cones/light", len(octrees) > 1
        of_nodes = [storage(name, "u32") for name in ("owners", "codes", "shown")] if beside else []
        self._sum = ComputePass(
            device, "sum", f"{folder}/sum_received.wgsl",
            [uniform("summed", SUMMED), storage("received", "u32"), *of_nodes, storage_rw("sums", "vec4u", "write")],
            structs=[SUMMED], workgroup=WORKGROUP, parts=PARTS, beside=beside,
            sides=OWN * octrees[0].bricks.representation.sides,
        )  # fmt: skip
        self._follow = ComputePass(
            device, "series", f"{folder}/series.wgsl",
            [uniform("bounced", BOUNCED), storage("sums", "vec4u"), storage_rw("series", SERIES)],
            structs=[BOUNCED, SERIES], sums=PARTS * len(octrees), most=MOST,
        )  # fmt: skip
        self._sums = device.buffer(_LABEL, size=32 * PARTS * len(octrees))
        self.result = device.buffer(_LABEL, SERIES.array(1))

    def follow(self, stage: Any, number: int, received: Sequence[Received]) -> None:
        """After bounce `number`, from 0. received: in each octree."""
        for i, (octree, of_octree) in enumerate(zip(self._octrees, received, strict=True)):
            summed = SUMMED.pack(
                begin=of_octree.begin, sides=of_octree.sides, first_brick=of_octree.first_brick, first_sum=PARTS * i,
                moves=i,
            )  # fmt: skip
            self._sum.run(
                stage, (PARTS,), summed=self.device.uniform(_LABEL, summed), received=of_octree.words, sums=self._sums,
                **self._of_nodes(octree),
            )  # fmt: skip
        bounced = self.device.uniform(_LABEL, BOUNCED.pack(number=number))
        self._follow.run(stage, (1,), bounced=bounced, sums=self._sums, series=self.result)

    def _of_nodes(self, octree: VoxelOctree) -> dict[str, Any]:
        if len(self._octrees) < 2:
            return {}
        shown = self._octrees[1].octree.shown
        return {"owners": octree.bricks.owners.resource, "codes": octree.octree.codes.resource, "shown": shown}
