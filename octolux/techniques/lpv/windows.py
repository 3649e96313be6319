"""Nested windows on the device: where each lies in its level, and where its light is read."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...gpu.bindings import Binding, uniform
from ...gpu.layout import Struct
from ...simulator.lpv.cascades import Window

# As simulator/lpv/cascades.py's Window.
WINDOW = Struct("Window", origin="vec3i", low="vec3f", high="vec3f")
_FAR = 1e6  # cells: beyond any volume


def windows_binding(count: int) -> Binding:
    return uniform("windows", f"array<Window, {count}>")


def pack_windows(windows: Sequence[Window]) -> np.ndarray:
    packed = WINDOW.array(len(windows))
    for entry, window in zip(packed, windows, strict=True):
        entry["origin"] = window.origin
        entry["low"], entry["high"] = np.maximum(window.low, -_FAR), np.minimum(window.high, _FAR)
    return packed


def one_window() -> Any:
    """The window of a volume that is whole."""
    return pack_windows([Window((0, 0, 0), 1, (-_FAR,) * 3, (_FAR,) * 3)])
