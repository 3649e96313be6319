"""From the binary tree to nodes of four children, level by level from the root."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from ..gpu.bindings import storage, storage_rw, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .ploc import BinaryTree
from .scan import BLOCK, PARAMETERS, PrefixSum, parameters

LEAF_SIZE = 3  # most triangles of a leaf; the format has room for 4


class Links(NamedTuple):
    """links: a vec4u for each node (collapse_link.wgsl), level after level.  levels: (first node, nodes) of each.
    order: for each triangle of the leaves its number."""

    links: Any
    levels: tuple[tuple[int, int], ...]
    order: Any


class Collapse:
    """Makes wide nodes of binary ones."""

    def __init__(self, device: Device):
        self.device = device
        self._sums = PrefixSum(device, "vec2u")
        given, tree, sizes = uniform("parameters", PARAMETERS), storage("tree", "vec4u"), storage("sizes", "u32")
        links = storage_rw("links", "vec4u")
        fixed: dict[str, Any] = {"structs": [PARAMETERS], "workgroup": (64, 1, 1), "leaf_size": LEAF_SIZE}
        self._open = ComputePass(device, "BVH open", "raytracing/collapse_open.wgsl",
                                 [given, tree, sizes, links, storage_rw("values", "vec2u")], **fixed)  # fmt: skip
        self._link = ComputePass(
            device, "BVH link", "raytracing/collapse_link.wgsl",
            [given, tree, sizes, links, storage("values", "vec2u"), storage("totals", "vec2u"), storage("ids", "u32"),
             storage_rw("order", "u32")], block=BLOCK, **fixed,
        )  # fmt: skip

    def run(self, submitted: Callable[[], Any], binary: BinaryTree, ids: Any, count: int) -> Links:
        """ids: numbers of the triangles that the leaves of `binary` name, `count` of them."""
        device = self.device
        links, order = device.buffer("BVH build", size=16 * count), device.buffer("BVH order", size=4 * count)
        root = max(2 * count - 2, 0)
        device.write(links, np.array([root, 0, 0, 0], np.uint32))
        sums = self._sums.sums(count)
        levels, first, nodes, triangles = [], 0, 1, 0
        while nodes:
            given = parameters(device, nodes, first, triangles, count)
            shared = {"parameters": given, "links": links, "tree": binary.tree, "sizes": binary.sizes}
            with submitted() as stage:
                self._open.run(stage, (nodes,), values=sums.values, **shared)
                self._sums.run(stage, sums, nodes, given)
                self._link.run(stage, (nodes,), ids=ids, order=order, **sums._asdict(), **shared)
            levels.append((first, nodes))
            below, placed = self._sums.total(sums, nodes)
            first, nodes, triangles = first + nodes, below, triangles + placed
        return Links(self._trimmed(links, first), tuple(levels), order)

    def _trimmed(self, links: Any, nodes: int) -> Any:
        """Only what is used: there could have been a node for each triangle."""
        kept = self.device.buffer("BVH links", size=16 * nodes)
        encoder = self.device.wgpu.create_command_encoder()
        encoder.copy_buffer_to_buffer(links, 0, kept, 0, 16 * nodes)
        self.device.queue.submit([encoder.finish()])
        return kept
