"""The voxel octree (techniques/voxel_cones/structure) against the dense float64 voxels of simulator/voxels."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import random_directions, scene_of
from voxel_tools import (
    ROUNDING,
    built,
    cells_of,
    leaves_of,
    mesh_of,
    random_triangles,
    read,
    sampled,
    shine,
    unit_normals,
)

from octolux.gpu.device import DeviceError
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.raytracing.bvh import triangle_ids
from octolux.scene.builtin.shapes import box
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance
from octolux.simulator.grid import Grid
from octolux.simulator.tonemap import srgb_decode
from octolux.simulator.voxels.fragments import dominant_axis, fragments
from octolux.simulator.voxels.pyramid import facing_levels, intensity_levels, sample
from octolux.simulator.voxels.surfaces import DIRECTIONS, Voxels, around, voxelise
from octolux.techniques.voxel_cones import structure
from octolux.techniques.voxel_cones.pools import Pool
from octolux.techniques.voxel_cones.reading import Reading
from octolux.techniques.voxel_cones.structure import VoxelOctree

RED, GREEN = (0.8, 0.1, 0.05), (0.1, 0.6, 0.3)
BYTE = 0.5 / 255
WITHIN = 1e-2  # what the filtered values may differ by (issue: "filtered values within 1e-2")


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
    return [Material(base_color=RED, specular=0.0), Material(base_color=GREEN, double_sided=True, **second)]


def random_scene(grid: Grid, count: int, size: float, seed: int, **second):
    """A scene of random triangles with two materials, and its reference."""
    corners = random_triangles(grid, count, size, seed)
    of = np.arange(len(corners)) % 2
    materials = two_materials(**second)
    scene = scene_of([mesh_of(corners[of == m], m) for m in (0, 1)], materials)
    order = np.argsort(of, kind="stable")
    return scene, reference(corners[order], materials, of[order], grid)


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


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 20, 12.0), (5, 300, 4.0), (6, 60, 40.0)])
def test_filtered_values(device, depth, count, size):
    """On every level trilinear values are those of the dense pyramid, near surfaces and far from them, also where nodes
    are missing (VCT figure 5.10)."""
    grid = grid_of(depth)
    scene, expected = random_scene(grid, count, size, 10 + depth)
    octree = built(device, scene, grid)
    points, towards = near_and_far(expected, np.random.default_rng(1))
    for level, facing in enumerate(facing_levels(expected.facing)):
        found, some = sampled(octree, points, level, towards)
        exact = (np.maximum(-towards @ DIRECTIONS.T, 0.0) * sample(facing, points / 2.0**level)).sum(axis=1)
        np.testing.assert_allclose(found[:, 3], exact, atol=WITHIN, err_msg=f"level {level}")
        assert not found[:, :3].any() and not exact[~some].any(), "a node is missing where something is"
        assert exact.max() > 3 * WITHIN


def near_and_far(voxels: Voxels, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Points (2000, 3) in voxels around what is touched, and anywhere; and unit directions."""
    n = len(voxels.touched)
    near = np.argwhere(voxels.touched)[:, ::-1]
    near = near[rng.integers(0, len(near), 1500)] + rng.uniform(-1.5, 2.5, (1500, 3))
    points = np.clip(np.concatenate([near, rng.uniform(0, n, (500, 3))]), 1e-3, n - 1e-3)
    return points, random_directions(rng, len(points))


@pytest.mark.parametrize(("depth", "count", "size"), [(4, 20, 12.0), (6, 60, 40.0)])
def test_filtered_light(device, depth, count, size):
    """Light that voxels of level 0 send six ways comes back from every level as from the dense pyramid."""
    grid, rng = grid_of(depth), np.random.default_rng(7)
    scene, expected = random_scene(grid, count, size, 20 + depth)
    octree = built(device, scene, grid)
    radiance = 40.0 * rng.uniform(size=(*expected.facing.shape, 3)) ** 2
    light = radiance * expected.facing[..., None]
    shine(octree, light, unit=50.0)
    points, towards = near_and_far(expected, rng)
    facings = facing_levels(expected.facing)
    for level, intensity in enumerate(intensity_levels(light, facings)):
        found, _ = sampled(octree, points, level, towards)
        against = np.maximum(-towards @ DIRECTIONS.T, 0.0)
        exact = np.einsum("mw,mwk->mk", against, sample(intensity, points / 2.0**level))
        np.testing.assert_allclose(found[:, :3], exact, atol=40.0 * WITHIN, err_msg=f"level {level}")
        assert exact.max() > 3 * 40.0 * WITHIN


