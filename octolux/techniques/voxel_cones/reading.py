"""How shaders read octrees' bricks: file, bindings and resources of `sample_voxels` and `is_empty` (octree.wgsl)."""

from __future__ import annotations

from typing import Any

from ...gpu.bindings import Binding, sampler, texture
from ...gpu.device import Device
from ...gpu.records import records, sampled_records
from ...simulator.voxels.lobes import LEAST
from .bricks import NODE, Bricks
from .octree import directory_binding

FILE = "techniques/voxel_cones/octree.wgsl"
STRUCTS = (NODE,)
PARTS = ("", "moving_")
"""What names begin with of what is static, and of what moves."""


class Reading:
    """Of what is static and of what moves, whose octrees have the same depth and cube: where the latter has nodes these
    are read, which hold what is static there too.

    bindings, structs, values: for the passes. Two of the bindings are storage textures: what is read most often.
    Raises ValueError for octrees of other depths or representations.
    """

    structs = STRUCTS
    file = FILE

    def __init__(self, device: Device, static: Bricks, moving: Bricks | None = None):
        octrees = [static] if moving is None else [static, moving]
        depths = [bricks.octree.depth for bricks in octrees]
        if len(set(depths)) > 1:
            raise ValueError(f"octrees that are read together have one depth, not {depths}")
        if moving and moving.representation != static.representation:
            raise ValueError("octrees that are read together keep light alike")
        self._octrees = dict(zip(PARTS, octrees, strict=False))
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear")
        self.bindings: list[Binding] = [sampler("brick_sampler"), directory_binding(), records("nodes", NODE)]
        if moving:
            self.bindings += [texture("moving_directory", "uint"), sampled_records("moving_nodes", NODE)]
        self.bindings += [texture(f"{part}bricks", "float", "3d") for part in self._octrees]
        self.values: dict[str, Any] = {**static.octree.values, "reads": ("nodes",), "parts": tuple(self._octrees),
                                       "sample": static.representation.file("sample"), "least": LEAST}  # fmt: skip

    @property
    def resources(self) -> dict[str, Any]:
        """What to bind to `bindings`, until the next build."""
        found = {"brick_sampler": self._sampler}
        for part, bricks in self._octrees.items():
            found[f"{part}directory"] = bricks.octree.shown
            found[f"{part}nodes"], found[f"{part}bricks"] = bricks.nodes.resource, bricks.bricks.resource
        return found
