"""Propagation of a volume's levels: k steps of face flux and reprojection, and the sum of all of them."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

from ...gpu.bindings import storage, storage_rw
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from ...simulator.lpv import transfer
from .constants import propagation_values
from .levels import ROW, WORKGROUP, Levels

# Cells a thread does: neighbours in y and z share loads, while threads side by side in x read what lies side by side.
# Each cell is a neighbour of another in its block, so all of the block's own cells are read.
BLOCK = (1, 2, 2)
CELL_TYPES = {"f32": "vec4f", "f16": "vec2u"}
CELL_BYTES = {"f32": 48, "f16": 24}


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


UNIT = ("1, 0, 0", "0, 1, 0", "0, 0, 1")  # of x, y and z, for templates


class _Faces:
    """`faces`: vec4f as the stored cells lie, three a cell: what its lower faces let through (faces.wgsl)."""

    def __init__(self, device: Device, levels: Levels):
        self.faces = device.buffer("LPV faces", size=levels.stored * 48)
        self._threads = levels.dispatched(beyond=1)
        self._pass = ComputePass(
            device, "faces", "techniques/lpv/faces.wgsl",
            [storage("shares", "vec4f"), storage_rw("faces", "vec4f", "write")], workgroup=(WORKGROUP, 1, 1),
            levels=levels.described(beyond=1), unit=UNIT, row=ROW, evaluation="", access=[],
        )  # fmt: skip

    def run(self, stage: Any, shares: Any) -> None:
        self._pass.run(stage, self._threads, shares=shares, faces=self.faces)


class Propagation:
    """`light` holds the accumulated light after `run`: vec4f [level][z][y][x][rgb], scaled for storage (cells.wgsl).

    sizes: cells along each side of the levels, all of which are propagated by the same dispatches; one is a uniform
    volume. Of a level of one cell all light leaves: it is not propagated.
    occlusion: the geometry volume dims what passes the cells' faces.
    threshold: with one, `touched` becomes 1 where a level has been brought light (OLPV 4.2, the index volume): a
    contribution of more than that share of the power of two below the largest injected one.
    """

    def __init__(
        self, device: Device, sizes: Sequence[int], *, evaluation: str, reprojection: str, gain: float,
        cell_format: str, threshold: float | None = None, occlusion: bool = False,
    ):  # fmt: skip
        self.levels = Levels(sizes)
        self._travelled = Levels([n for n in sizes if n > 1])
        self._device, self.kind = device, CELL_TYPES[cell_format]
        size = self.levels.stored * CELL_BYTES[cell_format]
        self._cells = [device.buffer("LPV cells", size=size) for _ in range(2)]
        self.light = device.buffer("LPV accumulated light", size=self.levels.cells * 48)
        marks = threshold is not None
        self._marked: dict[str, Any] = {}
        if marks:
            self._marked = {"touched": device.buffer("LPV index volume", size=self.levels.cells * 4)}
        self._values = {
            "format": cell_format, "row": ROW, "marks": marks,
            "threshold": 8.0 * (threshold or 0.0),  # storage_scale.wgsl: the peak's power of two is 8
            **propagation_values(evaluation, reprojection, gain),
        }  # fmt: skip
        self._start = ComputePass(
            device, "start", "techniques/lpv/start.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), storage_rw("light", "vec4f", "write"),
             storage_rw("cells_out", self.kind, "write"), *(storage_rw(name, "u32") for name in self._marked)],
            workgroup=(WORKGROUP, 1, 1), levels=self.levels.described(), access=["store"], **self._values,
        )  # fmt: skip
        self._steps: dict[tuple[int, bool], ComputePass] = {}
        self._faces = _Faces(device, self.levels) if occlusion else None
        self.last = self._cells[0]

    @property
    def values(self) -> dict[str, Any]:
        """What templates of cells.wgsl need to read `last`."""
        return {**self._values, "levels": self.levels.described(), "access": ["load"]}

    @property
    def touched(self) -> Any:
        """u32 [level][z][y][x]: 1 where the index volume's I_i is i."""
        return self._marked["touched"]

    def _step(self, adds: int, occluded: bool) -> ComputePass:
        """The pass that adds so many terms to the sum: none, what it makes, or what it reads as well."""
        if (adds, occluded) not in self._steps:
            faces = [storage("faces", "vec4f")] if occluded else []
            sums = [storage_rw("light", "vec4f"), *(storage_rw(name, "u32") for name in self._marked)] if adds else []
            self._steps[adds, occluded] = ComputePass(
                self._device, "propagate", "techniques/lpv/propagation.wgsl",
                [storage("cells_in", self.kind), storage_rw("cells_out", self.kind, "write"), *faces, *sums],
                workgroup=(WORKGROUP, 1, 1), block=BLOCK, adds=adds, sources=block_sources(),
                block_cells=list(itertools.product(*(range(b) for b in BLOCK))),
                levels=self._travelled.described(BLOCK), access=["load", "store"], occluded=occluded, unit=UNIT,
                **self._values,
            )  # fmt: skip
        return self._steps[adds, occluded]

    def run(self, stage: Any, injected: Any, peak: Any, iterations: int, shares: Any = None) -> None:
        """Accumulate S_0 to S_k of `injected` (vec4f [level][z][y][x][rgb], W/sr) with k = `iterations`. shares: the
        geometry volume (vec4f [level][z][y][x]), half a cell aside, with `occlusion`; no step but the first goes
        without (CLPV 3.3)."""
        source, target = self._cells
        self._start.run(
            stage, self.levels.dispatched(), injected=injected, peak=peak, light=self.light, cells_out=source,
            **self._marked,
        )  # fmt: skip
        threads = self._travelled.dispatched(BLOCK)
        # An odd number of steps begins with one that adds itself; then each second one adds two.
        if self._faces:
            self._faces.run(stage, shares)
        for number, adds in enumerate([1] * (iterations % 2) + [0, 2] * (iterations // 2)):
            others = {"light": self.light, **self._marked} if adds else {}
            if self._faces and number:
                others["faces"] = self._faces.faces
            step = self._step(adds, "faces" in others)
            step.run(stage, threads, cells_in=source, cells_out=target, **others)
            source, target = target, source
        self.last = source
