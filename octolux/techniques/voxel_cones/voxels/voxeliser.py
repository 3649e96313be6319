"""From triangles on the device to voxel fragments and their voxels (VCT 5.2.1; simulator/voxels/fragments.py)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ....frame.shader_values import surface_values
from ....frame.structs import VIEW
from ....gpu.bindings import Binding, atomic_words, storage, storage_rw, storage_words, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.passes import ComputePass
from ....gpu.profiler import Profiler
from ....gpu.records import word_texture, words, words_out
from ....gpu_scene.clusters import CLUSTER_TRIANGLES
from ....gpu_scene.gpu_scene import GpuScene
from ....gpu_scene.structs import INSTANCE, ITEM, TRIANGLE, VERTEX
from ....raytracing.scan import BLOCK, PARAMETERS, PrefixSum
from ....simulator.grid import Grid
from ....simulator.surfels import ASIDE
from ....simulator.voxels.fragments import BIAS, SAMPLES
from ..octree.octree import Octree, directory_binding
from ..octree.pools import ROW, WORKGROUP, parameters, threads

Region = tuple[np.ndarray, np.ndarray]
"""Lowest and highest corner of a box, float64 (3,), m."""
TILE = 4  # columns along the edge of what one thread has of a triangle
# The cube of voxels: low, m; voxels to a metre; and of the voxels that are summed the first, and for how many there is
# room. emission_scale: from nits to the sums' unit.  begin, last: of the columns in which fragments are sought.
CUBE = Struct(
    "Cube", low="vec3f", scale="f32", begin="vec3i", first="u32", last="vec3i", room="u32", first_leaf="u32",
    emission_scale="f32",
)  # fmt: skip
LAYER = 1 << 12
"""What a surface that covers all of a voxel's section adds to sums: 2^20 layers fit into 32 bits, and a sixteenth of
one, the least there is, is rounded by 1/512 of it."""
EMISSION_LAYER = 1 << 18
"""The same for the brightest emission of the scene, whose sums must hold dim ones beside it: 2^14 layers."""
SUM_WORDS, EMISSION_WORDS = 10, 3
"""u32 of a voxel's sums: six ways surfaces look, albedo, area; and emission, if there is any."""


@dataclass(frozen=True, eq=False)
class Triangles:
    """count: of triangles.  ids: texture of words, their numbers in the visibility buffer, less one.  starts: texture
    of words, the first tile of each and behind the last the number of all, `tiles`."""

    count: int
    ids: Any
    starts: Any
    tiles: int


