"""Cells that keep what static surfaces have filled of them in earlier frames, on the device
(simulator/lpv/keeping.py)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...gpu.bindings import storage, storage_rw, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.passes import ComputePass
from ...gpu_scene.gpu_scene import GpuScene
from ...simulator.grid import Grid
from ...simulator.lpv.keeping import forgotten_cells, window_shift
from .levels import Levels

SHIFT = Struct("Shift", cells="vec3i")


class KeptCells:
    """`volume`: buffers by name of so many vec4f a cell, [window][z][y][x], as `contents` says. They begin empty.

    offset: cells by which surfels are moved along their normals, at most.
    """

    def __init__(self, device: Device, levels: Levels, contents: Mapping[str, int], offset: float):
        self.device, self.n, self._offset = device, levels.sizes[0], offset
        cells, windows = levels.windows * self.n**3, levels.windows
        self.volume, self._other = (
            {name: device.buffer("LPV kept surfels", size=cells * 16 * k) for name, k in contents.items()}
            for _ in range(2)
        )
        self._forgotten = device.buffer("LPV forgotten cells", size=cells // 8)  # a bit a cell
        self._shifts = device.uniform("LPV shifts", SHIFT.array(windows))
        # A pass for each buffer: together they would be more than a pass may have.
        self._move = {
            count: ComputePass(
                device, "keep surfels", "techniques/lpv/keep_cells.wgsl",
                [uniform("shifts", f"array<Shift, {windows}>"), storage("forgotten", "u32"), storage("cells", "vec4f"),
                 storage_rw("cells_out", "vec4f", "write")],
                structs=[SHIFT], workgroup=(4, 4, 4), n=self.n, count=count,
            ) for count in set(contents.values())
        }  # fmt: skip
        self._contents = dict(contents)
        self._cells, self._windows = cells, windows
        self._grids: tuple[Grid, ...] = ()
        self._scene: GpuScene | None = None
        self._version = 0

    def forget(self) -> None:
        """The next frame finds them empty, whatever it brings."""
        self._grids = ()

    def follow(self, stage: Any, grids: Sequence[Grid], scene: GpuScene) -> None:
        """Bring them to where the windows are now, as `grids` in the world, and empty those that held what has begun to
        move, has gone or become another since the last frame."""
        found = [window_shift(*pair) for pair in zip(self._grids, grids, strict=True)] if self._grids else []
        shifts = np.array([shift for shift in found if shift is not None])
        missed = self._scene is not scene or scene.static_version - self._version > 1
        low, high = scene.left_boxes if scene.static_version != self._version else np.zeros((2, 0, 3))
        self._grids, self._scene, self._version = tuple(grids), scene, scene.static_version
        if missed or len(shifts) < len(grids):
            for buffer in self.volume.values():
                stage.encoder.clear_buffer(buffer)
            return
        forgotten = np.stack([forgotten_cells(grid, low, high, self._offset) for grid in grids])
        if forgotten.any() or shifts.any():
            self._run(stage, shifts, forgotten)

    def _run(self, stage: Any, shifts: np.ndarray, forgotten: np.ndarray) -> None:
        packed = SHIFT.array(self._windows)
        packed["cells"] = shifts
        self.device.write(self._shifts, packed)
        self.device.write(self._forgotten, np.packbits(forgotten, bitorder="little"))
        for name, count in self._contents.items():
            self._move[count].run(
                stage, (self.n, self.n, self.n * self._windows), shifts=self._shifts, forgotten=self._forgotten,
                cells=self.volume[name], cells_out=self._other[name],
            )  # fmt: skip
        self.volume, self._other = self._other, self.volume

    def copy_to(self, stage: Any, volume: Mapping[str, Any]) -> None:
        """Let the windows' cells of `volume`, which may have room for more, hold what these do."""
        for name, buffer in self.volume.items():
            stage.encoder.copy_buffer_to_buffer(buffer, 0, volume[name], 0, buffer.size)
