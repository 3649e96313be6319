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


AGX_INSET = np.array([
    [0.842479062253094, 0.0784335999999992, 0.0792237451477643],
    [0.0423282422610123, 0.878468636469772, 0.0791661274605434],
    [0.0423756549057051, 0.0784336, 0.879142973793104],
])  # fmt: skip
"""Rec. 709 to AgX's inset primaries (Sobotka 2022, AgX; as printed in Wrensch 2023, "Minimal AgX Implementation")."""

AGX_OUTSET = np.linalg.inv(AGX_INSET)
AGX_EV = (-12.47393, 4.026069)
"""The range of log2 that AgX's curve spans: 10 stops below and 6.5 above middle grey, 0.18."""

AGX_CURVE = (-0.00232, 0.1191, 0.4298, -6.868, 31.96, -40.14, 15.5)
"""Coefficients, constant first, of the polynomial fit of AgX's default contrast curve (Wrensch 2023)."""

AGX_POWER = 2.2
"""AgX's curve gives a signal for a display of this power; taken back to linear here."""

ACES_INPUT = np.array([[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]])
ACES_OUTPUT = np.array([[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]])
ACES_NUMERATOR = (0.0245786, -0.000090537)
ACES_DENOMINATOR = (0.983729, 0.4329510, 0.238081)
"""Fit of ACES's reference rendering and sRGB output transforms (Hill 2016, BakingLab, ACES.hlsl)."""


def agx(color) -> np.ndarray:
    """AgX's base look of exposed linear `color` (..., 3): linear, (..., 3) in [0, 1]."""
    inset = np.maximum(np.asarray(color, dtype=np.float64) @ AGX_INSET.T, 1e-10)
    x = np.clip((np.log2(inset) - AGX_EV[0]) / (AGX_EV[1] - AGX_EV[0]), 0.0, 1.0)
    curve = np.polynomial.polynomial.polyval(x, AGX_CURVE)
    return np.clip(curve @ AGX_OUTSET.T, 0.0, 1.0) ** AGX_POWER


def aces(color) -> np.ndarray:
    """Hill's fit of ACES of exposed linear `color` (..., 3): linear, (..., 3) in [0, 1]. White is reached slowly, and
    middle grey comes out darker than in the other maps, as in ACES itself."""
    x = np.asarray(color, dtype=np.float64) @ ACES_INPUT.T
    a, b = ACES_NUMERATOR
    c, d, e = ACES_DENOMINATOR
    return np.clip(((x * (x + a) + b) / (x * (c * x + d) + e)) @ ACES_OUTPUT.T, 0.0, 1.0)


def clipped(color) -> np.ndarray:
    """No curve: [0, 1] is kept, what is beyond is cut."""
    return np.clip(np.asarray(color, dtype=np.float64), 0.0, 1.0)


TONE_MAPS = {"none": clipped, "neutral": pbr_neutral, "agx": agx, "aces": aces}
"""Tone maps by name: exposed linear (..., 3), not negative, to linear (..., 3) in [0, 1]."""


def srgb_encode(linear) -> np.ndarray:
    """Linear [0, 1] to the sRGB signal [0, 1], any shape; clamps outside (IEC 61966-2-1:1999, 4.4, forward)."""
    linear = np.clip(np.asarray(linear, dtype=np.float64), 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)


def srgb_decode(signal) -> np.ndarray:
    """The sRGB signal [0, 1] to linear [0, 1], any shape; clamps outside (IEC 61966-2-1:1999, 4.3, inverse)."""
    signal = np.clip(np.asarray(signal, dtype=np.float64), 0.0, 1.0)
    return np.where(signal <= 0.04045, signal / 12.92, ((signal + 0.055) / 1.055) ** 2.4)


def signal(radiance, ev100: float, tone_map: str = "neutral") -> np.ndarray:
    """Radiance (..., 3), nits, to the sRGB signal float64 (..., 3) in [0, 1]: exposure, tone map, transfer function.
    Raises ValueError on an unknown tone map."""
    if tone_map not in TONE_MAPS:
        raise ValueError(f"unknown tone map '{tone_map}'; choose {', '.join(TONE_MAPS)}")
    exposed = np.asarray(radiance, dtype=np.float64) * exposure_factor(ev100)
    return srgb_encode(TONE_MAPS[tone_map](np.maximum(exposed, 0.0)))


def display(radiance, ev100: float, tone_map: str = "neutral") -> np.ndarray:
    """Radiance (..., 3), nits, to uint8 sRGB (..., 3), rounded to nearest; arguments as `signal`."""
    return np.floor(signal(radiance, ev100, tone_map) * 255.0 + 0.5).astype(np.uint8)
