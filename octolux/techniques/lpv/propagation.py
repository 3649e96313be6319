"""Propagation of a volume of n^3 cells: k steps of face flux and reprojection, and the sum of all of them."""

from __future__ import annotations

import itertools
from typing import Any

from ...gpu.bindings import storage, storage_rw
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from ...simulator.lpv import transfer
from .constants import propagation_values

# Cells a thread does: neighbours in y and z share loads, while threads side by side in x read what lies side by side.
BLOCK = (1, 2, 2)
_CELL_TYPES = {"f32": "vec4f", "f16": "vec2u"}
_CELL_BYTES = {"f32": 48, "f16": 24}


def block_sources(n: int, block: tuple[int, int, int] = BLOCK) -> list[dict[str, Any]]:
    """Which neighbours a block of cells reads: offset, guard against the border, and which cells use it how."""
    cells = list(itertools.product(*(range(b) for b in block)))
    sources: dict[tuple[int, ...], list[dict[str, Any]]] = {}
    for number, cell in enumerate(cells):
        for direction in transfer.DIRECTIONS.tolist():
            axis = next(i for i in range(3) if direction[i])
            offset = tuple(c - d for c, d in zip(cell, direction, strict=True))
            use = {"cell": number, "axis": "xyz"[axis], "sign": f"{direction[axis]}.0"}
            sources.setdefault(offset, []).append(use)
    return [{"offset": o, "guard": _guard(o, block, n), "uses": uses} for o, uses in sources.items()]


def _guard(offset: tuple[int, ...], block: tuple[int, int, int], n: int) -> str:
    for axis, (position, size) in enumerate(zip(offset, block, strict=True)):
        if position < 0:
            return f"base.{'xyz'[axis]} > 0"
        if position >= size:
            return f"base.{'xyz'[axis]} < {n - size}"
    return ""


class Propagation:
    """`light` holds the accumulated light after `run`: vec4f [z][y][x][rgb], scaled for storage (cells.wgsl)."""

    def __init__(
        self, device: Device, n: int, *, evaluation: str, reprojection: str, gain: float, cell_format: str
    ):
        kind, size = _CELL_TYPES[cell_format], n**3 * _CELL_BYTES[cell_format]
        self.n = n
        self._cells = [device.buffer("LPV cells", size=size) for _ in range(2)]
        self.light = device.buffer("LPV accumulated light", size=n**3 * 48)
        values = {"n": n, "format": cell_format, **propagation_values(evaluation, reprojection, gain)}
        self._start = ComputePass(
            device, "start", "techniques/lpv/start.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), storage_rw("light", "vec4f", "write"),
             storage_rw("cells_out", kind, "write")],
            workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        self._step = ComputePass(
            device, "propagate", "techniques/lpv/propagation.wgsl",
            [storage("cells_in", kind), storage_rw("cells_out", kind, "write"), storage_rw("light", "vec4f")],
            workgroup=(min(32, n), 1, 1), block=BLOCK, block_cells=list(itertools.product(*(range(b) for b in BLOCK))),
            sources=block_sources(n), **values,
        )  # fmt: skip

    def run(self, stage: Any, injected: Any, peak: Any, iterations: int) -> None:
        """Accumulate S_0 to S_k from `injected` (Injection.injected) with k = `iterations`."""
        a, b = self._cells
        self._start.run(
            stage, (self.n**3 * 3,), injected=injected, peak=peak, light=self.light, cells_out=a
        )
        if not iterations:
            return
        threads = tuple(-(-self.n // size) for size in BLOCK)
        forth = {"cells_in": a, "cells_out": b, "light": self.light}
        back = {"cells_in": b, "cells_out": a, "light": self.light}
        self._step.run_many(stage, threads, [(forth, back)[i % 2] for i in range(iterations)])
