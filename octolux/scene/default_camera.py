"""A camera for scenes that have none."""

from __future__ import annotations

from math import radians, sin

import numpy as np

from .cameras import Camera
from .scene import Scene

_FOV = radians(45.0)


def default_camera(scene: Scene) -> Camera:
    """A camera that holds the scene's bounding sphere, seen from the front, right and above."""
    low, high = scene.bounds()
    centre, radius = (low + high) / 2, max(float(np.linalg.norm(high - low)) / 2, 1e-3)
    direction = np.array([0.5, 0.35, 1.0])
    distance = radius / sin(_FOV / 2)
    position = centre + direction / np.linalg.norm(direction) * distance
    return Camera.look_at(position, centre, vertical_fov=_FOV, near=distance * 1e-3, name="default")
