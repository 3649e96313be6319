"""The BVH: a tree of boxes around the scene's triangles in world space, built and refitted on the device.

Build: Morton order (`sort.py`), a binary tree by locally-ordered clustering (`ploc.py`), nodes of four children
(`collapse.py`). Refit: triangles anew, then boxes level by level from the leaves, with the same tree.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import wgpu

from ..gpu.bindings import storage, storage_rw, storage_texture, storage_words, uniform
from ..gpu.device import Device, DeviceError
from ..gpu.layout import Struct
from ..gpu.limits import DEFAULT_LIMITS
from ..gpu.memory import readable
from ..gpu.passes import ComputePass
from ..gpu.profiler import Profiler, Stage
from ..gpu_scene.clusters import CLUSTER_TRIANGLES
from ..gpu_scene.gpu_scene import GpuScene
from ..gpu_scene.materials import MASKED, SINGLE_SIDED
from ..gpu_scene.structs import INSTANCE, ITEM, TRIANGLE, VERTEX
from .collapse import Collapse, Links
from .ploc import Ploc
from .scan import PARAMETERS, parameters
from .sort import RadixSort

_CLUSTER_BITS = CLUSTER_TRIANGLES.bit_length() - 1
# Where triangles lie for their Morton codes: (p - low) * scale is in [0, 2^20).
_FRAME = Struct("Frame", low="vec3f", scale="f32")
_MORTON_CELLS = 1 << 20
# Flags of an instance's triangles in the BVH.
FLAG_MASKED, FLAG_SINGLE_SIDED, FLAG_FLIPPED = 1, 2, 4
_TRIANGLE_WORDS = _NODE_WORDS = 3
# Of each drawn instance the triangles' corners (kept when a mesh is deformed), its first vertex and triangle.
Topology = list[tuple[np.ndarray, int, int]]
_ROW_BITS = 10  # words of a row of the texture: 8192 rows of them are as much as one buffer binding holds
_STACK_STEP = 32  # the stack's size is a multiple, so that shaders are rarely made anew


class Bvh:
    """Follows a GpuScene. `texture` is what rays go through (raytracing/traverse.wgsl), bound as `binding`; `values`
    what that shader wants to know. `version` grows when `values` changes, so that passes made for it are made anew.

    `buffer` is what the texture is a copy of, word by word: refits read and write it.
    """

    binding = storage_texture("bvh", "rgba32uint", access="read")

    def __init__(self, device: Device):
        self.device = device
        self.version = 0
        self.buffer: Any = None
        self.texture: Any = None
        self.values: dict[str, Any] = {
            "bvh_stack": _STACK_STEP, "bvh_row_bits": _ROW_BITS, "flag_masked": FLAG_MASKED,
            "flag_single_sided": FLAG_SINGLE_SIDED, "flag_flipped": FLAG_FLIPPED,
        }  # fmt: skip
        self._built_for: Topology | None = None
        self._moves = -1
        self._tree: Links
        self._triangles = 0
        scene = [storage_words(name, kind) for name, kind in
                 (("vertices", VERTEX), ("triangles", TRIANGLE), ("instances", INSTANCE), ("items", ITEM))]  # fmt: skip
        fixed: dict[str, Any] = {"workgroup": (64, 1, 1), "cluster_bits": _CLUSTER_BITS}
        structs, given = [VERTEX, TRIANGLE, INSTANCE, ITEM, PARAMETERS], uniform("parameters", PARAMETERS)
        self._leaves = ComputePass(
            device, "BVH leaves", "raytracing/leaves.wgsl",
            [*scene, given, uniform("frame", _FRAME), storage("ids", "u32"), storage_rw("boxes", "vec4u"),
             storage_rw("keys", "vec4u")], structs=[*structs, _FRAME], **fixed,
        )  # fmt: skip
        self._refit_triangles = ComputePass(
            device, "BVH triangles", "raytracing/refit_triangles.wgsl",
            [*scene, given, storage("order", "u32"), storage("flags", "u32"), storage_rw("bvh", "vec4u")],
            structs=structs, **fixed,
        )  # fmt: skip
        self._refit_nodes = ComputePass(
            device, "BVH nodes", "raytracing/refit_nodes.wgsl",
            [given, storage("links", "vec4u"), storage_rw("boxes", "vec4f"), storage_rw("bvh", "vec4u")],
            structs=[PARAMETERS], largest=float(np.finfo(np.float32).max), **fixed,
        )  # fmt: skip
        self._sort, self._ploc, self._collapse = RadixSort(device), Ploc(device), Collapse(device)

    def sync(self, scene: GpuScene, stage: Stage | None = None) -> None:
        """Bring the BVH up to date: built when other triangles are drawn, refitted when they moved.

        Call it after `scene.sync`. stage: records the refit; without one it is submitted here. A build waits for the
        device between its rounds and is always submitted here. Raises DeviceError when the scene needs a buffer larger
        than one binding.
        """
        if self._moves == scene.moves:
            return
        topology = [(slot.clusters.indices, slot.first_vertex, slot.first_triangle) for slot in scene.drawn.slots]
        if not _same(self._built_for, topology):
            self._built_for = None  # a build that fails leaves none
            self._build(scene)
            self._built_for = topology
        self._write_header(scene)
        if stage is not None:
            self._refit(stage, scene)
        else:
            with self._submitted() as own:
                self._refit(own, scene)
        self._moves = scene.moves

    @property
    def levels(self) -> tuple[int, ...]:
        """How many nodes each level of the tree has, from the root down."""
        return tuple(count for _, count in self._tree.levels)

    def _build(self, scene: GpuScene) -> None:
        self.buffer = self.texture = None
        ids = triangle_ids(scene)
        count = self._triangles = len(ids)
        self._check_size(2 * 16 * 2 * count, count)
        if not count:
            self._tree = Links(None, (), None)
            self._allocate(scene)
            return
        device, resources = self.device, _geometry(scene)
        low, high = scene.bounds
        frame = _FRAME.pack(low=low, scale=(_MORTON_CELLS - 1) / max(float((high - low).max()), 1e-30))
        id_buffer, boxes = device.buffer("BVH build", ids), device.buffer("BVH build", size=32 * count)
        keys = device.buffer("BVH build", size=16 * count)
        with self._submitted() as stage:
            self._leaves.run(stage, (count,), parameters=parameters(device, count), keys=keys, boxes=boxes,
                             frame=device.uniform("BVH build", frame), ids=id_buffer, **resources)  # fmt: skip
            keys = self._sort.run(stage, keys, count)
        binary = self._ploc.run(self._submitted, keys, boxes, count)
        self._tree = self._collapse.run(self._submitted, binary, id_buffer, count)
        self._allocate(scene)

    def _check_size(self, size: int, count: int) -> None:
        limit = DEFAULT_LIMITS["max-storage-buffer-binding-size"]
        if size > limit:
            raise DeviceError(
                f"the BVH of {count} triangles needs a buffer of {readable(size)}; one binding holds "
                f"{readable(limit)}. Use a scene of fewer triangles."
            )

    def _allocate(self, scene: GpuScene) -> None:
        nodes = sum(count for _, count in self._tree.levels) or 1
        self._root = 1 + _TRIANGLE_WORDS * self._triangles
        words = self._root + _NODE_WORDS * nodes
        self._check_size(16 * words, self._triangles)
        rows = -(-words // (1 << _ROW_BITS))
        self.buffer = self.device.buffer("BVH", size=rows << _ROW_BITS + 4)
        usage = wgpu.TextureUsage.STORAGE_BINDING | wgpu.TextureUsage.COPY_DST
        self.texture = self.device.texture("BVH", (1 << _ROW_BITS, rows), "rgba32uint", usage=usage)
        self._boxes = self.device.buffer("BVH boxes", size=32 * nodes)
        self._flags = self.device.buffer("BVH flags", size=4 * len(scene.drawn.instances))
        self._all = parameters(self.device, self._triangles)
        self._levels = [(count, parameters(self.device, count, first, self._root))
                        for first, count in reversed(self._tree.levels)]  # fmt: skip
        # The stack holds at most three siblings a level.
        needed = 3 * len(self._tree.levels) + 1
        stack = -(-needed // _STACK_STEP) * _STACK_STEP
        if stack != self.values["bvh_stack"]:
            self.values = {**self.values, "bvh_stack": stack}
            self.version += 1

    def _write_header(self, scene: GpuScene) -> None:
        low, high = scene.bounds
        header = np.zeros(4, np.uint32)
        header[:3] = self._root, self._triangles, sum(count for _, count in self._tree.levels)
        header[3:] = np.array([max(np.abs(low).max(), np.abs(high).max())], np.float32).view(np.uint32)
        self.device.write(self.buffer, header)
        self.device.write(self._flags, instance_flags(scene))

    def _refit(self, stage: Stage, scene: GpuScene) -> None:
        """Triangles, then boxes: a level sees what the one below it wrote only in a dispatch of its own."""
        if self._triangles:
            self._refit_triangles.run(
                stage, (self._triangles,), parameters=self._all, order=self._tree.order, flags=self._flags,
                bvh=self.buffer, **_geometry(scene),
            )  # fmt: skip
        for count, given in self._levels:
            self._refit_nodes.run(stage, (count,), parameters=given, links=self._tree.links, boxes=self._boxes,
                                  bvh=self.buffer)  # fmt: skip
        width, rows = self.texture.size[:2]
        layout = {"buffer": self.buffer, "bytes_per_row": 16 * width, "rows_per_image": rows}
        stage.encoder.copy_buffer_to_texture(layout, {"texture": self.texture}, (width, rows, 1))

    @contextmanager
    def _submitted(self) -> Iterator[Any]:
        profiler = Profiler(self.device, "off")
        with profiler.frame(), profiler.stage("BVH") as stage:
            yield stage


def _geometry(scene: GpuScene) -> dict[str, Any]:
    return {name: scene.resources[name] for name in ("vertices", "triangles", "instances", "items")}


def _same(before: Topology | None, now: Topology) -> bool:
    if before is None or len(before) != len(now):
        return False
    return all(a[0] is b[0] and a[1:] == b[1:] for a, b in zip(before, now, strict=True))


def triangle_ids(scene: GpuScene, chosen: np.ndarray | None = None) -> np.ndarray:
    """uint32 (triangles,): the numbers of all that is drawn, as the visibility buffer has them less one. chosen: bool
    (items,), of these alone."""
    counts = np.concatenate([s.clusters.count for s in scene.drawn.slots]) if scene.drawn.slots else np.zeros(0, int)
    if chosen is not None:
        counts = np.where(chosen, counts, 0)
    first = np.cumsum(counts) - counts
    items = np.repeat(np.arange(len(counts)), counts)
    return (items << _CLUSTER_BITS | (np.arange(len(items)) - first[items])).astype(np.uint32)


def instance_flags(scene: GpuScene) -> np.ndarray:
    """uint32 (drawn instances,): FLAG_MASKED, FLAG_SINGLE_SIDED, FLAG_FLIPPED."""
    drawn, table = scene.drawn, scene.materials.bucket
    if not drawn.instances:
        return np.zeros(0, np.uint32)
    linear = np.array([instance.transform[:3, :3] for instance in drawn.instances])
    materials = np.array([slot.mesh.material for slot in drawn.slots])
    bucket = table[materials] if len(table) else np.zeros(len(materials), np.int64)
    flags = FLAG_MASKED * ((bucket & MASKED) > 0) + FLAG_SINGLE_SIDED * ((bucket & SINGLE_SIDED) > 0)
    return (flags + FLAG_FLIPPED * (np.linalg.det(linear) < 0)).astype(np.uint32)
