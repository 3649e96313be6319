"""Lights. Directions are those in which light travels, of any length; colours are linear Rec. 709, in the unit
named. `node` is the index into `Scene.nodes` of the node that carries the light, or None: it stands at the node's
origin and shines along its -z, as in KHR_lights_punctual."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from .materials import Color
from .particles import ParticleLights

Vector = tuple[float, float, float]


@dataclass(frozen=True, kw_only=True)
class DirectionalLight:
    """Parallel light (a sun). `illuminance` in lux, on a plane perpendicular to `direction`."""

    direction: Vector
    illuminance: Color
    name: str = ""
    node: int | None = None


@dataclass(frozen=True, kw_only=True)
class PointLight:
    """A point that shines alike in all directions. `intensity` in candela."""

    position: Vector
    intensity: Color
    name: str = ""
    node: int | None = None


@dataclass(frozen=True, kw_only=True)
class SpotLight:
    """A point that shines into a cone. `intensity` in candela on the axis; it falls off between the half-angles
    `inner_angle` and `outer_angle` (radians) as KHR_lights_punctual says."""

    position: Vector
    direction: Vector
    intensity: Color
    inner_angle: float = 0.0
    outer_angle: float = pi / 4
    name: str = ""
    node: int | None = None


@dataclass(frozen=True, kw_only=True)
class AreaLight:
    """A one-sided, flat quadrilateral. `radiance` in nits; it shines towards the side from which its four `corners`
    run counter-clockwise."""

    corners: tuple[Vector, Vector, Vector, Vector]
    radiance: Color
    name: str = ""


SingleLight = DirectionalLight | PointLight | SpotLight | AreaLight
Light = SingleLight | ParticleLights
