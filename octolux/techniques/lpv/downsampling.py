"""Downsampling: the coarser levels of an octree from its finest (OLPV 4.2)."""

from __future__ import annotations

from typing import Any

from ...gpu.bindings import storage_rw
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from .levels import Levels

_AT_ONCE = 3  # levels that a workgroup makes in one dispatch
# But the first, which has most of the cells, comes alone: it is twice as fast where no thread waits for another.


class Downsampling:
    """Fills the levels above the last window of a buffer of vec4f [level][z][y][x][per_cell].

    A parent is `factor` times the sum of its children, each number at most `limit` if there is one: 1 keeps flux,
    1/8 is OLPV's eq. 11.
    """

    def __init__(
        self, device: Device, levels: Levels, *, per_cell: int, factor: float = 1.0, limit: float | None = None
    ):
        values: dict[str, Any] = {"workgroup": (4, 4, 4), "per_cell": per_cell, "factor": factor, "limit": limit}
        self._passes: list[tuple[int, ComputePass]] = []
        whole, last = levels.windows - 1, len(levels.sizes) - 1
        for base in (whole, *range(whole + 1, last, _AT_ONCE)) if last > whole else ():
            numbers = range(base, min(base + _AT_ONCE if base > whole else whole + 1, last) + 1)
            described = [{"n": levels.sizes[i], "first": levels.first(i)} for i in numbers]
            made = ComputePass(
                device, "downsample", "techniques/lpv/downsample.wgsl", [storage_rw("cells", "vec4f")],
                levels=described, **values,
            )  # fmt: skip
            self._passes.append((levels.sizes[base + 1], made))

    def run(self, stage: Any, cells: Any) -> None:
        for n, each in self._passes:
            each.run(stage, (n, n, n), cells=cells)
