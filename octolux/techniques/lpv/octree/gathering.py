"""Gathering on the device (simulator/lpv/gathering.py): light of the octree's nodes for the cells looked up."""

from __future__ import annotations

from math import pi
from typing import Any

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import sampler, storage, storage_rw, storage_texture, texture, uniform
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.lpv import gathering, geometry
from ..constants import GRID, SH_CONSTANTS
from ..downsampling import Downsampling
from ..injection import atomic_words
from ..levels import ROW, Levels

_LEAST = 2.0**-10  # the place's own cell is filled and has a weight of 1/8 at least: this only guards the division
_OPAQUE = 2.0**-12  # what passes less is black: below the steps of a half float


class Gathering:
    """`cube` holds irradiance times the square of the cell size, scaled for storage (storage_scale.wgsl), on the six
    faces of each cell that was asked for: rgba16float, the faces behind one another in z, as transfer.DIRECTIONS are.

    everywhere: all cells are filled, not only those that surfaces are looked up in.
    """

    def __init__(self, device: Device, levels: Levels, *, occlusion: bool, lookup_offset: float, everywhere: bool):
        self.device, self.levels, self.n = device, levels, levels.sizes[0]
        n, cells = self.n, self.n**3
        self._occlusion, self._everywhere = occlusion, everywhere
        self.nodes = device.buffer("LPV nodes", size=levels.cells * 48)
        self._moments = device.buffer("LPV moments", size=levels.cells * 16)
        self._kept = {
            "marks": device.buffer("LPV marked cells", size=cells * 4),
            "filled": device.buffer("LPV filled cells", size=cells // 8),  # a bit a cell, two words a block of 4^3
        }
        self.cube = device.texture(
            "LPV irradiance cube", (n, n, 6 * n), "rgba16float", usage=TEXTURE | STORAGE | COPY, dimension="3d"
        )
        self._downsampling = Downsampling(device, levels, per_cell=1)
        self._sampler = device.wgpu.create_sampler(
            mag_filter="linear", min_filter="linear", **{f"address_mode_{a}": "clamp-to-edge" for a in "uvw"}
        )
        self._make_node_passes()
        self._make_lookup_passes(lookup_offset)

    def _make_node_passes(self) -> None:
        n, device = self.n, self.device
        light, moments = storage("injected", "vec4f"), storage("moments", "vec4f")
        self._begin = ComputePass(
            device, "moments", "techniques/lpv/octree/moments.wgsl", [light, storage_rw("moments", "vec4f", "write")],
            workgroup=(4, 4, 4), n=n,
        )  # fmt: skip
        self._make_nodes = ComputePass(
            device, "nodes", "techniques/lpv/octree/nodes.wgsl",
            [light, moments, storage_rw("nodes", "vec4u", "write")], workgroup=(64, 1, 1), n=n, row=ROW,
            cells=self.levels.cells, pi=pi, **SH_CONSTANTS,
        )  # fmt: skip
        blockers = [storage("geometry", "u32")] if self._occlusion else []
        used = sum(n >= 4 for n in self.levels.sizes)  # all nodes of coarser levels are next to every cell's own
        self._gather = ComputePass(
            device, "gather", "techniques/lpv/octree/gather.wgsl",
            [storage("nodes", "vec4u"), storage("marks", "u32"), storage_rw("filled", "u32"), storage("peak", "u32"),
             *blockers, storage_texture("cube_out", "rgba16float", "3d")],
            workgroup=(64, 1, 1), n=n, row=ROW, levels=used, candidates=512 + 216 * (used - 1),
            occlusion=self._occlusion, everywhere=self._everywhere, spread=gathering.SPREAD,
            cone_length=geometry.CONE_LENGTH, left_out=geometry.LEFT_OUT, short=geometry.SHORT, opaque=_OPAQUE,
            bits=n.bit_length() - 1,
        )  # fmt: skip

    def _make_lookup_passes(self, lookup_offset: float) -> None:
        self._clear = ComputePass(
            self.device, "clear", "techniques/lpv/octree/clear_cube.wgsl",
            [storage_texture("cube_out", "rgba16float", "3d")], workgroup=(8, 4, 2),
        )  # fmt: skip
        seen = [views_binding(), texture("surface_map", "uint"), texture("depth_map"), uniform("grid", GRID)]
        values: dict[str, Any] = {"n": self.n, "lookup_offset": float(lookup_offset)}
        self._mark = ComputePass(
            self.device, "mark", "techniques/lpv/octree/mark.wgsl", [*seen, atomic_words("marks", "u32")],
            structs=[VIEW, GRID], **values,
        )  # fmt: skip
        self._lookup = ComputePass(
            self.device, "lookup", "techniques/lpv/octree/cube_lookup.wgsl",
            [*seen, storage("peak", "u32"), texture("cube", "float", "3d"), sampler("volume_sampler"),
             storage_texture("irradiance_out", "rgba32float")],
            structs=[VIEW, GRID], least=_LEAST, **values,
        )  # fmt: skip

    def update(self, stage: Any, injected: Any) -> None:
        """Make the nodes of `injected` (all levels, W/sr) and forget what was gathered from those before."""
        for name in ("marks", "filled"):
            stage.encoder.clear_buffer(self._kept[name])
        self._clear.run(stage, self.cube.size, cube_out=self.cube)
        self._begin.run(stage, (self.n,) * 3, injected=injected, moments=self._moments)
        self._downsampling.run(stage, self._moments)
        self._make_nodes.run(
            stage, self.levels.rows, injected=injected, moments=self._moments, nodes=self.nodes
        )

    def gather(self, stage: Any, frame: Frame, grid: Any, peak: Any, packed_shares: Any) -> None:
        """Fill the cells that the frame's pixels look up, if they are not filled yet."""
        kept = self._kept
        self._mark.run(stage, frame.pixels, **self._seen(frame, grid), marks=kept["marks"])
        blockers = {"geometry": packed_shares} if self._occlusion else {}
        self._gather.run(
            stage, Levels([self.n]).rows, nodes=self.nodes, **kept, peak=peak, cube_out=self.cube,
            **blockers,
        )  # fmt: skip

    def read(self, stage: Any, frame: Frame, grid: Any, peak: Any, irradiance: Any) -> None:
        """Write irradiance of every pixel."""
        self._lookup.run(
            stage, frame.pixels, **self._seen(frame, grid), peak=peak, cube=self.cube, volume_sampler=self._sampler,
            irradiance_out=irradiance,
        )  # fmt: skip

    @staticmethod
    def _seen(frame: Frame, grid: Any) -> dict[str, Any]:
        surface, depth = frame.targets.surface, frame.targets.depth
        return {"views": frame.buffers["views"], "surface_map": surface, "depth_map": depth, "grid": grid}
