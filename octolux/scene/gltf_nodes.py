"""The node hierarchy of a glTF file, flattened: world transforms, and the cameras and lights that nodes carry."""

from __future__ import annotations

from math import pi

import numpy as np

from .cameras import Camera
from .gltf_accessors import require
from .gltf_json import Fields
from .lights import DirectionalLight, Light, PointLight, SpotLight, Vector

_IDENTITY = tuple(np.eye(4).ravel())


def visible_nodes(root: Fields) -> list[tuple[Fields, np.ndarray]]:
    """The nodes of the scene that the file shows, each with its float64 (4, 4) transform to world.

    That is scene `scene`, else the first, else all nodes without parents. Raises SceneError: cycles, two parents.
    """
    nodes = root.children("nodes", "node")
    children = [node.indices("children", len(nodes), "node") for node in nodes]
    parents = _parents(nodes, children)
    pending = [(index, np.eye(4)) for index in reversed(_top(root, len(nodes), parents))]
    found, seen = [], set()
    while pending:
        index, outer = pending.pop()
        if index in seen:
            raise nodes[index].error("the scene lists it twice, as its own node and below another")
        seen.add(index)
        world = outer @ _local(nodes[index])
        if not np.isfinite(world).all():
            raise nodes[index].error("its transform to world is not finite")
        found.append((nodes[index], world))
        pending += [(child, world) for child in reversed(children[index])]
    return found


def _parents(nodes: list[Fields], children: list[list[int]]) -> list[int | None]:
    parents: list[int | None] = [None] * len(nodes)
    for parent, below in enumerate(children):
        for child in below:
            if parents[child] is not None:
                raise nodes[child].error(f"it is a child of node {parents[child]} and again of node {parent}")
            parents[child] = parent
    settled = [False] * len(nodes)
    for start in range(len(nodes)):
        path: list[int] = []
        index: int | None = start
        while index is not None and not settled[index]:
            if len(path) > len(nodes):
                raise nodes[start].error("it is below itself: the node hierarchy has a cycle")
            path.append(index)
            index = parents[index]
        for passed in path:
            settled[passed] = True
    return parents


def _top(root: Fields, count: int, parents: list[int | None]) -> list[int]:
    scenes = root.children("scenes", "scene")
    if not scenes:
        return [index for index, parent in enumerate(parents) if parent is None]
    shown = root.index("scene", len(scenes), "scene") or 0
    return scenes[shown].indices("nodes", count, "node")


def _local(node: Fields) -> np.ndarray:
    """A node's own transform, from `matrix` (column-major) or translation, rotation and scale (section 3.5.3)."""
    if "matrix" in node:
        matrix = np.array(node.numbers("matrix", 16, _IDENTITY)).reshape(4, 4).T
        if not np.allclose(matrix[3], (0.0, 0.0, 0.0, 1.0)):
            raise node.error("the last row of its 'matrix' is not 0 0 0 1")
        return matrix
    transform = np.eye(4)
    scale = np.array(node.numbers("scale", 3, (1.0, 1.0, 1.0)))
    transform[:3, :3] = _rotation(node) * scale
    transform[:3, 3] = node.numbers("translation", 3, (0.0, 0.0, 0.0))
    return transform


def _rotation(node: Fields) -> np.ndarray:
    quaternion = np.array(node.numbers("rotation", 4, (0.0, 0.0, 0.0, 1.0)))
    length = np.linalg.norm(quaternion)
    if not length > 1e-6:
        raise node.error("its 'rotation' is a quaternion of length zero")
    x, y, z, w = quaternion / length
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
            [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
            [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
        ]
    )


def read_cameras(root: Fields, nodes: list[tuple[Fields, np.ndarray]]) -> list[Camera]:
    """The cameras that nodes carry (section 3.10). Far planes and aspect ratios are not kept. Raises SceneError."""
    cameras = root.children("cameras", "camera")
    found = []
    for node, world in nodes:
        index = node.index("camera", len(cameras), "camera")
        if index is not None:
            found.append(_camera(cameras[index], node, world))
    return found


def _camera(fields: Fields, node: Fields, world: np.ndarray) -> Camera:
    name = node.string("name", "") or fields.string("name", "") or fields.place
    transform = _rigid(node, world)
    kind = fields.string("type")
    lens = fields.child(kind) if kind in ("perspective", "orthographic") else None
    if lens is None:
        raise fields.error("it needs 'type' perspective or orthographic, and an object of that name")
    if kind == "orthographic":
        height = 2.0 * lens.number("ymag", low=1e-9)
        return Camera(transform=transform, near=lens.number("znear", low=0.0), orthographic_height=height, name=name)
    fov = lens.number("yfov", low=1e-3, high=pi - 1e-3)
    return Camera(transform=transform, vertical_fov=fov, near=lens.number("znear", low=1e-9), name=name)


def _rigid(node: Fields, world: np.ndarray) -> np.ndarray:
    """`world` without its scale, mirroring or shear: the direction of z, then that of y, are kept."""
    z, x = world[:3, 2], np.cross(world[:3, 1], world[:3, 2])
    if not (np.linalg.norm(z) > 0 and np.linalg.norm(x) > 0):
        raise node.error("its transform flattens the camera that it carries")
    rigid = np.eye(4)
    rigid[:3, 0], rigid[:3, 2] = x / np.linalg.norm(x), z / np.linalg.norm(z)
    rigid[:3, 1] = np.cross(rigid[:3, 2], rigid[:3, 0])
    rigid[:3, 3] = world[:3, 3]
    return rigid


def read_lights(root: Fields, nodes: list[tuple[Fields, np.ndarray]], warnings: list[str]) -> list[Light]:
    """The lights of KHR_lights_punctual that nodes carry. `range` is left out with a warning. Raises SceneError."""
    extension = root.extension("KHR_lights_punctual")
    lights = extension.children("lights", "light") if extension else []
    found = []
    for node, world in nodes:
        carried = node.extension("KHR_lights_punctual")
        if carried is not None:
            index = require(carried, carried.index("light", len(lights), "light"), "light")
            found.append(_light(lights[index], node, world, warnings))
    return found


def _light(fields: Fields, node: Fields, world: np.ndarray, warnings: list[str]) -> Light:
    name = node.string("name", "") or fields.string("name", "") or fields.place
    red, green, blue = fields.numbers("color", 3, (1.0, 1.0, 1.0), low=0.0)
    strength = fields.number("intensity", 1.0, low=0.0)
    shine = (red * strength, green * strength, blue * strength)
    if "range" in fields:
        warnings.append(f"{fields.place}: its 'range' is left out; light reaches everywhere")
    kind = fields.string("type")
    position = _vector(world[:3, 3])
    if kind == "point":
        return PointLight(position=position, intensity=shine, name=name)
    length = np.linalg.norm(world[:3, 2])
    if not length > 0:
        raise node.error("its transform flattens the light that it carries")
    direction = _vector(-world[:3, 2] / length)
    if kind == "directional":
        return DirectionalLight(direction=direction, illuminance=shine, name=name)
    if kind != "spot":
        raise fields.error(f"'type' is '{kind}', must be directional, point or spot")
    spot = fields.child("spot") or Fields(fields.file, fields.place, {})
    outer = spot.number("outerConeAngle", pi / 4, low=1e-6, high=pi / 2)
    inner = spot.number("innerConeAngle", 0.0, low=0.0, high=outer)
    return SpotLight(
        position=position, direction=direction, intensity=shine, inner_angle=inner, outer_angle=outer, name=name
    )


def _vector(values: np.ndarray) -> Vector:
    x, y, z = (float(value) for value in values)
    return x, y, z
