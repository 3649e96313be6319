"""What lives on the device, by name: the source of `memory_bytes` in the statistics."""

from __future__ import annotations

import math
import weakref
from collections import defaultdict

# Bytes per texel of the formats we use; block-compressed ones are not among them.
TEXEL_BYTES = {
    "r8unorm": 1,
    "r16float": 2,
    "rgba8unorm": 4,
    "rgba8unorm-srgb": 4,
    "r32uint": 4,
    "r32float": 4,
    "rg32float": 8,
    "rg32uint": 8,
    "depth32float": 4,
    "rgba16float": 8,
    "rgba32uint": 16,
    "rgba32float": 16,
}


def texture_bytes(size: tuple[int, int, int], format: str, mip_levels: int = 1, dimension: str = "2d") -> int:
    """Bytes of a texture with its mip levels; layers of an array do not shrink, slices of a 3D texture do."""
    total = 0
    for level in range(mip_levels):
        width, height = max(1, size[0] >> level), max(1, size[1] >> level)
        depth = max(1, size[2] >> level) if dimension == "3d" else size[2]
        total += width * height * depth * TEXEL_BYTES[format]
    return total


class MemoryLedger:
    """Bytes on the device by label. An entry ends when its resource is collected."""

    def __init__(self) -> None:
        self._bytes: dict[str, int] = defaultdict(int)

    def add(self, label: str, resource: object, size: int) -> None:
        self._bytes[label] += size
        weakref.finalize(resource, self._remove, label, size)

    def _remove(self, label: str, size: int) -> None:
        self._bytes[label] -= size

    def by_label(self) -> dict[str, int]:
        """Label -> bytes, largest first."""
        return dict(sorted(((k, v) for k, v in self._bytes.items() if v), key=lambda item: (-item[1], item[0])))

    @property
    def total(self) -> int:
        return sum(self._bytes.values())


def readable(size: float) -> str:
    """A number of bytes for people: `12.3 MiB`."""
    if size < 1024:
        return f"{size:.0f} B"
    power = min(int(math.log2(size) // 10), 4)
    return f"{size / 1024**power:.1f} {('KiB', 'MiB', 'GiB', 'TiB')[power - 1]}"
