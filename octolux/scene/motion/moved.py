"""Lights, cameras, instances and nodes with some of their properties replaced: by the values of tracks, or by the place
of the node that carries them.

`values` maps properties, as `Track` names them, to float64 arrays; an empty one gives the object itself.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from ..cameras import Camera, look_at
from ..lights import AreaLight, DirectionalLight, Light, ParticleLights, PointLight
from ..meshes import Instance
from ..nodes import Node

_NO_ROTATION = np.array([0.0, 0.0, 0.0, 1.0])


def moved_light(light: Light, values: dict[str, np.ndarray]) -> Light:
    """The light with the given position, direction, intensity, illuminance or radiance, (3,) each.

    Light that a spline through its keys makes negative is none.
    """
    if not values:
        return light
    changes: dict[str, Any] = {
        key: tuple((value if key in ("position", "direction") else np.maximum(value, 0.0)).tolist())
        for key, value in values.items()
    }
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


def moved_instance(instance: Instance, values: dict[str, np.ndarray], space: np.ndarray | None = None) -> Instance:
    """The instance, scaled by `scale` (3,), turned by `rotation` (4,) and moved by `translation` (3,), in this order
    and about the origin of `space`, float64 (4, 4), invertible, to world; None is the world."""
    if not values:
        return instance
    motion = trs_matrix(values.get("translation", np.zeros(3)), values.get("rotation", _NO_ROTATION),
                        values.get("scale", np.ones(3)))
    if space is not None:
        motion = space @ motion @ np.linalg.inv(space)
    return replace(instance, transform=motion @ instance.transform)


def moved_node(node: Node, values: dict[str, np.ndarray]) -> Node:
    """The node with another translation (3,), rotation (4,) or scale (3,); itself where they are what it has."""
    changes: dict[str, Any] = {key: tuple(value.tolist()) for key, value in values.items()}
    return node if all(getattr(node, key) == value for key, value in changes.items()) else replace(node, **changes)


def carried_light(light: Light, world: np.ndarray) -> Light:
    """The light as a node carries it that stands at `world`, float64 (4, 4): at its origin, shining along its -z.

    Where the transform flattens z, the light keeps its direction.
    """
    if isinstance(light, AreaLight | ParticleLights):
        return light
    changes: dict[str, Any] = {}
    if not isinstance(light, DirectionalLight):
        changes["position"] = tuple(world[:3, 3].tolist())
    length = float(np.linalg.norm(world[:3, 2]))
    if not isinstance(light, PointLight) and length > 0:
        changes["direction"] = tuple((-world[:3, 2] / length).tolist())
    return replace(light, **changes)


def carried_camera(camera: Camera, world: np.ndarray) -> Camera:
    """The camera as a node carries it that stands at `world`, float64 (4, 4); it keeps its orientation where that
    flattens it."""
    transform = rigid(world)
    if transform is None:
        transform = camera.transform.copy()
        transform[:3, 3] = world[:3, 3]
    return replace(camera, transform=transform)


def rigid(world: np.ndarray) -> np.ndarray | None:
    """`world`, float64 (4, 4), without its scale, mirroring or shear: the direction of z, then that of y, are kept.
    None where it flattens one of them."""
    z, x = world[:3, 2], np.cross(world[:3, 1], world[:3, 2])
    if not (np.linalg.norm(z) > 0 and np.linalg.norm(x) > 0):
        return None
    result = np.eye(4)
    result[:3, 0], result[:3, 2] = x / np.linalg.norm(x), z / np.linalg.norm(z)
    result[:3, 1] = np.cross(result[:3, 2], result[:3, 0])
    result[:3, 3] = world[:3, 3]
    return result


def trs_matrix(translation, rotation, scale) -> np.ndarray:
    """float64 (4, 4): scale (3,), then rotation (4,), a unit quaternion, then translation (3,)."""
    matrix = np.eye(4)
    matrix[:3, :3] = rotation_matrix(np.asarray(rotation)) * np.asarray(scale)
    matrix[:3, 3] = translation
    return matrix


def rotation_matrix(quaternion: np.ndarray) -> np.ndarray:
    """float64 (3, 3) of a unit quaternion (x, y, z, w); (3, 3, n) of n of them, (4, n)."""
    x, y, z, w = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )
