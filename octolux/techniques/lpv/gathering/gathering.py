"""Gathering on the device (simulator/lpv/gathering.py): light of the nodes for the cells looked up."""

from __future__ import annotations

from math import pi
from typing import Any

from ....frame.frame import COPY, STORAGE, TEXTURE, Frame
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import atomic_words, sampler, storage, storage_rw, storage_texture, texture
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.passes import ComputePass
from ....gpu.records import record_texture, records, records_out
from ....simulator.blending import RATIO
from ....simulator.lpv import cones, corners, gathering
from ....simulator.lpv.cascades import transition
from ..constants import GRID, SH_CONSTANTS, STRIP_VALUES, grids_binding
from ..downsampling import Downsampling
from ..levels import ROW, Levels
from ..windows import WINDOW, one_window, windows_binding

_LEAST = 2.0**-10  # the place's own cell is filled and has a weight of 1/8 at least: this only guards the division
_OPAQUE = 2.0**-12  # what passes less is black: below the steps of a half float
# place: in the cells that `moments` count in.  weight: the light's band 0 over all channels.  The rest: nodes.wgsl.
NODE = Struct("Node", place="vec3f", weight="f32", red_green="vec4u", blue="vec4u")


class Gathering:
    """`cube` holds irradiance times the square of the cell size, scaled for storage (storage_scale.wgsl), on the six
    faces of each cell that was asked for: rgba16float, the windows behind one another in y and the faces in z, as
    transfer.DIRECTIONS are.

    `marks` are 1 (u32, [window][z][y][x]) where a cell is asked for.

    everywhere: all cells are filled, not only those that surfaces are looked up in. strips_first: number of the cell in
    the geometry volume's buffer that level 0 begins with. visibility: `read` is given a texture of ambient visibility.
    corners: surfaces are looked up in all eight cells around them, as far as planes let through, whoever asks for them;
    otherwise in those alone of them whose middles lie before surfaces that are seen, which takes half the time.
    placed: `measure` is given where in its cells light lies.  unit: cells of the finest level that `moments` count in,
    along the edge of one of level 0.
    """

    def __init__(
        self, device: Device, levels: Levels, *, occlusion: bool, lookup_offset: float, everywhere: bool = False,
        strips_first: int = 0, visibility: bool = False, corners: bool = False, placed: bool = False,
        unit: int = 1,
    ):  # fmt: skip
        self.device, self.levels, self.n = device, levels, levels.sizes[0]
        self._strips_first, self._visibility, self.corners = strips_first, visibility, corners
        self._placed, self._unit = placed, unit
        n, cells = self.n, levels.windows * self.n**3
        self._occlusion, self._everywhere = occlusion, everywhere
        self.nodes = record_texture(device, "LPV nodes", NODE, levels.cells)
        self.moments = device.buffer("LPV moments", size=levels.cells * 16)
        self.marks = device.buffer("LPV marked cells", size=cells * 4)
        self._filled = device.buffer("LPV filled cells", size=cells // 8)  # a bit a cell, two words a block of 4^3
        self.cube = device.texture(
            "LPV irradiance cube", (n, levels.windows * n, 6 * n), "rgba16float", usage=TEXTURE | STORAGE | COPY,
            dimension="3d",
        )  # fmt: skip
        self.whole = device.uniform("LPV windows", one_window())
        self._downsampling = Downsampling(device, levels, per_cell=3), Downsampling(device, levels, per_cell=1)
        self._sampler = device.wgpu.create_sampler(
            mag_filter="linear", min_filter="linear", **{f"address_mode_{a}": "clamp-to-edge" for a in "uvw"}
        )
        self._make_node_passes()
        self._make_lookup_passes(lookup_offset)

    def _make_node_passes(self) -> None:
        n, device, count = self.n, self.device, self.levels.windows
        light, moments = storage("injected", "vec4f"), storage("moments", "vec4f")
        windows = windows_binding(count)
        values: dict[str, Any] = {"n": n, "windows": count, "row": ROW}
        self._measure = ComputePass(
            device, "moments", "techniques/lpv/gathering/moments.wgsl",
            [light, *([storage("placed", "vec4f")] if self._placed else []), storage_rw("moments", "vec4f", "write"),
             windows],
            structs=[WINDOW], workgroup=(4, 4, 4), placed=self._placed, **values,
        )  # fmt: skip
        self._make_nodes = ComputePass(
            device, "nodes", "techniques/lpv/gathering/nodes.wgsl", [light, moments, records_out("nodes", NODE)],
            structs=[NODE], workgroup=(64, 1, 1), cells=self.levels.cells, pi=pi, row=ROW, **SH_CONSTANTS,
        )  # fmt: skip
        blockers = [storage("geometry", "vec4u")] if self._occlusion else []
        used = count + gathering.coarsest_read(n.bit_length())
        coarsest = self.levels.sizes[used - 1]
        self._gather = ComputePass(
            device, "gather", "techniques/lpv/gathering/gather.wgsl",
            [records("nodes", NODE), moments, storage("marks", "u32"), storage_rw("filled", "u32"),
             storage("peak", "u32"), windows, *blockers, storage_texture("cube_out", "rgba16float", "3d")],
            structs=[NODE, WINDOW], workgroup=(64, 1, 1), levels=used, coarsest=coarsest,
            candidates=512 + 216 * (used - 2) + coarsest**3,
            occlusion=self._occlusion, everywhere=self._everywhere, spread=gathering.SPREAD, side=gathering.SIDE, pi=pi,
            cone_length=cones.CONE_LENGTH, fade=cones.FADE, left_out=cones.LEFT_OUT, short=cones.SHORT, opaque=_OPAQUE,
            touches=cones.TOUCHES, bits=n.bit_length() - 1, unit=self._unit, strips_first=self._strips_first,
            **STRIP_VALUES, **values,
        )  # fmt: skip

    def _make_lookup_passes(self, lookup_offset: float) -> None:
        count = self.levels.windows
        self._clear = ComputePass(
            self.device, "clear", "techniques/lpv/gathering/clear_cube.wgsl",
            [storage_texture("cube_out", "rgba16float", "3d")], workgroup=(8, 4, 2),
        )  # fmt: skip
        seen = [views_binding(), texture("surface_map", "uint"), texture("depth_map"), grids_binding(count),
                windows_binding(count)]  # fmt: skip
        values: dict[str, Any] = {
            "n": self.n, "windows": count, "lookup_offset": float(lookup_offset), "transition": transition(self.n),
            "blend_ratio": RATIO, "corners": self.corners, "occlusion": self._occlusion, "least": _LEAST,
            "closed": corners.LEAST, "unsure": corners.UNSURE, **STRIP_VALUES,
        }  # fmt: skip
        if self.corners and self._occlusion:
            seen.append(storage("geometry", "vec4u"))
        self._mark = ComputePass(
            self.device, "mark", "techniques/lpv/gathering/mark.wgsl", [*seen, atomic_words("marks", "u32")],
            structs=[VIEW, GRID, WINDOW], **values,
        )  # fmt: skip
        self._lookup = ComputePass(
            self.device, "lookup", "techniques/lpv/gathering/cube_lookup.wgsl",
            [*seen, storage("peak", "u32"), texture("cube", "float", "3d"),
             *([] if self.corners else [sampler("volume_sampler")]),
             storage_texture("irradiance_out", "rgba32float"),
             *([texture("visibility_map")] if self._visibility else [])],
            structs=[VIEW, GRID, WINDOW], visibility=self._visibility, **values,
        )  # fmt: skip

    def forget(self, stage: Any) -> None:
        """No cell is filled, or asked for."""
        stage.encoder.clear_buffer(self.marks)
        stage.encoder.clear_buffer(self._filled)
        self._clear.run(stage, self.cube.size, cube_out=self.cube)

    def update(self, stage: Any, injected: Any, windows: Any = None) -> None:
        """Make the nodes, and the coarser levels of `injected`, W/sr, of which each window has all that lies in it;
        all that is asked for is to be gathered anew. windows: uniform buffer of WINDOW, where there are several."""
        self.measure(stage, injected, windows)
        self.finish(stage, injected)

    def measure(self, stage: Any, injected: Any, windows: Any = None, placed: Any = None) -> None:
        """Make `moments` of the windows' light. placed: injection.py's moments, where they are."""
        windows = windows or self.whole
        given = {"placed": placed} if self._placed else {}
        self._measure.run(
            stage, (self.n, self.n, self.n * self.levels.windows), injected=injected, moments=self.moments,
            windows=windows, **given,
        )  # fmt: skip

    def finish(self, stage: Any, injected: Any) -> None:
        """Make the coarser levels and the nodes of what the windows have, light and `moments`."""
        stage.encoder.clear_buffer(self._filled)
        for downsampling, cells in zip(self._downsampling, (injected, self.moments), strict=True):
            downsampling.run(stage, cells)
        self._make_nodes.run(stage, self.levels.rows, injected=injected, moments=self.moments, nodes=self.nodes)

    def mark(self, stage: Any, frame: Frame, grids: Any, windows: Any = None, packed_strips: Any = None) -> None:
        """Ask for the cells that the frame's pixels look up."""
        seen = self._seen(frame, grids, windows or self.whole, packed_strips)
        self._mark.run(stage, frame.pixels, **seen, marks=self.marks)

    def gather(self, stage: Any, peak: Any, packed_strips: Any, windows: Any = None) -> None:
        """Fill the cells that have been asked for, if they are not filled yet."""
        blockers = {"geometry": packed_strips} if self._occlusion else {}
        cells = Levels([self.n] * self.levels.windows)
        self._gather.run(
            stage, cells.rows, nodes=self.nodes, moments=self.moments, marks=self.marks, filled=self._filled,
            peak=peak, cube_out=self.cube, windows=windows or self.whole, **blockers,
        )  # fmt: skip

    def read(
        self, stage: Any, frame: Frame, grids: Any, peak: Any, irradiance: Any, windows: Any = None,
        visibility: Any = None, packed_strips: Any = None,
    ) -> None:  # fmt: skip
        """Write irradiance of every pixel, and ambient visibility in alpha: `visibility` (r32float), or 1."""
        visible = {"visibility_map": visibility} if self._visibility else {}
        self._lookup.run(
            stage, frame.pixels, **self._seen(frame, grids, windows or self.whole, packed_strips), peak=peak,
            cube=self.cube, **({} if self.corners else {"volume_sampler": self._sampler}), irradiance_out=irradiance,
            **visible,
        )  # fmt: skip

    def _seen(self, frame: Frame, grids: Any, windows: Any, packed_strips: Any) -> dict[str, Any]:
        surface, depth = frame.targets.surface, frame.targets.depth
        planes = {"geometry": packed_strips} if self.corners and self._occlusion else {}
        return {"views": frame.buffers["views"], "surface_map": surface, "depth_map": depth, "grids": grids,
                "windows": windows, **planes}  # fmt: skip
