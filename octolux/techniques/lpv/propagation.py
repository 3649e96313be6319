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
# Each cell is a neighbour of another in its block, so all of the block's own cells are read.
BLOCK = (1, 2, 2)
_CELL_TYPES = {"f32": "vec4f", "f16": "vec2u"}
_CELL_BYTES = {"f32": 48, "f16": 24}


def block_sources(block: tuple[int, int, int] = BLOCK) -> list[dict[str, Any]]:
    """Which neighbours a block of cells reads: offset, which of the block's own cells it is (or None), and which cells
    use it how."""
    cells = list(itertools.product(*(range(b) for b in block)))
    sources: dict[tuple[int, ...], list[dict[str, Any]]] = {}
    for number, cell in enumerate(cells):
        for direction in transfer.DIRECTIONS.tolist():
            axis = next(i for i in range(3) if direction[i])
            offset = tuple(c - d for c, d in zip(cell, direction, strict=True))
            use = {"cell": number, "axis": "xyz"[axis], "sign": f"{direction[axis]}.0"}
            sources.setdefault(offset, []).append(use)
    own = {cell: number for number, cell in enumerate(cells)}
    return [{"offset": o, "own": own.get(o), "uses": u} for o, u in sources.items()]


class Propagation:
    """`light` holds the accumulated light after `run`: vec4f [z][y][x][rgb], scaled for storage (cells.wgsl)."""

    def __init__(
        self, device: Device, n: int, *, evaluation: str, reprojection: str, gain: float, cell_format: str
    ):
        kind, size = _CELL_TYPES[cell_format], (n + 2) ** 3 * _CELL_BYTES[cell_format]
        self.n = n
        self._cells = [device.buffer("LPV cells", size=size) for _ in range(2)]
        self.light = device.buffer("LPV accumulated light", size=n**3 * 48)
        self._values = {"n": n, "format": cell_format, **propagation_values(evaluation, reprojection, gain)}
        self._device, self._kind = device, kind
        self._start = ComputePass(
            device, "start", "techniques/lpv/start.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), storage_rw("light", "vec4f", "write"),
             storage_rw("cells_out", kind, "write")],
            workgroup=(min(32, n), 4, 2), **self._values,
        )  # fmt: skip
        self._steps: dict[int, ComputePass] = {}

    def _step(self, adds: int) -> ComputePass:
        """The pass that adds so many terms to the sum: none, what it makes, or what it reads as well."""
        if adds not in self._steps:
            light = [storage_rw("light", "vec4f")] if adds else []
            self._steps[adds] = ComputePass(
                self._device, "propagate", "techniques/lpv/propagation.wgsl",
                [storage("cells_in", self._kind), storage_rw("cells_out", self._kind, "write"), *light],
                workgroup=(min(32, self.n), 1, 1), block=BLOCK, adds=adds, sources=block_sources(),
                block_cells=list(itertools.product(*(range(b) for b in BLOCK))), **self._values,
            )  # fmt: skip
        return self._steps[adds]

    def run(self, stage: Any, injected: Any, peak: Any, iterations: int) -> None:
        """Accumulate S_0 to S_k from `injected` (Injection.injected) with k = `iterations`."""
        source, target = self._cells
        self._start.run(stage, (self.n,) * 3, injected=injected, peak=peak, light=self.light, cells_out=source)
        threads = tuple(-(-self.n // size) for size in BLOCK)
        # An odd number of steps begins with one that adds itself; then each second one adds two.
        for adds in [1] * (iterations % 2) + [0, 2] * (iterations // 2):
            light = {"light": self.light} if adds else {}
            self._step(adds).run(stage, threads, cells_in=source, cells_out=target, **light)
            source, target = target, source
