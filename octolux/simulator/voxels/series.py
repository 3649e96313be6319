"""What bounces of light after the last that is followed would bring, float64.

Reflection and gathering are one linear operator A, which brings light x_k = A x_(k-1) by bounce k. Its powers bring
ever more of its first eigenvector (power iteration), so that bounces become a geometric series whose ratio r is the
eigenvalue, and those after the n-th bring r / (1 - r) of what it brings itself.

r is taken from sums of what all that reflects receives: of the last two bounces, for each color, as walls of one color
keep light of that color longer. The first is left out: lamps light what is beside them. A is positive, and symmetric
where what is received is weighed by areas and albedos (reciprocity), so ratios of such sums grow from bounce to bounce
towards r if light begins evenly: <x, A^k x> are moments of a positive measure, whose logarithms are convex. So less is
added than is missing, as a rule. In a closed room of one albedo, whose walls receive all that they reflect, the sums
are exact from the beginning.
"""

from __future__ import annotations

import numpy as np

MOST = 0.9
"""Of a ratio: of a closed room of fresh snow. Where walls reflect all light, none is left to find."""


def gain(sums) -> np.ndarray:
    """What all further bounces bring over what the last brings: (channels,), 0 before the third.

    sums: (n, channels), of all that is received, of n bounces: of 1, of 1 and 2, and so on.
    """
    brings = np.diff(np.asarray(sums, dtype=np.float64), axis=0, prepend=0.0)
    if len(brings) < 3:
        return np.zeros(brings.shape[1])
    last, before = brings[-1], brings[-2]
    ratio = np.clip(np.divide(last, before, out=np.zeros_like(last), where=before > 0.0), 0.0, MOST)
    return ratio / (1.0 - ratio)
