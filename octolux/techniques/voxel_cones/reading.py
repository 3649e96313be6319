"""How shaders read octrees' bricks: file, bindings and resources of `sample_voxels` and `is_empty` (octree.wgsl)."""

from __future__ import annotations

from typing import Any

from ...gpu.bindings import Binding, sampler, texture
from ...gpu.device import Device
from ...gpu.records import sampled_records
from .bricks import NODE, Bricks
from .octree import directory_binding

FILE = "techniques/voxel_cones/octree.wgsl"
STRUCTS = (NODE,)
PARTS = ("", "moving_")
"""What names begin with of what is static, and of what moves."""


class Reading:
    """Of what is static and, beside it, of what moves, whose octrees have the same depth and cube. A storage texture
    each: the directories.

    bindings, structs, values: for the passes. Raises ValueError for octrees of other depths.
    """

    structs = STRUCTS
    file = FILE

    def __init__(self, device: Device, *octrees: Bricks):
        depths = {bricks.octree.depth for bricks in octrees}
        if not 1 <= len(octrees) <= len(PARTS) or len(depths) > 1:
            raise ValueError(
                f"one or two octrees of one depth are read together, not {len(octrees)} of {sorted(depths)}"
            )
        self._octrees = dict(zip(PARTS, octrees, strict=False))
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear")
        self.bindings: list[Binding] = [sampler("brick_sampler")]
        for part in self._octrees:
            self.bindings += [
                directory_binding(f"{part}directory"), sampled_records(f"{part}nodes", NODE),
                texture(f"{part}bricks", "float", "3d"),
            ]  # fmt: skip
        self.values: dict[str, Any] = {**octrees[0].octree.values, "reads": ("nodes",), "parts": tuple(self._octrees)}

    @property
    def resources(self) -> dict[str, Any]:
        """What to bind to `bindings`, until the next build."""
        found = {"brick_sampler": self._sampler}
        for part, bricks in self._octrees.items():
            found[f"{part}directory"] = bricks.octree.directory
            found[f"{part}nodes"], found[f"{part}bricks"] = bricks.nodes.resource, bricks.bricks.resource
        return found
