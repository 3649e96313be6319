"""The atrium: a courtyard of two storeys with coloured curtains, lit by the sun through the open roof."""

from __future__ import annotations

from math import radians

import numpy as np

from ..cameras import Camera
from ..exposure import metered_exposure
from ..lights import DirectionalLight
from ..materials import Color, Material
from ..meshes import Instance
from ..motion.tracks import Track
from ..scene import Environment, Scene
from .courtyard import courtyard
from .courtyard_details import courtyard_details
from .placing import plain, textured
from .plant_textures import twig
from .textures import cloth, masonry, plaster, tiles

SUN_DIRECTION = (0.42, -1.0, 0.40)
SUN: Color = (66_000.0, 60_000.0, 50_000.0)
"""Lux: a clear sun, a little warm."""

SKY: Color = (2_600.0, 3_600.0, 5_400.0)
"""Nits: a clear blue sky."""

METERED_LUMINANCE = 800.0
"""Nits: between the mean of what the hall camera sees (about 1500) and the middle of what it sees (about 500)."""


def atrium() -> Scene:
    """A courtyard of two storeys of arches and columns with curtains, banners and a fountain, open to the sky.

    20 x 10.8 x 8.7 m (x, z, y), one mesh for each named part, in world space. The sun lights the floor beside the
    arcade at positive z ("sun" in the names), that arcade and its curtains; the other side ("shade") receives indirect
    light only. Cameras "hall" and "gallery"; the light "sun" moves over 10 s.
    """
    meshes = [*courtyard(), *courtyard_details()]
    return Scene(
        name="atrium",
        meshes=meshes,
        instances=[Instance(i, name=mesh.name) for i, mesh in enumerate(meshes)],
        materials=_materials(),
        lights=[DirectionalLight(direction=SUN_DIRECTION, illuminance=SUN, name="sun")],
        cameras=[
            Camera.look_at((-9.2, 1.7, -1.3), (2.0, 3.15, 0.5), vertical_fov=radians(60), near=0.05, name="hall"),
            Camera.look_at((-8.9, 6.2, -2.45), (0.6, 2.5, 0.75), vertical_fov=radians(60), near=0.05, name="gallery"),
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
        textured("masonry", masonry(1, (0.52, 0.43, 0.32)), 0.9),
        textured("floor", tiles(2, (0.56, 0.50, 0.42), (0.28, 0.16, 0.11)), 0.4),
        textured("stone", plaster(3, (0.60, 0.54, 0.45), strength=0.5), 0.8),
        textured("plaster", plaster(4, (0.62, 0.55, 0.45), strength=0.8), 0.9),
        textured("wood", plaster(5, (0.16, 0.085, 0.045)), 0.7),
        textured("clay", plaster(6, (0.42, 0.19, 0.11), strength=1.0), 0.9),
    ]
    cloths = [textured(name, cloth(7 + i, color, gold), 0.9, double_sided=True)
              for i, (name, color) in enumerate(fabrics)]
    others = [
        plain("water", (0.02, 0.05, 0.055), 0.08),
        Material(name="leaves", base_color_texture=twig(10, (0.09, 0.17, 0.04)), roughness=0.6, alpha_mode="mask",
                 double_sided=True),
        plain("iron", (0.05, 0.05, 0.055), 0.5),
    ]
    return stones + cloths + others


def _sun_track() -> Track:
    """From the still picture's direction on into the afternoon, back over noon to the morning, and to the start."""
    directions = [SUN_DIRECTION, (0.06, -1.0, 0.62), (-0.30, -1.0, 0.80), (0.06, -1.0, 0.62), SUN_DIRECTION,
                  (0.62, -1.0, 0.15), (0.70, -1.0, -0.25), (0.62, -1.0, 0.15), SUN_DIRECTION]
    return Track(target="light", name="sun", property="direction", times=np.linspace(0.0, 10.0, 9),
                 values=np.array(directions))
