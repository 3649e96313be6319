"""Composite: all light of a pixel added up, in nits, and the picture for display."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import storage_texture, texture, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .frame import Frame
from .shader_values import CONSTANTS
from .structs import COMPOSITE


class CompositePass:
    """Variants by which inputs there are; each is built when first needed."""

    def __init__(self, device: Device):
        self.device = device
        self._variants: dict[tuple[bool, bool, bool], ComputePass] = {}
        self._settings = device.uniform("composite settings", COMPOSITE.array(1))

    def _variant(self, emissive: bool, irradiance: bool, specular: bool) -> ComputePass:
        key = (emissive, irradiance, specular)
        if key not in self._variants:
            optional = [("emissive_map", emissive), ("irradiance_map", irradiance), ("specular_map", specular)]
            self._variants[key] = ComputePass(
                self.device, "composite", "frame/composite.wgsl",
                [
                    uniform("settings", COMPOSITE), texture("surface_map", "uint"), texture("depth_map"),
                    texture("direct_map"), *(texture(name) for name, there in optional if there),
                    storage_texture("radiance_out", "rgba32float"), storage_texture("display_out", "rgba8unorm"),
                ],
                structs=[COMPOSITE], workgroup=(32, 2, 1),  # it only loads and stores: rows suit it better than squares
                emissive=emissive, irradiance=irradiance, specular=specular, **CONSTANTS,
            )  # fmt: skip
        return self._variants[key]

    def run(self, frame: Frame, exposure: float) -> None:
        """Write `radiance` and `display`. `exposure` is the factor from nits to the picture's unit."""
        background = frame.scene.environment.radiance
        self.device.write(self._settings, COMPOSITE.pack(background=background, exposure=exposure))
        emissive = frame.targets.emissive if frame.gpu_scene.has_emission else None
        optional: dict[str, Any] = {
            "emissive_map": emissive, "irradiance_map": frame.irradiance, "specular_map": frame.specular,
        }  # fmt: skip
        there = {name: texture for name, texture in optional.items() if texture is not None}
        variant = self._variant(*(name in there for name in optional))
        t = frame.targets
        with frame.profiler.stage("composite") as stage:
            variant.run(
                stage, frame.pixels, settings=self._settings, surface_map=t.surface, depth_map=t.depth,
                direct_map=t.direct, radiance_out=t.radiance, display_out=t.display, **there,
            )  # fmt: skip
