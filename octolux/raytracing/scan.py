"""Exclusive prefix sums on the device."""

from __future__ import annotations

from typing import Any, NamedTuple

from ..gpu.bindings import storage_rw, uniform
from ..gpu.device import Device
from ..gpu.layout import Struct
from ..gpu.passes import ComputePass

BLOCK = 2048
# What a build pass is told: how many elements, and numbers whose meaning is the pass's own.
PARAMETERS = Struct("Parameters", count="u32", first="u32", second="u32", third="u32")


def parameters(device: Device, count: int, first: int = 0, second: int = 0, third: int = 0) -> Any:
    """A uniform buffer of PARAMETERS."""
    return device.uniform("BVH build", PARAMETERS.pack(count=count, first=first, second=second, third=third))


class Sums(NamedTuple):
    """Buffers: elements, and the totals of their blocks of BLOCK."""

    values: Any
    totals: Any


class PrefixSum:
    """Sums of `element` ("u32" or "vec2u"). After `run` element i's sum is values[i] + totals[i / BLOCK], and the sum
    of all stands in totals behind the last block."""

    def __init__(self, device: Device, element: str):
        self.device, self.size = device, {"u32": 4, "vec2u": 8}[element]
        given, values, totals = (
            uniform("parameters", PARAMETERS), storage_rw("values", element), storage_rw("totals", element),
        )  # fmt: skip
        fixed: dict[str, Any] = {"structs": [PARAMETERS], "element": element, "block": BLOCK, "workgroup": (256, 1, 1)}
        self._blocks = ComputePass(device, "scan", "raytracing/scan.wgsl", [given, values, totals], **fixed)
        self._totals = ComputePass(device, "scan", "raytracing/scan_totals.wgsl", [given, totals], **fixed)

    def sums(self, capacity: int) -> Sums:
        """Buffers for up to `capacity` elements."""
        totals = self.device.buffer("BVH build", size=(-(-capacity // BLOCK) + 1) * self.size)
        return Sums(self.device.buffer("BVH build", size=capacity * self.size), totals)

    def run(self, stage: Any, sums: Sums, count: int, given: Any) -> None:
        """given: uniform buffer of PARAMETERS that says how many elements there are, at most `count`."""
        blocks = -(-count // BLOCK)
        self._blocks.run(stage, (256 * blocks,), parameters=given, values=sums.values, totals=sums.totals)
        self._totals.run(stage, (256,), parameters=given, totals=sums.totals)

    def total(self, sums: Sums, count: int) -> tuple[int, ...]:
        """The sum of all of `count` elements, read back."""
        raw = self.device.queue.read_buffer(sums.totals, -(-count // BLOCK) * self.size, self.size)
        return tuple(memoryview(raw).cast("B").cast("I"))
