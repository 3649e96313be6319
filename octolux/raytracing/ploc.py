"""A binary tree over sorted boxes by parallel locally-ordered clustering (Meister and Bittner 2017).

Linear trees (Karras 2012) need no rounds, but their nodes are split by the Morton code alone; here what is merged is
chosen by the area of the common box, so that the tree comes near to one built by the surface area heuristic.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import wgpu

from ..gpu.bindings import storage, storage_rw, storage_texture, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .scan import BLOCK, PARAMETERS, PrefixSum, parameters

# Neighbours looked at on either side. Meister and Bittner, section 4: beyond 16 trees hardly get better.
RADIUS = 16
_ROW_BITS = 10  # words of a row of the clusters' textures
_ROUNDS = 4  # between two readbacks; a round leaves about 5/6 of the clusters of Crytek Sponza


class BinaryTree(NamedTuple):
    """tree: two vec4u a node, its box (f32) with the numbers of its children behind: leaves first (both are the
    triangle), then inner nodes; the last is the root.  sizes: triangles below each inner node."""

    tree: Any
    sizes: Any


class Ploc:
    """Builds binary trees."""

    def __init__(self, device: Device):
        self.device = device
        self._sums = PrefixSum(device, "vec2u")
        given, clusters, nearest = (
            uniform("parameters", PARAMETERS), storage_texture("clusters", "rgba32uint", access="read"),
            storage("nearest", "u32"),
        )  # fmt: skip
        tree, sizes = storage_rw("tree", "vec4u"), storage_rw("sizes", "u32")

        def make(name: str, bindings: list[Any]) -> ComputePass:
            return ComputePass(
                device, f"BVH {name}", f"raytracing/ploc_{name}.wgsl", [given, *bindings], structs=[PARAMETERS],
                workgroup=(64, 1, 1), radius=RADIUS, block=BLOCK, row_bits=_ROW_BITS,
            )  # fmt: skip

        keys, boxes = storage("keys", "vec4u"), storage("boxes", "vec4u")
        self._start = make("start", [keys, boxes, storage_texture("clusters", "rgba32uint"), tree])
        self._nearest = make("nearest", [clusters, storage_rw("nearest", "u32")])
        self._count = make("count", [nearest, storage_rw("values", "vec2u")])
        self._merge = make("merge", [nearest, clusters, storage("values", "vec2u"), storage("totals", "vec2u"),
                                     storage_texture("merged", "rgba32uint"), tree, sizes])  # fmt: skip
        self._advance = ComputePass(
            device, "BVH advance", "raytracing/ploc_advance.wgsl",
            [storage("totals", "vec2u"), storage_rw("state", "vec4u")], workgroup=(1, 1, 1), block=BLOCK,
        )  # fmt: skip

    def run(self, submitted: Callable[[], Any], keys: Any, boxes: Any, count: int) -> BinaryTree:
        """keys: sorted, with the numbers of `boxes` in z.  submitted: gives a stage and submits it.

        Each round at least the nearest pair of all merges, and where boxes are alike half of them. How many clusters
        are left is read back after every few rounds: with one left a round changes nothing.
        """
        device = self.device
        tree, sizes = device.buffer("BVH build", size=64 * count), device.buffer("BVH build", size=4 * count)
        clusters, merged = (self._clusters(count) for _ in range(2))
        nearest, sums = device.buffer("BVH build", size=4 * count), self._sums.sums(count)
        with submitted() as stage:
            self._start.run(stage, (count,), parameters=parameters(device, count), keys=keys, boxes=boxes,
                            clusters=clusters, tree=tree)  # fmt: skip
        state, left = parameters(device, count, count, count), count
        while left > 1:
            with submitted() as stage:
                for _ in range(_ROUNDS):
                    self._nearest.run(stage, (left,), parameters=state, clusters=clusters, nearest=nearest)
                    self._count.run(stage, (left,), parameters=state, nearest=nearest, values=sums.values)
                    self._sums.run(stage, sums, left, state)
                    self._merge.run(stage, (left,), parameters=state, nearest=nearest, clusters=clusters,
                                    **sums._asdict(), merged=merged, tree=tree, sizes=sizes)  # fmt: skip
                    self._advance.run(stage, (1,), totals=sums.totals, state=state)
                    clusters, merged = merged, clusters
            left = memoryview(device.queue.read_buffer(state, 0, 4)).cast("B").cast("I")[0]
        return BinaryTree(tree, sizes)

    def _clusters(self, count: int) -> Any:
        """A texture for `count` clusters (ploc_clusters.wgsl): neighbours are read far more often than written."""
        size = (1 << _ROW_BITS, -(-2 * count // (1 << _ROW_BITS)))
        return self.device.texture("BVH build", size, "rgba32uint", usage=wgpu.TextureUsage.STORAGE_BINDING)
