"""Lights and surroundings as emitters of Mitsuba 3."""

from __future__ import annotations

from math import cos, degrees, pi, tan
from pathlib import Path
from typing import Any

import numpy as np

from ..scene.environment import Environment
from ..scene.lights import AreaLight, DirectionalLight, PointLight, SingleLight, SpotLight
from ..simulator.direct import spot_attenuation
from ..simulator.environment import sampled
from .files import FileFolder
from .mitsuba_materials import Description, rgb
from .ply import write_ply

SPOT_TEXELS = 512
WIDEST_SPOT = 0.495 * pi
"""Radians. Mitsuba's spot is a picture thrown through a pyramid, which ends before a half space; 1 degree is lost."""


def light(source: SingleLight, number: int, files: FileFolder) -> Description:
    """The emitter, or for an area light the shape, of a light; `number` tells it apart from the others."""
    if isinstance(source, DirectionalLight):
        return {"type": "directional", "direction": _floats(source.direction), "irradiance": rgb(source.illuminance)}
    if isinstance(source, PointLight):
        return {"type": "point", "position": _floats(source.position), "intensity": rgb(source.intensity)}
    return _spot(source, number, files) if isinstance(source, SpotLight) else _area(source, number, files)


def _spot(source: SpotLight, number: int, files: FileFolder) -> Description:
    """Mitsuba's own falloff is linear in the angle: it is switched off (the beam fills the cone), and the falloff of
    KHR_lights_punctual is the picture that the light throws."""
    outer = min(source.outer_angle, WIDEST_SPOT)
    spot: Description = {
        "type": "spot", "to_world": _along_z(source.position, source.direction), "intensity": rgb(source.intensity),
        "cutoff_angle": degrees(outer), "beam_width": degrees(outer),
    }  # fmt: skip
    if cos(source.inner_angle) - cos(outer) > 1e-6:
        falloff = _falloff(source, outer)
        file = files.exr(("spot", number), f"light-{number}-falloff.exr", np.repeat(falloff[..., None], 3, axis=2))
        spot["texture"] = {"type": "bitmap", "filename": file, "raw": True, "wrap_mode": "clamp"}
    return spot


def _falloff(source: SpotLight, outer: float) -> np.ndarray:
    """float32 (texels, texels): the picture spans the cone at unit distance, tan(outer) to each side."""
    across = ((np.arange(SPOT_TEXELS) + 0.5) / SPOT_TEXELS * 2.0 - 1.0) * tan(outer)
    x, y = np.meshgrid(across, across)
    from_light = np.stack([x, y, np.ones_like(x)], axis=-1)
    from_light /= np.linalg.norm(from_light, axis=-1, keepdims=True)
    axis_z = SpotLight(position=(0, 0, 0), direction=(0, 0, 1), intensity=(1, 1, 1),
                       inner_angle=source.inner_angle, outer_angle=outer)  # fmt: skip
    return spot_attenuation(axis_z, -from_light).astype(np.float32)


def _along_z(position: Any, direction: Any) -> np.ndarray:
    """(4, 4) of a light at `position` whose +z looks along `direction`."""
    z = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    x = np.cross(np.eye(3)[np.argmin(np.abs(z))], z)
    x /= np.linalg.norm(x)
    matrix = np.eye(4)
    matrix[:3, 0], matrix[:3, 1], matrix[:3, 2], matrix[:3, 3] = x, np.cross(z, x), z, position
    return matrix


def _area(source: AreaLight, number: int, files: FileFolder) -> Description:
    """Two triangles that shine to the side from which their corners run counter-clockwise; all light passes them."""
    corners = np.asarray(source.corners, dtype=np.float64)
    normal = np.cross(corners[2] - corners[0], corners[3] - corners[1])
    normals = np.broadcast_to(normal / max(float(np.linalg.norm(normal)), 1e-300), (4, 3))
    uvs = np.array([[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])

    def write(path: Path) -> None:
        write_ply(path, corners, normals, np.array([[0, 1, 2], [0, 2, 3]]), uvs)

    return {
        "type": "ply", "filename": files.once(("area", number), f"light-{number}.ply", write),
        "bsdf": {"type": "null"},
        "emitter": {"type": "area", "radiance": rgb(source.radiance)},
    }  # fmt: skip


def environment(source: Environment, files: FileFolder) -> Description | None:
    """The emitter of the surroundings, None where they are black."""
    if source.is_black:
        return None
    if source.image is None:
        return {"type": "constant", "radiance": rgb(source.radiance)}
    pixels = envmap_pixels(source)
    return {
        "type": "envmap", "filename": files.exr("environment", "environment.exr", pixels),
        "to_world": _turn(pi + source.rotation),
    }  # fmt: skip


def envmap_pixels(source: Environment) -> np.ndarray:
    """float32 (2 height + 1, width, 3). Mitsuba's first and last row lie at the poles, where ours lie half a row below;
    with twice the rows every row of ours is one of Mitsuba's, and between them both are linear: nothing is lost."""
    assert source.image is not None
    height, width = source.image.shape[:2]
    polar = np.arange(2 * height + 1)[:, None] / (2 * height) * pi
    azimuth = ((np.arange(width) + 0.5) / width * 2.0 * pi - pi)[None, :]
    across = np.sin(polar) + 1e-9  # at the poles the columns still differ
    directions = np.stack(
        [across * np.sin(azimuth), np.broadcast_to(np.cos(polar), (len(polar), width)), -across * np.cos(azimuth)], -1
    )
    image = sampled(Environment(image=source.image), directions)
    return (image + np.asarray(source.radiance)).astype(np.float32)


def _turn(angle: float) -> np.ndarray:
    """(4, 4) rotation about +y."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s, 0.0], [0.0, 1.0, 0.0, 0.0], [-s, 0.0, c, 0.0], [0.0, 0.0, 0.0, 1.0]])


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(v) for v in values)
