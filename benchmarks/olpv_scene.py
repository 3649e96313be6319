"""The frames that OLPV's measurements are made on: three moving point lights in the atrium or in Crytek Sponza."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cache
from math import cos, pi, sin
from typing import Any

import octolux
from octolux.compare.choices import choice
from octolux.frame.frame import Frame, FrameSettings
from octolux.gpu.device import Device
from octolux.gpu.profiler import Profiler
from octolux.renderer import Renderer
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import PointLight
from octolux.scene.scene import Scene
from octolux.techniques.lpv.geometry import GeometryVolume
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.octree.technique import OctreeLpv
from octolux.techniques.lpv.uniform.technique import UniformLpv
from octolux.techniques.technique import Technique

from . import scenes_on_disk
from .lab import device

SCENES = {"atrium": "hall", "crytek": "nave"}
"""The scenes, and the camera that sees each."""

# OLPV 5.2 and 6: 1024^2 shadow maps of which 256^2 texels are injected. No light but the lamps: the sky and what glows
# would bring RSMs of their own.
MAPS = FrameSettings(shadow_resolution=1024, rsm_resolution=256, sky_lights=0, emitter_lights=0)
_LAMPS = (((-6.5, 1.6, 0.8), (900.0, 560.0, 280.0)), ((0.5, 1.4, -1.4), (1200.0, 800.0, 420.0)),
          ((7.0, 2.0, 0.6), (1100.0, 620.0, 260.0)))  # fmt: skip
_PERIOD, _REACH = 100, 0.7  # frames and metres of the circles that the lamps go round


@cache
def base_scene(name: str) -> Scene:
    """Raises NeedsData when its model is not there."""
    scene = octolux.load("atrium") if name == "atrium" else scenes_on_disk.load("crytek_lamps")
    still = scene.at(0.0) if scene.tracks else scene
    return replace(still, environment=Environment((0.0, 0.0, 0.0)), exposure=4.5)


def lit(scene: Scene, frame: int) -> Scene:
    """The scene in frame number `frame`: all lamps have moved."""
    lights = []
    for number, ((x, y, z), intensity) in enumerate(_LAMPS):
        turn = 2.0 * pi * (frame / _PERIOD + number / len(_LAMPS))
        place = (x + _REACH * cos(turn), y, z + _REACH * sin(turn))
        lights.append(PointLight(position=place, intensity=intensity, name=f"lamp {number}"))
    return replace(scene, lights=lights)


class _WithGeometry(Technique):
    """Fills a geometry volume of the RSMs' surfels first, as both systems of the thesis did in its table 1. Steps of
    these presets do not read it."""

    levels: Levels
    _grid_buffer: Any

    def update(self, frame: Frame) -> None:
        if not hasattr(self, "_filled"):
            self._filled = GeometryVolume(self.device, self.levels, camera=False, planes=False)
        with frame.profiler.stage("geometry volume") as stage:
            self._filled.run(stage, frame, self._grid_buffer)
        super().update(frame)


class _Octree(_WithGeometry, OctreeLpv):
    pass


class _Uniform(_WithGeometry, UniformLpv):
    def __init__(self, device: Device, settings: Any):
        super().__init__(device, settings)
        self.levels = Levels([settings.n])


def technique(text: str, geometry: bool = True) -> Technique:
    """What `text` names (NAME:PRESET,KEY=VALUE), with a geometry volume if it has none and `geometry` is set."""
    one = choice(text)
    own = getattr(one.settings, "occlusion", False)
    classes: dict[str, tuple[type[Technique], type[Technique]]] = {
        "octree-lpv": (OctreeLpv, _Octree), "uniform-lpv": (UniformLpv, _Uniform)
    }  # fmt: skip
    return classes[one.technique][geometry and not own](device(), one.settings)


def renderer(scene: str, text: str, size: tuple[int, int], profiler: Profiler, geometry: bool = True) -> Renderer:
    made = Renderer(lit(base_scene(scene), 0), "none", size=size, device=device(), frame_settings=MAPS)
    made.technique, made.profiler = technique(text, geometry), profiler
    return made


@dataclass(eq=False)
class Kept:
    """A technique with the frame it last saw, whose parts can be run again alone."""

    renderer: Renderer
    technique: Technique
    frame: Frame


def kept(scene: str, text: str, size: tuple[int, int] = (64, 36), geometry: bool = True) -> Kept:
    """After one frame of the scene."""
    made = renderer(scene, text, size, Profiler(device(), "off"), geometry)
    frames: list[Frame] = []
    update = made.technique.update

    def watched(frame: Frame) -> None:
        frames.append(frame)
        update(frame)

    made.technique.update = watched  # type: ignore[method-assign]
    camera: str | Camera = SCENES[scene]
    made.render(camera)
    made.technique.update = update  # type: ignore[method-assign]
    return Kept(made, made.technique, frames[0])