class Voxeliser:
    """Marks the voxels that triangles lie in, then, when these have numbers, sums what lies there. Of an octree of what
    moves these are voxels in whose nodes something lies that does. static: how the leaves of what is static are looked
    up then (`VoxelOctree.other_leaf_bindings`, under names with "static_"). interior: single-sided surfaces have backs
    too (simulator/voxels/surfaces.py)."""

    def __init__(
        self, device: Device, octree: Octree, texture_level: float = 0.0, interior: bool = False,
        static: tuple[Binding, ...] = (),
    ):  # fmt: skip
        self._static, self._interior = static, interior
        self.device, self.octree, self._texture_scale = device, octree, 2.0**texture_level
        self._sums = PrefixSum(device, "u32")
        self._accumulate: ComputePass | None = None
        self._accumulate_of: tuple[int, int] | None = None
        self.values: dict[str, Any] = {
            "n": 1 << octree.depth, "samples": SAMPLES, "aside": ASIDE, "bias": BIAS, "tile": TILE, "row": ROW,
        }  # fmt: skip
        kinds = {"vertices": VERTEX, "triangles": TRIANGLE, "instances": INSTANCE, "items": ITEM}
        scene = [storage_words(name, kind) for name, kind in kinds.items()]
        self._given = [uniform("parameters", PARAMETERS), uniform("cube", CUBE)]
        self._geometry = scene
        self._fixed: dict[str, Any] = {
            "structs": [*kinds.values(), PARAMETERS, CUBE], "workgroup": WORKGROUP, "depth": octree.depth,
            "cluster_bits": CLUSTER_TRIANGLES.bit_length() - 1, **self.values,
        }  # fmt: skip
        folder = "techniques/voxel_cones/voxels"
        self._tiles = ComputePass(
            device, "tiles", f"{folder}/tiles.wgsl",
            [*scene, *self._given, words("ids"), storage_rw("values", "u32", "write")], **self._fixed,
        )  # fmt: skip
        self._starts = ComputePass(
            device, "starts", f"{folder}/starts.wgsl",
            [self._given[0], storage("values", "u32"), storage("totals", "u32"), words_out("starts")],
            structs=[PARAMETERS], workgroup=WORKGROUP, row=ROW, block=BLOCK,
        )  # fmt: skip
        self._mark = self._over_tiles([atomic_words("occupied", "u32")], listed=False, near=octree.moving)

    def _over_tiles(self, out: list[Binding], listed: bool, near: bool = False) -> ComputePass:
        given = [*self._geometry, *self._given, words("ids"), words("starts")]
        return ComputePass(
            self.device, "fragments", "techniques/voxel_cones/voxels/mark.wgsl", [*given, *out],
            starts=True, listed=listed, near=near, **self._fixed,
        )  # fmt: skip

    def cube(
        self, grid: Grid, peak: float, region: Region | None = None, first: int = 0, room: int = 0, first_leaf: int = 0
    ) -> Any:  # fmt: skip
        """A uniform buffer of CUBE. peak: the scene's brightest emission, nits.  region: m, by default the cube."""
        scale = EMISSION_LAYER / LAYER / peak if peak > 0.0 else 0.0
        sides = [np.clip(np.floor(grid.to_cells(side)), 0, grid.n - 1) for side in region or ()]
        begin, last = sides or ((0,) * 3, (grid.n - 1,) * 3)
        packed = CUBE.pack(low=grid.origin, scale=1.0 / grid.cell_size, first=first, room=room, first_leaf=first_leaf,
                           emission_scale=scale, begin=begin, last=last)  # fmt: skip
        return self.device.uniform("voxel build", packed)

    def triangles(self, profiler: Profiler, scene: GpuScene, ids: np.ndarray, cube: Any) -> Triangles:
        """Cut triangles into tiles of columns. ids: uint32 (count,). The host waits, to learn how many tiles."""
        count, device = len(ids), self.device
        textures = [word_texture(device, "voxel build", count + 1, data) for data in (ids.astype(np.uint32), None)]
        sums, given = self._sums.sums(max(1, count)), parameters(device, count)
        with profiler.stage("fragments") as stage:
            self._tiles.run(stage, threads(count), parameters=given, cube=cube, ids=textures[0], values=sums.values,
                            **geometry_resources(scene))  # fmt: skip
            self._sums.run(stage, sums, count, given)
            self._starts.run(stage, threads(count + 1), parameters=given, values=sums.values, totals=sums.totals,
                             starts=textures[1])  # fmt: skip
        profiler.submit()
        return Triangles(count, textures[0], textures[1], self._sums.total(sums, count)[0])

    def mark(
        self, stage: Any, scene: GpuScene, triangles: Triangles, cube: Any, occupied: Any, moving: int
    ) -> None:
        """Set the bits of voxels that have fragments (`Octree.occupied`). moving: how many of the first triangles of an
        octree of what moves do so; of the others, nothing is marked but in the same nodes of level 0."""
        rounds = range(1 + self.octree.moving) if triangles.tiles else ()
        for first in rounds:
            given = parameters(self.device, triangles.count, first, second=triangles.tiles, third=moving)
            self._mark.run(stage, threads(triangles.tiles), cube=cube, ids=triangles.ids, starts=triangles.starts,
                           parameters=given, occupied=occupied, **geometry_resources(scene))  # fmt: skip

    @staticmethod
    def words_of(emissive: bool) -> int:
        """u32 of a voxel's sums."""
        return SUM_WORDS + EMISSION_WORDS * emissive

    def accumulate(
        self, stage: Any, scene: GpuScene, triangles: Triangles, cube: Any, sums: Any, **static: Any
    ) -> None:  # fmt: skip
        """Add what fragments bring to `sums`, u32 [voxel][words], for the voxels that `cube` names. static: what to
        bind to the bindings of that name."""
        key = (id(scene), scene.version)
        if self._accumulate is None or self._accumulate_of != key:
            self._accumulate, self._accumulate_of = self._made(scene), key
        if triangles.tiles:
            self._accumulate.run(
                stage, threads(triangles.tiles), scene.resources, cube=cube, ids=triangles.ids, starts=triangles.starts,
                parameters=parameters(self.device, triangles.count, second=triangles.tiles), sums=sums,
                directory=self.octree.directory, leaves=self.octree.leaves.resource, **static,
            )  # fmt: skip

    def _made(self, scene: GpuScene) -> ComputePass:
        bindings = [*self._given, words("ids"), words("starts"), words("leaves"), directory_binding(),
                    atomic_words("sums", "u32"), *self._static]  # fmt: skip
        parts = ("", "static_") if self._static else ("",)
        values = {**surface_values(scene), **self.octree.values, **self.values, "parts": parts}
        return ComputePass(
            self.device, "fragment values", "techniques/voxel_cones/voxels/accumulate.wgsl", bindings,
            structs=[PARAMETERS, CUBE, VIEW], shared=scene.bindings, workgroup=WORKGROUP, starts=True,
            layer=float(LAYER), words=self.words_of(scene.has_emission), texture_scale=self._texture_scale,
            interior=self._interior,
            **values,
        )  # fmt: skip


def geometry_resources(scene: GpuScene) -> dict[str, Any]:
    """What passes over tiles read of a scene."""
    return {name: scene.resources[name] for name in ("vertices", "triangles", "instances", "items")}
