"""Lights, cameras and instances with some of their properties replaced by the values of tracks.

`values` maps properties, as `Track` names them, to float64 arrays; an empty one gives the object itself.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from .cameras import Camera, look_at
from .lights import Light
from .meshes import Instance


def moved_light(light: Light, values: dict[str, np.ndarray]) -> Light:
    """The light with the given position, direction, intensity, illuminance or radiance, (3,) each."""
    if not values:
        return light
    changes: dict[str, Any] = {key: tuple(value.tolist()) for key, value in values.items()}
    return replace(light, **changes)


def moved_camera(camera: Camera, values: dict[str, np.ndarray]) -> Camera:
    """The camera at `position`, turned towards `look_at` (both (3,), metres); each is optional.

    Without `look_at` it keeps its orientation. With it the picture is upright: y is up, or what was up before where
    the camera looks straight up or down.
    """
    if not values:
        return camera
    transform = np.array(camera.transform, dtype=np.float64)
    transform[:3, 3] = values.get("position", camera.position)
    if "look_at" in values:
        position, target = transform[:3, 3], values["look_at"]
        sideways = np.linalg.norm((target - position)[[0, 2]])
        upright = sideways > 1e-6 * np.linalg.norm(target - position)
        transform = look_at(position, target, (0.0, 1.0, 0.0) if upright else camera.transform[:3, 1])
    return replace(camera, transform=transform)


def moved_instance(instance: Instance, values: dict[str, np.ndarray]) -> Instance:
    """The instance, scaled by `scale` (3,), turned by `rotation` (4,) and moved by `translation` (3,), in this order
    and about the world's origin."""
    if not values:
        return instance
    motion = np.eye(4)
    motion[:3, :3] = rotation_matrix(values.get("rotation", np.array([0.0, 0.0, 0.0, 1.0])))
    motion[:3, :3] *= values.get("scale", np.ones(3))
    motion[:3, 3] = values.get("translation", np.zeros(3))
    return replace(instance, transform=motion @ instance.transform)


def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """float64 (3, 3) of a unit quaternion (x, y, z, w)."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
