"""Gathering on the device: what pixels receive and reflect through cones (VCT 5.6; simulator/voxels/cones.py)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, sqrt
from typing import Any

from ....frame.environment import SurroundingsMap
from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.shader_values import CONSTANTS
from ....frame.structs import ENVIRONMENT, VIEW, views_binding
from ....gpu.bindings import Binding, storage_texture, texture, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.passes import ComputePass
from ....scene.errors import OctoluxError
from ....simulator.grid import Grid
from ....simulator.gtao import LEAST_WEIGHT
from ....simulator.reflection import CONE
from ....simulator.voxels import cones
from ....simulator.voxels.filtering import TURNED

# Where the cube of voxels lies: its lowest corner, and the edge of a voxel of level 0, metres.
VOXELS_OF = Struct("VoxelsOf", origin="vec3f", size="f32")
# absorbed: of light, for each voxel of level 0 of its way.  reach: of ambient visibility, voxels of level 0.
AIR = Struct("Air", absorbed="f32", reach="f32")
RESOLUTIONS = (1, 2, 4)
_DARKEST = 2.0**-10  # albedo of a specular lobe that is not seen: a quarter of a step of an 8-bit picture
_TILE, _TOGETHER = 4, 8  # of diffuse.wgsl


@dataclass(frozen=True)
class Voxels:
    """How shaders read voxels: (2^depth)^3 of level 0, 2^3 of the coarsest.

    file: WGSL from the package's folder with `sample_voxels` (cones.wgsl says what it is), and, where `skips`, with

        fn is_empty(position: vec3f, level: u32) -> bool

    whether `sample_voxels` finds nothing on this level and all finer ones anywhere in the cell of 2^3 voxels' edges
    around `position` whose corners are in the middles of voxels, the first in that of voxel (0, 0, 0).
    It may read `bindings`, of which two may be storage textures, whose structs are `structs`, and `values`.
    """

    depth: int
    file: str
    bindings: Sequence[Binding] = ()
    structs: Sequence[Struct] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    skips: bool = False


def cone_values(voxels: Voxels, offset: float, cover: str, absorbs: bool = False) -> dict[str, Any]:
    """What cones.wgsl wants to know. absorbs: the air does; AIR is then bound as `air`."""
    return {
        **CONSTANTS, "voxels": voxels.file, "depth": voxels.depth, "offset": float(offset), "cover": cover,
        "left": cones.LEFT, "clear": cones.CLEAR, "noted": False, "absorbs": absorbs, "limited": False, **voxels.values,
    }  # fmt: skip


def wide_cones(count: int, per_level: int, width: float) -> dict[str, Any]:
    """What wide_cone.wgsl wants to know besides."""
    return {
        "cones": count, "near": cones.near_samples(count, width),
        "first_level": cones.first_level_samples(count, per_level, width), "phases": cones.PHASES,
        "cone_turn": cones.CONE_TURN, "phase_turn": cones.PHASE_TURN,
    }  # fmt: skip


class Gathering:
    """What diffuse and specular cones share. resolution: pixels along each side of a block that shares a pixel's
    cones; offset: voxels from a surface to where they start; attenuation: 1/m, of light on its way through the cube;
    reach: m, of ambient visibility, 0 if it has no end. Raises OctoluxError for values out of range."""

    def __init__(
        self, device: Device, voxels: Voxels, resolution: int, offset: float, cover: str, attenuation: float = 0.0,
        reach: float = 0.0,
    ):  # fmt: skip
        if not (attenuation >= 0.0 and reach >= 0.0):
            raise OctoluxError(f"Attenuation and reach are 0 or more, not {attenuation} and {reach}.")
        if resolution not in RESOLUTIONS or cover not in cones.COVERS or not 0.0 <= offset <= 4.0:
            raise OctoluxError(
                f"Cones have a resolution of {RESOLUTIONS}, an offset of 0 to 4 voxels and a cover of {cones.COVERS}, "
                f"not {resolution}, {offset} and '{cover}'."
            )
        self.device, self._resolution = device, resolution
        self._of = device.uniform("voxel cones", VOXELS_OF.array(1))
        self._seen = [views_binding(), texture("surface_map", "uint"), texture("depth_map")]
        self._attenuation, self._reach = attenuation, reach
        self._air = device.uniform("voxel cones", AIR.array(1)) if attenuation or reach else None
        air = [uniform("air", AIR)] if self._air else []
        self._read = [*self._seen, uniform("voxels_of", VOXELS_OF), *air, *voxels.bindings]
        self._structs = [VIEW, VOXELS_OF, *([AIR] if air else []), *voxels.structs]
        self._filter_values: dict[str, Any] = {
            "resolution": resolution, "least_weight": LEAST_WEIGHT, "turned": TURNED, **CONSTANTS,
        }  # fmt: skip
        self._values: dict[str, Any] = {
            "resolution": resolution, **cone_values(voxels, offset, cover, attenuation > 0.0), "limited": reach > 0.0,
        }  # fmt: skip
        self._made_for: tuple[int, int] | None = None
        self._light: Any = None
        self._place: Any = None

    def _textures(self, pixels: tuple[int, int], raw: bool) -> None:
        if self._made_for == pixels:
            return
        self._made_for = pixels
        size = tuple(-(-side // self._resolution) for side in pixels)
        self._light = self._texture("voxel cones", size, "rgba32float")
        self._place = self._texture("voxel cones", size, "rgba32float") if raw else None
        self._make(pixels)

    def _make(self, pixels: tuple[int, int]) -> None:
        raise NotImplementedError

    def _texture(self, label: str, size: tuple[int, ...], format: str) -> Any:
        return self.device.texture(label, size, format, usage=STORAGE | TEXTURE | COPY)

    def _resources(self, frame: Frame, grid: Grid) -> dict[str, Any]:
        self.device.write(self._of, VOXELS_OF.pack(origin=grid.origin, size=grid.cell_size))
        if self._air is None:
            return {**_seen_by(frame), "voxels_of": self._of}
        size = grid.cell_size
        self.device.write(self._air, AIR.pack(absorbed=self._attenuation * size, reach=self._reach / size))
        return {**_seen_by(frame), "voxels_of": self._of, "air": self._air}


def _seen_by(frame: Frame) -> dict[str, Any]:
    targets = frame.targets
    return {"views": frame.buffers["views"], "surface_map": targets.surface, "depth_map": targets.depth}


class DiffuseCones(Gathering):
    """Irradiance and ambient visibility of every pixel.

    count: of cones, 4 to 16.  per_level: samples of a cone for each level, 1 to 4.  width: of the voxels that are read,
    over those that blur as much as a cone does, 0.25 to 2: smaller ones see finer, and need more samples a level.  sky:
    what is left of cones that meet nothing sees the surroundings. Otherwise as `Gathering`.

    irradiance: rgba32float, lux of a picture's pixel, alpha 1, as light past occluders is counted already.
    visibility: r32float, the share of each pixel's cones that meets nothing, or nothing within `reach`.
    """

    def __init__(
        self, device: Device, voxels: Voxels, *, count: int = 8, per_level: int = 2, width: float = 1.0,
        resolution: int = 1, offset: float = 1.0, cover: str = "surfaces", sky: bool = False, attenuation: float = 0.0,
        reach: float = 0.0,
    ):  # fmt: skip
        super().__init__(device, voxels, resolution, offset, cover, attenuation, reach)
        if not 4 <= count <= 16 or not 1 <= per_level <= 8 or not 0.25 <= width <= 2.0:
            raise OctoluxError(
                "There are 4 to 16 cones of 1 to 8 samples a level and a width of 0.25 to 2, "
                f"not {count} of {per_level} and {width}."
            )
        self._sky = sky
        # Half vectors of a GGX lobe of width alpha reflect it into 4 pi alpha^2, a cone has 2 pi (1 - cos).
        sky_alpha = sqrt(0.5 * (1.0 - cos(cones.half_angle(count))))
        out = [storage_texture("light_out", "rgba32float"), storage_texture("place_out", "rgba32float")]
        self._gather = ComputePass(
            device, "diffuse cones", "techniques/voxel_cones/cones/diffuse.wgsl",
            [*self._read, *(SurroundingsMap.bindings() if sky else []), *out],
            structs=[*self._structs, *([ENVIRONMENT] if sky else [])], sky=sky, sky_alpha=sky_alpha,
            **wide_cones(count, per_level, width), **self._values,
        )  # fmt: skip
        raw = [storage_texture(name, "rgba32float", access="read") for name in ("light_map", "place_map")]
        results = [storage_texture("irradiance_out", "rgba32float"), storage_texture("visibility_out", "r32float")]
        self._filter = ComputePass(
            device, "filter", "techniques/voxel_cones/cones/filter.wgsl", [*self._seen, *raw, *results], structs=[VIEW],
            **self._filter_values,
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
        around = _TILE * _TOGETHER
        width, height = self._light.size[:2]
        more = frame.surroundings_map.resources if self._sky else {}
        self._gather.run(
            stage, (around * -(-width // around), height), **self._resources(frame, grid), **voxels, **more,
            light_out=self._light, place_out=self._place,
        )  # fmt: skip

    def filter(self, stage: Any, frame: Frame) -> None:
        """Write `irradiance` and `visibility` from what was gathered."""
        self._filter.run(
            stage, frame.pixels, **_seen_by(frame), light_map=self._light, place_map=self._place,
            irradiance_out=self.irradiance, visibility_out=self.visibility,
        )  # fmt: skip


class SpecularCones(Gathering):
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
        self._textures(pixels, raw=self._resolution > 1)

    def _make(self, pixels: tuple[int, int]) -> None:
        self.specular = self._light if self._resolution == 1 else self._texture("voxel cones", pixels, "rgba32float")

    def run(self, stage: Any, frame: Frame, grid: Grid, **voxels: Any) -> None:
        """Write `specular`. grid: of the voxels; voxels: what the bindings of `Voxels` name."""
        around = frame.surroundings_map.resources
        table = {"brdf_table": around["brdf_table"]}
        out = {"light_out": self._light, **({"place_out": self._place} if self._resolution > 1 else {})}
        self._trace.run(
            stage, self._light.size[:2], **self._resources(frame, grid), **voxels, **(around if self._sky else table),
            **out,
        )  # fmt: skip
        if self._resolution > 1:
            self._reflect.run(
                stage, frame.pixels, **_seen_by(frame), **table, light_map=self._light, place_map=self._place,
                specular_out=self.specular,
            )  # fmt: skip
