"""Shadow maps of all lights in two depth arrays: one layer for a directional or spot light and six for a point light in
one, and those of emitters and the sky, which are many and coarse, in the other."""

from __future__ import annotations

from typing import Any

from ..gpu.device import Device
from .frame import RENDER, TEXTURE, Frame
from .visibility import VisibilityPass


class ShadowMaps:
    """An array of shadow maps, and of the triangle numbers that RSMs are made from.

    shown: what each layer was last drawn for, None where nothing is known of what it holds.
    """

    def __init__(self, device: Device, label: str):
        self.device, self.label = device, label
        self.depth: Any = None
        self.ids: Any = None
        self.shown: list[tuple | None] = []

    def need(self, resolution: int, layers: int, ids: bool) -> None:
        before = self.depth
        self.depth = self._array(self.depth, "shadow maps", "depth32float", layers, resolution)
        if self.depth is not before:
            self.shown = [None] * layers
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

    A face is drawn again only when what is drawn, or its view of it, is other than in the frame that drew it. What a
    camera sees has no part in that. `drawings` grows with every frame that draws any.
    """

    def __init__(self, device: Device, visibility: VisibilityPass):
        self.visibility = visibility
        self.main, self.coarse = ShadowMaps(device, ""), ShadowMaps(device, "coarse ")
        self.drawings = 0
        self.sampler = device.wgpu.create_sampler()  # nearest: the four depths are compared one by one

    def run(self, frame: Frame, ids: bool) -> None:
        """Fill the layers and set `frame.shadow_maps` and `frame.coarse_maps`."""
        settings, lights = frame.settings, frame.lights
        main, coarse = lights.main_views, len(lights.views) - lights.main_views
        self.main.need(settings.shadow_resolution, main, ids)
        self.coarse.need(settings.coarse_resolution, coarse, ids)
        frame.shadow_maps, frame.coarse_maps = self.main.depth, self.coarse.depth
        places = [*((self.main, n) for n in range(main)), *((self.coarse, n) for n in range(coarse))]
        shows = [(frame.gpu_scene.moves, ids, view.view_projection.tobytes()) for view in lights.views]
        stale = [n for n, (maps, layer) in enumerate(places) if maps.shown[layer] != shows[n]]
        if not stale:
            return
        self.drawings += 1
        with frame.profiler.stage("RSM rendering" if ids else "shadow maps") as stage:
            for n in stale:
                maps, layer = places[n]
                self.visibility.draw(stage, frame, n + 1, *maps.targets(layer, ids))
                maps.shown[layer] = shows[n]

    def forget(self) -> None:
        """Let the next frame draw all faces, though nothing be other than before."""
        for maps in (self.main, self.coarse):
            maps.shown = [None] * len(maps.shown)
