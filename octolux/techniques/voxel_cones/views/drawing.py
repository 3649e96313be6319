"""Cells of an octree as the camera sees them: which one each pixel looks at, and pictures of their values (VCT, figures
5.4 and 5.5)."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ....frame.frame import COPY, STORAGE, Frame
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import storage, storage_texture, uniform
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....gpu.profiler import Profiler
from ....simulator.camera import unpack_normals
from ....simulator.grid import Grid
from ....simulator.voxels.surfaces import DIRECTIONS
from ..cones.gathering import VOXELS_OF, voxels_of
from ..octree.octree import directory_binding
from ..voxels.structure import VoxelOctree
from .contents import keys_of

NOTHING = 0xFFFFFFFF
_SHADES = np.array([0.8, 0.8, 1.0, 0.5, 0.6, 0.6])  # of faces that look along +x, -x, +y, ...: cubes are seen as cubes


class Met(NamedTuple):
    """Of each pixel, (height, width): key: of the cell that it sees (contents.keys_of), NOTHING where there is none.
    way: which of simulator/voxels/surfaces.DIRECTIONS the cell's face there looks along.  distance: from the eye,
    in cells."""

    key: np.ndarray
    way: np.ndarray
    distance: np.ndarray


class Drawing:
    """Voxels of a level of an octree, in which something faces any way."""

    def __init__(self, device: Device, octree: VoxelOctree, level: int):
        self.device, self.octree = device, octree
        self._draw = ComputePass(
            device, "draw voxels", "techniques/voxel_cones/views/draw.wgsl",
            [views_binding(), uniform("voxels_of", VOXELS_OF), directory_binding(),
             storage("facing", "vec2u"), storage_texture("met_out", "rgba32uint")],
            structs=[VIEW, VOXELS_OF], level=level, nothing=NOTHING, **octree.octree.values,
        )  # fmt: skip

    def met(self, frame: Frame) -> Met:
        """What each pixel sees."""
        out = self.device.texture("voxel views", frame.pixels, "rgba32uint", usage=STORAGE | COPY)
        grid, profiler = self.octree.grid, Profiler(self.device, "off")
        with profiler.frame(), profiler.stage("draw voxels") as stage:
            self._draw.run(
                stage, frame.pixels, views=frame.buffers["views"], directory=self.octree.octree.directory, met_out=out,
                voxels_of=self.device.uniform("voxel views", voxels_of(grid)),
                facing=self.octree.bricks.facing.resource,
            )  # fmt: skip
        key, way, distance = np.moveaxis(self.device.read_texture(out, np.uint32, 4)[..., :3], 2, 0)
        return Met(key, way, np.where(key == NOTHING, np.inf, distance.copy().view(np.float32)))


def nearest(of_octrees: list[Met]) -> Met:
    """What pixels see of several octrees of one cube."""
    first = np.argmin([met.distance for met in of_octrees], axis=0)[None]
    fields = (np.stack([met[i] for met in of_octrees]) for i in range(len(Met._fields)))
    return Met(*(np.take_along_axis(field, first, axis=0)[0] for field in fields))


def surface_cells(device: Device, frame: Frame, grid: Grid) -> Met:
    """In which of the grid's cells the surfaces lie that pixels see, and the way that these look mostly."""
    packed = frame.views[0].pack()[0]
    depth = device.read_texture(frame.targets.depth, np.float32, 1).astype(np.float64)
    normals = unpack_normals(device.read_texture(frame.targets.surface, np.uint32, 4)[..., 0])
    width, height = frame.pixels
    x, y = (at[..., None] + 0.5 for at in np.meshgrid(np.arange(width), np.arange(height)))
    origin, towards = (packed[n] + x * packed[f"{n}_dx"] + y * packed[f"{n}_dy"] for n in ("origin", "direction"))
    cells = np.floor(grid.to_cells(origin + depth * towards)).astype(np.int64)
    inside = (depth[..., 0] > 0.0) & ((cells >= 0) & (cells < grid.n)).all(axis=-1)
    keys = keys_of(np.where(inside[..., None], cells, 0).reshape(-1, 3)).reshape(inside.shape)
    return Met(np.where(inside, keys, NOTHING), (normals @ DIRECTIONS.T).argmax(axis=-1), depth[..., 0])


def picture(met: Met, cells: np.ndarray, values: np.ndarray) -> np.ndarray:
    """float32 (height, width, 3): of the cells (m, 3) that are seen their `values` (m, 3), darker on some sides; black
    where there is none."""
    keys = keys_of(cells)
    there = np.isin(met.key, keys)
    order = np.argsort(keys)
    shown = np.zeros((*there.shape, 3), np.float32)
    number = order[np.searchsorted(keys, met.key[there], sorter=order)]
    shown[there] = values[number] * _SHADES[met.way[there], None]
    return shown
