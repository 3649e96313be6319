"""Light by steps through the leaves of an octree alone, each on its own level (OLPV 7.1; simulator/lpv/sparse.py)."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from ....gpu.bindings import atomic_words, storage, storage_rw, storage_texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.lpv import transfer
from ....simulator.lpv.octree import level_sizes
from ..constants import propagation_values, storage_scale
from ..levels import ROW, Levels
from ..lookup import CHANNELS, Lookup
from ..propagation import CELL_BYTES, CELL_TYPES
from .settings import OctreeLpvSettings

_SLOTS = 8  # of a brick
_ROOM = 1.25  # bricks that there is room for, over those that were needed when it became too small


def around(margin: int) -> list[dict[str, Any]]:
    """Cells whose children may be at most `margin` children away from one of a cell's own: their offset (x, y, z) and
    which children, as bits."""
    reach = range(-margin, margin + 2)
    parts: dict[tuple[int, ...], int] = {}
    for child in itertools.product(reach, repeat=3):
        offset, corner = tuple(c // 2 for c in child), sum((c % 2) << axis for axis, c in enumerate(child))
        parts[offset] = parts.get(offset, 0) | 1 << corner
    return [{"offset": offset, "bits": bits} for offset, bits in parts.items()]


def _directions() -> list[dict[str, Any]]:
    """The six ways light travels, for the template: near and strides are those of the four children of a brick at the
    side where light leaves."""
    found = []
    for direction in transfer.DIRECTIONS.tolist():
        axis = next(i for i in range(3) if direction[i])
        others = [i for i in range(3) if i != axis]
        found.append({
            "direction": direction, "axis": "xyz"[axis], "sign": f"{direction[axis]}.0",
            "near": (direction[axis] > 0) << axis, "others": ["xyz"[i] for i in others],
            "strides": [1 << i for i in others],
        })  # fmt: skip
    return found


class Tree:
    """Which cells are split, found anew each frame. After `count_bricks`, `bricks` of them.

    numbers: u32 of each cell of level 1 and above, its children's brick counted from 1, or 0.  nodes: u32 of each
    brick, where it lies (sparse_nodes.wgsl).  count: u32, how many there are.
    """

    def __init__(self, device: Device, n: int, threshold: float, margin: int):
        self._device, self.n, self.bricks = device, n, 0
        self._sizes = level_sizes(n)[1:]
        words = sum(size**3 for size in self._sizes)
        self.numbers, self.nodes, self._marks = (device.buffer("LPV tree", size=4 * words) for _ in range(3))
        self.count = device.buffer("LPV tree", size=4)
        self._lit = ComputePass(
            device, "lit", "techniques/lpv/octree/sparse_lit.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), storage_rw("marks", "u32", "write")],
            workgroup=(4, 4, 4), n=n, threshold=8.0 * threshold, reads=[],  # storage_scale.wgsl: the peak is 8 to 16
        )  # fmt: skip
        self._splits = [
            ComputePass(
                device, "split", "techniques/lpv/octree/sparse_split.wgsl",
                [atomic_words("marks", "u32"), atomic_words("count", "u32"),
                 storage_rw("brick_numbers", "u32", "write"), storage_rw("bricks", "u32", "write")],
                workgroup=(4, 4, 4), n=n, level=level, edge=size, margin=margin, around=around(margin), reads=[],
            )
            for level, size in enumerate(self._sizes, 1)
        ]  # fmt: skip

    def build(self, stage: Any, injected: Any, peak: Any) -> None:
        stage.encoder.clear_buffer(self._marks)
        stage.encoder.clear_buffer(self.count)
        self._lit.run(stage, (self._sizes[0],) * 3, injected=injected, peak=peak, marks=self._marks)
        for size, split in zip(self._sizes, self._splits, strict=True):
            split.run(stage, (size,) * 3, marks=self._marks, count=self.count, brick_numbers=self.numbers,
                      bricks=self.nodes)  # fmt: skip

    def count_bricks(self) -> int:
        """Waits for the device; what `build` was recorded in has been submitted."""
        self.bricks = int(np.frombuffer(self._device.queue.read_buffer(self.count, 0, 4), np.uint32)[0])
        return self.bricks

    @property
    def leaves(self) -> int:
        """How many leaves there were when bricks were counted: each split cell but the root is a slot that is none."""
        return (_SLOTS - 1) * self.bricks + 1

    def places(self) -> tuple[np.ndarray, np.ndarray]:
        """Level and (x, y, z) of each slot, (slots,) and (slots, 3)."""
        slots = np.arange(_SLOTS * self.bricks)
        packed = np.frombuffer(self._device.queue.read_buffer(self.nodes), np.uint32)[slots // _SLOTS].astype(int)
        parent = np.stack([packed & 127, packed >> 7 & 127, packed >> 14 & 127], axis=-1)
        return packed >> 21, 2 * parent + np.stack([slots & 1, slots >> 1 & 1, slots >> 2 & 1], axis=-1)


class SparseStepping:
    """`lookup` reads the volume that the leaves' light is written into, and `light` is theirs: vec4f
    [brick][slot][rgb], accumulated, scaled for storage. What holds light grows with the bricks of the tree."""

    def __init__(self, device: Device, settings: OctreeLpvSettings):
        s = settings
        self._device, self._settings = device, s
        self.tree = Tree(device, s.n, s.threshold, s.margin)
        self.lookup = Lookup(
            device, s.n, reading=s.reading, damping=False, lookup_offset=s.lookup_offset, scale=s.scale
        )
        kind = CELL_TYPES[s.cell_format]
        nodes = [storage("count", "u32"), storage("bricks", "u32"), storage("brick_numbers", "u32")]
        cells_out, light = storage_rw("cells_out", kind, "write"), storage_rw("light", "vec4f")
        depth = len(level_sizes(s.n))
        values = {
            "n": s.n, "depth": depth, "row": ROW, "format": s.cell_format, "reads": ["bricks", "brick_numbers"],
            "levels": Levels([s.n]).described(), **propagation_values(s.evaluation, s.reprojection, s.gain),
        }  # fmt: skip
        self._start = ComputePass(
            device, "start", "techniques/lpv/octree/sparse_start.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), *nodes, light, cells_out], workgroup=(64, 1, 1),
            access=["store"], **values,
        )  # fmt: skip
        self._step = ComputePass(
            device, "propagate", "techniques/lpv/octree/sparse_step.wgsl",
            [storage("cells_in", kind), *nodes, light, cells_out], workgroup=(64, 1, 1), access=["load", "store"],
            directions=_directions(), **values,
        )  # fmt: skip
        self._merge = ComputePass(
            device, "merge", "techniques/lpv/octree/sparse_merge.wgsl",
            [storage("light", "vec4f"), storage("brick_numbers", "u32"),
             *(storage_texture(f"{c}_out", "rgba16float", "3d") for c in CHANNELS)],
            workgroup=(4, 4, 4), n=s.n, depth=depth, reads=["brick_numbers"],
        )  # fmt: skip
        self._make_room(1)

    def _make_room(self, bricks: int) -> None:
        self.room = min(bricks, (self._settings.n**3 - 1) // (_SLOTS - 1))
        slots, size = _SLOTS * self.room, CELL_BYTES[self._settings.cell_format]
        self._cells = [self._device.buffer("LPV cells", size=slots * size) for _ in range(2)]
        self.light = self._device.buffer("LPV accumulated light", size=slots * CELL_BYTES["f32"])

    def run(self, profiler: Any, injected: Any, peak: Any) -> None:
        """From `injected` (W/sr, all levels) to the volumes that the lookup filters. The host waits once, to learn how
        many bricks there are: light never lacks room."""
        with profiler.stage("tree") as stage:
            self.tree.build(stage, injected, peak)
        profiler.submit()
        bricks = self.tree.count_bricks()
        if bricks > self.room:
            self._make_room(int(_ROOM * bricks))
        nodes = {"count": self.tree.count, "bricks": self.tree.nodes, "brick_numbers": self.tree.numbers}
        slots = _SLOTS * bricks
        threads = (min(slots, ROW), -(-slots // ROW))
        with profiler.stage("propagation") as stage:
            source, target = self._cells
            self._start.run(stage, threads, injected=injected, peak=peak, light=self.light, cells_out=source, **nodes)
            ways = [{"cells_in": a, "cells_out": b, "light": self.light, **nodes}
                    for a, b in ((source, target), (target, source))]  # fmt: skip
            self._step.run_many(stage, threads, [ways[i % 2] for i in range(self._settings.iterations)])
        with profiler.stage("merge") as stage:
            outputs = {f"{c}_out": self.lookup.volumes[c] for c in CHANNELS}
            given = {"light": self.light, "brick_numbers": self.tree.numbers, **outputs}
            self._merge.run(stage, (self._settings.n,) * 3, **given)

    def accumulated(self, peak: float) -> list[np.ndarray]:
        """float32 [z][y][x][rgb][4] on each level, W/sr, zero but in leaves."""
        levels, places = self.tree.places()
        flat = np.frombuffer(self._device.queue.read_buffer(self.light), np.float32).reshape(-1, 3, 4)
        found = [np.zeros((size, size, size, 3, 4), np.float32) for size in level_sizes(self._settings.n)]
        for level, cells in enumerate(found):
            here = levels == level
            x, y, z = places[here].T
            cells[z, y, x] = flat[: len(levels)][here] / storage_scale(peak)
        return found
