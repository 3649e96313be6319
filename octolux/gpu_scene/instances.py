"""Instances on the device, and their clusters as items: what is culled and drawn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..gpu.device import Device
from ..scene.meshes import Instance
from ..scene.scene import Scene
from .clusters import visible, world_boxes
from .geometry import Slot
from .history import InstanceHistory
from .materials import SINGLE_SIDED, MaterialTable
from .structs import INSTANCE, ITEM


@dataclass(frozen=True, eq=False)
class Drawn:
    """What the drawn numbers mean; kept by pictures, since the scene goes on.

    numbers: of the drawn instances in `Scene.instances`.  instances, slots: theirs.
    item_instance: uint32 (items,), which of the drawn instances.  item_first: int64 (items,), first triangle, counted
    within the mesh's clusters.
    """

    numbers: np.ndarray
    instances: tuple[Instance, ...]
    slots: tuple[Slot, ...]
    item_instance: np.ndarray
    item_first: np.ndarray

    @classmethod
    def of(cls, instances: Sequence[Instance], slots: Sequence[Slot | None]) -> Drawn:
        pairs = [(n, i, s) for n, i in enumerate(instances) if (s := slots[i.mesh]) is not None]
        counts = [len(slot.clusters.first) for _, _, slot in pairs]
        return cls(
            np.array([n for n, _, _ in pairs], dtype=np.int64), tuple(i for _, i, _ in pairs),
            tuple(s for _, _, s in pairs), np.repeat(np.arange(len(pairs), dtype=np.uint32), counts),
            np.concatenate([s.clusters.first for _, _, s in pairs]) if pairs else np.zeros(0, np.int64),
        )  # fmt: skip


class InstanceTable:
    """Buffers `instances` and `items`; boxes of the items for culling; and `history`, which tells what moves.

    left_boxes: float64 (2, k, 3), m, lowest and highest corners, in which those stood that `history.left` names.
    """

    def __init__(self, device: Device):
        self.device = device
        self.drawn: Drawn
        self.bounds = (np.zeros(3), np.zeros(3))
        self.history = InstanceHistory()
        self._rows: np.ndarray = INSTANCE.array(0)
        self._item_rows: np.ndarray = ITEM.array(0)
        self._boxes = np.zeros((2, 0, 3))  # of the drawn instances
        self.left_boxes = self._boxes
        self.instances: Any = None
        self.items: Any = None

    def wait(self) -> None:
        """A sync that brings no change: but what has moved comes to rest some time."""
        self.history.wait()
        moving = self.history.moving
        if (self._rows["moving"][: len(moving)] != moving).any():
            rows = self._rows.copy()
            rows["moving"][: len(moving)] = moving
            self._upload(rows, self._item_rows)

    def sync(self, scene: Scene, slots: Sequence[Slot | None], table: MaterialTable) -> None:
        """Upload rows that differ from what is there."""
        self.drawn = drawn = Drawn.of(scene.instances, slots)
        transforms = np.array([i.transform for i in drawn.instances]).reshape(-1, 4, 4)
        materials = np.array([s.mesh.material for s in drawn.slots], dtype=np.int64)
        stood, version = self._boxes, self.history.static_version
        self._place(drawn, transforms)
        self.history.see(drawn, transforms, scene.materials)
        if version != self.history.static_version:
            self.left_boxes = stood[:, self.history.left]
        rows = INSTANCE.array(max(1, len(transforms)))
        items = ITEM.array(max(1, len(drawn.item_instance)))
        if len(transforms):
            owner = drawn.item_instance
            items["instance"] = owner
            first = np.array([s.first_triangle for s in drawn.slots])
            items["first_triangle"] = drawn.item_first + first[owner]
            items["triangle_count"] = np.concatenate([s.clusters.count for s in drawn.slots])
            has_materials = len(table.bucket) > 0  # a scene without any is drawn in the table's empty row
            self._buckets = table.bucket[materials][owner] if has_materials else np.zeros(len(owner), np.int64)
            self._glowing = table.glowing[materials][owner] if has_materials else np.zeros(len(owner), bool)
            rows["row0"], rows["row1"], rows["row2"] = transforms[:, 0], transforms[:, 1], transforms[:, 2]
            rows["material"], rows["flipped"] = materials, np.linalg.det(transforms[:, :3, :3]) < 0
            rows["size"], rows["moving"] = (self._boxes[1] - self._boxes[0]).max(axis=1), self.history.moving
        else:
            self._buckets, self._glowing = np.zeros(0, np.int64), np.zeros(0, bool)
        self._upload(rows, items)

    def _place(self, drawn: Drawn, transforms: np.ndarray) -> None:
        """Find the boxes of items, of instances, each of which has items that stand together, and of all."""
        if not len(transforms):
            self._low = self._high = np.zeros((0, 3))
            self._boxes, self.bounds = np.zeros((2, 0, 3)), (np.zeros(3), np.zeros(3))
            return
        low = np.concatenate([s.clusters.low for s in drawn.slots])
        high = np.concatenate([s.clusters.high for s in drawn.slots])
        self._low, self._high = world_boxes(low, high, transforms[drawn.item_instance])
        starts = np.flatnonzero(np.diff(drawn.item_instance.astype(np.int64), prepend=-1))
        self._boxes = np.stack([np.minimum.reduceat(self._low, starts), np.maximum.reduceat(self._high, starts)])
        self.bounds = (self._low.min(axis=0), self._high.max(axis=0))

    @property
    def culls(self) -> bool:
        """Whether any of them has backs that a camera looks through."""
        return bool((self._buckets & SINGLE_SIDED).any())

    @property
    def item_boxes(self) -> tuple[np.ndarray, np.ndarray]:
        """float64 (items, 3) each, m: the lowest and the highest corner of each item's box, in world space."""
        return self._low, self._high

    def _upload(self, rows: np.ndarray, items: np.ndarray) -> None:
        self.instances = self._brought(self.instances, "instances", self._rows, rows)
        self.items = self._brought(self.items, "items", self._item_rows, items)
        self._rows, self._item_rows = rows, items

    def _brought(self, buffer: Any, label: str, before: np.ndarray, now: np.ndarray) -> Any:
        """`buffer` brought from `before` to `now`: only the run of rows that differ is written."""
        if buffer is None or len(before) != len(now):
            return self.device.buffer(label, now)
        differ = np.flatnonzero(before != now)
        if len(differ):
            first, end = int(differ[0]), int(differ[-1]) + 1
            self.device.write(buffer, now[first:end], first * now.dtype.itemsize)
        return buffer

    def visible_items(self, view_projection: np.ndarray, buckets: int, cull: bool, glowing: bool) -> list[np.ndarray]:
        """For each draw bucket the items whose box the view may see: uint32 arrays, in a fixed order."""
        seen = visible(self._low, self._high, view_projection) if cull else np.ones(len(self._low), bool)
        if not glowing:
            seen &= ~self._glowing
        return [np.flatnonzero(seen & (self._buckets == b)).astype(np.uint32) for b in range(buckets)]
