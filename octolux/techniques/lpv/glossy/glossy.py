"""Glossy reflections on the device (simulator/lpv/glossy.py): rays through the cells, from what the camera sees."""

from __future__ import annotations

from typing import Any

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.shader_values import CONSTANTS
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import Binding, sampler, storage, storage_texture, texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.lpv import glossy
from ....simulator.lpv.cascades import transition
from ....simulator.lpv.geometry import SHORT
from ..constants import GRID, SH_CONSTANTS, grids_binding
from ..levels import Levels
from ..lookup import CHANNELS
from ..windows import WINDOW, one_window, windows_binding

PAPER_CELLS = 4
"""CLPV 7: "in practice 4 cells proved to be sufficient"."""

_COARSEST = 4  # cells along each side of the coarsest level that is read: filters have some cells between their ends
_DARKEST = 2.0**-10  # albedo of a specular lobe that is not seen: a quarter of a step of an 8-bit picture
_APART = 0.02  # of its depth, that a pixel's light may come from: some pixels of a wall that is seen at a slant
_LEAST_NEAR = 1e-3  # of four pixels the only one that is as far away counts, be it the farthest


class Glossy:
    """Writes radiance that glossy surfaces reflect, weighted by their BRDF, for every pixel: rgba32float `specular`, in
    nits. What leaves the volume unblocked sees nothing: the sky's reflection is part of the direct light.

    cells: that a ray goes through at most; by default as many as reach from end to end of all windows.
    step: of a cell's edge, along a ray.  resolution: pixels along each side of a block that shares a ray's light.
    occlusion: the geometry volume's planes block; without it only what faces the ray does.
    paper: CLPV 7 by the letter, by cells' intensity over the square of their distance; 4 cells by default.
    """

    def __init__(
        self, device: Device, levels: Levels, *, occlusion: bool = True, lookup_offset: float = 0.5, cells: int = 0,
        step: float = 1.0, resolution: int = 1, paper: bool = False,
    ):  # fmt: skip
        self.device, self.levels, self.n, self._resolution = device, levels, levels.sizes[0], resolution
        self._occlusion, self._paper = occlusion and not paper, paper
        coarser = [size for size in levels.sizes[levels.windows :] if size >= _COARSEST]
        self._used = levels.windows + (0 if paper else len(coarser))
        self._whole = device.uniform("LPV windows", one_window())
        self._sampler = device.wgpu.create_sampler(
            mag_filter="linear", min_filter="linear", **{f"address_mode_{a}": "clamp-to-edge" for a in "uvw"}
        )
        self._values: dict[str, Any] = {
            "n": self.n, "windows": levels.windows, "used": self._used, "resolution": resolution,
            "apart": _APART, "least_near": _LEAST_NEAR, **CONSTANTS, **SH_CONSTANTS,
        }  # fmt: skip
        self._volumes: dict[str, Any] = {}
        self._make_volumes()
        self._make_rays(lookup_offset, cells, step)
        self._light: Any = None
        self.specular: Any = None

    def _make_volumes(self) -> None:
        n, windows = self.n, self.levels.windows
        shape = (n, n * self._used, n)
        if self._paper:
            formats = dict.fromkeys(CHANNELS, ("rgba16float", shape))
            shader, inputs = "paper_volumes", []
        else:
            formats = {"radiance": ("rgba16float", shape), "facing": ("rgba8unorm", (n, n * self._used, 8 * n))}
            shader, inputs = "surfaces", [storage("reflectors", "vec4f"), windows_binding(windows)]
        for name, (kind, size) in formats.items():
            self._volumes[name] = self.device.texture(
                "LPV glossy volumes", size, kind, usage=TEXTURE | STORAGE | COPY, dimension="3d"
            )
        outputs = [storage_texture(f"{name}_out", kind, "3d") for name, (kind, _) in formats.items()]
        self._fill = ComputePass(
            self.device, shader, f"techniques/lpv/glossy/{shader}.wgsl",
            [storage("injected", "vec4f"), storage("peak", "u32"), *inputs, *outputs],
            structs=[] if self._paper else [WINDOW], workgroup=(4, 4, 4), **self._values,
        )  # fmt: skip

    def _make_rays(self, lookup_offset: float, cells: int, step: float) -> None:
        windows, blocks = self.levels.windows, [storage("geometry", "u32")] if self._occlusion else []
        most = cells or (PAPER_CELLS if self._paper else windows * self.n)
        self._march = ComputePass(
            self.device, "glossy", "techniques/lpv/glossy/glossy.wgsl",
            [*self._seen_bindings(), grids_binding(windows), windows_binding(windows), storage("peak", "u32"), *blocks,
             *(texture(f"{name}_volume", "float", "3d") for name in self._volumes), sampler("volume_sampler"),
             storage_texture("light_out", "rgba32float")],
            structs=[VIEW, GRID, WINDOW], lookup_offset=float(lookup_offset), transition=transition(self.n),
            paper=self._paper, occlusion=self._occlusion, cells=most, steps=round(most / step), step=float(step),
            cone=glossy.CONE, forgets=glossy.FORGETS**step, least=glossy.LEAST, left=glossy.LEFT,
            look_ahead=glossy.LOOK_AHEAD, met=glossy.MET, near=glossy.NEAR, short=SHORT,
            darkest=_DARKEST, **self._values,
        )  # fmt: skip
        if self._resolution > 1:
            self._upsample = ComputePass(
                self.device, "upsample", "techniques/lpv/glossy/upsample.wgsl",
                [*self._seen_bindings(), texture("light_map"), storage_texture("specular_out", "rgba32float")],
                structs=[VIEW], **self._values,
            )  # fmt: skip

    @staticmethod
    def _seen_bindings() -> list[Binding]:
        return [views_binding(), texture("surface_map", "uint"), texture("depth_map"), texture("brdf_table")]

    def prepare(self, frame: Frame) -> None:
        """Make room for the frame's pixels."""
        if self.specular is None or self.specular.size[:2] != tuple(frame.pixels):
            usage = STORAGE | TEXTURE | COPY
            self.specular = self.device.texture("LPV glossy", frame.pixels, "rgba32float", usage=usage)
            if self._resolution > 1:
                size = tuple(-(-side // self._resolution) for side in frame.pixels)
                self._light = self.device.texture("LPV glossy", size, "rgba32float", usage=usage)

    def update(self, stage: Any, injected: Any, peak: Any, reflectors: Any = None, windows: Any = None) -> None:
        """Make the volumes of `injected`, W/sr, all levels, in which each window has all that lies in it.

        reflectors: lpv/reflectors.py's, made with `offset` 0.5 and `squares`, of which coarser windows' are complete;
        none for `paper`. windows: uniform buffer of WINDOW, where there are several."""
        inputs = {} if self._paper else {"reflectors": reflectors, "windows": windows or self._whole}
        outputs = {f"{name}_out": volume for name, volume in self._volumes.items()}
        self._fill.run(
            stage, (self.n, self.n, self.n * self._used), injected=injected, peak=peak, **inputs, **outputs
        )

    def run(
        self, stage: Any, frame: Frame, grids: Any, peak: Any, packed_shares: Any = None, windows: Any = None
    ) -> None:
        """Write `specular`. grids: uniform buffer of GRID, one for each window; packed_shares: the geometry volume's
        `packed`, where it blocks."""
        blockers = {"geometry": packed_shares} if self._occlusion else {}
        target = self._light if self._resolution > 1 else self.specular
        seen = {
            "views": frame.buffers["views"], "surface_map": frame.targets.surface, "depth_map": frame.targets.depth,
            "brdf_table": frame.surroundings_map.resources["brdf_table"],
        }  # fmt: skip
        volumes = {f"{name}_volume": volume for name, volume in self._volumes.items()}
        self._march.run(
            stage, target.size[:2], **seen, grids=grids, windows=windows or self._whole, peak=peak, **blockers,
            **volumes, volume_sampler=self._sampler, light_out=target,
        )  # fmt: skip
        if self._resolution > 1:
            self._upsample.run(stage, frame.pixels, **seen, light_map=self._light, specular_out=self.specular)
