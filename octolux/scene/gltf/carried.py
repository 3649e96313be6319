"""The cameras and lights that a glTF file's nodes carry."""

from __future__ import annotations

from math import pi

import numpy as np

from ..cameras import Camera
from ..lights import DirectionalLight, Light, PointLight, SpotLight
from ..motion.moved import carried_camera, carried_light, rigid
from .accessors import require
from .json import Fields
from .nodes import NodeTable

_ORIGIN, _FORWARD = (0.0, 0.0, 0.0), (0.0, 0.0, -1.0)


def read_cameras(root: Fields, table: NodeTable) -> list[Camera]:
    """The cameras that nodes carry (section 3.10). Far planes and aspect ratios are not kept. Raises SceneError."""
    cameras = root.children("cameras", "camera")
    found = []
    for node, number in table.shown:
        index = node.index("camera", len(cameras), "camera")
        if index is None:
            continue
        if rigid(table.worlds[number]) is None:
            raise node.error("its transform flattens the camera that it carries")
        name = node.string("name", "") or cameras[index].string("name", "") or cameras[index].place
        found.append(carried_camera(_camera(cameras[index], name, number), table.worlds[number]))
    return found


def _camera(fields: Fields, name: str, node: int) -> Camera:
    kind = fields.string("type")
    lens = fields.child(kind) if kind in ("perspective", "orthographic") else None
    if lens is None:
        raise fields.error("it needs 'type' perspective or orthographic, and an object of that name")
    if kind == "orthographic":
        height = 2.0 * lens.number("ymag", low=1e-9)
        near = lens.number("znear", low=0.0)
        return Camera(transform=np.eye(4), near=near, orthographic_height=height, name=name, node=node)
    fov = lens.number("yfov", low=1e-3, high=pi - 1e-3)
    return Camera(transform=np.eye(4), vertical_fov=fov, near=lens.number("znear", low=1e-9), name=name, node=node)


def read_lights(root: Fields, table: NodeTable, warnings: list[str]) -> list[Light]:
    """The lights of KHR_lights_punctual that nodes carry. `range` is left out with a warning. Raises SceneError."""
    extension = root.extension("KHR_lights_punctual")
    lights = extension.children("lights", "light") if extension else []
    found = []
    for node, number in table.shown:
        carried = node.extension("KHR_lights_punctual")
        if carried is None:
            continue
        index = require(carried, carried.index("light", len(lights), "light"), "light")
        if "range" in lights[index]:
            warnings.append(f"{lights[index].place}: its 'range' is left out; light reaches everywhere")
        name = node.string("name", "") or lights[index].string("name", "") or lights[index].place
        light, world = _light(lights[index], name, number), table.worlds[number]
        if not (isinstance(light, PointLight) or world[:3, 2].any()):
            raise node.error("its transform flattens the light that it carries")
        found.append(carried_light(light, world))
    return found


def _light(fields: Fields, name: str, node: int) -> Light:
    red, green, blue = fields.numbers("color", 3, (1.0, 1.0, 1.0), low=0.0)
    strength = fields.number("intensity", 1.0, low=0.0)
    shine = (red * strength, green * strength, blue * strength)
    kind = fields.string("type")
    if kind == "point":
        return PointLight(position=_ORIGIN, intensity=shine, name=name, node=node)
    if kind == "directional":
        return DirectionalLight(direction=_FORWARD, illuminance=shine, name=name, node=node)
    if kind != "spot":
        raise fields.error(f"'type' is '{kind}', must be directional, point or spot")
    spot = fields.child("spot") or Fields(fields.file, fields.place, {})
    outer = spot.number("outerConeAngle", pi / 4, low=1e-6, high=pi / 2)
    inner = spot.number("innerConeAngle", 0.0, low=0.0, high=outer)
    return SpotLight(position=_ORIGIN, direction=_FORWARD, intensity=shine, inner_angle=inner, outer_angle=outer,
                     name=name, node=node)
