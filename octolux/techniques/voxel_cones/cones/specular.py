"""What pixels reflect of the voxels, through a cone as wide as the lobe (VCT 5.6)."""

from __future__ import annotations

from typing import Any

from ....frame.environment import SurroundingsMap
from ....frame.frame import Frame
from ....frame.structs import ENVIRONMENT, VIEW
from ....gpu.bindings import storage_texture, texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....scene.errors import OctoluxError
from ....simulator.grid import Grid
from ....simulator.reflection import CONE
from .gathering import PictureCones, Voxels, seen_by

_DARKEST = 2.0**-10  # albedo of a specular lobe that is not seen: a quarter of a step of an 8-bit picture


class SpecularCones(PictureCones):
    """Radiance that every pixel reflects through a cone as wide as its lobe, weighted by its BRDF: rgba32float
    `specular`, nits. step: between samples, in voxels as large as the cone. sky: what is left of cones that meet
    nothing sees the surroundings. Otherwise as `Gathering`."""

    def __init__(
        self, device: Device, voxels: Voxels, *, step: float = 1.0, resolution: int = 1, offset: float = 1.0,
        cover: str = "surfaces", sky: bool = False, attenuation: float = 0.0,
    ):  # fmt: skip
        super().__init__(device, voxels, resolution, offset, cover, attenuation)
        if not 0.125 <= step <= 2.0:
            raise OctoluxError(f"Samples of a specular cone are 0.125 to 2 voxels apart, not {step}.")
        self._sky, table = sky, texture("brdf_table")
        places = ["light_out", "place_out"] if resolution > 1 else ["light_out"]
        self._trace = ComputePass(
            device, "specular cones", "techniques/voxel_cones/cones/specular.wgsl",
            [*self._read, *(SurroundingsMap.bindings() if sky else [table]),
             *(storage_texture(name, "rgba32float") for name in places)],
            structs=[*self._structs, *([ENVIRONMENT] if sky else [])], step=float(step), lobe=CONE, skip=voxels.skips,
            darkest=_DARKEST, sky=sky, **self._values,
        )  # fmt: skip
        if resolution > 1:
            raw = [storage_texture(name, "rgba32float", access="read") for name in ("light_map", "place_map")]
            self._reflect = ComputePass(
                device, "reflections", "techniques/voxel_cones/cones/reflect_all.wgsl",
                [*self._seen, table, *raw, storage_texture("specular_out", "rgba32float")], structs=[VIEW],
                **self._filter_values,
            )  # fmt: skip
        self.specular: Any = None

    def prepare(self, pixels: tuple[int, int]) -> None:
        """Make room for pictures of this size."""
        self._textures(pixels, raw=self.resolution > 1)

    def _make(self, pixels: tuple[int, int]) -> None:
        self.specular = self._light if self.resolution == 1 else self._texture("voxel cones", pixels, "rgba32float")

    def run(self, stage: Any, frame: Frame, grid: Grid, **voxels: Any) -> None:
        """Write `specular`. grid: of the voxels; voxels: what the bindings of `Voxels` name."""
        around = frame.surroundings_map.resources
        table = {"brdf_table": around["brdf_table"]}
        out = {"light_out": self._light, **({"place_out": self._place} if self.resolution > 1 else {})}
        self._trace.run(
            stage, self._light.size[:2], **self._resources(frame, grid), **voxels, **(around if self._sky else table),
            **out,
        )  # fmt: skip
        if self.resolution > 1:
            self._reflect.run(
                stage, frame.pixels, **seen_by(frame), **table, light_map=self._light, place_map=self._place,
                specular_out=self.specular,
            )  # fmt: skip
