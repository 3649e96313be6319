"""Surfels of the scene's own surfaces, seen or not: what blocks and reflects light does not depend on who looks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..gpu.bindings import uniform
from ..gpu.device import Device
from ..gpu.layout import Struct
from ..gpu.passes import ComputePass
from ..gpu.records import record_texture, records, records_out, word_texture, words_out
from ..gpu_scene.clusters import CLUSTER_TRIANGLES
from ..gpu_scene.gpu_scene import GpuScene
from ..gpu_scene.instances import Drawn
from ..scene.materials import Material
from ..simulator.surfels import lattice_samples
from .frame import Frame
from .shader_values import surface_values
from .structs import VIEW, VPL
from .traits import TRAIT_VALUES

# A place on a triangle: its number as the visibility buffer has it, less one; weights of its second and third corner;
# and what it stands for of the triangle's area, negative for the side that looks the other way.
SAMPLE = Struct("SurfelSample", triangle="u32", second="f32", third="f32", share="f32")
RANGE = Struct("SurfelRange", count="u32")
MOST = 1 << 20
"""Surfels at most: some 40 MB on the device, and as much work as the VPLs of three point lights."""
_ROW = 1 << 20


class SceneSurfels:
    """`surfels`: records of VPL without flux, and `surfaces`: their traits, in the order of the places they were first
    found in; `count` of them. spacing: metres between samples."""

    def __init__(self, device: Device):
        self.device, self.count, self.spacing = device, 0, 0.0
        self.surfels: Any = None
        self.surfaces: Any = None
        self._samples: Any = None
        self._of: tuple[Any, ...] = ()
        self._moves = -1
        self._pass: ComputePass | None = None
        self._pass_of = -1
        self._range = device.uniform("surfel range", RANGE.array(1))

    def run(self, frame: Frame, origin: np.ndarray, spacing: float) -> bool:
        """Bring them to where the scene's surfaces are now; returns whether anything is other than before. Samples are
        chosen when its triangles are others, on a lattice of `spacing` (m), or a multiple of it if there would be more
        than MOST, from `origin`."""
        scene, materials = frame.gpu_scene, frame.scene.materials
        key = (spacing, scene.drawn.item_instance.tobytes(), scene.drawn.item_first.tobytes(),
               *(len(slot.clusters.indices) for slot in scene.drawn.slots),
               *(materials[slot.mesh.material].double_sided for slot in scene.drawn.slots))  # fmt: skip
        if key != self._of:
            self._choose(scene.drawn, frame.scene.materials, origin, spacing)
            self._of, self._moves = key, -1
        if self._moves == scene.moves:
            return False
        self._moves = scene.moves
        if not self.count:
            return True
        if self._pass is None or self._pass_of != scene.version:
            self._pass, self._pass_of = self._made(scene), scene.version
        with frame.profiler.stage("scene surfels") as stage:
            threads = min(self.count, _ROW), -(-self.count // _ROW)
            self._pass.run(
                stage, threads, scene.resources, samples=self._samples, surfels=self.surfels, surfaces=self.surfaces,
                range=self._range,
            )  # fmt: skip
        return True

    def _made(self, scene: GpuScene) -> ComputePass:
        return ComputePass(
            self.device, "scene surfels", "frame/scene_surfels.wgsl",
            [records("samples", SAMPLE), records_out("surfels", VPL), words_out("surfaces"), uniform("range", RANGE)],
            structs=[VIEW, SAMPLE, VPL, RANGE], shared=scene.bindings, workgroup=(64, 1, 1), row=_ROW, **TRAIT_VALUES,
            **surface_values(scene),
        )  # fmt: skip

    def _choose(self, drawn: Drawn, materials: Sequence[Material], origin: np.ndarray, spacing: float) -> None:
        """Surfaces that are seen from both sides have a surfel for either: they reflect from cells of their own."""
        corners, numbers = world_triangles(drawn)
        both = np.concatenate([np.zeros(0, bool), *(
            np.full(len(slot.clusters.indices), materials[slot.mesh.material].double_sided) for slot in drawn.slots
        )])  # fmt: skip
        across = np.abs(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])).max(axis=1) / 2
        projected = across.sum() + across[both].sum()
        self.spacing = spacing * 2.0 ** max(0.0, np.ceil(0.5 * np.log2(max(projected / (MOST * spacing**2), 1.0))))
        triangle, weights, share = lattice_samples(corners, origin, self.spacing)
        twice = np.flatnonzero(both[triangle])
        triangle, weights = np.append(triangle, triangle[twice]), np.concatenate([weights, weights[twice]])
        share = np.append(share, -share[twice])
        place = corners[triangle, 0] + np.einsum("mi,mij->mj", weights, corners[triangle, 1:] - corners[triangle, :1])
        order = _along_a_curve(place - origin, 2.0 * self.spacing)
        samples = SAMPLE.array(len(order))
        samples["triangle"], samples["share"] = numbers[triangle[order]], share[order]
        samples["second"], samples["third"] = weights[order].T
        self.count = len(order)
        self._samples = record_texture(self.device, "surfel samples", SAMPLE, self.count, samples)
        self.surfels = record_texture(self.device, "scene surfels", VPL, self.count)
        self.surfaces = word_texture(self.device, "scene surfels", self.count)
        self.device.write(self._range, RANGE.pack(count=self.count))


def world_triangles(drawn: Drawn) -> tuple[np.ndarray, np.ndarray]:
    """Corners of all drawn triangles, float64 (T, 3, 3), and their numbers, uint32 (T,), in the visibility buffer, less
    one: of an item and in it."""
    corners, numbers, first = [np.zeros((0, 3, 3))], [np.zeros(0, np.uint32)], 0
    for instance, slot in zip(drawn.instances, drawn.slots, strict=True):
        clusters = slot.clusters
        local = slot.mesh.positions.astype(np.float64)[clusters.indices]
        corners.append(local @ instance.transform[:3, :3].T + instance.transform[:3, 3])
        item = first + np.repeat(np.arange(len(clusters.first)), clusters.count)
        within = np.arange(len(clusters.indices)) - np.repeat(clusters.first, clusters.count)
        numbers.append((item * CLUSTER_TRIANGLES + within).astype(np.uint32))
        first += len(clusters.first)
    return np.concatenate(corners), np.concatenate(numbers)


def _along_a_curve(places: np.ndarray, size: float) -> np.ndarray:
    """An order in which neighbours lie in one cell, or in cells side by side: threads that walk along it add up before
    they scatter."""
    cells = np.maximum(np.floor(places / size), 0.0).astype(np.int64)
    code = np.zeros(len(cells), np.int64)
    for bit in range(20):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
