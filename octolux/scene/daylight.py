"""Sun and sky, for scenes in which nothing shines: a clear day.

Illuminances after the IESNA Lighting Handbook (9th edition, 2000, chapter 8, "Daylight availability"): direct normal
E_xt exp(-c / sin h), with the solar illuminance constant E_xt = 127.5 klx and c = 0.21 of a clear sky; on the
horizontal from the sky alone A + B sin^C h, with 0.8 klx, 15.5 klx and 0.5. The sky's distribution is CIE S 011
(ISO 15469:2004), type 12, "CIE standard clear sky, low illuminance turbidity".
"""

from __future__ import annotations

from functools import lru_cache
from math import cos, exp, pi, radians, sin

import numpy as np

from .environment import Environment
from .lights import DirectionalLight
from .materials import Color

ELEVATION, AZIMUTH = radians(50.0), radians(-35.0)
"""Of the sun; azimuth from +z towards +x. A photographer's key light for the default camera, which looks from +z and a
little from +x: from the other side and above."""

SUN_TEMPERATURE, SKY_TEMPERATURE = 5500.0, 12000.0
"""K, correlated: D55, mean noon sunlight (CIE 15:2004), and a clear sky (Judd et al. 1964: 10,000 K and up)."""

GROUND_ALBEDO = 0.2
"""What is below the horizon reflects so much (CIE 108-1994: grass and dry soil)."""

_RGB_OF_XYZ = np.linalg.inv(
    [[0.4123908, 0.3575843, 0.1804808], [0.2126390, 0.7151687, 0.0721923], [0.0193308, 0.1191948, 0.9505322]]
)  # linear Rec. 709 (ITU-R BT.709-6)


def daylight_color(temperature: float) -> np.ndarray:
    """Linear Rec. 709 (3,) of luminance 1 of daylight of a correlated colour temperature of 4000 to 25000 K (CIE
    15:2004, 3.1: the daylight locus)."""
    t = 1e3 / temperature
    if temperature <= 7000.0:
        x = 0.244063 + 0.09911 * t + 2.9678 * t**2 - 4.6070 * t**3
    else:
        x = 0.237040 + 0.24748 * t + 1.9018 * t**2 - 2.0064 * t**3
    y = -3.000 * x * x + 2.870 * x - 0.275
    return np.maximum(_RGB_OF_XYZ @ np.array([x / y, 1.0, (1.0 - x - y) / y]), 0.0)


def _color(values: np.ndarray) -> Color:
    red, green, blue = (float(v) for v in values)
    return red, green, blue


def to_sun() -> np.ndarray:
    return np.array([sin(AZIMUTH) * cos(ELEVATION), sin(ELEVATION), cos(AZIMUTH) * cos(ELEVATION)])


@lru_cache(maxsize=1)
def sun() -> DirectionalLight:
    """The sun of a clear day."""
    illuminance = 127.5e3 * exp(-0.21 / sin(ELEVATION)) * daylight_color(SUN_TEMPERATURE)
    return DirectionalLight(direction=_color(-to_sun()), illuminance=_color(illuminance), name="default sun")


@lru_cache(maxsize=1)
def sky(height: int = 128) -> Environment:
    """The sky of a clear day without the sun, and the ground below it, nits."""
    polar = (np.arange(height) + 0.5) / height * pi
    azimuth = (np.arange(2 * height) + 0.5) / height * pi - pi
    directions = np.stack(np.broadcast_arrays(
        np.sin(polar)[:, None] * np.sin(azimuth), np.cos(polar)[:, None], -np.sin(polar)[:, None] * np.cos(azimuth),
    ), axis=-1)  # fmt: skip
    relative = _clear_sky(directions)
    above = directions[..., 1] > 0
    weight = np.where(above, directions[..., 1], 0.0) * np.sin(polar)[:, None] * (pi / height) ** 2
    horizontal = 800.0 + 15.5e3 * sin(ELEVATION) ** 0.5
    luminance = np.where(above, relative * horizontal / (relative * weight).sum(), 0.0)
    image = luminance[..., None] * daylight_color(SKY_TEMPERATURE)
    on_ground = horizontal * daylight_color(SKY_TEMPERATURE) + np.array(sun().illuminance) * sin(ELEVATION)
    image[~above] = GROUND_ALBEDO / pi * on_ground
    return Environment(image=image.astype(np.float32))


def _clear_sky(directions: np.ndarray) -> np.ndarray:
    """Relative luminance of ISO 15469, type 12: gradation a = -1, b = -0.32, indicatrix c = 10, d = -3, e = 0.45."""
    cos_zenith = np.maximum(directions[..., 1], 1e-3)
    from_sun = np.arccos(np.clip(directions @ to_sun(), -1.0, 1.0))
    gradation = 1.0 - np.exp(-0.32 / cos_zenith)
    indicatrix = 1.0 + 10.0 * (np.exp(-3.0 * from_sun) - exp(-3.0 * pi / 2.0)) + 0.45 * np.cos(from_sun) ** 2
    return gradation * indicatrix
