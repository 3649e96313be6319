"""Error metrics: of linear pictures against a reference that may be noisy, and of leaks."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..picture import REC709_LUMINANCE

TRIMMED_SHARE = 0.03
"""Share of the masked pixels, those with the largest error, that the trimmed figure leaves out."""

LEAK_SHARE = 0.01
"""Of the lit level: below it the reference counts as dark, above it a picture counts as lit."""

LEAST_DARK_SHARE = 0.01
"""Of the masked pixels: with fewer dark ones no share of them is told; they are corners, or noise of the reference."""


def luminance(radiance) -> np.ndarray:
    """Of linear Rec. 709 (..., 3): (...), float64."""
    return np.asarray(radiance, dtype=np.float64) @ REC709_LUMINANCE


def relative_errors(picture, seed_a, seed_b, mask, reference) -> dict[str, float | None]:
    """Ratio of means, relative RMSE and trimmed relative RMSE of `picture` (height, width, 3) where `mask` is set.

    The halves' noise is independent, so mean((x - A) (x - B)) is the mean squared error of x free of the noise's bias;
    noise may make it negative, which counts as 0. Divided by the masked mean of `reference`, all channels together.
    Trimmed leaves out the pixels with the largest |x - (A + B) / 2|^2, summed over the channels.
    Where the reference is black, or nothing is in the mask, no ratio exists: all are None.
    """
    x, a, b, truth = (np.asarray(v, dtype=np.float64)[mask] for v in (picture, seed_a, seed_b, reference))
    mean = truth.mean() if truth.size else 0.0
    if mean <= 0.0:
        return {"ratio": None, "rmse": None, "trimmed": None}
    product = (x - a) * (x - b)
    order = np.argsort(np.sum(np.square(x - 0.5 * (a + b)), axis=-1))
    kept = order[: round(len(order) * (1.0 - TRIMMED_SHARE))]
    return {
        "ratio": float(x.mean() / mean),
        "rmse": float(np.sqrt(max(product.mean(), 0.0)) / mean),
        "trimmed": float(np.sqrt(max(product[kept].mean(), 0.0)) / mean),
    }


def relative_noise(seed_a, seed_b, mask) -> float | None:
    """Relative RMSE of the mean of two halves, estimated from their difference: each half has the variance s^2, the
    difference 2 s^2, the mean s^2 / 2. None where the reference is black."""
    a, b = (np.asarray(v, dtype=np.float64)[mask] for v in (seed_a, seed_b))
    mean = 0.5 * (a + b).mean() if a.size else 0.0
    return float(0.5 * np.sqrt(np.mean(np.square(a - b))) / mean) if mean > 0.0 else None


def error_map(picture, reference, mask) -> np.ndarray:
    """Root mean square of the channels' errors over the masked mean of `reference`: (height, width).

    Its own root mean square over the mask is the relative RMSE, the reference's noise included. Zero outside.
    """
    mean = _masked_mean(reference, mask)
    difference = np.asarray(picture, dtype=np.float64) - reference
    return np.sqrt(np.mean(np.square(difference), axis=-1)) * mask / mean


def brightness_map(picture, reference, mask) -> np.ndarray:
    """Luminance of picture minus reference over the reference's masked mean luminance: (height, width), signed."""
    mean = _masked_mean(luminance(reference), mask)
    return (luminance(picture) - luminance(reference)) * mask / mean


def _masked_mean(values, mask) -> float:
    """1 where the mean is zero: maps of a black reference show the picture itself."""
    inside = np.asarray(values, dtype=np.float64)[mask]
    return float(inside.mean()) if inside.size and inside.mean() > 0.0 else 1.0


class Leak(NamedTuple):
    """How much light is where the reference is dark.

    score: share of the dark pixels that are lit.  mean: their mean luminance over the lit level.  Both None where
    fewer than LEAST_DARK_SHARE are dark.  dark_share: share of the masked pixels that are dark.
    """

    score: float | None
    mean: float | None
    dark_share: float


def lit_level(views: list[tuple[np.ndarray, np.ndarray]]) -> float | None:
    """The luminance of what is lit, nits: the mean over all pixels that direct light reaches, in all `views`.

    views: pairs of direct light (height, width, 3) and mask. It needs no reference and is the same for all techniques.
    The dark side of a wall may fill a picture, so other views of the scene have to say what lit means. None when no
    direct light is seen at all.
    """
    seen = [luminance(direct)[mask] for direct, mask in views]
    values = np.concatenate(seen) if seen else np.zeros(0)
    values = values[values > 0.0]
    return float(values.mean()) if values.size else None


def leak(light, seed_a, seed_b, mask, level: float) -> Leak:
    """What of `light` (height, width, 3), direct plus indirect, falls where the reference has none.

    A pixel is dark when the reference is below LEAK_SHARE of `level` in both of its halves (one half's noise alone
    would call lit pixels dark), and lit when `light` is above that.
    """
    limit = LEAK_SHARE * level
    dark = mask & (luminance(seed_a) < limit) & (luminance(seed_b) < limit)
    share = float(dark.sum() / max(1, np.sum(mask)))
    if share < LEAST_DARK_SHARE:
        return Leak(None, None, share)
    values = luminance(light)[dark]
    return Leak(float((values > limit).mean()), float(values.mean() / level), share)
