"""How different two pictures look: SSIM and FLIP of what is displayed."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ..picture import REC709_LUMINANCE

# Wang, Bovik, Sheikh, Simoncelli 2004, "Image Quality Assessment: From Error Visibility to Structural Similarity",
# section III.B and C: window of 11 x 11 with a standard deviation of 1.5 pixels, K1 and K2.
SSIM_WINDOW, SSIM_SIGMA, SSIM_K1, SSIM_K2 = 11, 1.5, 0.01, 0.03


def ssim(picture, reference) -> float:
    """Mean structural similarity of two sRGB signals (height, width, 3) in [0, 1], at least 11 x 11: 1 when equal.

    Of the luma (Rec. 709's weights on the signal), over the windows that lie inside the picture, as in the paper.
    Raises ValueError for pictures smaller than a window.
    """
    x, y = (np.asarray(v, dtype=np.float64) @ REC709_LUMINANCE for v in (picture, reference))
    if min(x.shape) < SSIM_WINDOW:
        raise ValueError(f"SSIM needs pictures of at least {SSIM_WINDOW} x {SSIM_WINDOW} pixels, not {x.shape}")
    mean_x, mean_y = _window(x), _window(y)
    var_x, var_y = _window(x * x) - mean_x**2, _window(y * y) - mean_y**2
    covariance = _window(x * y) - mean_x * mean_y
    c1, c2 = SSIM_K1**2, SSIM_K2**2
    similarity = (2 * mean_x * mean_y + c1) * (2 * covariance + c2)
    return float(np.mean(similarity / ((mean_x**2 + mean_y**2 + c1) * (var_x + var_y + c2))))


def _window(values: np.ndarray) -> np.ndarray:
    """Means of (height, width) under the Gaussian window, where it lies inside: (height - 10, width - 10)."""
    offsets = np.arange(SSIM_WINDOW) - SSIM_WINDOW // 2
    weights = np.exp(-0.5 * np.square(offsets / SSIM_SIGMA))
    weights /= weights.sum()
    for axis in (0, 1):
        values = np.lib.stride_tricks.sliding_window_view(values, SSIM_WINDOW, axis=axis) @ weights
    return values


@cache
def flip_missing() -> str:
    """Why there is no FLIP here, or empty."""
    try:
        import flip_evaluator  # noqa: F401
    except ImportError:
        return "the package flip-evaluator is not installed (it has no wheel for every system)"
    return ""


def flip(picture, reference) -> tuple[float, np.ndarray] | None:
    """Mean LDR-FLIP and its map (height, width) of two sRGB signals (height, width, 3) in [0, 1]; None without it.

    NVIDIA's own program at its default of 67 pixels a degree: a screen of 0.7 m and 3840 pixels seen from 0.7 m
    (Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images").
    """
    if flip_missing():
        return None
    from flip_evaluator import evaluate

    signals: list[Any] = [np.ascontiguousarray(v, dtype=np.float32) for v in (reference, picture)]
    errors, _, _ = evaluate(*signals, "LDR", applyMagma=False, computeMeanError=False, parameters={})
    return float(errors.mean(dtype=np.float64)), np.array(errors[..., 0])  # its own mean adds up in float32
