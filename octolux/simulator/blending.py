"""Giving way: from one estimate of a thing to another, by equal factors.

Where nested grids give way to each other, two estimates of the same light are read, which differ by a factor where only
the finer one knows what stands there. Their mean by shares would change by (ratio - 1) times the share's change on the
darker side. What changes least from frame to frame, as a part of itself, is their geometric mean: by log(ratio) times
the share's change everywhere.
"""

from __future__ import annotations

import numpy as np

RATIO = 16
"""Between two estimates, up to which what is read changes evenly from one to the other: black has no logarithm."""

_EVEN = 1e-3


def moved_share(one, other, share) -> np.ndarray:
    """The part m, for which m one + (1 - m) other is one^share other^(1 - share): as `share` is in [0, 1], and with a
    ratio of RATIO at most. one, other: at least 0. For colours take a sum over the channels, and blend each by m, so
    that what is read lies between both in all of them."""
    one, other, share = (np.asarray(a, dtype=np.float64) for a in (one, other, share))
    ratio = np.clip(one / np.maximum(other, 1e-30), 1.0 / RATIO, RATIO)
    even = (np.abs(ratio - 1.0) < _EVEN) | (share == 1.0)
    return np.where(even, share, (ratio**share - 1.0) / np.where(even, 1.0, ratio - 1.0))
