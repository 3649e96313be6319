"""Scenes of random triangles for tests of voxels, and what they are in the dense float64 grid."""

from __future__ import annotations

import numpy as np
from gpu_tools import random_directions, scene_of
from voxel_tools import mesh_of, random_triangles, unit_normals

from octolux.scene.materials import Material
from octolux.simulator.grid import Grid
from octolux.simulator.voxels.fragments import fragments
from octolux.simulator.voxels.surfaces import Voxels, voxelise

RED, GREEN = (0.8, 0.1, 0.05), (0.1, 0.6, 0.3)
BYTE = 0.5 / 255


def grid_of(depth: int) -> Grid:
    return Grid((-1.3, 0.4, 2.1), 0.05, 1 << depth)


def reference(corners: np.ndarray, materials: list[Material], of: np.ndarray, grid: Grid) -> Voxels:
    """Voxels of triangles without textures; of: (T,), their materials."""
    found = fragments(corners, grid)
    used = [materials[m] for m in of[found.triangle]]
    columns = ([m.base_color for m in used], [m.emissive for m in used], [m.alpha for m in used])
    return voxelise(
        found, unit_normals(corners), grid.n, *(np.array(c) for c in columns), [m.double_sided for m in used]
    )


def two_materials(**second) -> list[Material]:
    return [Material(base_color=RED, specular=0.0), Material(base_color=GREEN, **{"double_sided": True, **second})]


def random_scene(grid: Grid, count: int, size: float, seed: int, **second):
    """A scene of random triangles with two materials, and its reference."""
    corners = random_triangles(grid, count, size, seed)
    of = np.arange(len(corners)) % 2
    materials = two_materials(**second)
    scene = scene_of([mesh_of(corners[of == m], m) for m in (0, 1)], materials)
    order = np.argsort(of, kind="stable")
    return scene, reference(corners[order], materials, of[order], grid)


def near_and_far(voxels: Voxels, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Points (2000, 3) in voxels around what is touched, and anywhere; and unit directions."""
    n = len(voxels.touched)
    near = np.argwhere(voxels.touched)[:, ::-1]
    near = near[rng.integers(0, len(near), 1500)] + rng.uniform(-1.5, 2.5, (1500, 3))
    points = np.clip(np.concatenate([near, rng.uniform(0, n, (500, 3))]), 1e-3, n - 1e-3)
    return points, random_directions(rng, len(points))
