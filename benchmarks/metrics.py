"""Error metrics against a noisy path-traced reference given as two independent halves."""

from __future__ import annotations

import numpy as np

from octolux.compare.metrics import relative_errors

__all__ = ["pixel_errors", "relative_errors"]


def pixel_errors(picture, reference, unshadowed) -> np.ndarray:
    """Largest difference of a pixel's channels relative to the reference's largest channel: (height, width).

    Where the reference is black, relative to `unshadowed`, what the lights would bring there without shadows; where
    that is black too, infinite unless the picture is black as well.
    """
    difference = np.abs(np.asarray(picture, dtype=np.float64) - reference).max(axis=-1)
    scale = np.where(reference.max(axis=-1) > 0.0, reference.max(axis=-1), unshadowed.max(axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0.0, 0.0, difference / scale)
