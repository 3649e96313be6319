"""The atrium: a courtyard of two storeys with coloured curtains, lit by the sun through the open roof."""

from __future__ import annotations

from math import radians

import numpy as np

from ..animation import Track
from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import DirectionalLight
from ..materials import Color, Material
from ..meshes import Instance
from ..scene import Environment, Scene
from .courtyard import courtyard
from .textures import Surface, cloth, masonry, plaster, tiles

SUN_DIRECTION = (0.42, -1.0, 0.50)
SUN: Color = (66_000.0, 60_000.0, 50_000.0)
"""Lux: a clear sun, a little warm."""

SKY: Color = (2_600.0, 3_600.0, 5_400.0)
"""Nits: a clear blue sky."""

METERED_LUMINANCE = 800.0
"""Nits: between the mean of what the hall camera sees (about 1500) and the middle of its shade (about 450)."""


def atrium() -> Scene:
    """A courtyard of 20 x 10.8 x 8.7 m (x, z, y) open to the sky, one mesh for each named part, in world space.

    The sun lights the floor beside the arcade at positive z ("sun" in the names), that arcade and its curtains; the
    other side ("shade") receives indirect light only. Cameras "hall" and "gallery"; the light "sun" moves over 10 s.
    """
    meshes = list(courtyard())
    return Scene(
        name="atrium",
        meshes=meshes,
        instances=[Instance(i, name=mesh.name) for i, mesh in enumerate(meshes)],
        materials=_materials(),
        lights=[DirectionalLight(direction=SUN_DIRECTION, illuminance=SUN, name="sun")],
        cameras=[
            Camera.look_at((-9.3, 1.8, -1.0), (2.0, 3.3, 0.45), vertical_fov=radians(62), near=0.05, name="hall"),
            Camera.look_at((-6.6, 6.35, -3.85), (-0.4, 2.8, 1.1), vertical_fov=radians(62), near=0.05, name="gallery"),
        ],
        environment=Environment(SKY),
        tracks=[_sun_track()],
        exposure=metered_exposure(METERED_LUMINANCE),
    )


def _materials() -> list[Material]:
    """In the order of the constants of `courtyard`. Linear albedos."""
    gold = (0.52, 0.36, 0.10)
    fabrics = (("red cloth", (0.46, 0.030, 0.022)), ("green cloth", (0.045, 0.26, 0.055)),
               ("blue cloth", (0.035, 0.085, 0.38)))
    stones = [
        _material("masonry", masonry(1, (0.52, 0.43, 0.32)), 0.9),
        _material("floor", tiles(2, (0.56, 0.50, 0.42), (0.28, 0.16, 0.11)), 0.6),
        _material("stone", plaster(3, (0.60, 0.54, 0.45), strength=1.2), 0.8),
        _material("plaster", plaster(4, (0.62, 0.55, 0.45), strength=1.5), 0.9),
        _material("wood", plaster(5, (0.16, 0.085, 0.045)), 0.7),
        _material("clay", plaster(6, (0.42, 0.19, 0.11)), 0.9),
    ]
    cloths = [_material(name, cloth(7 + i, color, gold), 0.9, double_sided=True)
              for i, (name, color) in enumerate(fabrics)]
    return stones + cloths


def _material(name: str, surface: Surface, roughness: float, double_sided: bool = False) -> Material:
    return Material(name=name, base_color_texture=surface.base_color, normal_texture=surface.normal,
                    roughness=roughness, double_sided=double_sided)


def _sun_track() -> Track:
    """From the still picture's direction back to the morning and over noon to the afternoon."""
    directions = [SUN_DIRECTION, (0.06, -1.0, 0.68), (-0.30, -1.0, 0.85), (0.62, -1.0, 0.20), (0.70, -1.0, -0.25)]
    return Track(target="light", name="sun", property="direction", times=np.array([0.0, 2.5, 5.0, 7.5, 10.0]),
                 values=np.array(directions))
