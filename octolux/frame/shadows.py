"""Shadow maps of all lights in two depth arrays: one layer for a directional or spot light and six for a point light in
one, and those of emitters and the sky, which are many and coarse, in the other."""

from __future__ import annotations

from typing import Any

from ..gpu.device import Device
from .frame import RENDER, TEXTURE, Frame
from .visibility import VisibilityPass


class ShadowMaps:
    """An array of shadow maps, and of the triangle numbers that RSMs are made from."""

    def __init__(self, device: Device, label: str):
        self.device, self.label = device, label
        self.depth: Any = None
        self.ids: Any = None

    def need(self, resolution: int, layers: int, ids: bool) -> None:
        self.depth = self._array(self.depth, "shadow maps", "depth32float", layers, resolution)
        if ids:
            self.ids = self._array(self.ids, "shadow-map triangles", "r32uint", layers, resolution)

    def _array(self, texture: Any, what: str, format: str, layers: int, resolution: int) -> Any:
        size = (resolution, resolution, max(1, layers))
        if texture is not None and texture.size == size:
            return texture
        return self.device.texture(f"{self.label}{what}", size, format, usage=RENDER | TEXTURE)

    def targets(self, layer: int, ids: bool) -> tuple[Any, Any | None]:
        one = {"dimension": "2d", "base_array_layer": layer, "array_layer_count": 1}
        return self.depth.create_view(**one), self.ids.create_view(**one) if ids else None


class ShadowMapPass:
    """Draws every light's faces; with `ids` also, in the same rendering, the triangle numbers RSMs are made from.

    The coarse maps are drawn again only when something has moved: skies and lamps seldom do, and they are many.
    """

    def __init__(self, device: Device, visibility: VisibilityPass):
        self.visibility = visibility
        self.main, self.coarse = ShadowMaps(device, ""), ShadowMaps(device, "coarse ")
        self._coarse_of: tuple = ()
        self.sampler = device.wgpu.create_sampler()  # nearest: the four depths are compared one by one

    def run(self, frame: Frame, ids: bool) -> None:
        """Fill the layers and set `frame.shadow_maps` and `frame.coarse_maps`."""
        settings, lights = frame.settings, frame.lights
        first_coarse = lights.main_views
        self.main.need(settings.shadow_resolution, first_coarse, ids)
        self.coarse.need(settings.coarse_resolution, len(lights.views) - first_coarse, ids)
        frame.shadow_maps, frame.coarse_maps = self.main.depth, self.coarse.depth
        drawn = first_coarse if self._coarse_are_kept(frame, ids) else len(lights.views)
        if not lights.views:
            return
        with frame.profiler.stage("RSM rendering" if ids else "shadow maps") as stage:
            for number in range(drawn):
                coarse = number >= first_coarse
                maps, layer = (self.coarse, number - first_coarse) if coarse else (self.main, number)
                self.visibility.draw(stage, frame, number + 1, *maps.targets(layer, ids))

    def _coarse_are_kept(self, frame: Frame, ids: bool) -> bool:
        """Whether the coarse layers hold what would be drawn: all that they show is as it was."""
        views = b"".join(view.view_projection.tobytes() for view in frame.lights.views[frame.lights.main_views :])
        maps = self.coarse
        before, self._coarse_of = self._coarse_of, (frame.gpu_scene.moves, maps.depth, maps.ids, ids, views)
        return before == self._coarse_of
