"""Vertices and triangles of all meshes in two buffers. A mesh keeps its place as long as its topology stays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..gpu.device import Device
from ..scene.meshes import Mesh
from ..simulator.camera import pack_normals
from .clusters import Clusters, cluster, refitted
from .packing import pack_colors, pack_tangents
from .structs import TRIANGLE, VERTEX

# Room that is made beyond need when a scene outgrows its buffers: growing one mesh at a time costs O(1) copies each.
_GROWTH = 1.5


@dataclass(frozen=True, eq=False)
class Slot:
    """Where a mesh lies: its clusters, and the numbers of its first vertex and triangle in the buffers."""

    mesh: Mesh
    clusters: Clusters
    first_vertex: int
    first_triangle: int


class GeometryBuffers:
    """`slots[i]` is where mesh i of the scene lies; None for a mesh without triangles."""

    def __init__(self, device: Device):
        self.device = device
        self.slots: list[Slot | None] = []
        self._free_vertex = self._free_triangle = 0
        self._capacity = (0, 0)
        self.vertices = self.triangles = None

    def sync(self, meshes: Sequence[Mesh]) -> bool:
        """Upload what is not there yet; returns whether anything changed.

        A mesh that took the place of another with the same triangles is written over it: that is how animation comes.
        """
        if self.vertices is not None and _same(meshes, self.slots):
            return False
        kept = {id(slot.mesh): slot for slot in self.slots if slot}
        staying = {id(mesh) for mesh in meshes}
        slots: list[Slot | None] = []
        for number, mesh in enumerate(meshes):
            before = self.slots[number] if number < len(self.slots) else None
            if not len(mesh.indices):
                slots.append(None)
            elif id(mesh) in kept:
                slots.append(kept[id(mesh)])
            elif before and id(before.mesh) not in staying and _same_topology(before.mesh, mesh):
                staying.add(id(before.mesh))  # its place is taken, also where it was listed twice
                slots.append(kept.setdefault(id(mesh), self._rewritten(before, mesh)))
            else:
                slots.append(kept.setdefault(id(mesh), self._appended(mesh)))
        self.slots = slots
        if self._free_vertex > self._capacity[0] or self._free_triangle > self._capacity[1] or self.vertices is None:
            self._rebuild()
        return True

    def _rewritten(self, before: Slot, mesh: Mesh) -> Slot:
        clusters = refitted(before.clusters, mesh)
        slot = Slot(mesh, clusters, before.first_vertex, before.first_triangle)
        self.device.write(self.vertices, packed_vertices(mesh), slot.first_vertex * VERTEX.size)
        return slot

    def _appended(self, mesh: Mesh) -> Slot:
        """A place behind all others, written at once if the buffers reach that far, else when they are made anew."""
        slot = Slot(mesh, cluster(mesh), self._free_vertex, self._free_triangle)
        self._free_vertex += len(mesh.positions)
        self._free_triangle += len(mesh.indices)
        if self._free_vertex <= self._capacity[0] and self._free_triangle <= self._capacity[1]:
            self.device.write(self.vertices, packed_vertices(mesh), slot.first_vertex * VERTEX.size)
            self.device.write(self.triangles, _packed_triangles(slot), slot.first_triangle * TRIANGLE.size)
        return slot

    def _rebuild(self) -> None:
        """Lay out all meshes anew, without the places of those that are gone."""
        growing = self.vertices is not None
        moved: dict[int, Slot] = {}
        vertices = triangles = 0
        for slot in self.slots:
            if slot and id(slot.mesh) not in moved:
                moved[id(slot.mesh)] = Slot(slot.mesh, slot.clusters, vertices, triangles)
                vertices, triangles = vertices + len(slot.mesh.positions), triangles + len(slot.mesh.indices)
        self.slots = [moved[id(slot.mesh)] if slot else None for slot in self.slots]
        self._free_vertex, self._free_triangle = vertices, triangles
        room = _GROWTH if growing else 1.0
        self._capacity = (max(1, int(room * vertices)), max(1, int(room * triangles)))
        vertex_data, triangle_data = VERTEX.array(self._capacity[0]), TRIANGLE.array(self._capacity[1])
        for slot in moved.values():
            vertex_data[slot.first_vertex : slot.first_vertex + len(slot.mesh.positions)] = packed_vertices(slot.mesh)
            end = slot.first_triangle + len(slot.mesh.indices)
            triangle_data[slot.first_triangle : end] = _packed_triangles(slot)
        self.vertices = self.device.buffer("vertices", vertex_data)
        self.triangles = self.device.buffer("triangles", triangle_data)


def packed_vertices(mesh: Mesh) -> np.ndarray:
    """The mesh's vertices as the WGSL struct `Vertex`."""
    packed = VERTEX.array(len(mesh.positions))
    packed["position"], packed["uv"] = mesh.positions, mesh.uvs
    packed["normal"], packed["tangent"] = pack_normals(mesh.normals), pack_tangents(mesh.tangents)
    packed["color"] = 0xFFFFFFFF if mesh.colors is None else pack_colors(mesh.colors)
    return packed


def _packed_triangles(slot: Slot) -> np.ndarray:
    packed = TRIANGLE.array(len(slot.clusters.indices))
    packed["a"], packed["b"], packed["c"] = (slot.clusters.indices + np.uint32(slot.first_vertex)).T
    return packed


def _same(meshes: Sequence[Mesh], slots: Sequence[Slot | None]) -> bool:
    if len(meshes) != len(slots):
        return False
    pairs = zip(meshes, slots, strict=True)
    return all(slot.mesh is mesh if slot else not len(mesh.indices) for mesh, slot in pairs)


def _same_topology(a: Mesh, b: Mesh) -> bool:
    if a.indices is not b.indices and not np.array_equal(a.indices, b.indices):
        return False
    return len(a.positions) == len(b.positions)
