"""What GpuScene tells of its instances: how large they are, which of them move, and when static ones are forgotten."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import read_buffer, scene_of

from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.gpu_scene.history import MOVING_SYNCS
from octolux.gpu_scene.structs import INSTANCE
from octolux.scene.builtin.shapes import box
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene

BLOCK = box((-0.1, -0.3, -0.2), (0.1, 0.3, 0.2))


def at(x: float) -> np.ndarray:
    transform = np.eye(4)
    transform[0, 3] = x
    return transform


def bent(mesh):
    return replace(mesh, positions=mesh.positions * np.float32(1.5))


def rows(device, gpu_scene: GpuScene) -> np.ndarray:
    return read_buffer(device, gpu_scene.resources["instances"], INSTANCE.dtype)


@pytest.fixture
def seen(device) -> tuple[Scene, GpuScene]:
    """Three blocks: one, and two of another mesh; synced once."""
    scene = scene_of([BLOCK, bent(BLOCK)], [Material(), Material()],
                     instances=[Instance(0), Instance(1, at(1.0)), Instance(1, at(2.0))])  # fmt: skip
    gpu_scene = GpuScene(device)
    gpu_scene.sync(scene)
    return scene, gpu_scene


def synced(device, scene: Scene, gpu_scene: GpuScene) -> tuple[list[int], int]:
    """Which instances move after a sync, and by how much the version has grown in it."""
    before = gpu_scene.static_version
    gpu_scene.sync(scene)
    return rows(device, gpu_scene)["moving"].tolist(), gpu_scene.static_version - before


def test_all_is_static_at_first(device, seen):
    scene, gpu_scene = seen
    assert not rows(device, gpu_scene)["moving"].any() and gpu_scene.static_version == 1
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 0)


def test_it_moves_for_eight_syncs_and_rests(device, seen):
    scene, gpu_scene = seen
    scene.instances[1] = Instance(1, at(1.1))
    assert synced(device, scene, gpu_scene) == ([0, 1, 0], 1)
    for _ in range(MOVING_SYNCS - 1):
        assert synced(device, scene, gpu_scene) == ([0, 1, 0], 0)
    moves = gpu_scene.moves
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 0)  # coming to rest, nothing is forgotten
    assert gpu_scene.moves == moves
    scene.instances[1] = Instance(1, at(1.2))
    assert synced(device, scene, gpu_scene) == ([0, 1, 0], 1)


def test_what_moves_on_is_forgotten_once(device, seen):
    scene, gpu_scene = seen
    grown = []
    for step in range(5):
        scene.instances[0] = replace(scene.instances[0], transform=at(-0.1 * step - 0.1))
        grown.append(synced(device, scene, gpu_scene))
        gpu_scene.sync(scene)
    assert grown == [([1, 0, 0], 1)] + [([1, 0, 0], 0)] * 4


def test_an_instance_replaced_by_its_equal_has_not_moved(device, seen):
    scene, gpu_scene = seen
    scene.instances[:] = [replace(i, transform=i.transform.copy()) for i in scene.instances]
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 0)


def test_a_deformed_mesh_moves_all_that_show_it(device, seen):
    scene, gpu_scene = seen
    size = rows(device, gpu_scene)["size"].copy()
    scene.meshes[1] = bent(scene.meshes[1])
    assert synced(device, scene, gpu_scene) == ([0, 1, 1], 1)
    np.testing.assert_allclose(rows(device, gpu_scene)["size"], size * [1.0, 1.5, 1.5], rtol=1e-6)


def test_another_material_is_forgotten_but_does_not_move(device, seen):
    scene, gpu_scene = seen
    scene.materials[1] = Material(base_color=(0.5, 0.5, 0.5))  # nobody has it
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 0)
    scene.materials[0] = Material(base_color=(0.5, 0.5, 0.5))
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 1)
    scene.meshes[0] = replace(scene.meshes[0], material=1)
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 1)


def test_another_mesh_is_forgotten_but_does_not_move(device, seen):
    """Whatever of it is another, where a texture or vertex colours may cut holes."""
    scene, gpu_scene = seen
    scene.meshes[1] = replace(scene.meshes[1], uvs=scene.meshes[1].uvs + np.float32(0.5))
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 1)


def test_where_static_things_stood(device, seen):
    """Boxes as they were before they were left: of what is static, until something else is forgotten."""
    scene, gpu_scene = seen
    low, high = BLOCK.positions.min(axis=0), BLOCK.positions.max(axis=0)

    def left(*boxes: tuple[float, float]) -> None:
        """Boxes at such x, so many times as large as the block."""
        gpu_scene.sync(scene)
        expected = [[size * end + [x, 0, 0] for x, size in boxes] for end in (low, high)]
        np.testing.assert_allclose(gpu_scene.left_boxes, np.reshape(expected, (2, -1, 3)), rtol=1e-6)

    left()  # all have appeared
    scene.instances[1] = replace(scene.instances[1], transform=at(1.1))
    left((1.0, 1.5))
    left((1.0, 1.5))
    scene.instances[1] = replace(scene.instances[1], transform=at(1.3))
    left((1.0, 1.5))  # it has moved on: nothing more is forgotten
    del scene.instances[0]
    left((0.0, 1.0))
    scene.meshes[1] = bent(scene.meshes[1])
    left((2.0, 1.5))  # the other one moves
    for _ in range(MOVING_SYNCS):
        left((2.0, 1.5))
    scene.materials[0] = Material(base_color=(0.5, 0.5, 0.5))
    left((1.3, 2.25), (2.0, 2.25))
    scene.instances.append(Instance(0, at(3.0)))
    left()


def test_what_appears_or_vanishes_is_forgotten(device, seen):
    scene, gpu_scene = seen
    scene.instances.append(Instance(0, at(3.0)))
    assert synced(device, scene, gpu_scene) == ([0, 0, 0, 0], 1)
    del scene.instances[0]  # the others are known again by themselves, not by their place
    assert synced(device, scene, gpu_scene) == ([0, 0, 0], 1)
    scene.instances[2] = replace(scene.instances[2], transform=at(3.5))
    assert synced(device, scene, gpu_scene) == ([0, 0, 1], 1)
    del scene.instances[2]  # nothing is kept of what moves
    assert synced(device, scene, gpu_scene) == ([0, 0], 0)
    scene.instances.clear()
    before = gpu_scene.static_version
    gpu_scene.sync(scene)
    gpu_scene.sync(scene)
    assert gpu_scene.static_version == before + 1


def test_an_instance_listed_twice_stays_two(device, seen):
    scene, gpu_scene = seen
    scene.instances.append(scene.instances[0])
    assert synced(device, scene, gpu_scene) == ([0, 0, 0, 0], 0)  # no surface that was not there
    scene.instances[1] = replace(scene.instances[1], transform=at(1.5))
    assert synced(device, scene, gpu_scene) == ([0, 1, 0, 0], 1)


def test_sizes_are_the_longest_edges_in_the_world(device, seen):
    scene, gpu_scene = seen
    turned = np.array([[0.0, -2.0, 0.0, 5.0], [2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 4.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    scene.instances[0] = Instance(0, turned)
    gpu_scene.sync(scene)
    np.testing.assert_allclose(rows(device, gpu_scene)["size"], [1.6, 0.9, 0.9], rtol=1e-6)


def test_what_has_changed_once_has_for_good(device, seen):
    """Moved, made of something else or given another mesh; and only its first change is one of what lasts."""
    scene, gpu_scene = seen

    def changed(count: int) -> list[bool]:
        before = gpu_scene.lasting_version
        gpu_scene.sync(scene)
        assert gpu_scene.lasting_version == before + count
        return gpu_scene.has_changed.tolist()

    assert changed(0) == [False] * 3
    scene.instances[2] = Instance(1, at(2.1))
    assert changed(1) == [False, False, True]
    for _ in range(MOVING_SYNCS):
        assert changed(0) == [False, False, True]
    scene.instances[2] = Instance(1, at(2.0))
    assert changed(0) == [False, False, True]
    scene.materials[0] = Material(emissive=(1.0, 2.0, 3.0))
    assert changed(1) == [True] * 3
    del scene.instances[0]
    assert changed(0) == [True] * 2, "what has gone was none of what lasts"
    scene.instances.append(Instance(1, at(4.0)))
    assert changed(1) == [True, True, False]
    scene.meshes[1] = replace(scene.meshes[1], uvs=scene.meshes[1].uvs + np.float32(0.5))
    assert changed(1) == [True] * 3
