"""The BVH follows the scene: refitted when things move, built when other triangles are drawn."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import one_stage, scene_of
from ray_tools import Traced, check, random_rays, soup, triangle_mesh

from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene


@pytest.fixture
def rng():
    return np.random.default_rng(21)


@pytest.fixture
def scene(rng) -> Scene:
    made = scene_of([triangle_mesh(soup(rng, 300, size=0.4)), triangle_mesh(soup(rng, 20, size=0.4))])
    made.instances = [Instance(0), Instance(1, shifted(0.3)), Instance(1)]
    return made


@pytest.fixture(scope="module")
def traced(device) -> Traced:
    return Traced(device, Scene())


def shifted(by: float, turned: float = 0.0) -> np.ndarray:
    move = np.eye(4)
    c, s = np.cos(turned), np.sin(turned)
    move[:3, :3] = [[c, -s, 0], [s, c, 0], [0, 0, 1]]
    move[:3, 3] = by
    return move


def order(traced: Traced) -> bytes:
    """Which triangle stands where in the tree: it changes with every build of other triangles."""
    return bytes(traced.device.queue.read_buffer(traced.bvh._tree.order))


def same_answers(device, traced: Traced, rays: np.ndarray) -> None:
    """As right as ever, and at the distances, to the bit, of a BVH built for this very scene (which may number the
    triangles of a deformed mesh otherwise)."""
    hits = check(traced, rays)
    built = Traced(device, traced.scene).query(rays)
    assert (hits["id"] > 0).any() and np.array_equal(hits["t"], built["t"])


def test_moved_instances(device, traced, scene, rng):
    traced.follow(scene)
    buffer, before = traced.bvh.buffer, order(traced)
    moved = replace(scene, instances=[Instance(0, shifted(0.5, 2.0)), Instance(1, shifted(-0.8)), scene.instances[2]])
    traced.follow(moved)
    assert traced.bvh.buffer is buffer and order(traced) == before
    same_answers(device, traced, random_rays(rng, 800))


def test_far_moves(device, traced, scene, rng):
    """Everything is elsewhere, and much larger: boxes, their steps and the errors they allow for follow."""
    traced.follow(scene)
    far = np.diag([40.0, 40.0, -40.0, 1.0])
    far[:3, 3] = 100.0
    traced.follow(replace(scene, instances=[replace(i, transform=far @ i.transform) for i in scene.instances]))
    rays = random_rays(rng, 800)
    rays[:, :3] = 40.0 * rays[:, :3] + 100.0
    same_answers(device, traced, rays)


def test_deformed_meshes(device, traced, scene, rng):
    traced.follow(scene)
    buffer = traced.bvh.buffer
    mesh = scene.meshes[0]
    positions = mesh.positions + np.sin(3 * mesh.positions[:, ::-1]).astype(np.float32)
    traced.follow(replace(scene, meshes=[replace(mesh, positions=positions), scene.meshes[1]]))
    assert traced.bvh.buffer is buffer
    same_answers(device, traced, random_rays(rng, 800))


@pytest.mark.parametrize("change", ["instance added", "instance removed", "mesh replaced", "all gone and back"])
def test_other_triangles(device, traced, scene, rng, change):
    traced.follow(scene)
    if change == "instance added":
        scene = replace(scene, instances=[*scene.instances, Instance(0, shifted(-0.4, 1.0))])
    elif change == "instance removed":
        scene = replace(scene, instances=scene.instances[1:])
    elif change == "mesh replaced":
        scene = replace(scene, meshes=[triangle_mesh(soup(rng, 301)), scene.meshes[1]])
    else:
        traced.follow(replace(scene, instances=[]))
        assert not traced.query(random_rays(rng, 50))["id"].any()
    traced.follow(scene)
    same_answers(device, traced, random_rays(rng, 800))


def test_nothing_is_done_when_nothing_changed(device, traced, scene):
    traced.follow(scene)
    uploaded = device.uploaded_bytes
    traced.bvh.sync(traced.gpu_scene)
    assert device.uploaded_bytes == uploaded


def test_a_refit_can_be_recorded_in_a_stage(device, traced, scene, rng):
    traced.follow(scene)
    moved = replace(scene, instances=[replace(i, transform=shifted(0.2) @ i.transform) for i in scene.instances])
    traced.scene = moved
    traced.gpu_scene.sync(moved)
    with one_stage(device) as stage:
        traced.bvh.sync(traced.gpu_scene, stage)
    same_answers(device, traced, random_rays(rng, 300))


def test_replaced_materials_reach_the_bvh(traced, scene, rng):
    """A material that becomes invisible lets rays through, with the same tree."""
    traced.follow(scene)
    rays, buffer = random_rays(rng, 300), traced.bvh.buffer
    assert traced.query(rays)["id"].any()
    gone = Material(double_sided=True, alpha_mode="mask", alpha=0.0)
    traced.follow(replace(scene, materials=[gone]))
    assert traced.bvh.buffer is buffer and not traced.query(rays)["id"].any()
