"""Unit vectors as 32 bits: octahedral, two 16-bit signed normalised numbers (Cigolle et al. 2014, section 3.2)."""

from __future__ import annotations

import numpy as np


def _octahedral(vectors: np.ndarray) -> np.ndarray:
    v = vectors.astype(np.float64)
    v = v / np.maximum(np.abs(v).sum(axis=-1, keepdims=True), 1e-30)
    folded = (1 - np.abs(v[..., 1::-1])) * np.where(v[..., :2] >= 0, 1.0, -1.0)
    return np.where(v[..., 2:] >= 0, v[..., :2], folded)


def pack_unit_vectors(vectors: np.ndarray) -> np.ndarray:
    """float (n, 3), unit length -> uint32 (n,), x in the low half; as WGSL's `pack2x16snorm`."""
    codes = np.floor(_octahedral(vectors) * 32767 + 0.5).astype(np.int16).view(np.uint16).astype(np.uint32)
    return codes[..., 0] | codes[..., 1] << np.uint32(16)


def pack_tangents(tangents: np.ndarray) -> np.ndarray:
    """float (n, 4), xyz unit length and w = +1 or -1 -> uint32 (n,): the lowest bit is 1 where w is negative."""
    packed = pack_unit_vectors(tangents[:, :3])
    return (packed & np.uint32(0xFFFFFFFE)) | (tangents[:, 3] < 0).astype(np.uint32)
