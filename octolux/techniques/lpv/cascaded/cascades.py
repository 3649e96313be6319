"""The nested grids of a frame, and where the device finds them."""

from __future__ import annotations

from ....frame.ambient_occlusion import AmbientOcclusion
from ....frame.frame import Frame
from ....gpu.device import Device
from ....simulator.lpv.cascades import grids_of, moving_volume, place_windows, transition
from ..constants import GRID, grids_binding, pack_grids
from ..volume import scene_grid
from ..windows import WINDOW, pack_windows, windows_binding


class Cascades:
    """`windows` and `grids`, the finest first, once placed; `windows_buffer` and `grids_buffer` are uniform buffers of
    WINDOW and of GRID, one for each."""

    def __init__(self, device: Device, n: int, count: int, spacing: float = 0.0):
        self.device, self.n, self.count, self._spacing = device, n, count, spacing
        self.grids_buffer = device.uniform("LPV grids", GRID.array(count))
        self.windows_buffer = device.uniform("LPV windows", WINDOW.array(count))

    def place(self, frame: Frame) -> None:
        """Around the camera of `frame`, the last around the scene, or of `spacing` metres."""
        view = frame.views[0]
        volume = scene_grid(frame, self.n)
        if self._spacing:
            volume = moving_volume(self._spacing, self.n, view.position, view.forward)
        self.windows = place_windows(self.n, self.count, volume, view.position, view.forward)
        self.grids = grids_of(self.windows, volume)
        self.device.write(self.grids_buffer, pack_grids(self.grids))
        self.device.write(self.windows_buffer, pack_windows(self.windows))

    def ambient_occlusion(self, lookup_offset: float) -> AmbientOcclusion:
        """Of what is smaller than the cells of the cascade that a place is read in."""
        return AmbientOcclusion(
            self.device, radius_file="techniques/lpv/cascaded/ao_radius.wgsl",
            bindings=[grids_binding(self.count), windows_binding(self.count)], structs=[GRID, WINDOW], n=self.n,
            windows=self.count, transition=transition(self.n), lookup_offset=float(lookup_offset),
        )  # fmt: skip
