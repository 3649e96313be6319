"""What rays meet of surfaces that are not there everywhere, or on one side alone; and that none slips between."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import random_directions, scene_of
from ray_tools import Traced, meet_all, soup, triangle_mesh
from scipy.spatial import ConvexHull

from octolux.raytracing.query import packed_rays
from octolux.scene.builtin.shapes import quad
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene

SQUARE = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]


@pytest.fixture(scope="module")
def traced(device) -> Traced:
    return Traced(device, Scene())


def onto_square(rng, count: int, depth: float = -1.0) -> np.ndarray:
    """Rays along z through even points of the unit square."""
    origins = np.concatenate([rng.uniform(0, 1, (count, 2)), np.ones((count, 1))], axis=1)
    return packed_rays(origins, [[0, 0, depth]])


def checkers(texels: int = 4) -> Image:
    """Opaque and clear in turn, `texels` fields across, each large enough to have even middles."""
    field = np.indices((texels, texels)).sum(axis=0) % 2
    pixels = np.full((64, 64, 4), 255, np.uint8)
    pixels[..., 3] = 255 * np.kron(field, np.ones((64 // texels, 64 // texels)))
    return Image(pixels)


def test_masked_textures(traced):
    """Two checkered squares, one behind the other, and a wall: rays meet the first opaque field in their way."""
    material = Material(alpha_mode="mask", alpha_cutoff=0.5, base_color_texture=Texture(checkers()), double_sided=True)
    moved = [(x, y, -1) for x, y, _ in SQUARE]
    wall = [(x, y, -3) for x, y, _ in SQUARE]
    scene = scene_of([quad(SQUARE), quad(moved), quad(wall, material=1)], [material, Material(double_sided=True)])
    shift = np.eye(4)
    shift[0, 3] = 0.25  # one field: where the first is clear the second is opaque, within what both cover
    scene.instances = [Instance(0), Instance(1, shift), Instance(2)]
    traced.follow(scene)
    rays = onto_square(np.random.default_rng(31), 4000)
    hits = traced.query(rays)
    # The square's texture coordinates run as its corners do; what they say is read back from the mesh.
    uv = _uv_at(scene.meshes[0], rays[:, :2])
    field = 4 * uv
    middle = (np.abs(field - np.round(field)) > 0.1).all(axis=1)  # fields are 16 texels, the filter reaches one
    opaque = np.floor(field).astype(int).sum(axis=1) % 2 == 1
    second = (rays[:, 0] > 0.26) & ~opaque
    expected = np.where(opaque, 1.0, np.where(second, 2.0, 4.0))
    sure = middle & (np.abs(rays[:, 0] - 0.25) > 0.02)
    assert sure.mean() > 0.5 and set(np.unique(expected[sure])) == {1.0, 2.0, 4.0}
    assert np.abs(hits["t"] - expected)[sure].max() < 1e-6
    short = rays.copy()
    short[:, 7] = 1.5  # before the second square
    assert np.array_equal(traced.query(short, any_hit=True)["id"][sure] > 0, opaque[sure])


def _uv_at(mesh: Mesh, points: np.ndarray) -> np.ndarray:
    """Texture coordinates of an affine mesh at (x, y)."""
    known = np.column_stack([mesh.positions[:, :2], np.ones(len(mesh.positions))])
    affine = np.linalg.lstsq(known, mesh.uvs, rcond=None)[0]
    return np.column_stack([points, np.ones(len(points))]) @ affine


def test_vertex_colours_cut_too(traced):
    """Alpha rises from 0 to 1 along x; it is cut at a quarter."""
    square = quad(SQUARE)
    colors = np.ones((4, 4), np.float32)
    colors[:, 3] = square.positions[:, 0]
    material = Material(alpha_mode="mask", alpha_cutoff=0.25, double_sided=True)
    traced.follow(scene_of([replace(square, colors=colors)], [material]))
    rays = onto_square(np.random.default_rng(32), 2000)
    hit = traced.query(rays)["id"] > 0
    sure = np.abs(rays[:, 0] - 0.25) > 0.01
    assert np.array_equal(hit[sure], rays[sure, 0] > 0.25)


@pytest.mark.parametrize("alpha", [0.0, 0.3, 1.0])
def test_blended_surfaces_are_met_with_a_probability_of_alpha(traced, alpha):
    scene = scene_of([quad(SQUARE)], [Material(alpha_mode="blend", alpha=alpha, double_sided=True)])
    traced.follow(scene)
    rays = onto_square(np.random.default_rng(33), 20000)
    hits = traced.query(rays, alpha_seed=5)
    share, any_share = (hits["id"] > 0).mean(), (traced.query(rays, any_hit=True, alpha_seed=5)["id"] > 0)
    # Four standard deviations of so many independent draws; at 0 and 1 there is no chance at all.
    assert abs(share - alpha) <= 4 * np.sqrt(alpha * (1 - alpha) / len(rays))
    assert np.array_equal(any_share, hits["id"] > 0)  # one seed, one answer
    assert np.array_equal(traced.query(rays, alpha_seed=5), hits)
    if 0 < alpha < 1:
        assert not np.array_equal(traced.query(rays, alpha_seed=100005)["id"], hits["id"])


def test_blended_layers_are_independent(traced):
    """Through two layers goes the product of what each lets through."""
    layers = [quad([(x, y, -z) for x, y, _ in SQUARE]) for z in range(2)]
    traced.follow(scene_of(layers, [Material(alpha_mode="blend", alpha=0.4, double_sided=True)]))
    rays = onto_square(np.random.default_rng(34), 20000)
    t = traced.query(rays)["t"]
    for share, expected in (((t == 1).mean(), 0.4), ((t == 2).mean(), 0.24), ((t > 2).mean(), 0.36)):
        assert abs(share - expected) <= 4 * np.sqrt(expected * (1 - expected) / len(rays))


def test_culling(traced):
    """Camera rays pass through the backs of single-sided materials, also in mirrored instances, whatever their axis."""
    rng = np.random.default_rng(35)
    materials = [Material(double_sided=False), Material(double_sided=True)]
    scene = scene_of([triangle_mesh(soup(rng, 60, size=0.4)), triangle_mesh(soup(rng, 60, 0.4), material=1)], materials)
    scene.instances = [Instance(0), Instance(0, np.diag([-1.0, 1.0, 1.0, 1.0])), Instance(1)]
    traced.follow(scene)
    directions = random_directions(rng, 2000)
    rays = packed_rays(-2 * directions + 0.5 * rng.normal(size=(2000, 3)), directions)
    triangles, hits = traced.triangles(), traced.query(rays, cull_back=True)
    met = meet_all(triangles.corners, rays)
    mirrored = np.array([np.linalg.det(i.transform) < 0 for i in scene.instances])[triangles.instance]
    front = (met.determinant > 0) != mirrored
    seen = (met.margin > 0) & (met.t > 0) & (front | (triangles.instance == 2))
    t = np.where(seen, met.t, np.inf).min(axis=1)
    clear = (np.abs(met.margin) > 1e-4).all(axis=1)  # no edge within what float32 may mistake
    assert clear.mean() > 0.9 and 0.2 < np.isfinite(t).mean() < 0.95
    assert np.array_equal(hits["id"][clear] > 0, np.isfinite(t)[clear])
    both = clear & np.isfinite(t)
    assert np.abs(hits["t"] - t)[both].max() < 1e-4
    assert (traced.query(rays)["t"][both] < t[both] - 1e-3).any()  # without culling backs are met


@pytest.mark.parametrize("scale", [1.0, 1e3])
def test_closed_meshes_do_not_leak(traced, scale):
    """From within a closed mesh, rays at its vertices and edges, 10^5 of each: none escapes."""
    rng = np.random.default_rng(36)
    sphere = random_directions(rng, 1500)
    faces = ConvexHull(sphere).simplices
    points = (sphere * rng.uniform(0.7, 1.3, (1500, 1))).astype(np.float32)  # no longer convex, seen whole from 0
    arrays = {"normals": sphere, "tangents": np.ones((1500, 4)), "uvs": np.zeros((1500, 2))}
    mesh = Mesh(positions=points, indices=faces.astype(np.uint32),
                **{k: v.astype(np.float32) for k, v in arrays.items()})  # fmt: skip
    turn = np.linalg.qr(rng.normal(size=(3, 3)))[0] * scale
    move = np.eye(4)
    move[:3, :3], move[:3, 3] = turn, 0.3 * scale
    traced.follow(scene_of([mesh], [Material(double_sided=True)], instances=[Instance(0, move)]))
    world = points @ turn.T + 0.3 * scale
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    ends = world[edges[rng.integers(0, len(edges), 100000)]]
    targets = np.concatenate([
        world[rng.integers(0, 1500, 100000)],
        ends[:, 0] + rng.uniform(0, 1, (100000, 1)) * (ends[:, 1] - ends[:, 0]),
    ])  # fmt: skip
    origins = 0.3 * scale + 0.1 * scale * rng.normal(size=targets.shape)
    rays = packed_rays(origins, targets - origins)
    assert (traced.query(rays)["id"] > 0).all()
    assert (traced.query(rays, any_hit=True)["id"] > 0).all()
