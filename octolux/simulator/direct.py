"""Direct light without shadows: what lights bring to a surface point and what it sends to the eye."""

from __future__ import annotations

from math import cos, pi

import numpy as np

from octolux.scene.lights import AreaLight, DirectionalLight, ParticleLights, PointLight, SpotLight
from octolux.simulator import brdf
from octolux.simulator.solid_angles import polygon_moment


def _unit(vectors) -> tuple[np.ndarray, np.ndarray]:
    vectors = np.asarray(vectors, dtype=np.float64)
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0.0, length, 1.0), length


NARROWEST_RAMP = 1e-6
"""Least difference of the cosines of a spot's cones, so that equal cones divide by something. The extension's sample
code has 0.001 there, which dims every cone below 2.6 degrees; float32 tells cosines apart down to 6e-8."""


def spot_attenuation(light: SpotLight, to_light) -> np.ndarray:
    """Factor (...) of a spot light's intensity towards points that see it along unit `to_light` (..., 3).

    KHR_lights_punctual, "inner and outer cone angles": a linear ramp in the cosine between the two cones, clamped to
    [0, 1] and squared.
    """
    axis, _ = _unit(light.direction)
    slope = 1.0 / max(NARROWEST_RAMP, cos(light.inner_angle) - cos(light.outer_angle))
    cosine = -np.sum(np.asarray(to_light, dtype=np.float64) * axis, axis=-1)
    return np.square(np.clip((cosine - cos(light.outer_angle)) * slope, 0.0, 1.0))


def incident(
    light: DirectionalLight | PointLight | SpotLight, positions, inverse_square: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Unit direction to the `light` (..., 3), and the illuminance (..., 3), lx, on a plane perpendicular to it, at
    `positions` (..., 3). Point and spot lights: I / r^2, candela over square metres; without the inverse square what
    they bring at 1 m, whatever r is.

    Raises ValueError for a light that has no single direction (area lights).
    """
    positions = np.asarray(positions, dtype=np.float64)
    if isinstance(light, DirectionalLight):
        to_light, _ = _unit(np.broadcast_to(-np.asarray(light.direction, dtype=np.float64), positions.shape))
        return to_light, np.broadcast_to(np.asarray(light.illuminance, dtype=np.float64), positions.shape)
    if not isinstance(light, PointLight | SpotLight):
        raise ValueError(f"a {type(light).__name__} has no single direction; see area_light_irradiance")
    to_light, distance = _unit(np.asarray(light.position, dtype=np.float64) - positions)
    illuminance = np.asarray(light.intensity, dtype=np.float64) / np.square(distance if inverse_square else 1.0)
    illuminance = np.broadcast_to(illuminance, positions.shape)
    if isinstance(light, SpotLight):
        illuminance = illuminance * spot_attenuation(light, to_light)[..., None]
    return to_light, illuminance


def irradiance(light, positions, normals, inverse_square: bool = True) -> np.ndarray:
    """Irradiance (..., 3), lx, of any `light` at `positions` (..., 3) with unit `normals` (..., 3), without shadows;
    inverse_square: as in `incident`."""
    if isinstance(light, AreaLight):
        return area_light_irradiance(light, positions, normals)
    if isinstance(light, ParticleLights):
        return particles_irradiance(light, positions, normals)
    to_light, illuminance = incident(light, positions, inverse_square)
    cosine = np.maximum(0.0, np.sum(np.asarray(normals, dtype=np.float64) * to_light, axis=-1, keepdims=True))
    return illuminance * cosine


def particles_irradiance(light: ParticleLights, positions, normals) -> np.ndarray:
    """Irradiance (..., 3), lx, of `ParticleLights` at `positions` (..., 3) with unit `normals` (..., 3): the sum of
    I cos / r^2."""
    positions, normals = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (positions, normals)))
    result = np.zeros(positions.shape)
    for index in np.ndindex(positions.shape[:-1]):
        to_light, distance = _unit(light.positions - positions[index])
        cosine = np.maximum(0.0, to_light @ normals[index])
        result[index] = (cosine[:, None] / np.square(distance)).T @ light.intensities
    return result


def lambert_radiance(light, positions, normals, albedo) -> np.ndarray:
    """Radiance (..., 3), nits, that Lambertian points of `albedo` (..., 3) send in every direction: albedo / pi * E."""
    return np.asarray(albedo, dtype=np.float64) / pi * irradiance(light, positions, normals)


def radiance(light, positions, normals, eye, material: brdf.Surface) -> np.ndarray:
    """Radiance (..., 3), nits, that `positions` (..., 3) with unit `normals` (..., 3) send to `eye` (3,) under one
    directional, point or spot `light`: BRDF times irradiance. Raises ValueError for an area light."""
    positions = np.asarray(positions, dtype=np.float64)
    to_eye, _ = _unit(np.asarray(eye, dtype=np.float64) - positions)
    to_light, illuminance = incident(light, positions)
    cosine = np.maximum(0.0, np.sum(np.asarray(normals, dtype=np.float64) * to_light, axis=-1, keepdims=True))
    return brdf.evaluate(material, normals, to_light, to_eye) * illuminance * cosine


def area_light_irradiance(light: AreaLight, positions, normals) -> np.ndarray:
    """Irradiance (..., 3), lx, of an `AreaLight` at `positions` (..., 3) with unit `normals` (..., 3), closed form.

    Lambert's formula: L * n . (integral of w dw over the part of the polygon above the horizon)
    (`solid_angles.polygon_moment`); the polygon is clipped at the horizon first. Points behind the one-sided
    light, and points in its plane, receive nothing.
    """
    positions, normals = np.broadcast_arrays(*(np.asarray(v, dtype=np.float64) for v in (positions, normals)))
    corners = np.asarray(light.corners, dtype=np.float64)
    facing = np.cross(corners[1] - corners[0], corners[2] - corners[0]) + np.cross(
        corners[2] - corners[0], corners[3] - corners[0]
    )
    result = np.zeros(positions.shape)
    for index in np.ndindex(positions.shape[:-1]):
        relative = corners - positions[index]
        if relative[0] @ facing < 0.0:
            lit = normals[index] @ -polygon_moment(clip_at_horizon(relative, normals[index]))
            result[index] = np.asarray(light.radiance) * max(0.0, float(lit))
    return result


def clip_at_horizon(vertices: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The part (K', 3) of the convex polygon `vertices` (K, 3) with v . normal >= 0 (Sutherland & Hodgman 1974);
    (1, 3) of zeros when nothing is left."""
    heights = vertices @ normal
    kept = []
    for i in range(len(vertices)):
        j = (i + 1) % len(vertices)
        if heights[i] >= 0.0:
            kept.append(vertices[i])
        if heights[i] * heights[j] < 0.0:
            kept.append(vertices[i] + (vertices[j] - vertices[i]) * (heights[i] / (heights[i] - heights[j])))
    return np.array(kept) if kept else np.zeros((1, 3))
