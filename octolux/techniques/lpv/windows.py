"""Nested windows on the device: where each lies in its level, and where it gives way to the next."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...gpu.bindings import Binding, uniform
from ...gpu.layout import Struct
from ...simulator.lpv.cascades import Window

# origin: the window's first cell, counted in its level. low, high: by how many cells more than it
# has there it goes on before its light gives way to that of the next window: far where it ends with the whole volume.
WINDOW = Struct("Window", origin="vec3i", low="vec3f", high="vec3f")
_FAR = 1e6


def windows_binding(count: int) -> Binding:
    return uniform("windows", f"array<Window, {count}>")


def pack_windows(windows: Sequence[Window]) -> np.ndarray:
    packed = WINDOW.array(len(windows))
    for entry, window in zip(packed, windows, strict=True):
        entry["origin"] = window.origin
        entry["low"], entry["high"] = (np.where(ends, _FAR, 0.0) for ends in (window.at_low, window.at_high))
    return packed


def one_window() -> Any:
    """The window of a volume that is whole."""
    return pack_windows([Window((0, 0, 0), 1, (True,) * 3, (True,) * 3)])
