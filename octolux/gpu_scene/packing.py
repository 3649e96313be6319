"""Tangents and vertex colours as 32 bits."""

from __future__ import annotations

import numpy as np

from ..simulator.camera import pack_normals


def pack_tangents(tangents: np.ndarray) -> np.ndarray:
    """float (n, 4), xyz unit length and w = +1 or -1 -> uint32 (n,): an octahedral unit vector (simulator/camera.py)
    whose lowest bit is 1 where w is negative."""
    packed = pack_normals(tangents[:, :3])
    return (packed & np.uint32(0xFFFFFFFE)) | (tangents[:, 3] < 0).astype(np.uint32)


def pack_colors(colors: np.ndarray) -> np.ndarray:
    """float (n, 4), linear, in [0, 1] -> uint32 (n,): 8 bits each, r lowest. Square roots, so that eight bits show no
    steps in the dark; alpha too, to need no case of its own."""
    codes = np.floor(np.sqrt(np.clip(colors, 0.0, 1.0)) * 255.0 + 0.5).astype(np.uint32)
    return codes @ np.array([1, 1 << 8, 1 << 16, 1 << 24], dtype=np.uint32)
