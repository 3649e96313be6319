"""What voxels of level 0 hold of surfaces (techniques/voxel_cones/voxels/voxeliser), against simulator/voxels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import scene_of
from voxel_scenes import BYTE, grid_of, random_scene, reference, two_materials
from voxel_tools import ROUNDING, built, leaves_of, mesh_of, random_triangles, read, unit_normals

from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance
from octolux.simulator.grid import Grid
from octolux.simulator.tonemap import srgb_decode
from octolux.simulator.voxels.fragments import dominant_axis, fragments
from octolux.techniques.voxel_cones.voxels import structure
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree

OFF_DIAGONAL = ~np.eye(16, dtype=bool)  # along it two triangles share a voxel, each with its own middle


def test_points_of_surfaces_find_their_voxels(device):
    """Light that falls on a triangle lies in the voxel that has the triangle's fragment of that column."""
    grid, rng = grid_of(6), np.random.default_rng(14)
    corners = random_triangles(grid, 200, 9.0, 14)
    octree = built(device, scene_of([mesh_of(corners)]), grid)
    weights = rng.dirichlet((1.0, 1.0, 1.0), (len(corners), 20))
    points = np.einsum("tmw,twk->tmk", weights, corners).reshape(-1, 3)
    triangle = np.repeat(np.arange(len(corners)), 20)
    cells, number, some = leaves_of(octree, points, unit_normals(corners)[triangle])
    made = fragments(corners, grid)
    axes = dominant_axis(unit_normals(corners))
    columns = {(t, *np.delete(v, axes[t])): v for t, v in zip(made.triangle, made.voxel, strict=True)}
    at = grid.to_cells(points)
    clear = (np.abs(at - np.round(at)) > ROUNDING).all(axis=1)
    matched = 0
    for i in np.flatnonzero(clear):
        voxel = columns.get((triangle[i], *np.delete(np.floor(at[i]).astype(int), axes[triangle[i]])))
        if voxel is not None:
            assert some[i] and (cells[i] == voxel).all()
            matched += 1
    assert matched > 0.9 * clear.sum() > 0.9**2 * len(points)  # of the others no sample of the column is covered
    assert len(set(number[some])) == len({tuple(c) for c in cells[some]}) and number.max() < octree.octree.counts.voxels


def test_moved_instances_are_voxelised_where_they_are(device):
    grid = grid_of(5)
    corners = random_triangles(grid, 30, 8.0, 8)
    transform = np.eye(4)
    transform[:3, :3] = np.diag([0.5, -0.5, 0.5])  # it mirrors
    transform[:3, 3] = np.array(grid.origin) + 8 * grid.cell_size
    moved = ((corners - transform[:3, 3]) * np.array([2.0, -2.0, 2.0])).astype(np.float32)
    placed = moved.astype(np.float64) @ transform[:3, :3].T + transform[:3, 3]
    scene = scene_of([mesh_of(moved.astype(np.float64))], two_materials(), instances=[Instance(0, transform)])
    found = read(built(device, scene, grid))
    # The winding turns round in a mirror, and outward stays outward.
    expected = reference(placed[:, ::-1], two_materials(), np.zeros(len(placed), int), grid)
    np.testing.assert_array_equal(found.touched, expected.touched)
    np.testing.assert_allclose(found.facing, expected.facing, atol=BYTE + 30 / 8192)


def facing_quad(grid: Grid, first: int, edge: int) -> tuple[np.ndarray, np.ndarray]:
    """Two triangles of a square across z that covers edge^2 columns of voxels, and their uvs."""
    low = np.array(grid.origin) + grid.cell_size * np.array([first, first, 4.5])
    square = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=np.float64)
    corners = low + np.column_stack([square * edge * grid.cell_size, np.zeros(4)])
    order = np.array([[0, 1, 2], [0, 2, 3]])
    return corners[order], square[order]


