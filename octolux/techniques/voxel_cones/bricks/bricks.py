"""Bricks of an octree's nodes: what faces each of six ways, and the light that is sent (VCT 5.3, 5.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....frame.frame import COPY, STORAGE, TEXTURE
from ....gpu.bindings import storage, storage_rw, texture, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.limits import DEFAULT_LIMITS
from ....gpu.passes import ComputePass
from ....gpu.profiler import Profiler
from ....gpu.records import record_texture
from ....raytracing.scan import BLOCK, PARAMETERS, PrefixSum
from ..octree.octree import LABEL, Octree, directory_binding
from ..octree.pools import OWN, ROW, WORKGROUP, Pool, parameters, threads
from .representation import REPRESENTATIONS

# first: brick of a node; ways: bits, which of the six have one; scales: of those of +x, +y, +z, and of -x, -y, -z, 8
# bits each (octree.wgsl).
NODE = Struct("Node", first="u32", ways="u32", scales_up="u32", scales_down="u32")
EDGE = 3
"""Texels along the edge of a brick."""
_BUFFER = DEFAULT_LIMITS["max-storage-buffer-binding-size"]
PARAMETERS_OF = uniform("parameters", PARAMETERS)


def brick_texture(device: Device, count: int, row: int) -> Any:
    """A 3D texture for `count` bricks, or more, `row` along x and y: light as shares of scales, and what faces six
    ways. A sample is the same bits wherever its brick lies (octree.wgsl)."""
    size = (EDGE * row, EDGE * row, EDGE * -(-count // row**2))
    return device.texture("voxel bricks", size, "rgba8unorm", usage=STORAGE | TEXTURE | COPY, dimension="3d")


def _borrowed() -> list[list[int]]:
    """For templates: which of the eight voxels of each neighbour at a node's upper sides are in its bricks; number 0 is
    the node itself."""
    return [[voxel for voxel in range(OWN) if not voxel & number] for number in range(OWN)]


class Bricks:
    """facing: vec2u of the eight voxels that each node owns (facing.wgsl).  ways: u32 of each node, number of its first
    brick << 6 | which ways it has.  owners: u32 of each brick, its node << 3 | its way.  light: u32 of the eight voxels
    that each brick's node owns, what they send its way, radiance times share of section, as a share of a unit
    (bright.wgsl).  levels: first and number of bricks of each level, from level 0.  representation: what of this is
    other for lobes.

    static: where the octree is of what moves, the bricks of what is static, with the same depth and cube. From these
    come voxels in nodes that nothing lies in that moves, so that all nodes hold what an octree of everything would. Its
    `nodes` and `bricks`, which shaders read, have room for both: these stand behind its own.
    """

    def __init__(self, device: Device, octree: Octree, representation: str = "axial", static: Bricks | None = None):
        self.device, self.octree, self.static = device, octree, static
        self.representation = REPRESENTATIONS[representation]
        if static and (static.octree.depth, static.representation) != (octree.depth, self.representation):
            raise ValueError("octrees that are read together have one depth, and keep light alike")
        row = self.representation.row
        octree.values.update(bricks_row=row)
        self.levels: tuple[tuple[int, int], ...] = ((0, 0),) * octree.depth

        def words(count: int) -> Any:
            return device.buffer(LABEL, size=4 * count)

        most = min(row**2 * (DEFAULT_LIMITS["max-texture-dimension-3d"] // EDGE), _BUFFER // (4 * OWN))
        own = 8 * OWN  # bytes of what a node's voxels face
        self.facing = Pool("nodes", lambda count: device.buffer(LABEL, size=own * count), limit=_BUFFER // own)
        self.ways = Pool("nodes", words, limit=_BUFFER // 4)
        self.owners, self.scales = Pool("bricks", words, limit=most), Pool("bricks", words, limit=most)
        self.light = Pool("bricks", lambda count: device.buffer(LABEL, size=4 * OWN * count), limit=most)
        self.nodes: Pool = static.nodes if static else Pool(
            "nodes", lambda count: record_texture(device, LABEL, NODE, count), limit=_BUFFER // 4
        )
        self.bricks: Pool = static.bricks if static else Pool(
            "bricks", lambda count: brick_texture(device, count, row), limit=most
        )
        self._sums = PrefixSum(device, "u32")
        self.pass_values: dict[str, Any] = {
            "structs": [PARAMETERS, NODE], "workgroup": WORKGROUP, "row": ROW, "block": BLOCK,
            "borrowed": _borrowed(), **octree.values,
        }  # fmt: skip
        self._make_passes()

    def _make_passes(self) -> None:
        fixed = self.pass_values
        nodes = [PARAMETERS_OF, storage("codes", "u32"), directory_binding()]
        out = {name: storage_rw(name, "u32", "write") for name in ("masks", "values", "ways", "owners")}
        sums = [storage(name, "u32") for name in ("masks", "values", "totals")]
        folder = "techniques/voxel_cones/bricks"
        self._average = ComputePass(
            self.device, "averaging", f"{folder}/average.wgsl", [*nodes, storage_rw("facing", "vec2u")], **fixed
        )
        borrowed = [texture("static_directory", "uint"), storage("static_ways", "u32")] if self.static else []
        self._ways = ComputePass(
            self.device, "ways", self.representation.file("ways"),
            [*nodes, storage("facing", "vec2u"), out["masks"], out["values"], *borrowed], borrows=bool(borrowed),
            **{**fixed, "parts": self.parts},
        )  # fmt: skip
        if self.static:
            self._borrow = ComputePass(
                self.device, "facing", f"{folder}/borrow_facing.wgsl",
                [*nodes, borrowed[0], storage("static_facing", "vec2u"), storage_rw("facing", "vec2u", "write")],
                **{**fixed, "parts": self.parts},
            )  # fmt: skip
        self._owners = ComputePass(
            self.device, "owners", f"{folder}/owners.wgsl", [PARAMETERS_OF, *sums, out["ways"], out["owners"]], **fixed
        )

    @property
    def made(self) -> int:
        """How many times the textures that are read were made."""
        return self.nodes.made + self.bricks.made

    @property
    def count(self) -> int:
        return self.owners.used

    @property
    def first(self) -> int:
        """Where in the texture of bricks its own begin."""
        return self.static.count if self.static else 0

    @property
    def parts(self) -> tuple[str, ...]:
        """Names of the octrees that passes look nodes up in begin so (octree.wgsl)."""
        return ("", "static_") if self.static else ("",)

    def make_room(self, stage: Any) -> None:
        """For the nodes of the octree; nothing faces any way but what is static."""
        count = self.octree.counts.nodes
        for pool in (self.facing, self.ways):
            pool.need(count)
        if self.static:  # new numbers have its nodes, and those of what is static in the same words of the directory
            there = self.static.octree.counts.nodes
            self.nodes.reserve(there + min(32 * count, count + there))
        else:
            self.nodes.need(count)
        stage.encoder.clear_buffer(self.facing.resource)
        if self.static:
            self._borrow.run(
                stage, threads(OWN * count), parameters=parameters(self.device, count), facing=self.facing.resource,
                **self.of_nodes(), **self.of_static("facing"),
            )  # fmt: skip

    def average(self, stage: Any) -> None:
        """What faces each way, from level 0 up (VCT 5.4.3)."""
        for first, count in self.octree.counts.levels[1:]:
            self._average.run(stage, threads(OWN * count), parameters=parameters(self.device, count, first),
                              facing=self.facing.resource, **self.of_nodes())  # fmt: skip

    def number(self, profiler: Profiler) -> None:
        """Give each way that a node has a brick, without light. The host waits, to learn how many there are. Raises
        DeviceError when there are more than there can be room for."""
        device, count, octree = self.device, self.octree.counts.nodes, self.octree
        masks, sums = device.buffer("voxel build", size=4 * max(1, count)), self._sums.sums(max(1, count))
        given = parameters(device, count)
        starts = device.buffer("voxel build", size=8 * octree.depth + 4)
        with profiler.stage("bricks") as stage:
            self._ways.run(stage, threads(count), parameters=given, **self.of_nodes(), facing=self.facing.resource,
                           masks=masks, values=sums.values, **self.of_static("ways"))  # fmt: skip
            self._sums.run(stage, sums, count, given)
            places = [(sums.values, first) for first, _ in octree.counts.levels]
            places += [(sums.totals, first // BLOCK) for first, _ in octree.counts.levels]
            for i, (buffer, word) in enumerate([*places, (sums.totals, -(-count // BLOCK))]):
                stage.encoder.copy_buffer_to_buffer(buffer, 4 * word, starts, 4 * i, 4)
        profiler.submit()
        read = np.frombuffer(device.queue.read_buffer(starts), np.uint32).astype(np.int64)
        total = int(read[2 * octree.depth]) if count else 0
        first = (read[: octree.depth] + read[octree.depth : 2 * octree.depth]).tolist() if count else [0] * octree.depth
        self.levels = tuple((a, b - a) for a, b in zip(first, [total, *first], strict=False))
        for pool in (self.owners, self.scales, self.light):
            pool.need(total)
        if self.static:
            self.bricks.reserve(self.first + total)
        else:
            self.bricks.need(total)
        with profiler.stage("bricks") as stage:
            stage.encoder.clear_buffer(self.light.resource)
            self._owners.run(stage, threads(count), parameters=given, masks=masks, values=sums.values,
                             totals=sums.totals, ways=self.ways.resource, owners=self.owners.resource)  # fmt: skip

    def of_static(self, *names: str) -> dict[str, Any]:
        """What passes that borrow of what is static need, by the names of its pools."""
        if not self.static:
            return {}
        pools = {f"static_{name}": getattr(self.static, name).resource for name in names}
        return {"static_directory": self.static.octree.directory, **pools}

    def of_nodes(self) -> dict[str, Any]:
        """What passes over nodes need."""
        return {"codes": self.octree.codes.resource, "directory": self.octree.directory}
