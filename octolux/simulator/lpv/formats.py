"""Numbers as the device stores them while light travels: what faces let through and reflect, in thousandths.

Faces. Three numbers of [0, 1] lie in the 10-bit fields of a word, in steps of 1/1023, rounded to the nearest: 0 and 1
stay what they are, others move by at most half a step, 4.9e-4. A step with the stored numbers creates no light: what a
face blocks is one less what it lets through, both of the same stored number (bounces.py).
"""

from __future__ import annotations

import numpy as np

STEPS = 1023
"""Steps between 0 and 1 of a 10-bit field."""


def pack_thousandths(x) -> np.ndarray:
    """Numbers (..., 3) from 0 to 1 as words: uint32 (...)."""
    steps = np.round(np.asarray(x, dtype=np.float64) * STEPS).astype(np.uint32)
    return steps[..., 0] | (steps[..., 1] << 10) | (steps[..., 2] << 20)


def unpack_thousandths(words) -> np.ndarray:
    """The numbers of words (...): float64 (..., 3)."""
    words = np.asarray(words, dtype=np.uint32)[..., None]
    return ((words >> np.array([0, 10, 20], np.uint32)) & STEPS) / float(STEPS)
