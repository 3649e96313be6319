"""Depth peeling (Everitt 2001, Interactive order-independent transparency): what lies behind that which lamps and the
camera see, layer by layer. Light volumes take more surfels from it (CLPV 3.2); VPLs come from the first layer alone.

A surface is in one layer of a view at most, and all layers together are all that the view's rays meet, but for the
backs of single-sided surfaces behind the first layer (visibility.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from ..gpu.device import Device
from ..gpu.records import record_texture, word_texture
from ..gpu_scene.gpu_scene import GpuScene
from .frame import CameraSees, Frame
from .gbuffer import GBufferPass
from .rsm import RSMPass
from .shadows import ShadowMapPass, ShadowMaps
from .structs import VPL
from .visibility import VisibilityPass


@dataclass(frozen=True, eq=False)
class LampLayer:
    """A further layer of all lamps: vpls, surfaces: as `Frame.vpls` and `Frame.vpl_surfaces`, each in its place."""

    vpls: Any
    surfaces: Any


class PeelingPass:
    """Sets `frame.lamp_layers` and `frame.camera_layers`: as many as are asked for, less the first.

    Those of lamps are peeled anew when their maps are drawn, or something comes to rest, which is one of the traits.
    """

    def __init__(self, device: Device, scene: GpuScene, visibility: VisibilityPass):
        self.device, self._visibility = device, visibility
        self._gbuffer = GBufferPass(device, scene, visibility, emission=False)
        self._maps = [ShadowMaps(device, "peeled "), ShadowMaps(device, "peeled ")]  # a layer, and the one before it
        self._lamps: list[LampLayer] = []
        self._camera: list[CameraSees] = []
        self._room = 0
        self._made_of: tuple = ()

    def run(self, frame: Frame, shadow_maps: ShadowMapPass, rsm: RSMPass, lamps: int, camera: int) -> None:
        """lamps, camera: layers of each, with the first."""
        self._make_room(frame, lamps - 1, camera - 1)
        frame.lamp_layers, frame.camera_layers = self._lamps, self._camera
        before = self._made_of
        self._made_of = (shadow_maps.drawings, frame.gpu_scene.is_moving.tobytes(), frame.vpls)
        if self._lamps and before != self._made_of:
            with frame.profiler.stage("peeled RSMs") as stage:
                for view in range(frame.lights.main_views):
                    self._peel_lamp(stage, frame, shadow_maps.main, view, rsm)
        if self._camera:
            with frame.profiler.stage("peeled G-buffer") as stage:
                self._peel_camera(stage, frame)

    def _peel_lamp(self, stage: Any, frame: Frame, maps: ShadowMaps, view: int, rsm: RSMPass) -> None:
        nearer, _ = maps.targets(view, False)
        for number, layer in enumerate(self._lamps):
            target = self._maps[number % 2]
            target.need(frame.settings.shadow_resolution, 1, True)
            depth, ids = target.targets(0, True)
            self._visibility.draw(stage, frame, 1 + view, depth, ids, nearer)
            rsm.of_view(stage, frame, view, target.ids, layer.vpls, layer.surfaces)
            nearer = depth

    def _peel_camera(self, stage: Any, frame: Frame) -> None:
        nearer = frame.targets.raster_depth.create_view()
        for layer in self._camera:
            depth = layer.raster_depth.create_view()
            self._visibility.draw(stage, frame, 0, depth, layer.ids.create_view(), nearer)
            self._gbuffer.resolve(stage, frame, layer)
            nearer = depth

    def _make_room(self, frame: Frame, lamps: int, camera: int) -> None:
        vpls = sum(count for _, count in frame.vpl_ranges[: frame.lights.lamps])
        if (self._room, len(self._lamps)) != (vpls, lamps):
            self._room, self._made_of = vpls, ()
            self._lamps = [
                LampLayer(record_texture(self.device, "peeled VPLs", VPL, vpls),
                          word_texture(self.device, "peeled VPLs' surfaces", vpls)) for _ in range(lamps)
            ]  # fmt: skip
        if len(self._camera) != camera or any(layer.size != frame.pixels for layer in self._camera):
            self._camera = [CameraSees(self.device, *frame.pixels, "peeled ") for _ in range(camera)]
