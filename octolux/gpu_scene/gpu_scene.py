"""GpuScene: a scene's buffers and textures on the device, brought up to date before each frame."""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np
import wgpu

from ..gpu.bindings import BindGroup, storage_words
from ..gpu.device import Device
from ..scene.scene import Scene
from .geometry import GeometryBuffers
from .instances import Drawn, InstanceTable
from .materials import BUCKETS, MaterialTable
from .structs import INSTANCE, ITEM, MATERIAL, TRIANGLE, VERTEX


class GpuScene:
    """Only what changed is uploaded: a replaced material its table, a deformed mesh its vertices, a moved instance its
    row. Frozen elements are compared by identity; those of the last sync are kept alive, so an id is not reused.

    `bindings` is the bind group (group 1 of the passes that meet surfaces), `resources` what to bind to it, `values`
    what the shaders' templates want to know of the scene. `version` grows when `bindings` or `values` change, so
    that passes made for them are made anew.
    """

    def __init__(self, device: Device):
        self.device = device
        self.version = 0
        self.moves = 0  # grows with every change of what is drawn
        self.geometry, self.materials = GeometryBuffers(device), MaterialTable(device)
        self._placed = InstanceTable(device)
        self._instances: tuple | None = None
        self.values: dict[str, Any] = {}

    def sync(self, scene: Scene, normal_maps: bool = True) -> None:
        """Bring the device up to date with `scene`; without `normal_maps` as if no material had one."""
        before, self._instances = self._instances, None  # after a sync that fails half-way all counts as changed
        materials_changed = self.materials.sync(scene.materials, normal_maps)
        meshes_changed = self.geometry.sync(scene.meshes)
        if materials_changed or meshes_changed:
            values = {**self.materials.values, "vertex_colors": any(m.colors is not None for m in scene.meshes)}
            if values != self.values:
                self.values = values
                self.version += 1
                self.__dict__.pop("bindings", None)
        instances = tuple(scene.instances)
        moved = before is None or not _same(instances, before)
        if materials_changed or meshes_changed or moved:
            self.moves += 1
            self._placed.sync(scene, self.geometry.slots, self.materials)
        else:
            self._placed.wait()
        self._instances = instances

    @property
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """World-space box of all that is drawn, float64 (3,) each."""
        return self._placed.bounds

    @property
    def drawn(self) -> Drawn:
        """What the numbers in the visibility buffer mean at present."""
        return self._placed.drawn

    @property
    def static_version(self) -> int:
        """Grows when something static began to move, appeared, vanished or became another (history.py)."""
        return self._placed.history.static_version

    @property
    def left_boxes(self) -> np.ndarray:
        """World-space boxes (lowest and highest corners, k, 3), m, in which what had been static stood before the sync
        that brought this `static_version`."""
        return self._placed.left_boxes

    @property
    def has_changed(self) -> np.ndarray:
        """bool (drawn instances,): which have moved, been deformed or got another material (history.py)."""
        return self._placed.history.has_changed

    @property
    def is_moving(self) -> np.ndarray:
        """bool (drawn instances,): which count as moving now (history.py)."""
        return self._placed.history.moving

    @property
    def lasting_version(self) -> int:
        """Grows when what is drawn of the others began to change, appeared or vanished (history.py)."""
        return self._placed.history.lasting_version

    @property
    def culls(self) -> bool:
        """Whether anything that is drawn has backs that a camera looks through."""
        return self._placed.culls

    @property
    def item_boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """World-space boxes of all items, low and high, float64 (items, 3), m."""
        return self._placed.item_boxes

    @property
    def has_emission(self) -> bool:
        return self.values["emissive"]

    def visible_items(self, view_projection: np.ndarray, cull: bool = True, glowing: bool = True) -> list[np.ndarray]:
        """For each draw bucket the items whose box the view may see: uint32 arrays, in a fixed order.

        glowing: also those whose material emits light.
        """
        return self._placed.visible_items(view_projection, BUCKETS, cull, glowing)

    @cached_property
    def bindings(self) -> BindGroup:
        buffers = [
            storage_words("vertices", VERTEX), storage_words("triangles", TRIANGLE),
            storage_words("instances", INSTANCE), storage_words("items", ITEM), storage_words("materials", MATERIAL),
        ]  # fmt: skip
        visibility = wgpu.ShaderStage.COMPUTE | wgpu.ShaderStage.VERTEX | wgpu.ShaderStage.FRAGMENT
        structs = (VERTEX, TRIANGLE, INSTANCE, ITEM, MATERIAL)
        return BindGroup([*buffers, *self.materials.textures.bindings()], structs, visibility)

    @property
    def resources(self) -> dict[str, Any]:
        return {
            "vertices": self.geometry.vertices, "triangles": self.geometry.triangles,
            "instances": self._placed.instances, "items": self._placed.items, "materials": self.materials.buffer,
            **self.materials.textures.resources,
        }  # fmt: skip


def _same(a: tuple, b: tuple) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))
