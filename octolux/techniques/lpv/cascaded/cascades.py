"""The nested grids of a frame, and where the device finds them."""

from __future__ import annotations

from ....frame.frame import Frame
from ....gpu.device import Device
from ....simulator.lpv.cascades import grids_of, place_windows
from ..constants import GRID, pack_grids
from ..volume import scene_grid
from ..windows import WINDOW, pack_windows


class Cascades:
    """`windows` and `grids`, the finest first, once placed; `windows_buffer` and `grids_buffer` are uniform buffers of
    WINDOW and of GRID, one for each."""

    def __init__(self, device: Device, n: int, count: int):
        self.device, self.n, self.count = device, n, count
        self.grids_buffer = device.uniform("LPV grids", GRID.array(count))
        self.windows_buffer = device.uniform("LPV windows", WINDOW.array(count))

    def place(self, frame: Frame) -> None:
        """Around the camera of `frame`, the last around the scene."""
        view, volume = frame.views[0], scene_grid(frame, self.n)
        self.windows = place_windows(self.n, self.count, volume, view.position, view.forward)
        self.grids = grids_of(self.windows, volume)
        self.device.write(self.grids_buffer, pack_grids(self.grids))
        self.device.write(self.windows_buffer, pack_windows(self.windows))
