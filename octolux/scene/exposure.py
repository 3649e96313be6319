"""Exposure values at ISO 100."""

from __future__ import annotations

from math import log2

METER_CONSTANT = 12.5
"""Calibration constant K of a reflected-light meter, cd s / (m^2 ISO) (ISO 2720; the value most makers use)."""


def metered_exposure(mean_luminance: float) -> float:
    """The EV100 a reflected-light meter shows for a mean luminance in nits: log2(L * 100 / K).

    Raises ValueError unless the luminance is positive.
    """
    if not mean_luminance > 0:
        raise ValueError(f"mean luminance must be positive, got {mean_luminance}")
    return log2(mean_luminance * 100.0 / METER_CONSTANT)


MIDDLE_GREY = 0.18
"""What a picture's mean is shown as: the reference level of standard output sensitivity, signal 118 of 255 (ISO
12232:2006)."""


def display_exposure(mean_luminance: float) -> float:
    """The EV100 at which a mean luminance in nits is shown as MIDDLE_GREY: L / (1.2 * 2^EV100) = 0.18.

    That is 0.8 stops brighter than a meter's reading through a saturation-based sensor, which keeps room for highlights
    that a film-like curve brings down; the neutral tone map leaves all below its shoulder as it is.
    Raises ValueError unless the luminance is positive.
    """
    if not mean_luminance > 0:
        raise ValueError(f"mean luminance must be positive, got {mean_luminance}")
    return log2(mean_luminance / (1.2 * MIDDLE_GREY))
