"""Keyframes: values of a light, a camera or an instance over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Target = Literal["light", "camera", "instance"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Track:
    """One property over time, linear between keyframes (slerp for rotations), held before the first and after the last.

    target, name: what moves, by kind and name ("light", "lamp").
    property: lights: position, direction, intensity, illuminance; cameras: position, look_at;
        instances: translation, rotation (unit quaternion x y z w), scale, which act in the world after the
        instance's own transform.
    times: float64 (keys,), seconds, increasing.  values: float64 (keys, width).
    """

    target: Target
    name: str
    property: str
    times: np.ndarray
    values: np.ndarray
