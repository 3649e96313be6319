"""Irradiance of what is seen, gathered by wide cones (VCT 5.6, 7.2)."""

from __future__ import annotations

from math import cos, sqrt
from typing import Any

from ....frame.environment import SurroundingsMap
from ....frame.frame import Frame
from ....frame.structs import ENVIRONMENT, VIEW
from ....gpu.bindings import storage_texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.grid import Grid
from ....simulator.voxels.directions import half_angle
from .gathering import PictureCones, Voxels, seen_by
from .wide import USUAL, WideCones

_TOGETHER = 8  # of diffuse.wgsl


class DiffuseCones(PictureCones):
    """Irradiance and ambient visibility of every pixel.

    sky: what is left of cones that meet nothing sees the surroundings. Otherwise as `Gathering`.

    irradiance: rgba32float, lux of a picture's pixel, alpha 1, as light past occluders is counted already.
    visibility: r32float, the share of each pixel's cones that meets nothing, or nothing within `reach`.
    """

    def __init__(
        self, device: Device, voxels: Voxels, wide: WideCones = USUAL, *, resolution: int = 1,
        offset: float = 1.0, cover: str = "surfaces", sky: bool = False, attenuation: float = 0.0, reach: float = 0.0,
    ):  # fmt: skip
        super().__init__(device, voxels, resolution, offset, cover, attenuation, reach)
        self._wide, self._sky = wide, sky
        # Half vectors of a GGX lobe of width alpha reflect it into 4 pi alpha^2, a cone has 2 pi (1 - cos).
        sky_alpha = sqrt(0.5 * (1.0 - cos(half_angle(wide.count))))
        out = [storage_texture("light_out", "rgba32float"), storage_texture("place_out", "rgba32float")]
        self._gather = ComputePass(
            device, "diffuse cones", "techniques/voxel_cones/cones/diffuse.wgsl",
            [*self._read, *wide.bindings, *(SurroundingsMap.bindings() if sky else []), *out],
            structs=[*self._structs, *wide.structs, *([ENVIRONMENT] if sky else [])], sky=sky, sky_alpha=sky_alpha,
            **self._values, **wide.values(),
        )  # fmt: skip
        raw = [storage_texture(name, "rgba32float", access="read") for name in ("light_map", "place_map")]
        results = [storage_texture("irradiance_out", "rgba32float"), storage_texture("visibility_out", "r32float")]
        self._filter = ComputePass(
            device, "filter", "techniques/voxel_cones/cones/filter.wgsl", [*self._seen, *raw, *results], structs=[VIEW],
            tile=wide.tile, **self._filter_values,
        )  # fmt: skip
        self.irradiance: Any = None
        self.visibility: Any = None

    def prepare(self, pixels: tuple[int, int]) -> None:
        """Make room for pictures of this size."""
        self._textures(pixels, raw=True)

    def _make(self, pixels: tuple[int, int]) -> None:
        self.irradiance = self._texture("voxel cones", pixels, "rgba32float")
        self.visibility = self._texture("voxel cones", pixels, "r32float")

    @property
    def raw(self) -> tuple[Any, Any]:
        """Two rgba32float textures of the pixels that cones were traced for, before the filter: irradiance and
        visibility; shading normal and depth."""
        return self._light, self._place

    def gather(self, stage: Any, frame: Frame, grid: Grid, **voxels: Any) -> None:
        """Trace the cones. grid: of the voxels; voxels: what the bindings of `Voxels` name."""
        around = self._wide.tile * _TOGETHER
        width, height = self._light.size[:2]
        more = frame.surroundings_map.resources if self._sky else {}
        self._gather.run(
            stage, (around * -(-width // around), height), **self._resources(frame, grid), **voxels, **more,
            **self._wide.resources(self.device, frame, grid), light_out=self._light, place_out=self._place,
        )  # fmt: skip

    def filter(self, stage: Any, frame: Frame) -> None:
        """Write `irradiance` and `visibility` from what was gathered."""
        self._filter.run(
            stage, frame.pixels, **seen_by(frame), light_map=self._light, place_map=self._place,
            irradiance_out=self.irradiance, visibility_out=self.visibility,
        )  # fmt: skip
