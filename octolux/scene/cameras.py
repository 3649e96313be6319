"""Cameras."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class Camera:
    """A pinhole camera; it looks along its own -z with +y up, as in glTF.

    transform: float64 (4, 4), camera to world, rigid.
    vertical_fov: radians, full angle; unused when `orthographic_height` is set.
    near: metres; nothing nearer is seen. There is no far plane.
    orthographic_height: metres seen from bottom to top of the picture, or None for perspective.
    node: index into `Scene.nodes` of the node that carries it, or None.
    """

    transform: np.ndarray
    vertical_fov: float = radians(45.0)
    near: float = 0.01
    orthographic_height: float | None = None
    name: str = ""
    node: int | None = None

    @property
    def position(self) -> np.ndarray:
        return self.transform[:3, 3]

    @property
    def forward(self) -> np.ndarray:
        return -self.transform[:3, 2]

    @classmethod
    def look_at(cls, position, target, up=(0.0, 1.0, 0.0), **rest) -> Camera:
        """A camera at `position` (3,) that looks at `target` (3,). Raises ValueError when that gives no direction."""
        return cls(transform=look_at(position, target, up), **rest)


def look_at(position, target, up=(0.0, 1.0, 0.0)) -> np.ndarray:
    """The (4, 4) camera-to-world transform of a camera at `position` that looks at `target`."""
    position, target, up = (np.asarray(v, dtype=np.float64) for v in (position, target, up))
    backward = position - target
    if not np.linalg.norm(backward) > 0:
        raise ValueError("camera position and target are the same point")
    backward /= np.linalg.norm(backward)
    right = np.cross(up, backward)
    if not np.linalg.norm(right) > 1e-9 * max(float(np.linalg.norm(up)), 1e-300):
        raise ValueError("camera looks along its up direction")
    right /= np.linalg.norm(right)
    transform = np.eye(4)
    transform[:3, 0], transform[:3, 1], transform[:3, 2] = right, np.cross(backward, right), backward
    transform[:3, 3] = position
    return transform
