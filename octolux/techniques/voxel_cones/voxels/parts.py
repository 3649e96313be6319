"""Which part of a scene is static and which moves, and an octree for each (VCT 5.7)."""

from __future__ import annotations

import numpy as np

from ....gpu.device import Device
from ....gpu.profiler import Profiler
from ....gpu_scene.gpu_scene import GpuScene
from ....raytracing.bvh import triangle_ids
from ....simulator.grid import Grid
from ....simulator.voxels.surfaces import around
from .structure import VoxelOctree

_REACH = 4.0
"""Voxels between the boxes of triangles that may lie in one node of level 0: a fragment lies up to 1 beyond its
triangle's box, as its depth is that in the middle of a column, the node up to 1 beyond the fragment's voxel, and voxels
are 1 wide; of the two triangles one counts twice."""
_AIR = 1.0  # voxels at the cube's border that things which move may not enter (surfaces.around has 1.5 of them)

Boxes = tuple[np.ndarray, np.ndarray]
"""Lowest corners, and highest."""


class Parts:
    """static: the octree of what has been as it is since it appeared.  moving: that of what has not, has moved, been
    deformed or got another material, such as one that glows otherwise; None as long as there is nothing of the kind.

    What has changed once belongs to what moves for good: so each thing costs one build of what is static in its life,
    and, while it rests, nothing. Both octrees read the same as one of everything, so that nothing shows to which a
    thing belongs. box: what the cube of voxels is around, low and high (3,), m; by default as `cube_of` says.
    """

    def __init__(
        self, device: Device, depth: int, texture_level: float, representation: str = "axial", interior: bool = False,
        box: Boxes | None = None,
    ):  # fmt: skip
        self._made, self._box = (device, depth, texture_level, representation, interior), box
        self.static = VoxelOctree(*self._made)
        self.moving: VoxelOctree | None = None
        self._static_of: tuple[int, int, Grid] | None = None
        self._moving_of: tuple[tuple[int, int, Grid], int] | None = None

    @property
    def octrees(self) -> list[VoxelOctree]:
        return [self.static] if self.moving is None else [self.static, self.moving]

    def prepare(self, scene: GpuScene) -> bool:
        """Have the octrees that the scene needs; returns whether they are others than before."""
        wanted = bool(scene.has_changed.any())
        if wanted == (self.moving is not None):
            return False
        self.moving = VoxelOctree(*self._made, static=self.static) if wanted else None
        self._moving_of = None
        return True

    def build(self, profiler: Profiler, scene: GpuScene) -> bool:
        """Build what is not as the scene is; returns whether all light of what is static is to be filtered anew. Raises
        DeviceError when there is no room."""
        changed = scene.has_changed[scene.drawn.item_instance]
        if self._box:
            grid = around(*self._box, self.static.depth)
        else:
            grid = cube_of(*_split(scene.item_boxes, changed), self.static.depth)
        key = (id(scene), scene.lasting_version, grid)
        new = key != self._static_of
        if new:
            self._static_of = None  # a build that fails leaves none
            self.static.build(profiler, scene, grid, ids=triangle_ids(scene, ~changed))
            self._static_of = key
        if self.moving and self._moving_of != (key, scene.moves):
            self._moving_of = None
            reach = _REACH * grid.cell_size
            low, high = (side[changed] for side in scene.item_boxes)
            grown = self.moving.build(
                profiler, scene, grid, ids=triangle_ids(scene, changed),
                near=triangle_ids(scene, _near(scene, changed, reach)),
                region=(low.min(axis=0) - reach, high.max(axis=0) + reach),
            )  # fmt: skip
            self._moving_of = (key, scene.moves)
            new = new or grown
        return new


def cube_of(static: Boxes, moving: Boxes, depth: int) -> Grid:
    """The cube of voxels around what is static (VCT 5.7), or, where something that moves leaves that, around all: it
    is the same whatever moves inside. Boxes are float64 (n, 3), low and high, m."""
    if len(static[0]):
        grid = _around(static, depth)
        if (grid.to_cells(moving[0]) >= _AIR).all() and (grid.to_cells(moving[1]) <= grid.n - _AIR).all():
            return grid
    low, high = (np.concatenate(pair) for pair in zip(static, moving, strict=True))
    return _around((low, high), depth)


def _around(boxes: Boxes, depth: int) -> Grid:
    low, high = (boxes[0].min(axis=0), boxes[1].max(axis=0)) if len(boxes[0]) else (np.zeros(3), np.ones(3))
    if not np.any(high > low):  # a point: any box will do
        high = low + 1.0
    return around(low, high, depth)


def _split(boxes: Boxes, moving: np.ndarray) -> tuple[Boxes, Boxes]:
    low, high = boxes
    return (low[~moving], high[~moving]), (low[moving], high[moving])


def _near(scene: GpuScene, changed: np.ndarray, reach: float) -> np.ndarray:
    """bool (items,): those of what is static whose boxes are no farther than `reach`, m, from one that has changed."""
    low, high = scene.item_boxes
    found = np.zeros(len(low), bool)
    owner = scene.drawn.item_instance
    for number in np.flatnonzero(scene.has_changed):
        own = owner == number
        found |= ((low <= high[own].max(axis=0) + reach) & (high >= low[own].min(axis=0) - reach)).all(axis=1)
    return found & ~changed
