"""Fog (CLPV 7): its cost, what its coarser resolutions lose, and closed forms."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from math import pi

import numpy as np

import octolux
from octolux.frame.frame import FrameSettings
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.environment import Environment
from octolux.scene.lights import DirectionalLight
from octolux.scene.medium import Medium
from octolux.scene.scene import Scene
from octolux.simulator import fog
from octolux.simulator.camera import pixel_rays

from .lab import device
from .registry import at_most, figure

SIZE, ROUNDS, WARM_UP = (640, 360), 7, 2
RESOLUTIONS = {"full": 1, "half": 2, "quarter": 4}
TECHNIQUES = ("none", "uniform-lpv")
EXPOSURE = 12.6  # EV100; the same for all


def renderer(scene: Scene, technique: str, resolution: int = 2, **settings: int) -> Renderer:
    frame = FrameSettings(fog_resolution=resolution, **settings)
    return Renderer(scene, technique, size=SIZE, exposure=EXPOSURE, device=device(), profile=True,
                    default_light=False, frame_settings=frame)  # fmt: skip


def atrium(scattering: float = 0.03) -> Scene:
    return replace(octolux.load("atrium"), medium=Medium(scattering=(scattering,) * 3))


@cache
def atrium_frames(technique: str) -> tuple[dict[str, Renderer], dict[str, Picture]]:
    """Renderers whose frames took turns, all with maps of lights drawn anew, and their last pictures, by resolution;
    `clear` has no medium."""
    made = {"clear": renderer(replace(atrium(), medium=None), technique)}
    made |= {name: renderer(atrium(), technique, pixels) for name, pixels in RESOLUTIONS.items()}
    pictures = {}
    for number in range(WARM_UP + ROUNDS):
        for name, each in made.items():
            if number == WARM_UP:
                each.profiler.clear()
            each.forget()
            pictures[name] = each.render()
    return made, pictures


_COST_UNITS = {f"{t}.{r}_{what}": unit for t in TECHNIQUES for r in RESOLUTIONS
               for what, unit in (("fog", "ms"), ("frame", "ms"), ("share", ""))}  # fmt: skip


@figure("fog_cost", group="fog", unit=_COST_UNITS | {f"{t}.clear_frame": "ms" for t in TECHNIQUES})
def fog_cost() -> dict[str, float]:
    """Fog of the atrium at 640x360 by technique and resolution: ms, its share of the frame, and the frame's ms."""
    found = {}
    for technique in TECHNIQUES:
        for name, each in atrium_frames(technique)[0].items():
            frame = each.profiler.frame_ms()["median"]
            found[f"{technique}.{name}_frame"] = frame
            if name != "clear":
                time = next(row["median_ms"] for row in each.profiler.stages() if row["name"] == "fog")
                found |= {f"{technique}.{name}_fog": time, f"{technique}.{name}_share": time / frame}
    return found


# Half a texel of the marched picture is a pixel: what it loses of the light is far below an 8-bit step of the middle
# tones, 2 %.
@figure("fog_resolution", group="fog", bound={f"{t}.half": at_most(0.02) for t in TECHNIQUES})
def fog_resolution() -> dict[str, float]:
    """Relative RMSE of the atrium's picture with fog of half and quarter resolution against full."""
    found = {}
    for technique in TECHNIQUES:
        pictures = atrium_frames(technique)[1]
        whole = pictures["full"].radiance.astype(np.float64)
        for name in ("half", "quarter"):
            difference = pictures[name].radiance - whole
            found[f"{technique}.{name}"] = float(np.sqrt((difference**2).mean()) / whole.mean())
    return found


LOW, HIGH = (-4.0, -3.0, -8.0), (4.0, 3.0, 0.0)


def empty(medium: Medium, **rest) -> Scene:
    """A camera before a medium, and nothing else but a triangle out of sight."""
    scene = Scene.from_arrays([[0, 0, 9], [1, 0, 9], [0, 1, 9]], [[0, 1, 2]])
    camera = octolux.Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0))
    return replace(scene, cameras=[camera], medium=medium, **rest)


@figure("fog_closed_form", group="fog", bound=at_most(0.02))
def fog_closed_form() -> float:
    """Largest relative error of an even medium under a sun that it dims: L = s E / (4 pi) e^-xy (1 - e^-rl) / r."""
    medium = Medium(scattering=(0.05, 0.1, 0.2), absorption=(0.05, 0.0, 0.05), low=LOW, high=HIGH)
    sun = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(1.0, 1.0, 1.0))
    scene = empty(medium, lights=[sun])
    found = renderer(scene, "none").render().layers["fog"]
    origins, directions = pixel_rays(scene.cameras[0], *SIZE)
    first, last = (t[..., None] for t in fog.span(origins, directions, (np.array(LOW), np.array(HIGH))))
    rate = medium.extinction * (1.0 - directions[..., 1:2])
    start = origins[..., 1:2] + first * directions[..., 1:2]
    wanted = np.array(medium.scattering) / (4 * pi) * np.exp(-medium.extinction * (HIGH[1] - start)) / rate
    wanted *= 1.0 - np.exp(-rate * np.maximum(last - first, 0.0))
    there = wanted.max(axis=-1) > 0
    return float((np.abs(found - wanted)[there].max(axis=-1) / wanted[there].max(axis=-1)).max())


# Light that is scattered out of the sky's light on its way to the air is not scattered in again: below 1. Rounding.
@figure("fog_no_light_made", group="fog", bound=at_most(1.0 + 1e-5))
def fog_no_light_made() -> dict[str, float]:
    """Brightest pixel of an even sky through a medium that only scatters, over the sky's own; for three densities."""
    found = {}
    for scattering in (0.01, 0.1, 1.0):
        medium = Medium(scattering=(scattering,) * 3, low=LOW, high=HIGH)
        scene = empty(medium, environment=Environment((2.0, 2.0, 2.0)))
        found[f"scattering_{scattering:g}"] = float(renderer(scene, "none").render().radiance.max() / 2.0)
    return found
