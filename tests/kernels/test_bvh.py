"""The BVH's queries against every ray with every triangle in float64."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import random_directions, scene_of
from ray_tools import Traced, check, random_rays, soup, triangle_mesh

from octolux.gpu.device import DeviceError
from octolux.gpu.limits import DEFAULT_LIMITS
from octolux.raytracing.query import packed_rays
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene


@pytest.fixture(scope="module")
def traced(device) -> Traced:
    return Traced(device, Scene())


def test_random_triangles(traced):
    rng = np.random.default_rng(1)
    traced.follow(scene_of([triangle_mesh(soup(rng, 700))]))
    rays = random_rays(rng, 3000)
    hits = check(traced, rays)
    assert 0.1 < (hits["id"] > 0).mean() < 0.9


def test_ranges_of_rays(traced):
    """t_min and t_max, also beyond and within what would be hit."""
    rng = np.random.default_rng(2)
    traced.follow(scene_of([triangle_mesh(soup(rng, 400, size=0.5))]))
    rays = random_rays(rng, 2000)
    rays[:, 3] = rng.uniform(0, 1, len(rays))
    rays[:, 7] = rays[:, 3] + rng.uniform(0, 1, len(rays))
    assert 0.05 < (check(traced, rays)["id"] > 0).mean() < 0.95


def test_rays_along_the_axes(traced):
    """Directions with zeros, also from points on the planes of axis-aligned boxes."""
    rng = np.random.default_rng(3)
    corners = np.round(4 * soup(rng, 300, size=0.5)) / 4
    traced.follow(scene_of([triangle_mesh(corners)]))
    directions = np.concatenate([np.eye(3), -np.eye(3), [[1, 1, 0], [0, -1, 1], [-1, 0, -1]]])
    origins = np.concatenate([rng.uniform(-2, 2, (300, 3)), np.round(rng.uniform(-6, 6, (100, 3))) / 4])
    rays = packed_rays(np.repeat(origins, len(directions), axis=0), np.tile(directions, (len(origins), 1)))
    # Rays within a lattice meet edges and lie in planes: much is unsure, and the rest must be right.
    check(traced, rays, least_sure=0.5)


@pytest.mark.parametrize("scale, offset", [(1e-6, 0.0), (1e9, 0.0), (1.0, 1e3), (1e-3, 1.0)])
def test_scales(traced, scale, offset):
    """From micrometres to a million kilometres, and far from the origin."""
    rng = np.random.default_rng(4)
    traced.follow(scene_of([triangle_mesh(scale * soup(rng, 200, size=0.6) + offset)]))
    rays = random_rays(rng, 500)
    rays[:, :3] = scale * rays[:, :3] + offset
    # What is far off is only known to some share of its distance.
    check(traced, rays, least_sure=0.9 if offset == 0.0 else 0.5)


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4, 5, 64, 65, 255, 256, 257, 2048, 2049])
def test_counts(traced, count):
    """Sizes around those of leaves, nodes, workgroups and blocks; each triangle is found by a ray of its own."""
    rng = np.random.default_rng(5)
    corners = soup(rng, count, size=0.01)
    traced.follow(scene_of([triangle_mesh(corners)] if count else []))
    centres = corners.mean(axis=1) if count else np.zeros((1, 3))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]) if count else np.ones((1, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    hits = traced.query(packed_rays(centres + 1e-3 * normal, -normal))
    if not count:
        assert not hits["id"].any()
        return
    near = np.abs(hits["t"] - 1e-3) < 1e-5  # unless another lies between
    assert (hits["t"] < 1e-3 + 1e-5).all() and near.mean() > 0.9
    assert len(np.unique(hits["id"][near])) == near.sum()


def test_many_triangles(traced):
    """More than 2^16: several blocks of every scan."""
    rng = np.random.default_rng(6)
    traced.follow(scene_of([triangle_mesh(soup(rng, 65537, size=0.02))]))
    check(traced, random_rays(rng, 60))


def test_duplicates_and_degenerates(traced):
    """Triangles on one another, as points, as lines, and all at one place: answers are those of the others."""
    rng = np.random.default_rng(7)
    some = soup(rng, 40, size=0.5)
    points = np.repeat(soup(rng, 50)[:, :1], 3, axis=1)
    lines = soup(rng, 50)[:, [0, 1, 1]]
    traced.follow(scene_of([triangle_mesh(np.concatenate([some, np.repeat(some[:3], 300, axis=0), points, lines]))]))
    hits = check(traced, random_rays(rng, 800))
    # Of equal triangles the first is named, whatever the tree.
    triangles = traced.triangles()
    first = {c.tobytes(): i for c, i in reversed(list(zip(triangles.corners, triangles.ids, strict=True)))}
    number = np.searchsorted(triangles.ids, hits["id"][hits["id"] > 0])
    assert all(first[triangles.corners[n].tobytes()] == triangles.ids[n] for n in number)


@pytest.mark.parametrize("corners", [np.zeros((1000, 3, 3)), np.tile([[0, 0, 0], [1, 0, 0], [0, 1, 0]], (1000, 1, 1))])
def test_all_alike(traced, corners):
    """A thousand equal triangles pair off round by round and make a shallow tree."""
    traced.follow(scene_of([triangle_mesh(corners)]))
    assert len(traced.bvh.levels) <= 7  # 1000 in leaves of 2 are 9 binary levels
    hits = traced.query(packed_rays([[0.2, 0.2, 1.0]], [[0, 0, -1]]))
    assert hits["id"][0] == (1 if corners.any() else 0)


def test_nested_triangles_of_growing_size(traced):
    """Each is larger by half than the one before: a tree as deep as it gets, and the stack that it needs."""
    sizes = 1.5 ** np.arange(150)
    corners = sizes[:, None, None] * np.array([[-1, -1, 1], [1, -1, 1], [0, 2, 1]])
    traced.follow(scene_of([triangle_mesh(corners * 1e-9)]))
    directions = random_directions(np.random.default_rng(8), 200)
    hits = check(traced, packed_rays(np.zeros((200, 3)), directions), least_sure=0.9)
    assert (hits["id"] > 0).any()


def test_instances(traced):
    """Mirrored, stretched, sheared and shrunk instances of two meshes."""
    rng = np.random.default_rng(9)
    moves = [np.eye(4) for _ in range(6)]
    for i, move in enumerate(moves):
        move[:3, :3] = rng.normal(size=(3, 3)) * (0.1 if i == 4 else 0.6)
        move[:3, 3] = rng.uniform(-0.5, 0.5, 3)
    assert len({np.sign(np.linalg.det(m)) for m in moves}) == 2
    scene = scene_of([triangle_mesh(soup(rng, 60, size=0.5)), triangle_mesh(soup(rng, 150, size=0.5))])
    scene.instances = [Instance(i % 2, m) for i, m in enumerate(moves)]
    traced.follow(scene)
    hits = check(traced, random_rays(rng, 1500))
    triangles = traced.triangles()
    seen = triangles.instance[np.searchsorted(triangles.ids, hits["id"][hits["id"] > 0])]
    assert set(seen) == set(range(6))


def test_the_same_bits_in_every_run(device, traced):
    rng = np.random.default_rng(10)
    scene = scene_of([triangle_mesh(soup(rng, 5000))])
    traced.follow(scene)
    other = Traced(device, scene)
    words = [np.frombuffer(device.queue.read_buffer(t.bvh.buffer), np.uint32) for t in (traced, other)]
    assert np.array_equal(*words)


def test_too_many_triangles_are_an_error(device, monkeypatch):
    """300 instances of ten triangles: little geometry, but as many triangles in the world."""
    scene = scene_of([triangle_mesh(soup(np.random.default_rng(11), 10))])
    scene.instances = [Instance(0) for _ in range(300)]
    fresh = Traced(device, Scene())
    monkeypatch.setitem(DEFAULT_LIMITS, "max-storage-buffer-binding-size", 1 << 16)
    with pytest.raises(DeviceError, match=r"BVH of 3000 triangles needs a buffer of 187\.5 KiB; one binding"):
        fresh.follow(scene)
    monkeypatch.undo()
    fresh.follow(scene)
    check(fresh, random_rays(np.random.default_rng(12), 100))
