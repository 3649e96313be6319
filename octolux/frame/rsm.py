"""Reflective shadow maps (Dachsbacher and Stamminger 2005): the lit surfaces as VPLs."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import storage_rw, texture
from ..gpu.device import Device, DeviceError
from ..gpu.limits import DEFAULT_LIMITS
from ..gpu.passes import ComputePass
from ..gpu_scene.gpu_scene import GpuScene
from .frame import Frame, FrameSettings
from .shader_values import CONSTANTS, surface_values
from .shadows import ShadowMapPass
from .structs import LIGHT, VIEW, VPL, lights_binding, views_binding


class RSMPass:
    """Takes one texel of each block of the shadow maps and makes it a VPL that reflects what the whole block receives:
    flux = albedo * intensity * solid angle of the block (OLPV 3.3), or albedo * illuminance * its area across a
    directional light."""

    def __init__(self, device: Device, scene: GpuScene, settings: FrameSettings):
        self.device, self.settings = device, settings
        self._buffer: Any = None
        stride = settings.shadow_resolution // settings.rsm_resolution
        self._pass = ComputePass(
            device, "RSM", "frame/rsm.wgsl",
            [
                views_binding(), lights_binding(),
                texture("shadow_ids", "uint", "2d-array"), storage_rw("vpls", VPL, "write"),
            ],
            structs=[VIEW, LIGHT, VPL], shared=scene.bindings, shadows=False,
            resolution=settings.rsm_resolution, stride=stride, **CONSTANTS, **surface_values(scene),
        )  # fmt: skip

    def run(self, frame: Frame, shadow_maps: ShadowMapPass) -> None:
        """Fill `frame.vpls`: [layer][row][column], of size layers * rsm_resolution^2."""
        layers, resolution = len(frame.lights.views), self.settings.rsm_resolution
        size = max(1, layers) * resolution**2 * VPL.size
        limit = DEFAULT_LIMITS["max-storage-buffer-binding-size"]
        if size > limit:
            raise DeviceError(
                f"{layers} views of lights with {resolution} x {resolution} VPLs each are more than the "
                f"{limit // (resolution**2 * VPL.size)} that fit. Use fewer lights (a point light has six views) or a "
                "lower --rsm-resolution."
            )
        if self._buffer is None or self._buffer.size != size:
            self._buffer = self.device.buffer("VPLs", size=size)
        frame.vpls = self._buffer
        if not layers:
            return
        with frame.profiler.stage("RSM surfaces") as stage:
            self._pass.run(
                stage, (resolution, resolution, layers), frame.gpu_scene.resources, views=frame.buffers["views"],
                lights=frame.buffers["lights"], shadow_ids=shadow_maps.ids, vpls=frame.vpls,
            )  # fmt: skip
