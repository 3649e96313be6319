"""GpuScene: a scene's buffers and textures on the device, brought up to date before each frame."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import wgpu

from ..gpu.bindings import BindGroup, storage_words
from ..gpu.device import Device
from ..scene.materials import Material, Texture
from ..scene.scene import Scene
from ..simulator.camera import pack_normals
from .clusters import Clusters, cluster, visible, world_boxes
from .packing import pack_tangents
from .structs import INSTANCE, ITEM, MATERIAL, TRIANGLE, VERTEX
from .textures import TextureArrays

_SLOTS = (
    ("base_color_texture", True), ("metallic_roughness_texture", False),
    ("normal_texture", False), ("emissive_texture", True),
)  # fmt: skip
# Draw buckets: bit 0 alpha-masked, bit 1 single-sided (its back faces are culled for the camera).
MASKED, SINGLE_SIDED = 1, 2
BUCKETS = 4
_NEVER = (object(),)  # is not what any scene holds, not even an empty one


class GpuScene:
    """Meshes and materials are uploaded when their lists hold other elements than before, transforms likewise.

    `bindings` is the bind group (group 1 of the passes that meet surfaces), `resources` what to bind to it.
    """

    def __init__(self, device: Device):
        self.device = device
        self.version = 0  # grows when the bindings change, so that passes made for them are made anew
        self._geometry_of: tuple = _NEVER
        self._placement_of: tuple = _NEVER
        self.bounds = (np.zeros(3), np.zeros(3))

    def sync(self, scene: Scene) -> None:
        """Bring the device up to date with `scene`; what has not changed is left alone.

        Frozen elements are compared by identity: the tuple of the last sync keeps them alive, so an id is not reused.
        """
        geometry = (*scene.meshes, *scene.materials)
        placement = (*geometry, *scene.instances)
        if _same(geometry, self._geometry_of) and _same(placement, self._placement_of):
            return
        if not _same(geometry, self._geometry_of):
            self._upload_materials(scene.materials)
            self._upload_meshes(scene)
            self.version += 1
        self._upload_instances(scene)
        self._geometry_of, self._placement_of = geometry, placement

    def _upload_meshes(self, scene: Scene) -> None:
        self._clusters = [cluster(mesh) for mesh in scene.meshes if len(mesh.indices)]
        self._slot_of = {i: slot for slot, i in enumerate(i for i, m in enumerate(scene.meshes) if len(m.indices))}
        self._clear_derived()
        meshes = [m for m in scene.meshes if len(m.indices)]
        vertices = VERTEX.array(max(1, sum(len(m.positions) for m in meshes)))
        triangles = TRIANGLE.array(max(1, sum(len(c.indices) for c in self._clusters)))
        base, done = 0, 0
        for mesh, clusters in zip(meshes, self._clusters, strict=True):
            part = vertices[base : base + len(mesh.positions)]
            part["position"], part["uv"] = mesh.positions, mesh.uvs
            part["normal"], part["tangent"] = pack_normals(mesh.normals), pack_tangents(mesh.tangents)
            corners = triangles[done : done + len(clusters.indices)]
            corners["a"], corners["b"], corners["c"] = (clusters.indices + np.uint32(base)).T
            base, done = base + len(mesh.positions), done + len(clusters.indices)
        self._vertices = self.device.buffer("vertices", vertices)
        self._triangles = self.device.buffer("triangles", triangles)

    def _clear_derived(self) -> None:
        for name in ("bindings", "_first_triangles"):
            self.__dict__.pop(name, None)

    @cached_property
    def _first_triangles(self) -> np.ndarray:
        """Where each mesh's triangles begin in the common buffer."""
        counts = [len(c.indices) for c in self._clusters]
        return np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)

    def _upload_materials(self, materials: list[Material]) -> None:
        slots = [(m, slot, srgb) for m in materials for slot, srgb in _SLOTS]
        uses: list[tuple[Texture, bool]] = [(t, srgb) for m, slot, srgb in slots if (t := getattr(m, slot))]
        self.textures = TextureArrays(self.device, uses)
        self.used_slots = {slot for m, slot, _ in slots if getattr(m, slot)}
        self.has_other_wraps = any(t.wrap != ("repeat", "repeat") for t, _ in uses)
        self.has_emission = any(max(m.emissive) > 0 for m in materials)
        table = MATERIAL.array(max(1, len(materials)))
        for row, material in zip(table, materials, strict=False):
            for name in ("base_color", "alpha", "emissive", "alpha_cutoff", "metallic", "roughness", "specular"):
                row[name] = getattr(material, name)
            row["normal_scale"] = material.normal_scale
            # Blended surfaces are cut at their cutoff until a later issue brings transparency.
            row["masked"], row["double_sided"] = material.alpha_mode != "opaque", material.double_sided
            for slot, srgb in _SLOTS:
                row[slot] = self.textures.packed_reference(getattr(material, slot), srgb)
        self._materials = self.device.buffer("materials", table)
        masked = np.array([m.alpha_mode != "opaque" for m in materials], dtype=np.int64)
        single = np.array([not m.double_sided for m in materials], dtype=np.int64)
        self._material_bucket = masked * MASKED + single * SINGLE_SIDED

    def _upload_instances(self, scene: Scene) -> None:
        drawn = [i for i in scene.instances if i.mesh in self._slot_of]
        table = INSTANCE.array(max(1, len(drawn)))
        items, low, high, buckets = [], [], [], []
        for index, instance in enumerate(drawn):
            m, slot = instance.transform, self._slot_of[instance.mesh]
            material = scene.meshes[instance.mesh].material
            table[index]["row0"], table[index]["row1"], table[index]["row2"] = m[0], m[1], m[2]
            table[index]["material"], table[index]["flipped"] = material, np.linalg.det(m[:3, :3]) < 0
            items.append(self._items_of(index, slot, self._clusters[slot]))
            boxes = world_boxes(self._clusters[slot].low, self._clusters[slot].high, m)
            low.append(boxes[0])
            high.append(boxes[1])
            buckets.append(np.full(len(boxes[0]), self._material_bucket[material]))
        self._instances = self.device.buffer("instances", table)
        self._items = self.device.buffer("items", np.concatenate(items) if items else ITEM.array(1))
        self._low = np.concatenate(low) if low else np.zeros((0, 3))
        self._high = np.concatenate(high) if high else np.zeros((0, 3))
        self._buckets = np.concatenate(buckets) if buckets else np.zeros(0, np.int64)
        self.instance_of_item = np.concatenate([i["instance"] for i in items]) if items else np.zeros(0, np.uint32)
        if len(self._low):
            self.bounds = (self._low.min(axis=0), self._high.max(axis=0))

    def _items_of(self, instance: int, slot: int, clusters: Clusters) -> np.ndarray:
        items = ITEM.array(len(clusters.first))
        items["instance"] = instance
        items["first_triangle"] = clusters.first + self._first_triangles[slot]
        items["triangle_count"] = clusters.count
        return items

    def visible_items(self, view_projection: np.ndarray, cull: bool = True) -> list[np.ndarray]:
        """For each draw bucket the items whose box the view may see: uint32 arrays, in a fixed order."""
        seen = visible(self._low, self._high, view_projection) if cull else np.ones(len(self._low), bool)
        return [np.flatnonzero(seen & (self._buckets == b)).astype(np.uint32) for b in range(BUCKETS)]

    @cached_property
    def bindings(self) -> BindGroup:
        buffers = [
            storage_words("vertices", VERTEX), storage_words("triangles", TRIANGLE),
            storage_words("instances", INSTANCE), storage_words("items", ITEM), storage_words("materials", MATERIAL),
        ]  # fmt: skip
        visibility = wgpu.ShaderStage.COMPUTE | wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
        structs = (VERTEX, TRIANGLE, INSTANCE, ITEM, MATERIAL)
        return BindGroup([*buffers, *self.textures.bindings()], structs, visibility)

    @property
    def resources(self) -> dict[str, Any]:
        return {
            "vertices": self._vertices, "triangles": self._triangles, "instances": self._instances,
            "items": self._items, "materials": self._materials, **self.textures.resources,
        }  # fmt: skip


def _same(a: tuple, b: tuple) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))
