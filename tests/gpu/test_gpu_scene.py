"""GpuScene: only what changed is uploaded, and the picture is then that of a fresh renderer."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.gpu_scene.structs import INSTANCE, ITEM, MATERIAL, TRIANGLE, VERTEX
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quads
from octolux.scene.lights import PointLight
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene

LAMP = PointLight(position=(0.5, 1.5, 2.0), intensity=(9.0, 8.0, 7.0))


def image(seed: int, edge: int = 8) -> Image:
    return Image(np.random.default_rng(seed).integers(0, 256, (edge, edge, 4)).astype(np.uint8))


def moved(x: float, y: float = 0.0) -> np.ndarray:
    transform = np.eye(4)
    transform[:2, 3] = (x, y)
    return transform


def bent(mesh: Mesh, by: float = 0.3) -> Mesh:
    """Other positions, the same triangles."""
    wave = np.sin(7 * mesh.positions) * np.float32(by)
    return replace(mesh, positions=mesh.positions + wave.astype(np.float32))


def panel(x: float, material: int = 0) -> Mesh:
    return quads([[(x, -1, 0), (x + 0.6, -1, 0), (x + 0.6, 1, 0.2), (x, 1, 0.2)]], material=material)


def three() -> Scene:
    """Two panels and a block, of three materials, two with textures."""
    meshes = [panel(-1.0, 0), panel(0.3, 1), box((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3), material=2)]
    materials = [Material(base_color_texture=Texture(image(1)), double_sided=True),
                 Material(metallic_roughness_texture=Texture(image(2)), metallic=0.5, double_sided=True),
                 Material(base_color=(0.2, 0.4, 0.9))]  # fmt: skip
    instances = [Instance(0), Instance(1), Instance(2, moved(0.0)), Instance(2, moved(0.1, 0.7))]
    return scene_of(meshes, materials, instances=instances, lights=[LAMP])


def renderer_of(device, scene: Scene) -> Renderer:
    return Renderer(scene, "none", size=(24, 24), device=device, default_light=False,
                    frame_settings=small_settings(sky_lights=0, emitter_lights=0))  # fmt: skip


def layers(renderer: Renderer) -> dict[str, np.ndarray]:
    """All but motion, which a first picture has none of; and display."""
    picture = renderer.render(front_camera(3.0))
    return {k: v for k, v in picture.layers.items() if k != "motion"} | {"display": picture.display}


def same(a: dict[str, np.ndarray], b: dict[str, np.ndarray]) -> bool:
    return all(np.array_equal(a[name], b[name]) for name in a)


def uploaded(device, gpu_scene: GpuScene, scene: Scene) -> int:
    before = device.uploaded_bytes
    gpu_scene.sync(scene)
    return device.uploaded_bytes - before


def replace_material(scene: Scene) -> int:
    scene.materials[2] = replace(scene.materials[2], base_color=(0.9, 0.1, 0.3), roughness=0.4)
    return 3 * MATERIAL.size


def replace_textured_material(scene: Scene) -> int:
    scene.materials[0] = replace(scene.materials[0], base_color=(0.5, 1.0, 0.5))
    return 3 * MATERIAL.size


def move_instance(scene: Scene) -> int:
    scene.instances[2] = Instance(2, moved(-0.2, -0.6))
    return INSTANCE.size


def move_the_last_two(scene: Scene) -> int:
    scene.instances[2:] = [Instance(2, moved(-0.2)), Instance(2, moved(-0.2, 0.9))]
    return 2 * INSTANCE.size


def deform_mesh(scene: Scene) -> int:
    scene.meshes[2] = bent(scene.meshes[2])
    return len(scene.meshes[2].positions) * VERTEX.size + 2 * INSTANCE.size  # both change their size, and move


def nothing(scene: Scene) -> int:
    scene.meshes, scene.instances = list(scene.meshes), list(scene.instances)
    return 0


CHANGES: list[Callable[[Scene], int]] = [
    nothing, move_instance, move_the_last_two, replace_material, replace_textured_material, deform_mesh,
]  # fmt: skip


@pytest.mark.parametrize("change", CHANGES, ids=lambda c: c.__name__)
def test_only_what_changed_is_uploaded(device, change):
    scene, gpu_scene = three(), GpuScene(device)
    assert uploaded(device, gpu_scene, scene) > 0
    version, resources = gpu_scene.version, gpu_scene.resources
    expected = change(scene)
    assert uploaded(device, gpu_scene, scene) == expected
    assert uploaded(device, gpu_scene, scene) == 0
    assert gpu_scene.version == version  # passes stay
    assert all(gpu_scene.resources[name] is kept for name, kept in resources.items())


def swap_image(scene: Scene) -> None:
    scene.materials[0] = replace(scene.materials[0], base_color_texture=Texture(image(9)))


def larger_image(scene: Scene) -> None:
    scene.materials[0] = replace(scene.materials[0], base_color_texture=Texture(image(9, 300)))


def another_bucket(scene: Scene) -> None:
    scene.materials[2] = replace(scene.materials[2], alpha_mode="blend", alpha=0.5, double_sided=True)


def append_mesh(scene: Scene) -> None:
    scene.meshes.append(box((-0.9, 0.5, 0.3), (-0.5, 0.9, 0.6), material=2))
    scene.instances.append(Instance(3))


def append_many(scene: Scene) -> None:
    for n in range(5):
        scene.meshes.append(panel(0.1 * n - 0.5, n % 3))
        scene.instances.append(Instance(3 + n, moved(0.0, 0.3 * n)))


def remove_mesh(scene: Scene) -> None:
    del scene.meshes[0]
    scene.instances[:] = [replace(i, mesh=i.mesh - 1) for i in scene.instances if i.mesh > 0]


def exchange_meshes(scene: Scene) -> None:
    scene.meshes[0], scene.meshes[1] = scene.meshes[1], scene.meshes[0]


def shift_and_deform(scene: Scene) -> None:
    """The first mesh takes the second's number, and a bent copy of the second the first's."""
    scene.meshes[0], scene.meshes[1] = bent(scene.meshes[1]), scene.meshes[0]


def other_topology(scene: Scene) -> None:
    mesh = scene.meshes[2]
    scene.meshes[2] = replace(mesh, indices=np.ascontiguousarray(mesh.indices[::2]))


def colour_a_mesh(scene: Scene) -> None:
    colors = np.random.default_rng(4).random((4, 4)).astype(np.float32)
    scene.meshes[0] = replace(scene.meshes[0], colors=colors)


def deform_while_growing(scene: Scene) -> None:
    scene.meshes[1] = bent(scene.meshes[1])
    append_many(scene)


MORE = [swap_image, larger_image, another_bucket, append_mesh, append_many, remove_mesh, exchange_meshes,
        shift_and_deform, other_topology, colour_a_mesh, deform_while_growing]  # fmt: skip


@pytest.fixture(scope="module")
def live(device) -> tuple[Renderer, dict[str, np.ndarray]]:
    """A renderer that all changes go through, one after the other, and its picture before the first."""
    renderer = renderer_of(device, three())
    return renderer, layers(renderer)


@pytest.mark.parametrize("change", [*CHANGES[1:], *MORE], ids=lambda c: c.__name__)
def test_a_changed_scene_looks_as_if_it_was_always_so(device, live, change):
    renderer, before = live
    renderer.scene = three()
    change(renderer.scene)
    after = layers(renderer)
    assert not same(before, after)
    assert same(after, layers(renderer_of(device, renderer.scene)))


def test_and_back_again(live):
    renderer, before = live
    renderer.scene = three()
    assert same(before, layers(renderer))


def test_an_appended_mesh_alone_is_uploaded(device):
    """Once there is room: growing makes half as much again."""
    scene, gpu_scene = three(), GpuScene(device)
    gpu_scene.sync(scene)
    append_mesh(scene)
    gpu_scene.sync(scene)
    extra = panel(0.0)
    scene.meshes.append(extra)
    expected = len(extra.positions) * VERTEX.size + len(extra.indices) * TRIANGLE.size
    assert uploaded(device, gpu_scene, scene) == expected  # not shown yet
    scene.instances.append(Instance(4))
    assert uploaded(device, gpu_scene, scene) == 6 * (INSTANCE.size + ITEM.size)


def test_a_mesh_listed_twice_becomes_two(device):
    """Its place is taken by the first of the two; the other gets a place of its own."""
    shared = box((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3))
    scene = scene_of([shared, shared], [Material()], instances=[Instance(0, moved(-0.5)), Instance(1, moved(0.5))],
                     lights=[LAMP])  # fmt: skip
    renderer = renderer_of(device, scene)
    layers(renderer)
    for pair in ((bent(shared), bent(shared, -0.5)), (bent(shared, 0.1),) * 2):
        scene.meshes[:] = pair
        assert same(layers(renderer), layers(renderer_of(device, scene)))


def test_one_new_mesh_listed_twice_is_uploaded_once(device):
    shared = box((-0.3, -0.3, -0.3), (0.3, 0.3, 0.3))
    scene, gpu_scene = scene_of([shared, shared], [Material()]), GpuScene(device)
    gpu_scene.sync(scene)
    for by in (0.1, 0.2, 0.3):
        scene.meshes[:] = [bent(shared, by)] * 2
        assert uploaded(device, gpu_scene, scene) == len(shared.positions) * VERTEX.size + 2 * INSTANCE.size


def test_emptied_and_refilled(device):
    renderer, full = renderer_of(device, three()), three()
    before = layers(renderer)
    renderer.scene = Scene(exposure=0.0, lights=[LAMP])
    empty = layers(renderer)
    assert not empty["depth"].any() and same(empty, layers(renderer_of(device, renderer.scene)))
    low, high = renderer.gpu_scene.bounds
    assert not low.any() and not high.any()  # nothing of what was there
    renderer.scene = full
    assert same(before, layers(renderer))


@pytest.mark.parametrize("broken", ["materials.MaterialTable._write", "geometry.GeometryBuffers.sync"])
def test_a_sync_that_failed_half_way_is_made_up_for(device, monkeypatch, broken):
    """Materials come before meshes: what was uploaded, and what was not, is other than what maps were drawn of."""
    renderer = renderer_of(device, three())
    renderer.render()
    renderer.scene = replace(renderer.scene, materials=[replace(m, alpha=0.0, alpha_mode="mask") if n == 2 else m
                                                        for n, m in enumerate(renderer.scene.materials)])  # fmt: skip
    with monkeypatch.context() as patched, pytest.raises(ZeroDivisionError):
        patched.setattr(f"octolux.gpu_scene.{broken}", lambda *given: 1 // 0)
        renderer.render()
    assert same(layers(renderer), layers(renderer_of(device, renderer.scene)))