def test_only_what_is_touched_is_filtered(device):
    """Light that changes in a corner of the scene: the same as when all is filtered, from fewer bricks."""
    grid, rng = grid_of(6), np.random.default_rng(8)
    scene, expected = random_scene(grid, 300, 5.0, 30)
    octree = built(device, scene, grid)
    light = 9.0 * rng.uniform(size=(*expected.facing.shape, 3)) * expected.facing[..., None]
    shine(octree, light, unit=10.0)
    first, count = octree.octree.counts.levels[0]
    cells = cells_of(octree.codes()[first : first + count])
    touched = (cells < 10).all(axis=1)
    x, y, z = np.concatenate([2 * cells[touched] + [c & 1, c >> 1 & 1, c >> 2] for c in range(8)]).T
    light[z, y, x] = light[z, y, x][:, ::-1] * 0.3
    shine(octree, light, 10.0, touched)
    updated = int(np.frombuffer(device.queue.read_buffer(octree.filtering.update_count), np.uint32)[0])
    points, towards = near_and_far(expected, rng)
    partly = [sampled(octree, points, level, towards)[0] for level in range(6)]
    shine(octree, light, unit=10.0)
    for level in range(6):
        np.testing.assert_array_equal(partly[level], sampled(octree, points, level, towards)[0])
    assert 0 < updated < 0.4 * octree.bricks.bricks.used
    assert not np.frombuffer(device.queue.read_buffer(octree.bricks.touched.resource), np.uint32).any()


