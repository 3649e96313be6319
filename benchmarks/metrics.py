"""Error metrics against a noisy path-traced reference given as two independent halves."""

from __future__ import annotations

import numpy as np

TRIMMED_SHARE = 0.03
"""Share of the masked pixels, those with the largest error, that the trimmed figure leaves out."""


def relative_errors(picture, seed_a, seed_b, mask, reference) -> dict[str, float]:
    """Ratio of means, relative RMSE and trimmed relative RMSE of `picture` (height, width, 3) where `mask` is set.

    The halves' noise is independent, so mean((x - A) (x - B)) is the mean squared error of x free of the noise's bias;
    noise may make it negative, which counts as 0. Divided by the masked mean of `reference`, all channels together.
    Trimmed leaves out the pixels with the largest |x - (A + B) / 2|^2, summed over the channels.
    """
    x, a, b, truth = (np.asarray(v, dtype=np.float64)[mask] for v in (picture, seed_a, seed_b, reference))
    mean = truth.mean()
    product = (x - a) * (x - b)
    order = np.argsort(np.sum(np.square(x - 0.5 * (a + b)), axis=-1))
    kept = order[: round(len(order) * (1.0 - TRIMMED_SHARE))]
    return {
        "ratio": float(x.mean() / mean),
        "rmse": float(np.sqrt(max(product.mean(), 0.0)) / mean),
        "trimmed": float(np.sqrt(max(product[kept].mean(), 0.0)) / mean),
    }


def pixel_errors(picture, reference, unshadowed) -> np.ndarray:
    """Largest difference of a pixel's channels relative to the reference's largest channel: (height, width).

    Where the reference is black, relative to `unshadowed`, what the lights would bring there without shadows; where
    that is black too, infinite unless the picture is black as well.
    """
    difference = np.abs(np.asarray(picture, dtype=np.float64) - reference).max(axis=-1)
    scale = np.where(reference.max(axis=-1) > 0.0, reference.max(axis=-1), unshadowed.max(axis=-1))
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0.0, 0.0, difference / scale)
