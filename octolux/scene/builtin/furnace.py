"""The white furnace: a closed box that glows, whose radiance is known exactly."""

from __future__ import annotations

from ..cameras import Camera
from ..exposure import metered_exposure
from ..materials import Material
from ..meshes import Instance
from ..scene import Scene
from .shapes import box

ALBEDO = 0.5
EMISSION = 1.0
"""Emitted radiance of every wall, in nits."""


def furnace() -> Scene:
    """A closed cube of 2 m that glows, seen from inside, for checks: its exact radiance is 2 nits everywhere.

    Albedo a = 0.5, emission e = 1 nit: radiance e / (1 - a) = 2 nits, of which half is emitted and half is indirect
    light. Camera "inside".
    """
    return Scene(
        name="furnace",
        meshes=[box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), inward=True, name="walls")],
        instances=[Instance(0, name="walls")],
        materials=[Material(name="walls", base_color=(ALBEDO,) * 3, specular=0.0, emissive=(EMISSION,) * 3)],
        cameras=[Camera.look_at((-0.4, 0.2, 0.7), (0.5, -0.3, -1.0), name="inside")],
        exposure=metered_exposure(EMISSION / (1.0 - ALBEDO)),
    )
