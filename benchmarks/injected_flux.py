"""Does the volume receive what the lit surfaces reflect? Each kind of light in a scene whose flux is known."""

from __future__ import annotations

from math import cos, pi

import numpy as np

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, Light, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene
from octolux.simulator.lpv.propagation import total_flux

from .lab import device
from .registry import figure, within

ALBEDO = np.array([0.8, 0.5, 0.2])
COLOR = np.array([1.0, 2.0, 3.0])


def injected(mesh: Mesh, light: Light) -> np.ndarray:
    """Flux (3,) in the volume before the first step: `mesh` of ALBEDO under `light`, default preset and resolutions."""
    scene = Scene(
        meshes=[mesh], instances=[Instance(0)], lights=[light], exposure=0.0,
        materials=[Material(base_color=tuple(ALBEDO), specular=0.0, double_sided=True)],
        cameras=[Camera.look_at((0.0, 0.5, 0.8), (0.0, 0.0, 0.0))],
    )  # fmt: skip
    renderer = Renderer(scene, "uniform-lpv", size=(8, 8), device=device())
    renderer.render()
    return total_flux(renderer.technique.debug_views()["injected"].astype(np.float64))


def _room() -> Mesh:
    return box((-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), inward=True)


def point_light() -> float:
    """In a closed box everything is lit: albedo * 4 pi I."""
    light = PointLight(position=(0.3, -0.2, 0.4), intensity=tuple(COLOR))
    return float((injected(_room(), light) / (ALBEDO * COLOR * 4.0 * pi)).mean())


def spot_flux(light: SpotLight) -> np.ndarray:
    """Flux (3,), lm: the ramp t^2 with t from 0 at the outer to 1 at the inner cone is linear in the cosine, so
    2 pi I ((1 - cos inner) + (cos inner - cos outer) / 3)."""
    inner, outer = cos(light.inner_angle), cos(light.outer_angle)
    return np.array(light.intensity) * 2.0 * pi * ((1.0 - inner) + (inner - outer) / 3.0)


def spot_light() -> float:
    """In a closed box the whole cone is lit."""
    light = SpotLight(
        position=(0.1, 0.2, -0.3), direction=(0.4, -1.0, 0.2), intensity=tuple(COLOR), inner_angle=0.35, outer_angle=0.7
    )
    return float((injected(_room(), light) / (ALBEDO * spot_flux(light))).mean())


def directional_light() -> float:
    """On a floor of 2 m x 2 m: albedo * E * area * cosine."""
    direction = np.array([0.4, -1.0, 0.3])
    light = DirectionalLight(direction=tuple(direction), illuminance=tuple(COLOR))
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    reflected = ALBEDO * COLOR * 4.0 * -direction[1] / np.linalg.norm(direction)
    return float((injected(floor, light) / reflected).mean())


@figure("injected_flux", group="closed_form", unit="x", bound=dict.fromkeys(
    ("point", "spot", "directional"), within(1.0, 0.01)))  # fmt: skip
def injected_flux() -> dict[str, float]:
    """Flux in the volume after injection over the flux that the lit surfaces reflect, in closed form."""
    return {"point": point_light(), "spot": spot_light(), "directional": directional_light()}
