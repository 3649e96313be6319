"""Composite: all light of a pixel added up, in nits, and the picture for display."""

from __future__ import annotations

from typing import Any

from ..gpu.bindings import storage_texture, texture, uniform
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from .environment import SurroundingsMap
from .frame import Frame
from .shader_values import CONSTANTS
from .structs import COMPOSITE, ENVIRONMENT, VIEW, views_binding

# The shader's name of each tone map of simulator/tonemap.py.
_FUNCTIONS = {"none": "clipped", "neutral": "neutral_tone_map", "agx": "agx", "aces": "aces"}
_INPUTS = ("emissive_map", "irradiance_map", "specular_map", "given_map", "fog_map")


class CompositePass:
    """transparent: without the surroundings. Variants by which inputs there are and which sample of the pixel it is;
    each is built when first needed."""

    def __init__(self, device: Device, tone_map: str, transparent: bool):
        self.device, self.tone_map, self.transparent = device, tone_map, transparent
        self._variants: dict[tuple[frozenset[str], bool, bool, bool], ComputePass] = {}
        self._settings = device.uniform("composite settings", COMPOSITE.array(1))

    def _variant(self, there: frozenset[str], first: bool, last: bool, even: bool) -> ComputePass:
        key = (there, first, last, even)
        if key not in self._variants:
            flags: dict[str, Any] = {name.removesuffix("_map"): name in there for name in _INPUTS}
            self._variants[key] = ComputePass(
                self.device, "composite", "frame/composite.wgsl",
                [
                    uniform("settings", COMPOSITE), views_binding(), texture("surface_map", "uint"),
                    texture("depth_map"), texture("direct_map"), *(texture(name) for name in _INPUTS if name in there),
                    *((texture("transmittance_map"),) if "fog_map" in there else ()),
                    *(() if first else (texture("radiance_so_far"),)), storage_texture("radiance_out", "rgba32float"),
                    *((storage_texture("display_out", "rgba8unorm"),) if last else ()), *SurroundingsMap.bindings(),
                ],
                structs=[COMPOSITE, VIEW, ENVIRONMENT],
                workgroup=(32, 2, 1),  # it only loads and stores: rows suit it better than squares
                first=first, last=last, sky=0, tone_map=_FUNCTIONS[self.tone_map],
                transparent=self.transparent, even_surroundings=even, **flags, **CONSTANTS,
            )  # fmt: skip
        return self._variants[key]

    def run(self, frame: Frame, exposure: float, surroundings: SurroundingsMap) -> None:
        """Add this sample to `radiance`; after the last one also write `display`. `exposure` is the factor from nits to
        the picture's unit."""
        self.device.write(self._settings, COMPOSITE.pack(exposure=exposure, weight=1.0 / frame.samples))
        t, first, last = frame.targets, frame.sample == 0, frame.sample == frame.samples - 1
        emissive = t.emissive if frame.gpu_scene.has_emission else None
        given = (emissive, frame.irradiance, frame.specular, frame.radiance, frame.inscattered)
        optional = dict(zip(_INPUTS, given, strict=True))
        inputs: dict[str, Any] = {name: texture for name, texture in optional.items() if texture is not None}
        # Software adapters work out both sides of a branch: without a map nobody should pay for reading one.
        variant = self._variant(frozenset(inputs), first, last, frame.surroundings.image is None)
        if frame.inscattered:
            inputs["transmittance_map"] = frame.transmittance
        if not first:
            inputs["radiance_so_far"] = t.swap_radiance(self.device)
        if last:
            inputs["display_out"] = t.display
        with frame.profiler.stage("composite") as stage:
            variant.run(
                stage, frame.pixels, settings=self._settings, views=frame.buffers["views"], surface_map=t.surface,
                depth_map=t.depth, direct_map=t.direct, radiance_out=t.radiance, **inputs, **surroundings.resources,
            )  # fmt: skip
