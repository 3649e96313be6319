"""Room on the device for what a build makes: how full it is, how it grows, and when it cannot."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from ....gpu.device import Device, DeviceError
from ....raytracing.scan import PARAMETERS

ROW = 1 << 20  # threads along x of passes whose threads are many
WORKGROUP = (64, 1, 1)
OWN = 8
"""Voxels that a node owns."""
_GROWTH = 1.25  # room made beyond need when there is too little: the first time a scene has just what it needs


def threads(count: int) -> tuple[int, int]:
    """A dispatch of `count` threads or more, numbered id.x + ROW id.y."""
    return min(max(1, count), ROW), max(1, -(-count // ROW))


def parameters(device: Device, count: int, first: int = 0, second: int = 0, third: int = 0) -> Any:
    """A uniform buffer of PARAMETERS, the numbers that a build pass is told."""
    return device.uniform("voxel build", PARAMETERS.pack(count=count, first=first, second=second, third=third))


class Pool:
    """Room for elements of one kind. `resource` is what `make` made for `capacity` of them, for the `made`th time;
    `used`: how many there are.

    limit: the most that one binding holds, or that can be numbered.
    """

    def __init__(self, name: str, make: Callable[[int], Any], limit: int):
        self.name, self._make, self.limit = name, make, limit
        self.used = self.capacity = self.made = 0
        self.resource: Any = None

    @property
    def fullness(self) -> dict[str, int]:
        """How many elements there are, for how many there is room now, and for how many there can be."""
        return {"used": self.used, "room": self.capacity, "most": self.limit}

    def need(self, count: int) -> bool:
        """Have room for `count` elements; what was in it is lost when it grows. Returns whether it did.

        Raises DeviceError when there are more than the limit; nothing has changed then.
        """
        if count > self.limit:
            raise DeviceError(
                f"The voxel octree needs {count} {self.name}; there can be {self.limit}. Set a smaller depth, or a box "
                "around a part of the scene."
            )
        grows = self.resource is None or count > self.capacity
        if grows:
            growth = 1.0 if self.resource is None else _GROWTH
            self.capacity = max(1, min(self.limit, math.ceil(growth * count)))
            self.resource = None  # before the other is made: there may not be memory for both
            self.resource = self._make(self.capacity)
            self.made += 1
        self.used = count
        return grows

    def reserve(self, count: int) -> bool:
        """The same, for more elements than the pool's own: `used` stays."""
        used = self.used
        grows = self.need(count)
        self.used = used
        return grows
