"""Tangents as 32 bits: an octahedral unit vector (simulator/camera.py) whose lowest bit is the bitangent's sign."""

from __future__ import annotations

import numpy as np

from ..simulator.camera import pack_normals


def pack_tangents(tangents: np.ndarray) -> np.ndarray:
    """float (n, 4), xyz unit length and w = +1 or -1 -> uint32 (n,): the lowest bit is 1 where w is negative."""
    packed = pack_normals(tangents[:, :3])
    return (packed & np.uint32(0xFFFFFFFE)) | (tangents[:, 3] < 0).astype(np.uint32)
