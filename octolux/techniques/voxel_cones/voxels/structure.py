"""The sparse voxel octree of a scene and its bricks, built on the device (VCT 5.2 to 5.4)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....gpu.bindings import Binding, storage, storage_rw, texture, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.passes import ComputePass
from ....gpu.profiler import Profiler
from ....gpu.records import record_texture, records_out, sampled_words, words
from ....gpu_scene.gpu_scene import GpuScene
from ....raytracing.bvh import triangle_ids
from ....raytracing.scan import PARAMETERS
from ....simulator.grid import Grid
from ..bricks.bricks import Bricks
from ..bricks.filtering import Filtering
from ..octree.octree import LABEL, Octree, directory_binding
from ..octree.pools import OWN, ROW, WORKGROUP, Pool, parameters, threads
from .voxeliser import CUBE, EMISSION_LAYER, LAYER, Region, Triangles, Voxeliser

# What is known of the surfaces in a voxel of level 0; voxel.wgsl packs it.
VOXEL = Struct("Voxel", albedo="u32", facing_up="u32", facing_down="u32", emission="u32")
_SUMS_BYTES = 64 << 20  # of sums at a time: more voxels take more rounds


class VoxelOctree:
    """octree: where nodes are.  bricks: what is read of them.  filtering: brings light into them.  voxels: texture of
    VOXEL.  grid: of the voxels.  peak: the scene's brightest emission, nits, of which voxels' emissions are shares.

    static: makes this the octree of what moves, beside that one of what does not (VCT 5.7). In nodes of level 0 that
    something lies in that moves it holds all that is there; around them, and on coarser levels, what is static it has
    from the other. So each of its nodes is the same, to the bit, as that of an octree of everything, and stands for the
    other's: nothing is added up, and nothing of the other is touched. The thesis has both in one pool, and inserts the
    nodes of what moves among those of what is static.
    """

    leaf_bindings: tuple[Binding, ...] = (uniform("cube", CUBE), words("leaves"), directory_binding())
    """With `leaf_values` and the struct CUBE, for shaders that look up voxels of level 0 (leaves.wgsl)."""

    def __init__(
        self, device: Device, depth: int, texture_level: float = 0.0, representation: str = "axial",
        interior: bool = False, static: VoxelOctree | None = None,
    ):  # fmt: skip
        self.device, self.depth, self.static = device, depth, static
        self.grid: Grid
        self.peak = 0.0
        self.octree: Octree = Octree(device, depth, static.octree if static else None)
        self.bricks: Bricks = Bricks(device, self.octree, representation, static.bricks if static else None)
        self.filtering = Filtering(device, self.bricks)
        beside = self.other_leaf_bindings("static_") if static else ()
        self._voxeliser = Voxeliser(device, self.octree, texture_level, interior, beside)
        self.voxels = Pool("voxels", lambda count: record_texture(device, LABEL, VOXEL, count), limit=1 << 24)
        self._surfaces = {
            emissive: ComputePass(
                device, "voxels", "techniques/voxel_cones/voxels/surfaces.wgsl",
                [uniform("parameters", PARAMETERS), uniform("cube", CUBE), words("leaves"), storage("sums", "u32"),
                 records_out("voxels", VOXEL), storage_rw("facing", "vec2u", "write")],
                structs=[PARAMETERS, CUBE, VOXEL], emissive=emissive, words=self._voxeliser.words_of(emissive),
                layer=float(LAYER), emission_layer=float(EMISSION_LAYER), workgroup=WORKGROUP, row=ROW,
            )
            for emissive in (False, True)
        }  # fmt: skip

        self.leaf_values = {**self.octree.values, **self._voxeliser.values}

    @staticmethod
    def other_leaf_bindings(part: str) -> tuple[Binding, ...]:
        """The same of another octree, whose names begin with `part`, for shaders that have taken their storage
        textures. With both a voxel's leaf is found in the one that has all of it."""
        directory = texture(f"{part}directory", "uint")
        return (uniform(f"{part}cube", CUBE), sampled_words(f"{part}leaves"), directory)

    def leaf_resources(self, part: str = "") -> dict[str, Any]:
        """What to bind to these, until the next build."""
        found = {"cube": self._cube, "leaves": self.octree.leaves.resource, "directory": self.octree.directory}
        return {f"{part}{name}": resource for name, resource in found.items()}

    def build(
        self, profiler: Profiler, scene: GpuScene, grid: Grid, peak: float = 0.0, ids: np.ndarray | None = None,
        near: np.ndarray | None = None, region: Region | None = None,
    ) -> bool:  # fmt: skip
        """Build it anew in the voxels of `grid`, 2^depth along each side. Inside a frame of `profiler`; the host waits
        three times. ids: uint32, which triangles (`triangle_ids`), by default all that is drawn of `scene`.  near:
        uint32, for what moves: which triangles of what is static may lie in nodes of level 0 with `ids`.  region: a box
        that holds all fragments of these nodes.

        Returns whether the textures that are read are others than before: where this is of what moves, the light of
        what is static is then to be filtered anew. Raises DeviceError when the scene needs more nodes than there can
        be, ValueError for another grid.
        """
        if grid.n != 1 << self.depth:
            raise ValueError(f"an octree of depth {self.depth} has {1 << self.depth} voxels a side, not {grid.n}")
        self.grid, self.peak = grid, peak
        before = self.bricks.made
        cube, occupied = self._voxeliser.cube(grid, peak, region), self.octree.occupied()
        first = triangle_ids(scene) if ids is None else ids
        both = first if near is None else np.concatenate([first, near])
        triangles = self._voxeliser.triangles(profiler, scene, both, cube)
        with profiler.stage("fragments") as stage:
            self._voxeliser.mark(stage, scene, triangles, cube, occupied, len(first))
        self.octree.build(profiler, occupied)
        counts = self.octree.counts
        self.voxels.need(counts.voxels)
        self._cube = self._voxeliser.cube(grid, peak, first_leaf=counts.levels[0][0])
        with profiler.stage("voxels") as stage:
            self.bricks.make_room(stage)
            self._sum(stage, scene, triangles, region)
        with profiler.stage("averaging") as stage:
            self.bricks.average(stage)
        self.bricks.number(profiler)
        self.filtering.updates.make_room()
        with profiler.stage("edge copy") as stage:
            if self.static and self.bricks.made != before:
                self.static.filtering.surfaces(stage)
            self.filtering.surfaces(stage)
            self.filtering.everything(stage)
        return self.bricks.made != before

    def _sum(self, stage: Any, scene: GpuScene, triangles: Triangles, region: Region | None) -> None:
        """As many voxels at a time as there is room for sums."""
        counts, size = self.octree.counts, 4 * self._voxeliser.words_of(scene.has_emission)
        room = max(1, min(counts.voxels, _SUMS_BYTES // size))
        sums = self.device.buffer("voxel build", size=room * size)
        first_leaf, leaves = counts.levels[0]
        beside = self.static.leaf_resources("static_") if self.static else {}
        for first in range(0, counts.voxels, room):
            cube = self._voxeliser.cube(self.grid, self.peak, region, first, room, first_leaf)
            stage.encoder.clear_buffer(sums)
            self._voxeliser.accumulate(stage, scene, triangles, cube, sums, **beside)
            self._surfaces[scene.has_emission].run(
                stage, threads(OWN * leaves), parameters=parameters(self.device, leaves, first_leaf), cube=cube,
                leaves=self.octree.leaves.resource, sums=sums, voxels=self.voxels.resource,
                facing=self.bricks.facing.resource,
            )  # fmt: skip

    def pools(self) -> dict[str, dict[str, int]]:
        """How full each pool is (Technique.pools)."""
        all_pools = self.octree.leaves, self.voxels, self.bricks.facing, self.bricks.owners
        return {pool.name: pool.fullness for pool in all_pools}

    def codes(self) -> np.ndarray:
        """The code of each node, uint32 (nodes,); see codes.wgsl."""
        read = np.frombuffer(self.device.queue.read_buffer(self.octree.codes.resource), np.uint32)
        return read[: self.octree.counts.nodes]
