"""Settings of `voxel-cones`."""

from __future__ import annotations

from dataclasses import dataclass

from ..settings import Settings, setting


@dataclass(frozen=True)
class VoxelConesSettings(Settings):
    """The structure: what is voxelised, and how finely."""

    depth: int = setting(
        8, meaning="levels of the octree: 2^depth voxels along each side of the cube around the scene", unit="levels",
        allowed=[6, 9], cost="each one more takes four times the memory and the time of filtering",
        source="VCT 5.2, tables 6.6 and 6.9",
    )  # fmt: skip
    texture_level: float = setting(
        0.0, meaning="mip level of textures that voxels take their colour from, over that whose texels are as large as "
        "a voxel", unit="levels", allowed=[-4.0, 4.0],
        cost="none; less picks out texels, more blurs over the borders of what a texture shows", source="VCT 5.2.1",
    )  # fmt: skip
