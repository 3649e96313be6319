"""Direct light with shadows, towards the camera."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import sampler, storage_texture, texture, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .frame import Frame
from .shader_values import CONSTANTS
from .structs import LIGHT, LIGHT_COUNTS, VIEW, lights_binding, views_binding


class DirectLightPass:
    """The glTF BRDF under every directional, spot and point light: radiance in nits."""

    def __init__(self, device: Device):
        self._pass = ComputePass(
            device, "direct light", "frame/direct.wgsl",
            [
                views_binding(), lights_binding(), uniform("counts", LIGHT_COUNTS),
                texture("surface_map", "uint"), texture("depth_map"), texture("shadow_maps", "depth", "2d-array"),
                sampler("shadow_sampler", "non-filtering"), storage_texture("direct_out", "rgba32float"),
            ],
            structs=[VIEW, LIGHT, LIGHT_COUNTS], shadows=True, **CONSTANTS,
        )  # fmt: skip

    def run(self, frame: Frame, shadow_sampler: Any) -> None:
        names = ("views", "lights", "counts")
        with frame.profiler.stage("direct light") as stage:
            self._pass.run(
                stage, frame.pixels, surface_map=frame.targets.surface, depth_map=frame.targets.depth,
                shadow_maps=frame.shadow_maps, shadow_sampler=shadow_sampler, direct_out=frame.targets.direct,
                **{name: frame.buffers[name] for name in names},
            )  # fmt: skip
