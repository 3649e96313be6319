"""Cells of an octree as the camera sees them: which one each pixel looks at, and pictures of their values (VCT, figures
5.4 and 5.5)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...frame.frame import COPY, STORAGE, Frame
from ...frame.structs import VIEW, views_binding
from ...gpu.bindings import storage, storage_texture, uniform
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from ...gpu.profiler import Profiler
from .gathering import VOXELS_OF
from .octree import directory_binding
from .structure import VoxelOctree

NOTHING = 0xFFFFFFFF
_SHADES = np.array([0.8, 0.8, 1.0, 0.5, 0.6, 0.6])  # of faces that look along +x, -x, +y, ...: cubes are seen as cubes


class Drawing:
    """Cells of a level of an octree: nodes, or voxels in which something faces any way."""

    def __init__(self, device: Device, octree: VoxelOctree, level: int, nodes: bool):
        self.device, self.octree, self._nodes = device, octree, nodes
        facing = [] if nodes else [storage("facing", "vec2u")]
        self._draw = ComputePass(
            device, "draw voxels", "techniques/voxel_cones/draw.wgsl",
            [views_binding(), uniform("voxels_of", VOXELS_OF), directory_binding(), *facing,
             storage_texture("met_out", "rg32uint")],
            structs=[VIEW, VOXELS_OF], nodes=nodes, level=level, **octree.octree.values,
        )  # fmt: skip

    def met(self, frame: Frame) -> tuple[np.ndarray, np.ndarray]:
        """Of each pixel the number of the cell that it sees, uint32 (height, width): of the node, or 8 times its node's
        and which of the eight voxels, NOTHING where it sees none; and which of simulator/voxels/surfaces.DIRECTIONS the
        cell's face there looks along."""
        out = self.device.texture("voxel views", frame.pixels, "rg32uint", usage=STORAGE | COPY)
        grid, profiler = self.octree.grid, Profiler(self.device, "off")
        more: dict[str, Any] = {} if self._nodes else {"facing": self.octree.bricks.facing.resource}
        with profiler.frame(), profiler.stage("draw voxels") as stage:
            self._draw.run(
                stage, frame.pixels, views=frame.buffers["views"], directory=self.octree.octree.directory, met_out=out,
                voxels_of=self.device.uniform("voxel views", VOXELS_OF.pack(origin=grid.origin, size=grid.cell_size)),
                **more,
            )  # fmt: skip
        read = self.device.read_texture(out, np.uint32, 2)
        return read[..., 0], read[..., 1]


def picture(met: tuple[np.ndarray, np.ndarray], first: int, values: np.ndarray) -> np.ndarray:
    """float32 (height, width, 3): `values` (m, 3) of the cells from number `first` on, darker on some sides; black
    where no cell is."""
    number, way = met
    there = number != NOTHING
    shown = np.zeros((*number.shape, 3), np.float32)
    shown[there] = values[number[there] - first] * _SHADES[way[there], None]
    return shown
