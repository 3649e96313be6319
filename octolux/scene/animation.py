"""Keyframes: values of a light, a camera or an instance over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Target = Literal["light", "camera", "instance", "node"]
Interpolation = Literal["linear", "step", "cubic", "smooth"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Track:
    """One property over time, linear between keyframes (slerp for rotations), held before the first and after the last.

    target, name: what moves, by kind and name ("light", "lamp").
    property: lights: position, direction, intensity, illuminance, radiance; cameras: position, look_at;
        instances: translation, rotation (unit quaternion x y z w), scale, which act in the world after the
        instance's own transform.
    times: float64 (keys,), seconds, increasing.  values: float64 (keys, width).
    """

    target: Target
    name: str
    property: str
    times: np.ndarray
    values: np.ndarray

    def at(self, time: float) -> np.ndarray:
        """The value at `time` in seconds: float64 (width,)."""
        after = int(np.searchsorted(self.times, time, side="right"))
        if after == 0 or after == len(self.times):
            return np.array(self.values[min(after, len(self.times) - 1)], dtype=np.float64)
        start, end = self.times[after - 1], self.times[after]
        share = float((time - start) / (end - start))
        if self.property == "rotation":
            return slerp(self.values[after - 1], self.values[after], share)
        return (1.0 - share) * self.values[after - 1] + share * self.values[after]


def slerp(start: np.ndarray, end: np.ndarray, share: float) -> np.ndarray:
    """The unit quaternion (4,) at `share` in [0, 1] of the shorter way between two (Shoemake 1985)."""
    start, end = (np.asarray(q, dtype=np.float64) / np.linalg.norm(q) for q in (start, end))
    cosine = float(start @ end)
    if cosine < 0.0:  # q and -q are the same rotation; this one is nearer
        end, cosine = -end, -cosine
    angle = np.arccos(min(cosine, 1.0))
    if angle < 1e-6:  # sin(angle) is too small to divide by, and the straight way is as good
        mixed = (1.0 - share) * start + share * end
    else:
        mixed = np.sin((1.0 - share) * angle) * start + np.sin(share * angle) * end
    return mixed / np.linalg.norm(mixed)