def test_colours_are_means_of_what_a_voxel_shows(device):
    """Of a texture with 16 texels to a voxel's edge each voxel has the mean of its 256, in linear light."""
    grid, rng = Grid((0.0, 0.0, 0.0), 0.25, 32), np.random.default_rng(9)
    brightest = rng.integers(1, 256, (16, 16, 3)).repeat(16, axis=0).repeat(16, axis=1)
    pixels = np.full((256, 256, 4), 255, np.uint8)
    pixels[..., :3] = rng.integers(0, brightest + 1)
    corners, uvs = facing_quad(grid, 8, 16)
    material = Material(base_color_texture=Texture(Image(pixels)), specular=0.0)
    found = read(built(device, scene_of([mesh_of(corners, uvs=uvs)], [material]), grid))
    means = srgb_decode(pixels[..., :3] / 255.0).reshape(16, 16, 16, 16, 3).mean(axis=(1, 3))
    # The mip level is stored in 8 bits of sRGB, the voxel in 8 of the square root; samples lie aside by 2^-10 voxels.
    error = (found.albedo[4, 8:24, 8:24] - means)[OFF_DIAGONAL]
    assert np.abs(error).max() < 5 * BYTE + 2.0**-9 and means.std() > 0.05


def test_masks_count_for_what_they_leave(device):
    """A mask whose alpha is 0 or 1 leaves its mean; what is under the cutoff everywhere leaves nothing but the node."""
    grid = Grid((0.0, 0.0, 0.0), 0.25, 32)
    pixels = np.full((256, 256, 4), 255, np.uint8)
    pixels[:, ::4, 3] = 0  # a quarter of each voxel
    corners, uvs = facing_quad(grid, 8, 16)
    mask = Material(base_color_texture=Texture(Image(pixels)), alpha_mode="mask", specular=0.0)
    found = read(built(device, scene_of([mesh_of(corners, uvs=uvs)], [mask]), grid))
    np.testing.assert_allclose(found.facing[4, 8:24, 8:24, 4], 0.75, atol=2 * BYTE + 2.0**-9)
    gone = replace(mask, base_color_texture=None, alpha=0.3)
    found = read(built(device, scene_of([mesh_of(corners)], [gone]), grid))
    assert found.touched[4, 8:24, 8:24].all() and not found.facing.any()


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 30, 12.0), (5, 300, 4.0), (6, 60, 40.0), (6, 3000, 1.5)])
def test_voxels_of_random_triangles(device, depth, count, size):
    """The same voxels are occupied, with the same shares, albedo and emission: few large triangles, and many small."""
    grid = grid_of(depth)
    scene, expected = random_scene(grid, count, size, depth, emissive=(30.0, 5.0, 0.0), alpha=0.5, alpha_mode="blend")
    found = read(built(device, scene, grid, peak=30.0))
    assert expected.touched.sum() > 100
    np.testing.assert_array_equal(found.touched, expected.touched)
    # Shares are sums of fragments rounded by 1/8192, of which some tens are in a voxel, then stored in 8 bits.
    np.testing.assert_allclose(found.facing, expected.facing, atol=BYTE + 30 / 8192)
    # Square roots of albedo in 8 bits; sums are rounded by 1/8192 of a layer, against the least area, 1/16 half clear.
    np.testing.assert_allclose(found.albedo, expected.albedo, atol=2 * BYTE + 32 * 1.01 / 8192)
    np.testing.assert_allclose(30.0 * found.emission, expected.emission, atol=30.0 / 256 + 30.0 * 32 / 8192)


def test_sums_in_several_rounds(device, monkeypatch):
    """Where there is no room for the sums of all voxels at a time the result is the same."""
    grid = grid_of(5)
    scene, _ = random_scene(grid, 100, 8.0, 7)
    whole = read(built(device, scene, grid))
    monkeypatch.setattr(structure, "_SUMS_BYTES", 4096)
    parts = read(built(device, scene, grid))
    for a, b in zip(vars(whole).values(), vars(parts).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_the_inside_of_solids(device):
    """With `interior` single-sided surfaces are as double-sided ones are without, to the bit."""
    grid = grid_of(5)
    found = []
    for double_sided in (False, True):
        scene, _ = random_scene(grid, 200, 6.0, 12, double_sided=double_sided)
        octree = VoxelOctree(device, 5, interior=not double_sided)
        scene.materials[0] = replace(scene.materials[0], double_sided=double_sided)
        found.append(read(built(device, scene, grid, octree)))
    for one, other in zip(*(vars(each).values() for each in found), strict=True):
        np.testing.assert_array_equal(one, other)
    assert (found[0].facing[..., 0::2] * found[0].facing[..., 1::2]).any()
