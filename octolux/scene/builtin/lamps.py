"""Lamps: intensities from the lumens on the packet, and the swing of what hangs."""

from __future__ import annotations

from math import cos, pi, sqrt

import numpy as np

from ..lights import Vector
from ..materials import Color, Material
from ..motion.moved import rotation_matrix
from ..motion.tracks import Track

GRAVITY = 9.81
"""m/s^2"""

WARM_WHITE: Color = (1.414, 0.924, 0.534)
"""Linear Rec. 709 of a black body of 4000 K, of luminance 1 (0.2126 R + 0.7152 G + 0.0722 B)."""

NEUTRAL_WHITE: Color = (1.212, 0.961, 0.763)
"""The same at 5000 K."""


WARM_BULB = Material(name="bulb", base_color=(0.8, 0.8, 0.8), roughness=0.9, emissive=(565.0, 370.0, 214.0))
"""Of the bulb in `pendant`, so that it is seen to be on: a sphere of 5 cm at 400 nits gives 4 pi^2 * 0.05^2 * 400 =
40 lumen, little beside the light that stands for the lamp."""


def point_intensity(lumen: float, color: Color = (1.0, 1.0, 1.0)) -> Color:
    """Candela of a lamp that shines alike in all directions: the flux over 4 pi."""
    return _times(color, lumen / (4.0 * pi))


def spot_intensity(lumen: float, inner: float, outer: float, color: Color = (1.0, 1.0, 1.0)) -> Color:
    """Candela on the axis of a spot light of so many lumen; `inner` and `outer` half-angles in radians.

    KHR_lights_punctual's falloff is the square of a ramp in the cosine, so the flux is the intensity times
    2 pi ((1 - cos inner) + (cos inner - cos outer) / 3).
    """
    solid_angle = 2.0 * pi * ((1.0 - cos(inner)) + (cos(inner) - cos(outer)) / 3.0)
    return _times(color, lumen / solid_angle)


def pendulum(
    pivot: Vector, length: float, degrees: float, *, lamps: dict[str, Vector] | None = None, instances: tuple = (),
    keys: int = 33,
) -> list[Track]:
    """One full swing across z, about an axis along x through `pivot`; starts and ends at rest's place.

    length: metres; the period is 2 pi sqrt(length / g).  degrees: the greatest angle.  lamps: rest positions of point
    lights by name.  instances: names of what swings. Between keys the path is a chord: with 33 keys and 20 degrees it
    is off by less than length * (20 deg * 2 pi / 32)^2 / 8 = length / 1700.
    """
    times = np.linspace(0.0, 2.0 * pi * sqrt(length / GRAVITY), keys)
    angle = np.radians(degrees) * np.sin(np.linspace(0.0, 2.0 * pi, keys))
    angle[-1] = 0.0  # not the 1e-16 of sin(2 pi): it ends exactly where it began
    quaternions = np.stack([np.sin(angle / 2.0), 0.0 * angle, 0.0 * angle, np.cos(angle / 2.0)], axis=1)
    turns = np.array([rotation_matrix(q) for q in quaternions])
    tracks = [Track(target="light", name=name, property="position", times=times,
                    values=pivot + turns @ (np.array(place) - pivot)) for name, place in (lamps or {}).items()]
    # Instances turn about the world's origin: the translation brings the pivot back to its place.
    shift = np.array(pivot) - turns @ np.array(pivot)
    for name in instances:
        tracks += [Track(target="instance", name=name, property="rotation", times=times, values=quaternions),
                   Track(target="instance", name=name, property="translation", times=times, values=shift)]
    return tracks


def _times(color: Color, factor: float) -> Color:
    red, green, blue = color
    return red * factor, green * factor, blue * factor
