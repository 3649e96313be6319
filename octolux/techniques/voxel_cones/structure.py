"""The sparse voxel octree of a scene and its bricks of what faces each way, built on the device (VCT 5.2 to 5.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...frame.frame import COPY, STORAGE, TEXTURE
from ...gpu.bindings import storage, storage_rw, storage_texture, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.limits import DEFAULT_LIMITS
from ...gpu.passes import ComputePass
from ...gpu.profiler import Profiler
from ...gpu.records import record_texture, records_out, words
from ...gpu_scene.gpu_scene import GpuScene
from ...raytracing.bvh import triangle_ids
from ...raytracing.scan import PARAMETERS
from ...simulator.grid import Grid
from .octree import LABEL, Octree, directory_binding
from .pools import ROW, WORKGROUP, Pool, parameters, threads
from .voxeliser import CUBE, EMISSION_LAYER, LAYER, Triangles, Voxeliser

# What is known of the surfaces in a voxel of level 0; voxel.wgsl packs it.
VOXEL = Struct("Voxel", albedo="u32", facing_up="u32", facing_down="u32", emission="u32")
BRICK = 3
"""Texels along the edge of a brick."""
LOG2_BRICKS = 6  # bricks along x and y of their textures: 192 texels
_MOST_BRICKS = (DEFAULT_LIMITS["max-texture-dimension-3d"] // BRICK) << 2 * LOG2_BRICKS
_OWN = 8  # voxels of a node
_MOST_NODES = DEFAULT_LIMITS["max-storage-buffer-binding-size"] // (8 * _OWN)
_SUMS_BYTES = 64 << 20  # of sums at a time: more voxels take more rounds


def brick_texture(device: Device, label: str, format: str, count: int) -> Any:
    """A 3D texture for `count` bricks, or more."""
    edge = BRICK << LOG2_BRICKS
    size = (edge, edge, BRICK * -(-count >> 2 * LOG2_BRICKS)) if count else (edge, edge, BRICK)
    return device.texture(label, size, format, usage=STORAGE | TEXTURE | COPY, dimension="3d")


class VoxelOctree:
    """octree: where nodes are.  voxels: texture of VOXEL.  facing: vec2u of the eight voxels that each node owns
    (facing.wgsl).  bricks_up, bricks_down: 3D textures of the shares of voxels' sections that face +x, +y, +z, and -x,
    -y, -z, filtered by hardware.  grid: of the voxels.  peak: the scene's brightest emission, nits, of which voxels'
    emissions are shares.

    values: what octree.wgsl wants to know.
    """

    def __init__(self, device: Device, depth: int, texture_level: float = 0.0):
        self.device, self.depth = device, depth
        self.grid: Grid
        self.peak = 0.0
        self.octree = Octree(device, depth)
        self.octree.values.update(bricks=1 << LOG2_BRICKS, log2_bricks=LOG2_BRICKS)
        self.values = self.octree.values
        self._voxeliser = Voxeliser(device, self.octree, texture_level)
        self.voxels = Pool("voxels", lambda count: record_texture(device, LABEL, VOXEL, count), limit=1 << 24)
        self.facing = Pool("nodes", lambda count: device.buffer(LABEL, size=8 * _OWN * count), limit=_MOST_NODES)
        self.bricks_up, self.bricks_down = (
            Pool("bricks", lambda count: brick_texture(device, "voxel bricks", "rgba8unorm", count), limit=_MOST_BRICKS)
            for _ in range(2)
        )
        given = uniform("parameters", PARAMETERS)
        fixed: dict[str, Any] = {"workgroup": WORKGROUP, "row": ROW, **self.values}
        folder = "techniques/voxel_cones"
        self._surfaces = {
            emissive: ComputePass(
                device, "voxels", f"{folder}/surfaces.wgsl",
                [given, uniform("cube", CUBE), words("leaves"), storage("sums", "u32"), records_out("voxels", VOXEL),
                 storage_rw("facing", "vec2u", "write")], structs=[PARAMETERS, CUBE, VOXEL], emissive=emissive,
                words=self._voxeliser.words_of(emissive), layer=float(LAYER), emission_layer=float(EMISSION_LAYER),
                **fixed,
            )
            for emissive in (False, True)
        }  # fmt: skip
        nodes = [given, storage("codes", "u32"), directory_binding()]
        self._average = ComputePass(
            device, "averaging", f"{folder}/average.wgsl", [*nodes, storage_rw("facing", "vec2u")],
            structs=[PARAMETERS], **fixed,
        )  # fmt: skip
        self._copy = ComputePass(
            device, "edge copy", f"{folder}/bricks.wgsl",
            [*nodes, storage("facing", "vec2u"),
             *(storage_texture(f"bricks_{side}", "rgba8unorm", "3d") for side in ("up", "down"))],
            structs=[PARAMETERS], **fixed,
        )  # fmt: skip

    def build(self, profiler: Profiler, scene: GpuScene, grid: Grid, peak: float = 0.0) -> None:
        """Build it anew for what is drawn of `scene` in the voxels of `grid`, 2^depth along each side. Inside a frame
        of `profiler`; the host waits twice.

        Raises DeviceError when the scene needs more nodes than there can be, ValueError for another grid.
        """
        if grid.n != 1 << self.depth:
            raise ValueError(f"an octree of depth {self.depth} has {1 << self.depth} voxels a side, not {grid.n}")
        self.grid, self.peak = grid, peak
        cube, occupied = self._voxeliser.cube(grid, peak), self.octree.occupied()
        triangles = self._voxeliser.triangles(profiler, scene, triangle_ids(scene), cube)
        with profiler.stage("fragments") as stage:
            self._voxeliser.mark(stage, scene, triangles, cube, occupied)
        self.octree.build(profiler, occupied)
        counts = self.octree.counts
        self.voxels.need(counts.voxels)
        for pool in (self.facing, self.bricks_up, self.bricks_down):
            pool.need(counts.nodes)
        self._fill(profiler, scene, triangles)

    def _fill(self, profiler: Profiler, scene: GpuScene, triangles: Triangles) -> None:
        """Brick filling (VCT 5.4): voxels from fragments, levels from each other, then all bricks."""
        with profiler.stage("voxels") as stage:
            stage.encoder.clear_buffer(self.facing.resource)
            self._sum(stage, scene, triangles)
        with profiler.stage("averaging") as stage:
            for first, count in self.octree.counts.levels[1:]:
                self._average.run(
                    stage, threads(_OWN * count), parameters=parameters(self.device, count, first),
                    codes=self.octree.codes.resource, directory=self.octree.directory, facing=self.facing.resource,
                )  # fmt: skip
        with profiler.stage("edge copy") as stage:
            self._copy.run(
                stage, threads(self.facing.used), codes=self.octree.codes.resource, directory=self.octree.directory,
                parameters=parameters(self.device, self.facing.used, third=max(self.facing.used, 1) - 1),
                facing=self.facing.resource, bricks_up=self.bricks_up.resource,
                bricks_down=self.bricks_down.resource,
            )  # fmt: skip

    def _sum(self, stage: Any, scene: GpuScene, triangles: Triangles) -> None:
        """As many voxels at a time as there is room for sums."""
        counts, size = self.octree.counts, 4 * self._voxeliser.words_of(scene.has_emission)
        room = max(1, min(counts.voxels, _SUMS_BYTES // size))
        sums = self.device.buffer("voxel build", size=room * size)
        first_leaf, leaves = counts.levels[0]
        for first in range(0, counts.voxels, room):
            cube = self._voxeliser.cube(self.grid, self.peak, first, room, first_leaf)
            stage.encoder.clear_buffer(sums)
            self._voxeliser.accumulate(stage, scene, triangles, cube, sums)
            self._surfaces[scene.has_emission].run(
                stage, threads(_OWN * leaves), parameters=parameters(self.device, leaves, first_leaf), cube=cube,
                leaves=self.octree.leaves.resource, sums=sums, voxels=self.voxels.resource,
                facing=self.facing.resource,
            )  # fmt: skip

    def pools(self) -> dict[str, tuple[int, int]]:
        """How many elements each pool holds, and for how many it has room."""
        all_pools = self.octree.leaves, self.voxels, self.facing, self.bricks_up
        return {pool.name: (pool.used, pool.capacity) for pool in all_pools}

    def codes(self) -> np.ndarray:
        """The code of each node, uint32 (nodes,); see codes.wgsl."""
        return np.frombuffer(self.device.queue.read_buffer(self.octree.codes.resource), np.uint32)[: self.facing.used]
