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
