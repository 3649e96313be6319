"""The sparse octree over the voxels of a scene, level by level (VCT 5.2.2, 5.2.3); octree.wgsl says how it is read."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise, product
from typing import Any

import numpy as np

from ....frame.frame import COPY, STORAGE, TEXTURE
from ....gpu.bindings import atomic_words, storage, storage_rw, storage_texture, texture, uniform
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....gpu.profiler import Profiler
from ....gpu.records import word_texture, words_out
from ....raytracing.scan import BLOCK, PARAMETERS, PrefixSum
from .pools import ROW, WORKGROUP, Pool, parameters, threads

DIRECTORY_ROW = 4096  # texels of a row of the directory
LABEL = "voxel octree"


def directory_binding(name: str = "directory", access: str = "read") -> Any:
    """The texture that octree.wgsl looks nodes up in."""
    return storage_texture(name, "rg32uint", access=access)


def corners() -> list[dict[str, Any]]:
    """For the template of levels.wgsl: nodes at these offsets (x, y, z) below a node have those of its voxels in their
    bricks, by bits, that lie at its lower sides there."""
    found = []
    for number in range(8):
        offset = [number >> axis & 1 for axis in range(3)]
        lower = sum(1 << voxel for voxel in range(8) if not voxel & number)
        found.append({"offset": ", ".join(f"{o}u" for o in offset), "lower": lower})
    return found


def _neighbours() -> list[str]:
    """For the same: offsets of a node and its neighbours at all sides."""
    return [", ".join(map(str, offset)) for offset in product((-1, 0, 1), repeat=3)]


@dataclass(frozen=True)
class Counts:
    """levels: first node and number of nodes of each level, from level 0.  nodes, voxels: how many there are."""

    levels: tuple[tuple[int, int], ...]
    nodes: int
    voxels: int


class Octree:
    """directory: texture, see octree.wgsl.  codes: u32 of each node.  leaves: texture of words, of each node of level
    0: number of its first voxel << 8 | which of its eight are occupied.  counts: of the last build.

    static: where this is of what moves, the octree of what is static. Then it has nodes at all sides of what is
    occupied (levels.wgsl), of which `shown`, u32 of bits by codes, are whole; and `merged` is the directory of what is
    read, of both (merge_directory.wgsl), else `directory`.
    values: what octree.wgsl wants to know.
    """

    def __init__(self, device: Device, depth: int, static: Octree | None = None):
        self.device, self.depth, self.static, self.moving = device, depth, static, static is not None
        moving, self.shown = self.moving, None
        self.counts = Counts(((0, 0),) * depth, 0, 0)
        self.values: dict[str, Any] = {
            "depth": depth, "directory_row": DIRECTORY_ROW, "reads": (), "parts": ("",),
        }  # fmt: skip
        self.words = max(4, 2 * 8 ** (depth - 1) // 32)  # of all cells
        rows = -(-self.words // DIRECTORY_ROW)
        textures = [
            device.texture(LABEL, (DIRECTORY_ROW, rows), "rg32uint", usage=STORAGE | TEXTURE | COPY)
            for _ in range(1 + moving)
        ]
        self.directory, self.merged = textures[0], textures[-1]
        self.codes = Pool("nodes", lambda count: device.buffer(LABEL, size=4 * count), limit=1 << 25)
        self.leaves = Pool("leaves", lambda count: word_texture(device, LABEL, count), limit=1 << 24)
        self._sums = PrefixSum(device, "u32")
        given = uniform("parameters", PARAMETERS)
        fixed: dict[str, Any] = {"structs": [PARAMETERS], "workgroup": WORKGROUP, "row": ROW, "block": BLOCK}
        sums = [storage("values", "u32"), storage("totals", "u32")]
        folder = "techniques/voxel_cones/octree"
        self._levels = ComputePass(
            device, "levels", f"{folder}/levels.wgsl",
            [given, *(atomic_words(name, "u32") for name in ("occupied", "nodes", "shown")[: 2 + moving])],
            corners=corners(), neighbours=_neighbours() if moving else (), **fixed,
        )  # fmt: skip
        self._count = ComputePass(
            device, "count", f"{folder}/count_bits.wgsl",
            [given, storage("bits", "u32"), storage_rw("values", "u32", "write")], **fixed,
        )  # fmt: skip
        self._directory = ComputePass(
            device, "directory", f"{folder}/directory.wgsl",
            [given, storage("nodes", "u32"), *sums, storage_rw("codes", "u32", "write"),
             directory_binding(access="write")], **fixed, **self.values,
        )  # fmt: skip
        if moving:
            of_static = texture("static_directory", "uint")
            self._merge_bits = ComputePass(
                device, "merge", f"{folder}/merge_bits.wgsl",
                [given, of_static, storage("shown", "u32"), storage_rw("merged", "u32", "write"),
                 storage_rw("values", "u32", "write")], **fixed, **self.values,
            )  # fmt: skip
            self._merge = ComputePass(
                device, "merge", f"{folder}/merge_directory.wgsl",
                [given, of_static, storage("merged", "u32"), *sums, directory_binding(access="write")],
                **fixed, **self.values,
            )  # fmt: skip
        self._leaf_voxels = ComputePass(
            device, "leaves", f"{folder}/leaf_voxels.wgsl",
            [given, storage("codes", "u32"), storage("occupied", "u32"), *sums, words_out("leaves")], **fixed,
        )  # fmt: skip

    def occupied(self) -> Any:
        """A buffer of zeros for a bit of each voxel of each level: code_of(depth, voxel) for those of level 0."""
        return self.device.buffer("voxel build", size=max(16, 2 * 8**self.depth // 8))

    def build(self, profiler: Profiler, occupied: Any) -> None:
        """From the voxels of level 0 in `occupied`; those of the other levels are added there. The host waits once, to
        learn how many nodes there are. Raises DeviceError when there are more than there can be room for."""
        device, words = self.device, self.words
        first_word = 8**self.depth // 32  # of the voxels of level 0, which have as many
        nodes = device.buffer("voxel build", size=4 * words)
        self.shown = device.buffer(LABEL, size=4 * words) if self.moving else None
        shown = {"shown": self.shown} if self.moving else {}
        of_nodes, of_voxels = self._sums.sums(words), self._sums.sums(first_word)
        starts = device.buffer("voxel build", size=8 * self.depth + 8)
        with profiler.stage("octree") as stage:
            for log2_edge in range(self.depth - 1, -1, -1):
                given = parameters(device, 0, first=log2_edge)
                self._levels.run(stage, threads(max(1, 8**log2_edge // 4)), parameters=given, occupied=occupied,
                                 nodes=nodes, **shown)  # fmt: skip
            each = (nodes, of_nodes, words, 0), (occupied, of_voxels, first_word, first_word)
            for bits, sums, count, first in each:
                given = parameters(device, count, first=first)
                self._count.run(stage, threads(count), parameters=given, bits=bits, values=sums.values)
                self._sums.run(stage, sums, count, given)
            self._copy_starts(stage, of_nodes, of_voxels, starts)
        profiler.submit()
        self.counts = self._read(np.frombuffer(device.queue.read_buffer(starts), np.uint32).astype(np.int64))
        self.codes.need(self.counts.nodes)
        first, count = self.counts.levels[0]
        self.leaves.need(count)
        with profiler.stage("octree") as stage:
            self._directory.run(
                stage, threads(words), parameters=parameters(device, words), nodes=nodes, values=of_nodes.values,
                totals=of_nodes.totals, codes=self.codes.resource, directory=self.directory,
            )  # fmt: skip
            self._leaf_voxels.run(
                stage, threads(count), parameters=parameters(device, count, first, first_word),
                codes=self.codes.resource, occupied=occupied, values=of_voxels.values, totals=of_voxels.totals,
                leaves=self.leaves.resource,
            )  # fmt: skip
            if self.static:
                self._merge_with(self.static, stage)

    def _merge_with(self, static: Octree, stage: Any) -> None:
        words, sums = self.words, self._sums.sums(self.words)
        merged = self.device.buffer("voxel build", size=4 * words)
        given, of_static = parameters(self.device, words, static.counts.nodes), {"static_directory": static.directory}
        self._merge_bits.run(stage, threads(words), parameters=given, shown=self.shown, merged=merged,
                             values=sums.values, **of_static)  # fmt: skip
        self._sums.run(stage, sums, words, given)
        self._merge.run(stage, threads(words), parameters=given, merged=merged, values=sums.values, totals=sums.totals,
                        directory=self.merged, **of_static)  # fmt: skip

    def _copy_starts(self, stage: Any, of_nodes: Any, of_voxels: Any, starts: Any) -> None:
        """Behind each other in `starts`: sum within its block and of the blocks before, of each level's first word from
        the third level down; then all nodes, and all voxels."""
        places = [(of_nodes, 8**k // 32) for k in range(2, self.depth)]
        pairs = [((sums.values, word), (sums.totals, word // BLOCK)) for sums, word in places]
        ends = ((of_nodes.totals, -(-self.words // BLOCK)), (of_voxels.totals, -(-(8**self.depth // 32) // BLOCK)))
        for i, (buffer, word) in enumerate([*(one for pair in pairs for one in pair), *ends]):
            stage.encoder.copy_buffer_to_buffer(buffer, 4 * word, starts, 4 * i, 4)

    def _read(self, starts: np.ndarray) -> Counts:
        pairs = 2 * (self.depth - 2)
        nodes, voxels = starts[pairs : pairs + 2].tolist()
        top = [0, min(1, nodes)]  # the root, and what follows
        first = [*top, *(starts[0:pairs:2] + starts[1:pairs:2]).tolist(), nodes]
        levels = [(a, b - a) for a, b in pairwise(first)]
        return Counts(tuple(levels[::-1]), nodes, voxels)
