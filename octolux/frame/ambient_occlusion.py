"""Ambient occlusion in screen space: how much of the light from around reaches what the camera sees, past what the
depth buffer shows nearby (GTAO; simulator/gtao.py)."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, pi
from typing import Any

from ..gpu.bindings import Binding, storage_texture, uniform
from ..gpu.device import Device
from ..gpu.layout import Struct
from ..gpu.passes import ComputePass
from ..scene.errors import OctoluxError
from ..simulator.blending import RATIO
from ..simulator.gtao import BEYOND, FALLOFF, GOLDEN, LEAST_WEIGHT
from .frame import COPY, STORAGE, TEXTURE, Frame
from .structs import VIEW, views_binding

AO_EXTENT = Struct("AoExtent", radius="f32")
MOST_SLICES, MOST_STEPS = 8, 16


class AmbientOcclusion:
    """Ambient visibility in [0, 1] of every pixel, cosine-weighted, past what stands within a radius.

    slices: planes through the sight line of each pixel; steps: samples of the depth buffer on either side of each; the
    cost grows with their product, and so does the shader, in which they are unrolled.  resolution: 1 for every pixel, 2
    for every second one in rows and columns (a quarter of the samples) with the pixels between filled in.  falloff:
    share of the radius over which a blocker's weight falls to 0, which it has at the radius.  filtered: turn the slices
    differently in the pixels of 4 x 4 tiles and take the mean of a window as large; else all pixels are alike and
    resolution is 1.
    radius_file: WGSL from the package's folder with `fn ao_radii(position: vec3f, normal: vec3f) -> Radii` (gtao.wgsl):
    metres at a point of a surface in world space, with its geometric normal. It may read `bindings` (of which one may
    be a storage texture), whose structs are `structs`, and `values`. Without it the radius is one length, which `run`
    is given.
    Raises OctoluxError for numbers out of range.
    """

    def __init__(
        self, device: Device, slices: int = 3, steps: int = 6, resolution: int = 1, *, falloff: float = FALLOFF,
        filtered: bool = True, radius_file: str = "", bindings: Sequence[Binding] = (), structs: Sequence[Struct] = (),
        **values: Any,
    ):  # fmt: skip
        _check(slices, steps, resolution, falloff, filtered)
        self.device, self.resolution, self.filtered = device, resolution, filtered
        self._extent = None if radius_file else device.uniform("AO radius", AO_EXTENT.array(1))
        own = [] if radius_file else [uniform("ao_extent", AO_EXTENT)]
        surfaces = [views_binding(), _read("surface_map", "rgba32uint"), _read("depth_map", "r32float")]
        self._horizons = ComputePass(
            device, "ambient occlusion", "frame/gtao.wgsl",
            [*surfaces, *own, *bindings, storage_texture("visibility_out", "rg32float" if filtered else "r32float")],
            structs=[VIEW, *structs, *([] if radius_file else [AO_EXTENT])], pi=pi, golden=GOLDEN, beyond=BEYOND,
            slices=slices, steps=steps, falloff=float(falloff), resolution=resolution, filtered=filtered,
            blend_ratio=RATIO, radius_file=radius_file or "frame/gtao_radius.wgsl", **values,
        )  # fmt: skip
        self._filter: ComputePass | None = None
        if filtered:
            self._filter = ComputePass(
                device, "ambient occlusion filter", "frame/gtao_filter.wgsl",
                [*surfaces, _read("raw_map", "rg32float"), storage_texture("visibility_out", "r32float")],
                structs=[VIEW], resolution=resolution, least_weight=LEAST_WEIGHT,
            )  # fmt: skip
        self.raw: Any = None
        self.visibility: Any = None

    def prepare(self, pixels: tuple[int, int]) -> None:
        """Allocate for pictures of this size: `visibility` is an r32float texture; `raw`, rg32float, holds visibility
        and depth before the filter, where there is one."""
        if self.visibility is not None and self.visibility.size[:2] == pixels:
            return
        usage = STORAGE | TEXTURE | COPY
        self.visibility = self.device.texture("ambient visibility", pixels, "r32float", usage=usage)
        if self.filtered:
            raw = tuple(-(-n // self.resolution) for n in pixels)
            self.raw = self.device.texture("ambient visibility", raw, "rg32float", usage=usage)

    def run(self, stage: Any, frame: Frame, radius: float | None = None, **resources: Any) -> Any:
        """Write `visibility`, and return it. radius: metres, where no `radius_file` says it.  resources: what the
        radius file's bindings name. Raises OctoluxError when there is no radius, or it is not positive."""
        self.prepare(frame.pixels)
        if self._extent is not None:
            if radius is None or not 0.0 < radius < inf:
                raise OctoluxError(f"The radius of ambient occlusion is a positive length in metres, not {radius}.")
            self.device.write(self._extent, AO_EXTENT.pack(radius=radius))
            resources["ao_extent"] = self._extent
        t = frame.targets
        seen = {"views": frame.buffers["views"], "surface_map": t.surface, "depth_map": t.depth}
        out = self.raw if self._filter else self.visibility
        self._horizons.run(stage, out.size[:2], **seen, **resources, visibility_out=out)
        if self._filter:
            self._filter.run(stage, frame.pixels, **seen, raw_map=out, visibility_out=self.visibility)
        return self.visibility


def _read(name: str, format: str) -> Binding:
    """Scattered reads: a software adapter makes these the fastest (gpu/bindings.py)."""
    return storage_texture(name, format, access="read")


def _check(slices: int, steps: int, resolution: int, falloff: float, filtered: bool) -> None:
    if not 1 <= slices <= MOST_SLICES or not 1 <= steps <= MOST_STEPS:
        raise OctoluxError(
            f"Ambient occlusion takes 1 to {MOST_SLICES} slices of 1 to {MOST_STEPS} steps, not {slices} of {steps}."
        )
    if resolution not in (1, 2) or (resolution == 2 and not filtered):
        raise OctoluxError(f"Ambient occlusion has resolution 1, or 2 where it is filtered, not {resolution}.")
    if not 0.0 <= falloff <= 1.0:
        raise OctoluxError(f"The falloff of ambient occlusion is a share of its radius, 0 to 1, not {falloff}.")
