"""Keyframes: values of a light, a camera, an instance or a node over time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Target = Literal["light", "camera", "instance", "node"]
Interpolation = Literal["linear", "step", "cubic", "smooth"]


@dataclass(frozen=True, eq=False, kw_only=True)
class Track:
    """One property over time, held before the first and after the last keyframe.

    target, name: what moves, by kind and name ("light", "lamp"); a node is told by `index` alone.
    property: lights: position, direction, intensity, illuminance, radiance; cameras: position, look_at;
        instances: translation, rotation (unit quaternion x y z w), scale, which act in the world after the
        instance's own transform; nodes: translation, rotation, scale, in place of the node's own, and weights, those of
        the morph targets of the node's mesh.
    times: float64 (keys,), seconds, not decreasing.
    values: float64 (keys, width); for "cubic" (keys, 3, width): slope before the key, value, slope after it.
    index: nodes: which of `Scene.nodes`; instances: the node in whose space the property acts, None for the world.
    interpolation: "linear" (rotations: slerp, at constant speed), "step", "cubic" (glTF 2.0, appendix C.5), or
        "smooth", a Catmull-Rom spline through the keys. The quaternions of rotations are splined as vectors, the nearer
        of q and -q, and normalised.
    clip: the animation that the track belongs to; "" plays with every one.
    period: seconds after which it begins again at time 0, or None.

    Raises ValueError when shapes do not fit or times decrease.
    """

    target: Target
    name: str
    property: str
    times: np.ndarray
    values: np.ndarray
    index: int | None = None
    interpolation: Interpolation = "linear"
    clip: str = ""
    period: float | None = None

    def __post_init__(self) -> None:
        shape = (len(self.times), 3) if self.interpolation == "cubic" else (len(self.times),)
        if not len(self.times) or self.values.shape[:-1] != shape:
            raise ValueError(f"track of '{self.name}': {len(self.times)} times and values {self.values.shape}")
        if not (np.diff(self.times) >= 0).all():
            raise ValueError(f"track of '{self.name}': times decrease")
        if self.period is not None and not self.period > 0:
            raise ValueError(f"track of '{self.name}': period {self.period} is not above 0")

    def at(self, time: float) -> np.ndarray:
        """The value at `time` in seconds: float64 (width,); rotations have unit length."""
        if self.period is not None:
            time = time % self.period
        after = int(np.searchsorted(self.times, time, side="right"))
        if after == 0 or after == len(self.times) or self.interpolation == "step":
            value = np.array(self._value(max(after - 1, 0)), dtype=np.float64)
        else:
            value = self._between(after - 1, time)
        return value / np.linalg.norm(value) if self._turns() else value

    def _turns(self) -> bool:
        return self.property == "rotation"

    def _value(self, key: int) -> np.ndarray:
        return self.values[key, 1] if self.interpolation == "cubic" else self.values[key]

    def _between(self, key: int, time: float) -> np.ndarray:
        """The value between `key` and the next one, whose times differ, for `time` is less than the latter's."""
        length = float(self.times[key + 1] - self.times[key])
        share = float(time - self.times[key]) / length
        start, end = self._value(key), self._value(key + 1)
        if self.interpolation == "linear":
            return slerp(start, end, share) if self._turns() else (1.0 - share) * start + share * end
        if self.interpolation == "cubic":
            value = hermite(start, length * self.values[key, 2], end, length * self.values[key + 1, 0], share)
        else:
            sign = -1.0 if self._turns() and start @ end < 0 else 1.0
            value = hermite(start, length * self._slope(key), sign * end, sign * length * self._slope(key + 1), share)
        return value if value.any() or not self._turns() else start  # a quaternion of length 0 turns nowhere

    def _slope(self, key: int) -> np.ndarray:
        """The slope at a key of the Catmull-Rom spline for keys of any distance (Barry and Goldman, "A recursive
        evaluation algorithm for a class of Catmull-Rom splines", 1988): that of the parabola through the key and its
        neighbours. At an end it is that of the only segment."""
        segments = [segment for segment in (self._segment(key, -1), self._segment(key, 1)) if segment]
        if len(segments) == 1:
            return segments[0][0]
        (before, before_length), (after, after_length) = segments
        return (before * after_length + after * before_length) / (before_length + after_length)

    def _segment(self, key: int, step: int) -> tuple[np.ndarray, float] | None:
        """Slope and length of the segment from a key to its neighbour. A closed path goes on at its other end."""
        last, other, time = len(self.times) - 1, key + step, self.times[key]
        if not 0 <= other <= last:
            if not self._closed():
                return None
            other, time = (last - 1, self.times[last]) if step < 0 else (1, self.times[0])
        sign = -1.0 if self._turns() and self.values[key] @ self.values[other] < 0 else 1.0
        length = float(self.times[other] - time)
        return (sign * self.values[other] - self.values[key]) / length, abs(length)

    def _closed(self) -> bool:
        """Whether the path begins again where it ends."""
        whole = self.times[0] == 0 and self.times[-1] == self.period and len(self.times) > 2
        return whole and bool(np.allclose(self.values[0], self.values[-1]))


def hermite(start: np.ndarray, start_slope: np.ndarray, end: np.ndarray, end_slope: np.ndarray,
            share: float) -> np.ndarray:
    """The cubic at `share` in [0, 1] between two values, with slopes per unit of `share` (glTF 2.0, appendix C.5)."""
    square, cube = share**2, share**3
    return ((2 * cube - 3 * square + 1) * start + (cube - 2 * square + share) * start_slope
            + (3 * square - 2 * cube) * end + (cube - square) * end_slope)


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
