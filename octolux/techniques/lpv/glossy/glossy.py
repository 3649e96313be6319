"""Glossy reflections on the device (simulator/lpv/glossy.py): rays through the cells, from what the camera sees."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.shader_values import CONSTANTS
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import Binding, sampler, storage, storage_texture, texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.lpv import glossy
from ....simulator.lpv.cascades import transition
from ....simulator.lpv.cones import SHORT
from ....simulator.reflection import CONE
from ..constants import GRID, SH_CONSTANTS, STRIP_VALUES, grids_binding
from ..levels import Levels
from ..lookup import CHANNELS
from ..windows import WINDOW, one_window, windows_binding

PAPER_CELLS = 4
"""CLPV 7: "in practice 4 cells proved to be sufficient"."""

_COARSEST = 4  # cells along each side of the coarsest level that is read: filters have some cells between their ends
_DARKEST = 2.0**-10  # albedo of a specular lobe that is not seen: a quarter of a step of an 8-bit picture
_APART = 0.02  # of its depth, that a pixel's light may come from: some pixels of a wall that is seen at a slant
_LEAST_NEAR = 1e-3  # of four pixels the only one that is as far away counts, be it the farthest


class _Rays:
    """A ray for each pixel, or for a block of `resolution` pixels along each side, into volumes of a technique's light:
    radiance that glossy surfaces reflect, weighted by their BRDF, rgba32float `specular`, in nits."""

    def __init__(
        self, device: Device, levels: Levels, march: str, more: list[Binding], lookup_offset: float, resolution: int,
        **values: Any,
    ):  # fmt: skip
        self.device, self.n, self._resolution = device, levels.sizes[0], resolution
        self._whole = device.uniform("LPV windows", one_window())
        self._sampler = device.wgpu.create_sampler(
            mag_filter="linear", min_filter="linear", **{f"address_mode_{a}": "clamp-to-edge" for a in "uvw"}
        )
        seen = [views_binding(), texture("surface_map", "uint"), texture("depth_map"), texture("brdf_table")]
        common: dict[str, Any] = {"resolution": resolution, **CONSTANTS}
        self._march = ComputePass(
            device, "glossy", "techniques/lpv/glossy/glossy.wgsl",
            [*seen, grids_binding(levels.windows), windows_binding(levels.windows), storage("peak", "u32"), *more,
             sampler("volume_sampler"), storage_texture("light_out", "rgba32float")],
            structs=[VIEW, GRID, WINDOW], march=march, n=self.n, windows=levels.windows, cone=CONE,
            lookup_offset=float(lookup_offset), transition=transition(self.n), darkest=_DARKEST, **common, **values,
        )  # fmt: skip
        if resolution > 1:
            self._upsample = ComputePass(
                device, "upsample", "techniques/lpv/glossy/upsample.wgsl",
                [*seen, texture("light_map"), storage_texture("specular_out", "rgba32float")], structs=[VIEW],
                apart=_APART, least_near=_LEAST_NEAR, **common,
            )  # fmt: skip
        self._light: Any = None
        self.specular: Any = None

    def prepare(self, frame: Frame) -> None:
        """Make room for the frame's pixels."""
        if self.specular is None or self.specular.size[:2] != tuple(frame.pixels):
            usage = STORAGE | TEXTURE | COPY
            self.specular = self.device.texture("LPV glossy", frame.pixels, "rgba32float", usage=usage)
            if self._resolution > 1:
                size = tuple(-(-side // self._resolution) for side in frame.pixels)
                self._light = self.device.texture("LPV glossy", size, "rgba32float", usage=usage)

    def _run(self, stage: Any, frame: Frame, grids: Any, peak: Any, windows: Any, more: Mapping[str, Any]) -> None:
        target = self._light if self._resolution > 1 else self.specular
        seen = {
            "views": frame.buffers["views"], "surface_map": frame.targets.surface, "depth_map": frame.targets.depth,
            "brdf_table": frame.surroundings_map.resources["brdf_table"],
        }  # fmt: skip
        self._march.run(
            stage, target.size[:2], **seen, grids=grids, windows=windows or self._whole, peak=peak, **more,
            volume_sampler=self._sampler, light_out=target,
        )  # fmt: skip
        if self._resolution > 1:
            self._upsample.run(stage, frame.pixels, **seen, light_map=self._light, specular_out=self.specular)


class Glossy(_Rays):
    """Rays through surfaces' radiance and areas, blocked by the geometry volume's planes. What leaves the volume
    unblocked sees nothing: the sky's reflection is part of the direct light.

    levels: of `injected`, the reflectors and the geometry volume; rays go through windows, and the coarser levels
    that follow them, down to 4^3 cells.
    cells: that a ray goes through at most; by default as many as reach from end to end of all windows.
    step: of a cell's edge, along a ray.  resolution: pixels along each side of a block that shares a ray's light.
    occlusion: planes block; without them only what faces the ray does.
    """

    def __init__(
        self, device: Device, levels: Levels, *, occlusion: bool = True, lookup_offset: float = 0.5, cells: int = 0,
        step: float = 1.0, resolution: int = 1,
    ):  # fmt: skip
        n, windows, self._occlusion = levels.sizes[0], levels.windows, occlusion
        used = windows + sum(size >= _COARSEST for size in levels.sizes[windows:])
        self._slots = slots = windows + (used > windows)
        formats, size = {"radiance": "rgba16float", "facing": "rgba8unorm"}, (n, n * slots, 8 * n)
        self.volumes = {
            name: device.texture("LPV glossy volumes", size, kind, usage=TEXTURE | STORAGE | COPY, dimension="3d")
            for name, kind in formats.items()
        }
        self._fill = ComputePass(
            device, "surfaces", "techniques/lpv/glossy/surfaces.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), storage("reflectors", "vec4f"),
             windows_binding(windows), *(storage_texture(f"{name}_out", kind, "3d") for name, kind in formats.items())],
            structs=[WINDOW], workgroup=(4, 4, 4), n=n, windows=windows, used=used, slots=slots,
            **CONSTANTS, **SH_CONSTANTS,
        )  # fmt: skip
        read = [texture(f"{name}_volume", "float", "3d") for name in formats]
        super().__init__(
            device, levels, "march", [*([storage("geometry", "vec4u")] if occlusion else []), *read], lookup_offset,
            resolution, used=used, slots=slots, occlusion=occlusion, steps=round((cells or windows * n) / step),
            step=float(step), forgets=glossy.FORGETS**step, least=glossy.LEAST, left=glossy.LEFT, met=glossy.MET,
            near=glossy.NEAR, look_ahead=glossy.LOOK_AHEAD, short=SHORT, **STRIP_VALUES,
        )  # fmt: skip

    def update(self, stage: Any, injected: Any, peak: Any, reflectors: Any, windows: Any = None) -> None:
        """Make the volumes of `injected`, W/sr, in which each window has all that lies in it, as have the levels above.

        reflectors: lpv/reflectors.py's, made with `offset` 0.5 and `squares`, complete in all windows.
        windows: uniform buffer of WINDOW, where there are several."""
        self._fill.run(
            stage, (self.n, self.n, self.n * self._slots), injected=injected, peak=peak, reflectors=reflectors,
            windows=windows or self._whole, **{f"{name}_out": volume for name, volume in self.volumes.items()},
        )  # fmt: skip

    def run(
        self, stage: Any, frame: Frame, grids: Any, peak: Any, packed_strips: Any = None, windows: Any = None
    ) -> None:
        """Write `specular`. grids: uniform buffer of GRID, one for each window; packed_strips: the geometry volume's
        `packed`, where it blocks."""
        blockers = {"geometry": packed_strips} if self._occlusion else {}
        volumes = {f"{name}_volume": volume for name, volume in self.volumes.items()}
        self._run(stage, frame, grids, peak, windows, {**blockers, **volumes})


class PaperGlossy(_Rays):
    """CLPV 7 by the letter: the mean over `cells` cells of their intensity by the square of their distance."""

    def __init__(
        self, device: Device, levels: Levels, *, lookup_offset: float = 0.0, cells: int = PAPER_CELLS,
        resolution: int = 1,
    ):  # fmt: skip
        volumes = [texture(channel, "float", "3d") for channel in CHANNELS]
        super().__init__(device, levels, "paper", volumes, lookup_offset, resolution, cells=cells, **SH_CONSTANTS)

    def run(self, stage: Any, frame: Frame, grids: Any, peak: Any, volumes: Any, windows: Any = None) -> None:
        """Write `specular`. volumes: lpv/lookup.py's, of light scaled for storage; the rest as for Glossy."""
        self._run(stage, frame, grids, peak, windows, volumes)
