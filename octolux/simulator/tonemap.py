"""From scene-referred radiance to a picture: exposure, tone curve, transfer function, in this order."""

from __future__ import annotations

import numpy as np

START_COMPRESSION = 0.8 - 0.04
"""Peak above which the neutral curve compresses."""

DESATURATION = 0.15
"""How fast compressed colours turn to white."""

F90_OFFSET = 0.04
"""What the neutral curve takes off: the light a dielectric of F0 = 0.04 reflects of a white surround."""


def exposure_factor(ev100):
    """Factor from luminance (nits) to the unit of the picture, 1 / (1.2 * 2^EV100): a saturation-based sensor clips at
    1.2 * 2^EV100 nits (Lagarde & de Rousiers 2014, "Moving Frostbite to PBR", physically based camera; ISO 12232)."""
    return 1.0 / (1.2 * np.exp2(np.asarray(ev100, dtype=np.float64)))


def pbr_neutral(color) -> np.ndarray:
    """Khronos PBR Neutral tone map of exposed linear `color` (..., 3), not negative: (..., 3) in [0, 1).

    Constants and formula as published (Khronos, ToneMapping/PBR_Neutral, 2024). Base colours up to 0.8 come out as
    they were lit by a white surround; only highlights are compressed, and then desaturated.
    """
    color = np.asarray(color, dtype=np.float64)
    darkest = color.min(axis=-1, keepdims=True)
    offset = np.where(darkest < 2.0 * F90_OFFSET, darkest - 6.25 * darkest * darkest, F90_OFFSET)
    color = color - offset
    peak = color.max(axis=-1, keepdims=True)
    room = 1.0 - START_COMPRESSION
    high = np.maximum(peak, START_COMPRESSION)
    new_peak = 1.0 - room * room / (high + room - START_COMPRESSION)
    white = 1.0 - 1.0 / (DESATURATION * (high - new_peak) + 1.0)
    compressed = color * (new_peak / high) * (1.0 - white) + new_peak * white
    return np.where(peak < START_COMPRESSION, color, compressed)


def srgb_encode(linear) -> np.ndarray:
    """Linear [0, 1] to the sRGB signal [0, 1], any shape; clamps outside (IEC 61966-2-1:1999, 4.4, forward)."""
    linear = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def srgb_decode(signal) -> np.ndarray:
    """The sRGB signal [0, 1] to linear [0, 1], any shape; clamps outside (IEC 61966-2-1:1999, 4.3, inverse)."""
    signal = np.clip(np.asarray(signal, dtype=np.float64), 0.0, 1.0)
    return np.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)


def display(radiance, ev100: float, tone_map: str = "neutral") -> np.ndarray:
    """Radiance (..., 3), nits, to uint8 sRGB (..., 3): exposure, tone map ("neutral", or "none" which only clips),
    transfer function, rounding to nearest. Raises ValueError on an unknown tone map."""
    exposed = np.asarray(radiance, dtype=np.float64) * exposure_factor(ev100)
    if tone_map not in ("neutral", "none"):
        raise ValueError(f"unknown tone map '{tone_map}'; choose neutral or none")
    mapped = pbr_neutral(np.maximum(exposed, 0.0)) if tone_map == "neutral" else exposed
    return np.floor(srgb_encode(mapped) * 255.0 + 0.5).astype(np.uint8)
