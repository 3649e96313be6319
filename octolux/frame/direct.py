"""Direct light with shadows, towards the camera."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import sampler, storage_texture, texture
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .frame import Frame
from .shader_values import CONSTANTS
from .structs import LIGHT, VIEW, lights_binding, views_binding
from .views import CUBE_FACES

# Up to so many lights are unrolled; more would make the shader long to build.
_UNROLLED = 8


class DirectLightPass:
    """The glTF BRDF under every directional, spot and point light: radiance in nits. A pass is built for each number of
    lights of each kind, and kept."""

    def __init__(self, device: Device):
        self.device = device
        self._variants: dict[tuple[int, ...], ComputePass] = {}

    def _variant(self, counts: tuple[int, int, int]) -> ComputePass:
        if counts not in self._variants:
            self._variants[counts] = ComputePass(
                self.device, "direct light", "frame/direct.wgsl",
                [
                    views_binding(), lights_binding(), texture("surface_map", "uint"), texture("depth_map"),
                    texture("shadow_maps", "depth", "2d-array"), sampler("shadow_sampler", "non-filtering"),
                    storage_texture("direct_out", "rgba32float"),
                ],
                structs=[VIEW, LIGHT], shadows=True, groups=_groups(counts), unrolled=sum(counts) <= _UNROLLED,
                **CONSTANTS,
            )  # fmt: skip
        return self._variants[counts]

    def run(self, frame: Frame, shadow_sampler: Any) -> None:
        with frame.profiler.stage("direct light") as stage:
            self._variant(frame.lights.counts).run(
                stage, frame.pixels, surface_map=frame.targets.surface, depth_map=frame.targets.depth,
                shadow_maps=frame.shadow_maps, shadow_sampler=shadow_sampler, direct_out=frame.targets.direct,
                views=frame.buffers["views"], lights=frame.buffers["lights"],
            )  # fmt: skip


def _groups(counts: tuple[int, int, int]) -> list[tuple[str, int, int, int, int]]:
    """For each kind in the order of the lights: name, first light, number of lights, first view, views of each."""
    groups, light, view = [], 0, 1  # view 0 is the camera
    for kind, count, views_each in zip(("directional", "spot", "point"), counts, (1, 1, CUBE_FACES), strict=True):
        groups.append((kind, light, count, view, views_each))
        light, view = light + count, view + count * views_each
    return groups
