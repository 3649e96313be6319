"""Further bounces: voxels gather light through cones, and send it again (VCT 7.2)."""

from __future__ import annotations

from typing import Any

from ....gpu.bindings import storage, storage_rw, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.limits import DEFAULT_LIMITS
from ....gpu.passes import ComputePass
from ....gpu.records import records, words
from ..bricks.reading import Reading
from ..cones.gathering import AIR, Voxels, cone_values
from ..cones.wide import USUAL
from ..octree.octree import directory_binding
from ..octree.pools import OWN, ROW, WORKGROUP, Pool, threads
from ..voxels.structure import VOXEL, VoxelOctree
from .series import SERIES, Received, Series

# Bricks of level 0 and of the coarse level, the first and how many. first_leaf: node of level 0. per_unit: 1 / nits.
# now, before: first words of what is received, by this bounce and by the one before.  endless: 1 where what further
# ones bring is added.
BOUNCE = Struct(
    "Bounce", first="u32", count="u32", coarse_first="u32", coarse_count="u32", first_leaf="u32", per_unit="f32",
    now="u32", before="u32", endless="f32",
)  # fmt: skip


class Bounces:
    """Adds to what was injected what voxels reflect of it, from scratch: the same light whatever there was before.

    level: of the voxels that gather; those of level 0 in them reflect, each with its own albedo, what these receive. A
    voxel receives a mean of radiances that others send, so no bounce is brighter than its light. What arrives is
    spread over a coarse voxel: cones are the cheapest.

    octree: one of those that `reading` reads. Of two each has Bounces, which take turns: all gather before any
    reflects, and that of what is static is filtered before the other borrows from it.  attenuation: 1/m, of light on
    its way through the cube.
    """

    def __init__(
        self, device: Device, octree: VoxelOctree, reading: Reading, level: int, attenuation: float = 0.0
    ):  # fmt: skip
        self.device, self.octree, self._reading, self._level = device, octree, reading, level
        kept = octree.bricks.representation
        size = 4 * OWN * kept.sides  # bytes of a brick
        most = DEFAULT_LIMITS["max-storage-buffer-binding-size"] // size
        self._received = Pool("bricks", lambda n: device.buffer("voxel light", size=size * n), limit=most)
        voxels = Voxels(octree.depth, reading.file, reading.bindings, reading.structs, reading.values)
        own = [uniform("bounce", BOUNCE), storage("owners", "u32"), storage("codes", "u32"), storage("facing", "vec2u")]
        self._attenuation = attenuation
        air = [uniform("air", AIR)] if attenuation else []
        self._receive = ComputePass(
            device, "receive", "techniques/voxel_cones/light/receive.wgsl",
            [*own, *air, *reading.bindings, storage_rw("received", "u32", "write")],
            structs=[BOUNCE, *([AIR] if air else []), *reading.structs], workgroup=WORKGROUP, row=ROW, level=level,
            sides=kept.sides, **USUAL.values(), **cone_values(voxels, 1.0, "surfaces", attenuation > 0.0),
        )  # fmt: skip
        self._reflect = ComputePass(
            device, "reflect", kept.file("reflect"),
            [*own, directory_binding(), words("leaves"), records("voxels", VOXEL), storage("ways", "u32"),
             storage("received", "u32"), storage("series", SERIES), storage("injected_light", "u32"),
             storage_rw("light", "u32", "write")],
            structs=[BOUNCE, VOXEL, SERIES], workgroup=WORKGROUP, level=level, **{**octree.octree.values, "row": ROW},
        )  # fmt: skip

    def receive(self, stage: Any, unit: float, number: int) -> Received:
        """What the coarse voxels receive, of light that is filtered. number: of the bounce, from 0."""
        first, coarse = self.octree.bricks.levels[self._level]
        self._received.need(2 * coarse)
        sides = self.octree.bricks.representation.sides
        packed = AIR.pack(absorbed=self._attenuation * self.octree.grid.cell_size, reach=0.0)
        air = {"air": self.device.uniform("voxel light", packed)} if self._attenuation else {}
        words, count = self._received.resource, OWN * sides * coarse
        self._receive.run(stage, threads(count), **self._own(unit, number), received=words, **air,
                          **self._reading.resources)  # fmt: skip
        return Received(words, self._half(number), count, first)

    def reflect(
        self, stage: Any, injected: Any, unit: float, number: int, series: Series, endless: bool = False
    ) -> None:  # fmt: skip
        """What was injected (buffer `injected`, of the bricks of level 0), and what is reflected, filtered. endless:
        further bounces, too, as `series` says, which has followed this one."""
        octree, bricks = self.octree.octree, self.octree.bricks
        self._reflect.run(
            stage, threads(OWN * bricks.levels[0][1]), **self._own(unit, number, endless),
            received=self._received.resource, series=series.result, directory=octree.directory,
            leaves=octree.leaves.resource, voxels=self.octree.voxels.resource, ways=bricks.ways.resource,
            injected_light=injected, light=bricks.light.resource,
        )  # fmt: skip
        self.octree.filtering.everything(stage, unit)

    def _half(self, number: int) -> int:
        """Where in the buffer what bounce `number` brings begins: behind or before that of the one before."""
        bricks = self.octree.bricks
        return number % 2 * OWN * bricks.representation.sides * bricks.levels[self._level][1]

    def _own(self, unit: float, number: int, endless: bool = False) -> dict[str, Any]:
        bricks, octree = self.octree.bricks, self.octree.octree
        (first, count), (coarse_first, coarse_count) = bricks.levels[0], bricks.levels[self._level]
        given = BOUNCE.pack(
            first=first, count=count, coarse_first=coarse_first, coarse_count=coarse_count,
            first_leaf=octree.counts.levels[0][0], per_unit=1.0 / unit, now=self._half(number),
            before=self._half(number + 1), endless=float(endless),
        )  # fmt: skip
        return {
            "bounce": self.device.uniform("voxel light", given), "owners": bricks.owners.resource,
            "codes": octree.codes.resource, "facing": bricks.facing.resource,
        }  # fmt: skip
