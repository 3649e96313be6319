"""The scene's lights for the device: sorted by kind, each with the views of its shadow maps."""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi

import numpy as np

from ..gpu.device import DeviceError
from ..gpu.limits import DEFAULT_LIMITS
from ..scene.lights import DirectionalLight, Light, PointLight, SpotLight
from ..simulator.direct import NARROWEST_RAMP
from .emitters import EmitterLight
from .structs import LIGHT
from .views import CUBE_FACES, MAX_HALF_ANGLE, View, directional_views, point_views, spot_views

Bounds = tuple[np.ndarray, np.ndarray]
Counts = tuple[int, int, int, int, int]


@dataclass(frozen=True, eq=False)
class LightSet:
    """Lights in the order of KINDS, packed as WGSL's `Light`.

    counts: of each kind, in that order.
    views: of all shadow maps, those of emitters and the sky last.  light_of_view: the index of each one's light.
    total_flux: (lights, 3), lm or W: what each sends into its views, an upper bound of what the scene can reflect.
    """

    lights: list[Light]
    packed: np.ndarray
    counts: Counts
    views: list[View]
    light_of_view: list[int]
    total_flux: np.ndarray

    @property
    def main_views(self) -> int:
        """How many of the views have maps of full resolution: view i is layer i of these, then of the coarse maps."""
        return len(self.views) - CUBE_FACES * self.counts[3] - self.counts[4]

    @property
    def lamps(self) -> int:
        """How many of the lights, the first ones, have maps of full resolution."""
        return sum(self.counts[:3])

    @property
    def emitters(self) -> list[EmitterLight]:
        return [light for light in self.lights if isinstance(light, EmitterLight)]

    @property
    def emitter_views(self) -> range:
        """Numbers of the emitters' views, the camera's being 0."""
        first = 1 + self.main_views
        return range(first, first + CUBE_FACES * self.counts[3])


@dataclass(frozen=True, kw_only=True)
class SkyLight(DirectionalLight):
    """A part of the sky, as if all its light came from one direction."""


KINDS = {
    "directional": DirectionalLight, "spot": SpotLight, "point": PointLight, "emitter": EmitterLight, "sky": SkyLight,
}  # fmt: skip
"""Lights that have shadow maps, in the order in which they lie on the device."""


def light_set(
    lights: list[Light], bounds: Bounds, resolution: int, coarse_resolution: int = 1, inverse_square: bool = True
) -> LightSet:
    """Pack the lights that have shadow maps: area lights have none, but are among the emitters.

    Raises DeviceError when their shadow maps need more layers than an array has.
    """
    by_kind: list[list[Light]] = [[x for x in lights if type(x) is kind] for kind in KINDS.values()]
    ordered = [light for group in by_kind for light in group]
    packed = LIGHT.array(max(1, len(ordered)))
    views: list[View] = []
    owners: list[int] = []
    for index, light in enumerate(ordered):
        made = _views_of(light, bounds, coarse_resolution if isinstance(light, SkyLight | EmitterLight) else resolution)
        packed[index] = _pack(light, made)[0]
        views += made
        owners += [index] * len(made)
    if len(views) > DEFAULT_LIMITS["max-texture-array-layers"]:
        raise DeviceError(
            f"{len(ordered)} lights need {len(views)} shadow maps; {DEFAULT_LIMITS['max-texture-array-layers']} is the "
            "most (a point light needs six). Use fewer lights."
        )
    directional, spot, point, emitter, sky = (len(group) for group in by_kind)
    flux = np.array([_total_flux(light, v) for light, v in zip(ordered, _grouped(views, owners), strict=True)])
    flux = flux.reshape(-1, 3)
    if not inverse_square:
        flux *= np.array([_growth(light, bounds) for light in ordered]).reshape(-1, 1)
    return LightSet(ordered, packed, (directional, spot, point, emitter, sky), views, owners, flux)


def _grouped(views: list[View], owners: list[int]) -> list[list[View]]:
    return [[v for v, o in zip(views, owners, strict=True) if o == owner] for owner in sorted(set(owners))]


def _views_of(light: Light, bounds: Bounds, resolution: int) -> list[View]:
    if isinstance(light, DirectionalLight):
        return directional_views(light, bounds, resolution)
    if isinstance(light, SpotLight):
        return spot_views(light, bounds, resolution)
    assert isinstance(light, PointLight)
    return point_views(light, bounds, resolution)


def _unit(direction: np.ndarray) -> np.ndarray:
    return direction / np.linalg.norm(direction)


def _pack(light: Light, views: list[View]) -> np.ndarray:
    # Texels of a directional map are oblong: the larger edge decides the shadow offset.
    texel = 2.0 * max(float(np.linalg.norm(views[0].right)), float(np.linalg.norm(views[0].up))) / views[0].width
    values = {"position": (0, 0, 0), "direction": (0, 0, 0), "cos_outer": 0.0, "cone_slope": 0.0}
    if isinstance(light, DirectionalLight | SpotLight):
        values["direction"] = _unit(np.asarray(light.direction, dtype=np.float64))
    if isinstance(light, PointLight | SpotLight):
        values["position"] = light.position
    if isinstance(light, EmitterLight):
        values |= {"direction": light.axis, "cos_outer": light.beam, "cone_slope": light.square_radius}
    if isinstance(light, SpotLight):
        outer = min(light.outer_angle, MAX_HALF_ANGLE)
        values["cos_outer"] = cos(outer)
        values["cone_slope"] = 1.0 / max(NARROWEST_RAMP, cos(min(light.inner_angle, outer)) - cos(outer))
    color = light.illuminance if isinstance(light, DirectionalLight) else light.intensity  # type: ignore[union-attr]
    return LIGHT.pack(color=color, texel=texel, **values)


def _total_flux(light: Light, views: list[View]) -> np.ndarray:
    """Flux of the light through its views: at most this can be reflected, since albedos are at most 1."""
    if isinstance(light, DirectionalLight):
        area = 4.0 * float(np.linalg.norm(views[0].right) * np.linalg.norm(views[0].up))
        return np.asarray(light.illuminance) * area
    assert isinstance(light, PointLight | SpotLight)
    # The area that a view shows at distance 1 is more than its solid angle: a tight bound for a narrow spot. The RSM's
    # midpoint rule for solid angles (frame/rsm.wgsl) may exceed them by less than 1 / resolution.
    area = sum(4.0 * float(np.linalg.norm(v.right) * np.linalg.norm(v.up)) for v in views)
    # An emitter's lobe brings its flux to 4 pi * intensity as well.
    return np.asarray(light.intensity) * min(area, 4.0 * pi) * (1.0 + 1.0 / views[0].width)


def _growth(light: Light, bounds: Bounds) -> float:
    """Of a lamp without falloff, which shines on what is r metres away as one of r^2 times its intensity does: the
    square of the distance to the farthest corner of the box. Emitters stand for surfaces, and keep theirs."""
    if isinstance(light, EmitterLight) or not isinstance(light, PointLight | SpotLight):
        return 1.0
    low, high = (np.asarray(corner) - light.position for corner in bounds)
    return float(np.square(np.maximum(np.abs(low), np.abs(high))).sum())
