"""What the geometry volume's surfaces reflect, on the device (simulator/lpv/reflectors.py)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from ...frame.frame import Frame
from ...frame.peeling import LampLayer
from ...frame.scene_surfels import SceneSurfels
from ...frame.structs import VIEW, VPL, views_binding
from ...frame.traits import PIXEL_STRUCTS, TRAIT_VALUES, pixel_bindings, pixel_resources
from ...gpu.bindings import atomic_words, storage, storage_rw, texture, uniform
from ...gpu.device import Device, DeviceError
from ...gpu.limits import DEFAULT_LIMITS
from ...gpu.passes import ComputePass
from ...gpu.records import records, words
from ...gpu_scene.structs import INSTANCE
from ...simulator.environment import LUMINANCE
from ...simulator.lpv.reflectors import MOST_WALLS
from ...simulator.rsm import MIN_COSINE
from .constants import GRID, grids_binding
from .geometry import SURFELS
from .injection import RUN, walks
from .keeping import KeptCells
from .levels import Levels
from .surfels import SurfelBuffer, surfel_buffers

_ONE = 1 << 16  # fixed point of shares, as the geometry volume's
# Of albedo times area. A walk of RUN surfels of MOST_WALLS each stays below 2^32.
_TINT_ONE = 1 << 20
_AT_ONCE = 4  # buffers that have sums of their own, if they fit in one binding


class Reflectors:
    """`reflectors`: vec4f x 3 a cell [level][z][y][x]: the shares of its cross section that face +x, -x, +y, -y | +z,
    -z, 0, 0 | the mean albedo, linear, and its luminance; 0 where no surface lies.

    `places`, if asked for: vec4f a cell, where in it these surfaces lie on average, in cells from its middle.

    levels: as the geometry volume's. All windows are filled; the octree's levels above are the caller's.
    offset: cells by which a surfel counts before its surface, along the normal: 0.5 is where inject.wgsl puts VPLs,
    -BEHIND (simulator/lpv/geometry.py) where the geometry volume has shares.
    squares: shares are areas times the squares of the normal's components, which add up to the area: what a cube of
    irradiance is read by. Otherwise the cross sections' own, which light along an axis meets.
    camera: the G-buffer's surfaces count besides those that lights see.
    A technique that has one needs "rsm" and "surfaces". Raises DeviceError for more cells than fit in a binding.
    """

    def __init__(
        self, device: Device, levels: Levels, offset: float, camera: bool = True, *, squares: bool = False,
        places: bool = False,
    ):  # fmt: skip
        self.device, self.levels, self._camera, self._offset = device, levels, camera, offset
        self._windows = levels.windows
        self._cells = cells = levels.windows * levels.sizes[0] ** 3
        room = DEFAULT_LIMITS["max-storage-buffer-binding-size"]
        if levels.cells * 48 > room:
            raise DeviceError(f"Reflectors of {levels.cells} cells do not fit in a binding. Use a smaller n.")
        self._at_once = min(_AT_ONCE, room // (cells * 24))
        self.reflectors = device.buffer("LPV reflectors", size=levels.cells * 48)
        self._sums = device.buffer("LPV reflector sums", size=self._at_once * cells * 24)
        self._tints = device.buffer("LPV reflector sums", size=cells * (56 if places else 32))
        self.places = device.buffer("LPV reflector places", size=cells * 16) if places else None
        self._surfels: list[Any] = []
        self._values: dict[str, Any] = {
            "run": RUN, "grids": levels.windows, "offset": offset, "min_cosine": MIN_COSINE,
            "one": _ONE, "tint_one": _TINT_ONE, "most_walls": MOST_WALLS, "squares": squares, "places": places,
            **TRAIT_VALUES,
        }  # fmt: skip
        self._passes: dict[tuple[bool, bool], ComputePass] = {}
        self._merges: dict[tuple[int, bool, bool], ComputePass] = {}
        self._joins: dict[str, ComputePass] = {}

    def _surfel_pass(self, camera: bool, static_only: bool) -> ComputePass:
        """Surfels of the G-buffer or an RSM. static_only: of what does not move."""
        if (camera, static_only) not in self._passes:
            bindings = [uniform("surfels", SURFELS), grids_binding(self.levels.windows), atomic_words("sums", "u32"),
                        atomic_words("tints", "u32")]  # fmt: skip
            if camera:
                bindings += [views_binding(), texture("depth_map"), *pixel_bindings()]
            else:
                bindings += [records("vpls", VPL), words("surfaces")]
            self._passes[camera, static_only] = ComputePass(
                self.device, f"reflectors of {'the G-buffer' if camera else 'an RSM'}",
                f"techniques/lpv/reflectors_{'gbuffer' if camera else 'rsm'}.wgsl", bindings,
                structs=[SURFELS, GRID, *([VIEW, *PIXEL_STRUCTS] if camera else [INSTANCE, VPL])],
                workgroup=(64, 1, 1), static_only=static_only, **self._values,
            )  # fmt: skip
        return self._passes[camera, static_only]

    def _joining(self, target: str) -> ComputePass:
        """Of `newer` and `older` into that of them which `target` is."""
        if target not in self._joins:
            kinds = [("", "vec4f"), *([("_places", "vec4f")] if self.places is not None else [])]
            self._joins[target] = ComputePass(
                self.device, "keep reflectors", "techniques/lpv/reflectors_keep.wgsl",
                [(storage_rw if name == target else storage)(name + end, kind)
                 for name in ("newer", "older") for end, kind in kinds],
                workgroup=(64, 1, 1), cells=self._cells, places=self.places is not None, target=target,
            )  # fmt: skip
        return self._joins[target]

    def _merging(self, buffers: int, first: bool, last: bool) -> ComputePass:
        """The pass that merges the sums of so many buffers, the first or last of a frame among them. A software adapter
        has to be told beforehand what it need not read."""
        key = (buffers, first, last)
        if key not in self._merges:
            tints = [storage("tints", "vec2u")] if last else []
            places = [storage_rw("places", "vec4f")] if last and self.places is not None else []
            self._merges[key] = ComputePass(
                self.device, "merge reflectors", "techniques/lpv/reflectors_merge.wgsl",
                [storage("sums", "vec2u"), storage_rw("reflectors", "vec4f"), *tints, *places], workgroup=(64, 1, 1),
                buffers=buffers, first=first, last=last, places=bool(places), cells=self._cells, one=_ONE,
                luminance=", ".join(map(str, LUMINANCE)),
            )  # fmt: skip
        return self._merges[key]

    def run(
        self, stage: Any, frame: Frame, grids: Any, scene: SceneSurfels | None = None, kept: KeptCells | None = None
    ) -> None:
        """From the RSM of each lamp and the G-buffer, or from the whole `scene`. Shares are merged by maximum, as each
        may have seen the same surface (CLPV 3.2); the albedo is the mean of all. grids: uniform buffer of GRID, one for
        each window.  kept: of `keeping`, which has followed the windows: what static surfaces have filled in earlier
        frames. It takes what they fill in this one."""
        buffers = list(surfel_buffers(frame, self._camera, scene))
        if kept is None:
            self._fill(stage, frame, grids, buffers)
            return
        moving = bool(frame.gpu_scene.is_moving.any())
        self._fill(stage, frame, grids, buffers, static_only=moving)
        self._join(stage, kept, "older")
        if moving:
            self._fill(stage, frame, grids, buffers)
            self._join(stage, kept, "newer")
        else:
            kept.copy_to(stage, self._contents)

    def keeping(self) -> KeptCells:
        """For `run`."""
        contents = {"reflectors": 3, "places": 1}
        return KeptCells(self.device, self.levels, {name: contents[name] for name in self._contents}, self._offset)

    @property
    def _contents(self) -> dict[str, Any]:
        return {"reflectors": self.reflectors, **({"places": self.places} if self.places is not None else {})}

    def _join(self, stage: Any, kept: KeptCells, target: str) -> None:
        given = {"newer": self.reflectors, "older": kept.volume["reflectors"]}
        if self.places is not None:
            given |= {"newer_places": self.places, "older_places": kept.volume["places"]}
        self._joining(target).run(stage, (self._cells,), **given)

    def _fill(
        self, stage: Any, frame: Frame, grids: Any, buffers: Sequence[SurfelBuffer], static_only: bool = False
    ) -> None:
        stage.encoder.clear_buffer(self._tints)
        if not buffers:
            stage.encoder.clear_buffer(self.reflectors, 0, self._cells * 48)
        for start in range(0, len(buffers), self._at_once):
            group = buffers[start : start + self._at_once]
            stage.encoder.clear_buffer(self._sums, 0, len(group) * self._cells * 24)
            for number, buffer in enumerate(group, start):
                self._scatter(stage, frame, grids, number, buffer, static_only)
            last = start + len(group) == len(buffers)
            tints = {"tints": self._tints} if last else {}
            if last and self.places is not None:
                tints["places"] = self.places
            merge = self._merging(len(group), start == 0, last)
            merge.run(stage, (self._cells,), sums=self._sums, reflectors=self.reflectors, **tints)

    def _scatter(
        self, stage: Any, frame: Frame, grids: Any, number: int, buffer: SurfelBuffer, static_only: bool
    ) -> None:
        surfels, threads = self._surfels_buffer(number, buffer), (walks(buffer.count, buffer.width), self._windows)
        common = {"surfels": surfels, "grids": grids, "sums": self._sums, "tints": self._tints}
        for layer in buffer.layers:
            if isinstance(layer, LampLayer):
                own = {"vpls": layer.vpls, "surfaces": layer.surfaces}
            else:
                own = {"views": frame.buffers["views"], "depth_map": layer.depth, **pixel_resources(frame, layer)}
            made = self._surfel_pass(not isinstance(layer, LampLayer), static_only)
            made.run(stage, threads, **common, **own)

    def _surfels_buffer(self, number: int, buffer: SurfelBuffer) -> Any:
        """A uniform buffer for each buffer of a frame: all are written before the first pass runs."""
        if number == len(self._surfels):
            self._surfels.append(self.device.uniform("LPV surfels", SURFELS.array(1)))
        sums = number % self._at_once * self._cells
        self.device.write(self._surfels[number], SURFELS.pack(sums=sums, one=_ONE, **buffer.where))
        return self._surfels[number]
