"""How shaders read octrees' bricks: file, bindings and resources of `sample_voxels` and `is_empty` (octree.wgsl)."""

from __future__ import annotations

from typing import Any

from ....gpu.bindings import Binding, sampler, texture
from ....gpu.device import Device
from ....gpu.records import records
from ....simulator.voxels.lobes import LEAST
from ..octree.octree import directory_binding
from .bricks import NODE, Bricks

FILE = "techniques/voxel_cones/octree/octree.wgsl"
STRUCTS = (NODE,)


class Reading:
    """Of what is static and, as long as there is one, of `moving`, the octree of what moves beside it: where that has
    nodes these are read, which hold what is static there too. Shaders know nothing of it: both stand in the same
    textures, and one directory names the nodes of both (merge_directory.wgsl).

    bindings, structs, values: for the passes. Two of the bindings are storage textures: what is read most often.
    """

    structs = STRUCTS
    file = FILE

    def __init__(self, device: Device, static: Bricks):
        self.static = static
        self.moving: Bricks | None = None
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear")
        self.bindings: list[Binding] = [
            sampler("brick_sampler"), directory_binding(), records("nodes", NODE), texture("bricks", "float", "3d"),
        ]  # fmt: skip
        self.values: dict[str, Any] = {**static.octree.values, "reads": ("nodes",),
                                       "sample": static.representation.file("sample"), "least": LEAST}  # fmt: skip

    @property
    def resources(self) -> dict[str, Any]:
        """What to bind to `bindings`, until the next build."""
        static = self.static
        return {
            "brick_sampler": self._sampler, "directory": (self.moving or static).octree.merged,
            "nodes": static.nodes.resource, "bricks": static.bricks.resource,
        }  # fmt: skip
