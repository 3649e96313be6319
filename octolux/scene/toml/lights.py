"""The [[light]] tables of a TOML scene."""

from __future__ import annotations

from collections.abc import Callable
from math import radians

import numpy as np

from ..geometry.quadrilaterals import flaw
from ..lights import AreaLight, DirectionalLight, Light, PointLight, SpotLight, Vector
from .fields import Table
from .particles import load_particles


def load_light(table: Table, number: int) -> Light:
    """The light that one [[light]] table describes; `number` names it when it has no name. Raises SceneError."""
    make = LIGHTS[table.choice("type", tuple(LIGHTS))]
    return make(table, table.text("name", f"light {number}"))


def _directional(table: Table, name: str) -> DirectionalLight:
    table.allow(("type", "name", "direction", "illuminance"))
    return DirectionalLight(direction=table.direction("direction"), illuminance=table.color("illuminance"), name=name)


def _point(table: Table, name: str) -> PointLight:
    table.allow(("type", "name", "position", "intensity"))
    return PointLight(position=table.numbers("position", 3), intensity=table.color("intensity"), name=name)


def _spot(table: Table, name: str) -> SpotLight:
    table.allow(("type", "name", "position", "direction", "intensity", "inner_angle", "outer_angle"))
    outer = table.number("outer_angle", 45.0, above=0.0, high=90.0)
    inner = table.number("inner_angle", 0.0, low=0.0, high=90.0)
    if not inner < outer:
        raise table.error("inner_angle", f"is {inner:g}, not smaller than outer_angle, {outer:g}",
                          "give half-angles in degrees, the inner one smaller")
    return SpotLight(
        position=table.numbers("position", 3), direction=table.direction("direction"),
        intensity=table.color("intensity"), inner_angle=radians(inner), outer_angle=radians(outer), name=name,
    )


def _area(table: Table, name: str) -> AreaLight:
    table.allow(("type", "name", "corners", "radiance"))
    corners: list[Vector] = [(x, y, z) for x, y, z in table.rows("corners", (3,), lines=4)]
    a, b, c, d = (np.array(corner) for corner in corners)
    normal = np.cross(c - a, d - b)  # twice the area
    size = max(float(np.linalg.norm(c - a)), float(np.linalg.norm(d - b)))
    if not np.linalg.norm(normal) > 1e-9 * size**2:
        raise table.error("corners", "enclose no area", "give the corners of a quadrilateral in order around it")
    if found := flaw(corners):
        raise table.error("corners", *found)
    return AreaLight(corners=(corners[0], corners[1], corners[2], corners[3]), radiance=table.color("radiance"),
                     name=name)


LIGHTS: dict[str, Callable[[Table, str], Light]] = {
    "directional": _directional, "point": _point, "spot": _spot, "area": _area, "particles": load_particles,
}  # fmt: skip
