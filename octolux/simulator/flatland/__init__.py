"""Flatland: light propagation in the plane, with circular harmonics of any number of bands.

Kaplanyan & Dachsbacher 2010, section 5, compares the propagation of a light propagation volume with discrete ordinates
and the analytic solution here. Lengths are in cells; flux is in watts, intensity in W/rad, radiance in W/(cell rad).
"""

from .bases import Harmonics, Sectors
from .lights import AreaLight, Setting, l_shape, one_light
from .schemes import SCHEMES, Scheme, propagate, step

__all__ = [
    "SCHEMES", "AreaLight", "Harmonics", "Scheme", "Sectors", "Setting", "l_shape", "one_light", "propagate", "step",
]  # fmt: skip
