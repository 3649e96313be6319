"""A camera for scenes that have none."""

from __future__ import annotations

from math import radians, tan

import numpy as np

from .cameras import Camera, look_at
from .errors import OctoluxError
from .scene import Scene

_FOV = radians(35.0)
_FROM = (0.5, 0.35, 1.0)
# Of the picture's half width and height; the rest is a rim.
_FILLED = 0.85


def default_camera(scene: Scene, aspect: float = 16 / 9) -> Camera:
    """A camera that holds the scene's bounding box, seen from the front, right and above.

    aspect: width over height of the picture.
    """
    low, high = scene.bounds()
    size = max(float(np.linalg.norm(high - low)), 1e-3)
    centre = (low + high) / 2
    axes = look_at(np.asarray(_FROM), np.zeros(3))[:3, :3]
    corners = np.array(np.meshgrid(*zip(low, high, strict=True), indexing="ij")).reshape(3, -1).T
    x, y, z = ((corners - centre) @ axes).T  # right, up, and towards the camera
    half = tan(_FOV / 2)
    # A corner is seen where |y| <= half * (distance - z), and |x| <= aspect * half * (distance - z).
    beyond = np.maximum(np.abs(x) / aspect, np.abs(y)) / (_FILLED * half)
    distance = max(float((z + beyond).max()), size * 1e-2)
    position = centre + axes[:, 2] * distance
    return Camera.look_at(position, centre, vertical_fov=_FOV, near=size * 1e-3, name="default")


def chosen_camera(scene: Scene, wanted: str | int | Camera | None, aspect: float = 16 / 9) -> Camera:
    """A camera of the scene by name or number, the first one for None, or `wanted` itself; the default one where the
    scene has none. Raises OctoluxError for one that is not there."""
    if isinstance(wanted, Camera):
        return wanted
    cameras = scene.cameras or [default_camera(scene, aspect)]
    names = [c.name for c in cameras]
    if isinstance(wanted, str) and wanted in names:
        return cameras[names.index(wanted)]
    number = 0 if wanted is None else int(wanted) if str(wanted).isdecimal() else -1
    if not 0 <= number < len(cameras):
        known = ", ".join(f"{i} '{name}'" for i, name in enumerate(names))
        raise OctoluxError(f"The scene has no camera '{wanted}'. There are: {known}.")
    return cameras[number]
