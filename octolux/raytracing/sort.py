"""A stable radix sort of 60-bit keys on the device."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import storage, storage_rw, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .scan import BLOCK, PARAMETERS, PrefixSum, parameters

# Keys that one thread counts and places, one after the other: that keeps the sort stable and the same in every run
# without any exchange between threads. The table of counts has 256 / _RUN entries a key.
_RUN = 128
_DIGITS = tuple((word, shift) for word in (0, 1) for shift in (0, 8, 16, 24))


class RadixSort:
    """Sorts elements of (low 30 bits, high 30 bits, payload, unused)."""

    def __init__(self, device: Device):
        self.device = device
        self._sums = PrefixSum(device, "u32")
        given, keys = uniform("parameters", PARAMETERS), storage("keys", "vec4u")
        fixed: dict[str, Any] = {"structs": [PARAMETERS], "workgroup": (64, 1, 1), "run": _RUN, "block": BLOCK}
        self._count = ComputePass(device, "sort: count", "raytracing/sort_count.wgsl",
                                  [given, keys, storage_rw("counts", "u32")], **fixed)  # fmt: skip
        self._place = ComputePass(
            device, "sort: place", "raytracing/sort_place.wgsl",
            [given, keys, storage_rw("counts", "u32"), storage("totals", "u32"), storage_rw("sorted", "vec4u")],
            **fixed,
        )  # fmt: skip

    def run(self, stage: Any, keys: Any, count: int) -> Any:
        """keys: buffer of `count` elements, written over. Returns the buffer that holds them sorted."""
        threads = -(-count // _RUN)
        sums, other = self._sums.sums(256 * threads), self.device.buffer("BVH build", size=16 * count)
        of_sums = parameters(self.device, 256 * threads)
        for word, shift in _DIGITS:
            given = {"parameters": parameters(self.device, count, word, shift), "keys": keys, "counts": sums.values}
            self._count.run(stage, (threads,), **given)
            self._sums.run(stage, sums, 256 * threads, of_sums)
            self._place.run(stage, (threads,), totals=sums.totals, sorted=other, **given)
            keys, other = other, keys
        return keys
