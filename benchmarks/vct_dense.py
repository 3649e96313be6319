"""The device's octree and bricks beside the dense float64 grid of simulator/voxels, on scenes of random triangles."""

from __future__ import annotations

import numpy as np

from octolux.simulator.voxels.pyramid import facing_levels, intensity_levels, sample
from octolux.simulator.voxels.surfaces import DIRECTIONS

from . import from_tests  # noqa: F401
from .lab import device
from .registry import at_most, figure

import voxel_scenes  # isort: skip
import voxel_tools  # isort: skip

SCENES = ((4, 20, 12.0), (5, 300, 4.0), (6, 60, 40.0))
"""Depth, triangles, and voxels that these measure: few large ones, many small ones, and few that cross all of it."""
BRIGHTEST = 40.0


@figure("vct_octree", group="vct", unit={"voxels": "voxels"}, bound={
    "voxels": at_most(0.0), "opacity": at_most(1e-2), "light": at_most(1e-2),
})  # fmt: skip
def vct_octree() -> dict[str, float]:
    """Octree and bricks beside a dense grid: voxels that are in one alone; and of filtered values on all levels, near
    surfaces and far, the largest difference of opacity, and of light over the brightest."""
    found = {"voxels": 0.0, "opacity": 0.0, "light": 0.0}
    for depth, count, size in SCENES:
        for name, value in _differences(depth, count, size).items():
            found[name] = max(found[name], value)
    return found


def _differences(depth: int, count: int, size: float) -> dict[str, float]:
    grid, rng = voxel_scenes.grid_of(depth), np.random.default_rng(depth)
    scene, expected = voxel_scenes.random_scene(grid, count, size, seed=100 + depth)
    octree = voxel_tools.built(device(), scene, grid)
    there = voxel_tools.read(octree).touched
    light = BRIGHTEST * rng.uniform(size=(*expected.facing.shape, 3)) ** 2 * expected.facing[..., None]
    voxel_tools.shine(octree, light, unit=1.25 * BRIGHTEST)
    points, towards = voxel_scenes.near_and_far(expected, rng)
    against = np.maximum(-towards @ DIRECTIONS.T, 0.0)
    facings, off = facing_levels(expected.facing), {"opacity": 0.0, "light": 0.0}
    for level, (facing, intensity) in enumerate(zip(facings, intensity_levels(light, facings), strict=True)):
        values, _ = voxel_tools.sampled(octree, points, level, towards)
        at = points / 2.0**level
        opacity = (against * sample(facing, at)).sum(axis=1)
        sent = np.einsum("mw,mwk->mk", against, sample(intensity, at))
        off["opacity"] = max(off["opacity"], float(np.abs(values[:, 3] - opacity).max()))
        off["light"] = max(off["light"], float(np.abs(values[:, :3] - sent).max()) / BRIGHTEST)
    return {"voxels": float((there != expected.touched).sum()), **off}
