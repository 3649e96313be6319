"""The same scene gives the same bytes, and a changed scene what a fresh renderer gives."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from octolux.frame.composite import CompositePass
from octolux.frame.frame import FrameSettings
from octolux.gpu.device import DeviceError
from octolux.renderer import Renderer
from octolux.scene.load import load_scene
from octolux.scene.meshes import Instance

SIZE = (160, 120)
TECHNIQUES = ("none", "constant", "uniform-lpv", "voxel-cones")


def renderer_of(device, scene, technique: str) -> Renderer:
    settings = FrameSettings(shadow_resolution=256, rsm_resolution=128)
    return Renderer(scene, technique, size=SIZE, device=device, frame_settings=settings)


def same(a, b) -> bool:
    return np.array_equal(a.radiance, b.radiance) and np.array_equal(a.display, b.display)


@pytest.fixture(scope="module", params=TECHNIQUES)
def renderer(request, device):
    return renderer_of(device, load_scene("cornell-box"), request.param)


def fresh(renderer: Renderer):
    """A new renderer's picture of the same scene."""
    return renderer_of(renderer.device, renderer.scene, renderer.technique.name).render()


def test_two_runs_give_the_same_bytes(renderer):
    first = renderer.render()
    assert same(first, renderer.render())
    assert same(first, fresh(renderer))
    assert first.radiance.max() > 0 and len(np.unique(first.display)) > 50


def test_a_changed_light(renderer):
    before, lights = renderer.render(), list(renderer.scene.lights)
    renderer.scene.lights[0] = replace(lights[0], position=(0.5, 1.4, 0.3), intensity=(10.0, 40.0, 90.0))
    moved = renderer.render()
    assert not same(before, moved)
    assert same(moved, fresh(renderer))
    renderer.scene.lights[:] = lights
    assert same(before, renderer.render())


def test_more_and_fewer_lights(renderer):
    before, lights = renderer.render(), list(renderer.scene.lights)
    renderer.scene.lights.append(replace(lights[0], position=(-0.5, 0.4, 0.8)))
    more = renderer.render()
    assert not same(before, more)
    assert same(more, fresh(renderer))
    renderer.scene.lights[:] = lights
    assert same(before, renderer.render())


def test_a_moved_instance(renderer):
    """Only its placement is uploaded: geometry and textures stay the same objects."""
    before, instances = renderer.render(), list(renderer.scene.instances)
    objects = before.layers["object_id"]
    names = ("vertices", "triangles", "materials", "material_sampler")
    kept = {name: renderer.gpu_scene.resources[name] for name in names}
    turned = instances[3].transform.copy()
    turned[:3, 3] += [-0.3, 0.4, 0.2]
    renderer.scene.instances[3] = Instance(3, turned, name="short block")
    moved = renderer.render()
    assert not same(before, moved)
    assert same(moved, fresh(renderer))
    assert all(renderer.gpu_scene.resources[name] is kept[name] for name in names)
    renderer.scene.instances[:] = instances
    assert same(before, renderer.render())
    assert np.array_equal(before.layers["object_id"], objects)


def test_a_picture_keeps_its_layers_when_the_scene_changes(device):
    """Layers are worked out when asked for: by then the scene may have other instances."""
    renderer = renderer_of(device, load_scene("cornell-box"), "none")
    picture, twin = renderer.render(), renderer.render()
    expected = {name: layer.copy() for name, layer in twin.layers.items()}
    renderer.scene.instances[:] = [Instance(3), Instance(0)]
    renderer.render()
    for name, layer in picture.layers.items():
        assert np.array_equal(layer, expected[name]), name


def test_a_changed_material_and_camera(renderer):
    before, materials = renderer.render(), list(renderer.scene.materials)
    renderer.scene.materials[0] = replace(materials[0], base_color=(0.1, 0.2, 0.9))
    changed = renderer.render()
    assert not same(before, changed) and same(changed, fresh(renderer))
    renderer.scene.materials[:] = materials
    assert same(before, renderer.render())


@pytest.mark.parametrize("technique", ["octree-lpv", "cascaded-lpv", "voxel-cones"])
def test_a_frame_that_fails_leaves_nothing(device, monkeypatch, technique):
    """What techniques keep from frame to frame is made anew after one whose commands were never carried out."""
    scene = load_scene("cornell-box")

    def renderer() -> Renderer:
        settings = {"n": 16} if technique.endswith("lpv") else {"depth": 6, "bounces": 1}
        frame = FrameSettings(shadow_resolution=64, rsm_resolution=32)
        return Renderer(
            scene, technique, settings=settings, size=(32, 24), exposure=0.0, device=device, frame_settings=frame
        )

    def fails(*given: object) -> None:
        raise DeviceError("full")

    made = renderer()
    with monkeypatch.context() as patched:
        patched.setattr(CompositePass, "run", fails)
        with pytest.raises(DeviceError, match="full"):
            made.render()
    assert np.array_equal(made.render().radiance, renderer().render().radiance)
