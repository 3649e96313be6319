"""Shadow maps of all lights in one depth array, one layer for a directional or spot light and six for a point light."""

from __future__ import annotations

from typing import Any

from ..gpu.device import Device
from .frame import RENDER, TEXTURE, Frame
from .visibility import VisibilityPass


class ShadowMapPass:
    """Draws every light's faces; with `ids` also, in the same rendering, the triangle numbers RSMs are made from."""

    def __init__(self, device: Device, visibility: VisibilityPass):
        self.device, self.visibility = device, visibility
        self.depth: Any = None
        self.ids: Any = None
        self.sampler = device.wgpu.create_sampler()  # nearest: the four depths are compared one by one

    def _layers(self, texture: Any, label: str, format: str, layers: int, resolution: int) -> Any:
        if texture is not None and texture.size == (resolution, resolution, layers):
            return texture
        return self.device.texture(label, (resolution, resolution, layers), format, usage=RENDER | TEXTURE)

    def run(self, frame: Frame, ids: bool) -> None:
        """Fill the layers and set `frame.shadow_maps`."""
        resolution, layers = frame.settings.shadow_resolution, max(1, len(frame.lights.views))
        self.depth = self._layers(self.depth, "shadow maps", "depth32float", layers, resolution)
        if ids:
            self.ids = self._layers(self.ids, "shadow-map triangles", "r32uint", layers, resolution)
        frame.shadow_maps = self.depth
        if not frame.lights.views:
            return
        with frame.profiler.stage("RSM rendering" if ids else "shadow maps") as stage:
            for layer in range(len(frame.lights.views)):
                one = {"dimension": "2d", "base_array_layer": layer, "array_layer_count": 1}
                depth, id_view = self.depth.create_view(**one), self.ids.create_view(**one) if ids else None
                self.visibility.draw(stage, frame, layer + 1, depth, id_view)
