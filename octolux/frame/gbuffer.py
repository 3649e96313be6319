"""G-buffer: what the camera sees, packed into 128 bits a pixel (shaders/gbuffer.wgsl), and depth."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import storage_texture, texture
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from ..gpu_scene.gpu_scene import GpuScene
from .frame import CameraSees, Frame
from .shader_values import CONSTANTS, surface_values
from .structs import VIEW, views_binding
from .visibility import VisibilityPass


class GBufferPass:
    """Rasterises the camera's view and leads each pixel's triangle back to its surface.

    emission: also what the surface emits, if anything in the scene does."""

    def __init__(self, device: Device, scene: GpuScene, visibility: VisibilityPass, emission: bool = True):
        self.visibility = visibility
        self._values = {**surface_values(scene), "emissive": emission and scene.has_emission}
        outputs = [storage_texture("surface_out", "rgba32uint"), storage_texture("depth_out", "r32float")]
        if self._values["emissive"]:
            outputs.append(storage_texture("emissive_out", "rgba32float"))
        self._resolve = ComputePass(
            device, "G-buffer", "frame/gbuffer.wgsl",
            [views_binding(), texture("visibility", "uint"), *outputs],
            structs=[VIEW], shared=scene.bindings, **CONSTANTS, **self._values,
        )  # fmt: skip

    def run(self, frame: Frame) -> None:
        t = frame.targets
        with frame.profiler.stage("visibility") as stage:
            self.visibility.draw(stage, frame, 0, t.raster_depth.create_view(), t.ids.create_view())
        emitted = {}
        if self._values["emissive"]:
            t.need_emissive(frame.device)
            emitted["emissive_out"] = t.emissive
        with frame.profiler.stage("G-buffer") as stage:
            self.resolve(stage, frame, t, **emitted)

    def resolve(self, stage: Any, frame: Frame, to: CameraSees, **emitted: Any) -> None:
        """Write `surface` and `depth` of what its `ids` say."""
        self._resolve.run(
            stage, frame.pixels, frame.gpu_scene.resources, views=frame.buffers["views"], visibility=to.ids,
            surface_out=to.surface, depth_out=to.depth, **emitted,
        )  # fmt: skip
