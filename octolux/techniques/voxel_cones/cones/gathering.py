"""What passes that trace cones through voxels share (VCT 5.6; simulator/voxels/cones.py)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.shader_values import CONSTANTS
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import Binding, texture, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....scene.errors import OctoluxError
from ....simulator.grid import Grid
from ....simulator.gtao import LEAST_WEIGHT
from ....simulator.voxels import cones
from ....simulator.voxels.filtering import TURNED

# Where the cube of voxels lies: its lowest corner, and the edge of a voxel of level 0, metres.  sample: number of that
# of each pixel.
VOXELS_OF = Struct("VoxelsOf", origin="vec3f", size="f32", sample="u32")
# absorbed: of light, for each voxel of level 0 of its way.  reach: of ambient visibility, voxels of level 0.
AIR = Struct("Air", absorbed="f32", reach="f32")
RESOLUTIONS = (1, 2, 4)


def voxels_of(grid: Grid, sample: int = 0) -> np.ndarray:
    """A VOXELS_OF."""
    return VOXELS_OF.pack(origin=grid.origin, size=grid.cell_size, sample=sample)


@dataclass(frozen=True)
class Voxels:
    """How shaders read voxels: (2^depth)^3 of level 0, 2^3 of the coarsest.

    file: WGSL from the package's folder with `sample_voxels` and `facing_voxels` (cones.wgsl says what they are), and,
    where `skips`, with

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


class Gathering:
    """Cones of what is seen. resolution: pixels along each side of a block that shares a pixel's cones; offset: voxels
    from a surface to where they start; attenuation: 1/m, of light on its way through the cube; reach: m, of ambient
    visibility, 0 if it has no end. Raises OctoluxError for values out of range."""

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
        self.device, self.resolution = device, resolution
        self._of = device.uniform("voxel cones", VOXELS_OF.array(1))
        self._seen = [views_binding(), texture("surface_map", "uint"), texture("depth_map")]
        self._attenuation, self._reach = attenuation, reach
        self._air = device.uniform("voxel cones", AIR.array(1)) if attenuation or reach else None
        air = [uniform("air", AIR)] if self._air else []
        self._read = [*self._seen, uniform("voxels_of", VOXELS_OF), *air, *voxels.bindings]
        self._structs = [VIEW, VOXELS_OF, *([AIR] if air else []), *voxels.structs]
        self._values: dict[str, Any] = {
            "resolution": resolution, **cone_values(voxels, offset, cover, attenuation > 0.0), "limited": reach > 0.0,
        }  # fmt: skip

    def _resources(self, frame: Frame, grid: Grid) -> dict[str, Any]:
        self.device.write(self._of, voxels_of(grid, frame.sample))
        if self._air is None:
            return {**seen_by(frame), "voxels_of": self._of}
        size = grid.cell_size
        self.device.write(self._air, AIR.pack(absorbed=self._attenuation * size, reach=self._reach / size))
        return {**seen_by(frame), "voxels_of": self._of, "air": self._air}


class PictureCones(Gathering, ABC):
    """Cones of all that is seen, whose light is kept in pictures. Arguments are those of `Gathering`."""

    def __init__(self, device: Device, voxels: Voxels, resolution: int, *more: Any):
        super().__init__(device, voxels, resolution, *more)
        self._filter_values: dict[str, Any] = {
            "resolution": resolution, "least_weight": LEAST_WEIGHT, "turned": TURNED, **CONSTANTS,
        }  # fmt: skip
        self._made_for: tuple[int, int] | None = None
        self._light: Any = None
        self._place: Any = None

    def _textures(self, pixels: tuple[int, int], raw: bool) -> None:
        if self._made_for == pixels:
            return
        self._made_for = pixels
        size = tuple(-(-side // self.resolution) for side in pixels)
        self._light = self._texture("voxel cones", size, "rgba32float")
        self._place = self._texture("voxel cones", size, "rgba32float") if raw else None
        self._make(pixels)

    @abstractmethod
    def _make(self, pixels: tuple[int, int]) -> None:
        """The results for pictures of this size."""

    def _texture(self, label: str, size: tuple[int, ...], format: str) -> Any:
        return self.device.texture(label, size, format, usage=STORAGE | TEXTURE | COPY)


def seen_by(frame: Frame) -> dict[str, Any]:
    """What to bind to what is seen."""
    targets = frame.targets
    return {"views": frame.buffers["views"], "surface_map": targets.surface, "depth_map": targets.depth}
