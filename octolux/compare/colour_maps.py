"""Colours for numbers: error maps and signed differences."""

from __future__ import annotations

import numpy as np


def _colours(text: str) -> np.ndarray:
    return np.array([[int(word[i : i + 2], 16) for i in (0, 2, 4)] for word in text.split()], dtype=np.float64)


MAGMA = _colours(
    "000004 0a0822 1d1147 36106b 51127c 6a1c81 832681 9c2e7f b73779 cf4070 e55064 f4695c fb8761 fea571 fec287 fde0a1 "
    "fcfdbf"
)
"""Every sixteenth colour of matplotlib's `magma` (van der Walt and Smith 2015, CC0), which grows evenly brighter; what
lies between is within 1 % of it."""

BLUE_RED = _colours("053061 2166ac 4393c3 92c5de d1e5f0 f7f7f7 fddbc7 f4a582 d6604d b2182b 67001f")
"""ColorBrewer's RdBu with blue first (Brewer, Harrower; colorbrewer2.org)."""

LEVELS = 256


def palette(anchors: np.ndarray) -> np.ndarray:
    """uint8 (256, 3): the colours of `anchors` (k, 3), evenly spaced, and what lies between."""
    where = np.linspace(0.0, len(anchors) - 1.0, LEVELS)
    channels = [np.interp(where, np.arange(len(anchors)), anchors[:, c]) for c in range(3)]
    return np.round(np.stack(channels, axis=-1)).astype(np.uint8)


def levels(values, low: float, high: float) -> np.ndarray:
    """`values` of any shape as uint8 numbers of a palette's colours, from `low` to `high`; clamped."""
    scaled = (np.asarray(values, dtype=np.float64) - low) / (high - low)
    return np.floor(np.clip(scaled, 0.0, 1.0) * (LEVELS - 1) + 0.5).astype(np.uint8)


def gradient(anchors: np.ndarray) -> str:
    """The same as a CSS gradient from left to right."""
    stops = ", ".join(f"#{r:02x}{g:02x}{b:02x}" for r, g, b in anchors.astype(int).tolist())
    return f"linear-gradient(to right, {stops})"
