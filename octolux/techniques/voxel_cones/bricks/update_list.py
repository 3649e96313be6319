"""Filtering of what is touched alone: the light that is other than before, and what is made of it (VCT 5.5)."""

from __future__ import annotations

from typing import Any

import numpy as np
import wgpu

from ....gpu.bindings import Binding, atomic_words, storage_rw
from ....gpu.device import Device
from ..octree.octree import LABEL
from ..octree.pools import Pool, parameters
from .bricks import Bricks

ARGUMENTS = 4
"""Words of `lists` for each list: workgroups x, y, z, and its length."""


class UpdateList:
    """Lists that are as long as what is touched (touch.wgsl): of the nodes of each level, and of bricks. Who changes
    light of level 0 touches its nodes, with `touching` and `resources`; passes over lists are as many threads as these
    are long, so that nothing is looked at but what is touched.

    count: buffer of a u32, how many bricks the last update made anew.
    """

    touching: tuple[Binding, ...] = (
        atomic_words("touched", "u32"), atomic_words("lists", "u32"), storage_rw("node_list", "u32"),
    )  # fmt: skip

    def __init__(self, device: Device, bricks: Bricks):
        self.device, self.bricks = device, bricks
        empty = np.tile(np.array([0, 1, 1, 0], np.uint32), bricks.octree.depth + 1)
        self._empty, self._lists = device.buffer(LABEL, empty), device.buffer(LABEL, empty)
        self._arguments = device.buffer(LABEL, size=16, usage=wgpu.BufferUsage.INDIRECT)
        self.count = device.buffer(LABEL, size=4)

        def words(count: int) -> Any:
            return device.buffer(LABEL, size=4 * count)

        self._touched, self._nodes = (Pool("nodes", words, limit=bricks.ways.limit) for _ in range(2))
        self._updates = Pool("bricks", words, limit=bricks.light.limit)

    def make_room(self) -> None:
        """For the octree's nodes and bricks."""
        for pool in (self._touched, self._nodes):
            pool.need(self.bricks.octree.counts.nodes)
        self._updates.need(self.bricks.count)
        begins = np.cumsum([0, *(count for _, count in self.bricks.octree.counts.levels)]).tolist()
        self.levels = [parameters(self.device, level, *begins[level : level + 2]) for level in range(len(begins) - 1)]
        """For each level the parameters of climb.wgsl."""

    @property
    def resources(self) -> dict[str, Any]:
        """What to bind to `touching`."""
        return {"touched": self._touched.resource, "lists": self._lists, "node_list": self._nodes.resource}

    @property
    def listed(self) -> dict[str, Any]:
        """What to bind to `lists`, read only, and `update_list`: the bricks."""
        return {"lists": self._lists, "update_list": self._updates.resource}

    def arguments(self, stage: Any, number: int) -> Any:
        """A buffer of the arguments for a pass over a list: of a level, or, as number `depth`, of the bricks."""
        stage.encoder.copy_buffer_to_buffer(self._lists, 4 * ARGUMENTS * number, self._arguments, 0, 4 * ARGUMENTS)
        return self._arguments

    def forget(self, stage: Any) -> None:
        """Empty all lists."""
        stage.encoder.copy_buffer_to_buffer(self._empty, 0, self._lists, 0, self._empty.size)
        stage.encoder.clear_buffer(self._touched.resource)

    def note(self, stage: Any) -> None:
        """Keep how many bricks are listed, in `count`."""
        place = 4 * (ARGUMENTS * self.bricks.octree.depth + 3)
        stage.encoder.copy_buffer_to_buffer(self._lists, place, self.count, 0, 4)

    def read(self) -> np.ndarray:
        """uint32 (count,): the bricks that the last update made anew, in any order."""
        read = self.device.queue.read_buffer
        count = int(np.frombuffer(read(self.count), np.uint32)[0])
        return np.frombuffer(read(self._updates.resource), np.uint32)[:count]