def test_no_jump_at_the_faces_of_bricks(device):
    """Values on both sides of faces between bricks, and between a brick and nothing, are the same."""
    grid = grid_of(5)
    scene, _ = random_scene(grid, 40, 10.0, 3)
    octree = built(device, scene, grid)
    rng = np.random.default_rng(2)
    for level in range(4):
        cells = rng.integers(0, (grid.n >> level) // 2 - 1, (2000, 3))
        middle = 2.0 * (cells + 1) + 0.5  # the upper corner of a brick
        across = np.eye(3)[rng.integers(0, 3, len(cells))]
        at = middle - (1 - across) * rng.uniform(0, 2, (len(cells), 3))
        towards = random_directions(rng, len(cells))
        below, above = (sampled(octree, 2.0**level * (at + s * 1e-4 * across), level, towards)[0] for s in (-1, 1))
        # Two voxels may differ by 1 for each of three ways, and 2e-4 of them lie between; the filter's weights have 8
        # bits, as texels have.
        np.testing.assert_allclose(below[:, 3], above[:, 3], atol=np.sqrt(3) * (2e-4 + 2 / 256))
        assert level == 3 or (below[:, 3] > 0.1).any()


def test_nodes_of_a_level_stand_together(device):
    """Numbers go by codes, from the root; each level has as many as it says; parents are there."""
    grid = grid_of(6)
    octree = built(device, random_scene(grid, 60, 20.0, 4)[0], grid)
    codes, counts = octree.codes(), octree.octree.counts
    assert np.all(np.diff(codes.astype(np.int64)) > 0) and codes[0] == 1
    for level, (first, count) in enumerate(counts.levels):
        assert np.all(codes[first : first + count].astype(np.int64) >> (3 * (5 - level)) == 1)
    assert set(codes[1:] >> 3) <= set(codes)
    assert sum(count for _, count in counts.levels) == counts.nodes == len(codes)


def test_which_nodes_there_are(device):
    """One for every 3^3 voxels of a brick of which one is occupied, on every level."""
    grid = grid_of(5)
    scene, expected = random_scene(grid, 25, 6.0, 5)
    octree = built(device, scene, grid)
    codes, touched = octree.codes(), expected.touched
    for first, count in octree.octree.counts.levels:
        m = len(touched) // 2
        padded = np.pad(touched, (0, 1))
        needed = np.zeros((m, m, m), bool)
        for offset in np.ndindex(3, 3, 3):
            z, y, x = (slice(o, o + 2 * m - 1, 2) for o in offset)
            needed |= padded[z, y, x]
        x, y, z = cells_of(codes[first : first + count]).T
        there = np.zeros_like(needed)
        there[z, y, x] = True
        np.testing.assert_array_equal(there, needed)
        touched = touched.reshape(m, 2, m, 2, m, 2).any(axis=(1, 3, 5))


def test_the_same_bits_in_two_runs(device):
    grid = grid_of(6)
    scene, _ = random_scene(grid, 3000, 4.0, 6, emissive=(1.0, 2.0, 3.0))
    octree = built(device, scene, grid, peak=3.0)
    first, before = octree.codes().copy(), read(octree)
    facing = bytes(device.queue.read_buffer(octree.bricks.facing.resource))
    again = built(device, scene, grid, octree, peak=3.0)
    np.testing.assert_array_equal(again.codes(), first)
    assert bytes(device.queue.read_buffer(again.bricks.facing.resource)) == facing
    for a, b in zip(vars(before).values(), vars(read(again)).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_sums_in_several_rounds(device, monkeypatch):
    """Where there is no room for the sums of all voxels at a time the result is the same."""
    grid = grid_of(5)
    scene, _ = random_scene(grid, 100, 8.0, 7)
    whole = read(built(device, scene, grid))
    monkeypatch.setattr(structure, "_SUMS_BYTES", 4096)
    parts = read(built(device, scene, grid))
    for a, b in zip(vars(whole).values(), vars(parts).values(), strict=True):
        np.testing.assert_array_equal(a, b)


def test_a_closed_box_is_closed(device):
    """Along each axis both walls of a box stop everything, from within and from without as its sides look; on the next
    level too."""
    grid = around((0, 0, 0), (1, 1, 1), 5)
    for inward, ways in ((False, 0), (True, 1)):
        octree = built(device, scene_of([box((0, 0, 0), (1, 1, 1), inward=inward)]), grid)
        inside = np.random.default_rng(3).uniform(4.0, grid.n - 4.0, (200, 3))
        for axis in range(3):
            for level, walls in ((0, (1.5, grid.n - 1.5)), (1, (1.0, grid.n - 1.0))):
                for side, wall in enumerate(walls):
                    points = inside.copy()
                    points[:, axis] = wall
                    way = 2 * axis + (1 - side if ways == 0 else side)
                    found, _ = sampled(octree, points, level, -DIRECTIONS[way])
                    np.testing.assert_allclose(found[:, 3], 1.0, atol=BYTE + 1 / 256)


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


OFF_DIAGONAL = ~np.eye(16, dtype=bool)  # along it two triangles share a voxel, each with its own middle


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


def test_what_moves_beside_what_is_static(device):
    """Two octrees of a scene's parts hold together what one of the whole does, and are read together."""
    grid, rng = grid_of(5), np.random.default_rng(16)
    scene, expected = random_scene(grid, 200, 5.0, 15)
    gpu_scene = GpuScene(device)
    gpu_scene.sync(scene)
    ids = triangle_ids(gpu_scene)
    octrees = tuple(built(device, scene, grid, ids=some) for some in (ids[::2], ids[1::2]))
    parts = [read(octree) for octree in octrees]
    np.testing.assert_array_equal(parts[0].touched | parts[1].touched, expected.touched)
    both = np.minimum(parts[0].facing + parts[1].facing, 1.0)
    np.testing.assert_allclose(both, expected.facing, atol=2 * BYTE + 30 / 8192)
    points, towards = near_and_far(expected, rng)
    for octree, strength in zip(octrees, (3.0, 7.0), strict=True):
        shine(octree, strength * read(octree).facing[..., None] * np.ones(3), unit=8.0)
    for level in range(5):
        apart = [sampled(octree, points, level, towards) for octree in octrees]
        values, some = sampled(octrees, points, level, towards)
        np.testing.assert_allclose(values, apart[0][0] + apart[1][0], atol=1e-5)
        np.testing.assert_array_equal(some, apart[0][1] | apart[1][1])


def test_octrees_of_other_depths_are_not_read_together(device):
    with pytest.raises(ValueError, match=r"have one depth, not \[4, 5\]"):
        Reading(device, *(VoxelOctree(device, depth).bricks for depth in (4, 5)))


def test_pools_grow_and_say_how_full_they_are(device):
    grid = grid_of(5)
    octree = built(device, random_scene(grid, 5, 3.0, 11)[0], grid)
    small = octree.pools()
    assert all(used == room > 0 for used, room in small.values())
    scene, expected = random_scene(grid, 200, 8.0, 12)
    built(device, scene, grid, octree)
    for name, (used, room) in octree.pools().items():
        assert small[name][1] < used <= room, name
    np.testing.assert_array_equal(read(octree).touched, expected.touched)
    largest = octree.pools()
    built(device, random_scene(grid, 5, 3.0, 11)[0], grid, octree)
    for name, (used, room) in octree.pools().items():
        assert used == small[name][0] and room == largest[name][1], name


def test_a_pool_that_cannot_grow_says_so():
    pool = Pool("nodes", lambda count: count, limit=10)
    assert pool.need(4) and not pool.need(3) and pool.need(9) and pool.capacity == 10
    with pytest.raises(DeviceError, match=r"11 nodes; there can be 10.*smaller depth"):
        pool.need(11)
    assert (pool.used, pool.capacity) == (9, 10)


def test_an_empty_scene_has_no_nodes(device):
    octree = built(device, scene_of([]), grid_of(4))
    assert octree.octree.counts.nodes == 0 and not read(octree).touched.any()
    values, some = sampled(octree, np.full((1, 3), 5.0), 0, (1.0, 0.0, 0.0))
    assert not values.any() and not some.any()


def test_another_grid_is_refused(device):
    octree = VoxelOctree(device, 4)
    with pytest.raises(ValueError, match="16 voxels a side, not 32"):
        built(device, scene_of([]), grid_of(5), octree)
