"""Surfels of the scene's own surfaces (frame/scene_surfels): their places, areas and albedo, as objects move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.frame import traits
from octolux.frame.scene_surfels import SceneSurfels
from octolux.frame.structs import VPL
from octolux.gpu.records import read_records, read_words
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.materials import Material
from octolux.simulator.camera import unpack_normals
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

LOW, HIGH = np.array([-1.0, -0.5, -0.25]), np.array([1.0, 0.5, 0.75])
SPACING = 0.125
NORMALS = 1e-4  # packed normals are turned by up to 6.5e-5


class Sampling(NoTechnique):
    """A technique that only has the scene's surfels."""

    def update(self, frame) -> None:
        self.surfels = getattr(self, "surfels", None) or SceneSurfels(frame.device)
        self.changed = self.surfels.run(frame, np.zeros(3), SPACING)


def rendered(device, scene) -> tuple[Renderer, np.ndarray, np.ndarray]:
    renderer = Renderer(scene, "none", size=(8, 8), device=device, exposure=0.0, frame_settings=small_settings())
    renderer.technique = Sampling(device, Settings())
    return renderer, *read(renderer)


def read(renderer: Renderer) -> tuple[np.ndarray, np.ndarray]:
    """VPL and traits after a frame."""
    renderer.render(front_camera())
    made = renderer.technique.surfels
    return read_records(renderer.device, made.surfels, VPL, made.count), read_words(
        renderer.device, made.surfaces, made.count
    )


def the_box(**material):
    return scene_of([box(LOW, HIGH)], [Material(specular=0.0, **material)])


def test_a_box(device):
    """Each side has its area in surfels that look outwards, on it, and of its colour: SPACING^2 each, as sides are
    whole numbers of it."""
    _, surfels, words = rendered(device, the_box(base_color=(0.5, 0.25, 1.0)))
    normals, positions = unpack_normals(surfels["normal"]), surfels["position"].astype(np.float64)
    np.testing.assert_allclose(surfels["area"], SPACING**2, rtol=1e-5)
    edges = HIGH - LOW
    for axis in range(3):
        for sign, face in ((-1, LOW), (1, HIGH)):
            here = normals[:, axis] * sign > 1.0 - NORMALS
            np.testing.assert_allclose(positions[here, axis], face[axis], atol=1e-6)
            assert here.sum() * SPACING**2 == pytest.approx(np.delete(edges, axis).prod())
    albedo, size, moving = traits.unpack_traits(words)
    np.testing.assert_allclose(albedo, np.tile((0.5, 0.25, 1.0), (len(words), 1)), atol=traits.ROOT_STEP * 2.1)
    assert not moving.any() and np.all(np.abs(np.log2(size / 2.0)) < 0.13)


def test_the_other_side(device):
    """Of a material that is seen from both sides each place has a second surfel, turned round, of negative area."""
    _, surfels, _ = rendered(device, the_box(double_sided=True))
    front, back = surfels[surfels["area"] > 0], surfels[surfels["area"] < 0]
    assert len(front) == len(back) == len(surfels) / 2
    front, back = (side[np.lexsort(side["position"].T)] for side in (front, back))
    np.testing.assert_array_equal(front["position"], back["position"])
    np.testing.assert_array_equal(front["area"], -back["area"])
    np.testing.assert_allclose(unpack_normals(front["normal"]), -unpack_normals(back["normal"]), atol=2 * NORMALS)


def test_surfels_go_with_their_object(device):
    """Moved, turned and made twice as large: the same places on it, four times the area, and moving."""
    scene = the_box()
    renderer, before, _ = rendered(device, scene)
    turned = np.array([[0.0, -2.0, 0, 3.0], [2.0, 0, 0, 1.0], [0, 0, 2.0, -1.0], [0, 0, 0, 1.0]])
    scene.instances[0] = replace(scene.instances[0], transform=turned)
    after, words = read(renderer)
    expected = before["position"] @ turned[:3, :3].T + turned[:3, 3]
    np.testing.assert_allclose(after["position"], expected, atol=1e-5)
    np.testing.assert_allclose(after["area"], 4.0 * before["area"], rtol=1e-5)
    np.testing.assert_allclose(
        unpack_normals(after["normal"]), unpack_normals(before["normal"]) @ turned[:3, :3].T / 2.0, atol=2 * NORMALS
    )
    assert traits.unpack_traits(words)[2].all()


def test_nothing_is_cut_out_or_clear(device):
    """What a mask cuts out has no area; what is half clear, half."""
    _, cut, _ = rendered(device, the_box(alpha=0.3, alpha_mode="mask", alpha_cutoff=0.5))
    assert not cut["area"].any()
    _, clear, _ = rendered(device, the_box(alpha=0.5, alpha_mode="blend"))
    np.testing.assert_allclose(clear["area"], 0.5 * SPACING**2, rtol=1e-5)


def test_it_tells_whether_anything_has_changed(device):
    """Only in frames before which something has been moved, added or taken away, or looks otherwise."""
    scene = the_box()
    renderer, _, _ = rendered(device, scene)
    assert renderer.technique.changed
    moved = np.eye(4)
    moved[0, 3] = 0.5
    there = list(scene.instances)
    changes = {
        "nothing": lambda: None,
        "moved": lambda: scene.instances.__setitem__(0, replace(there[0], transform=moved)),
        "still": lambda: None,
        "material": lambda: scene.materials.__setitem__(0, Material(base_color=(0.1, 0.2, 0.3))),
        "one more": lambda: scene.instances.append(there[0]),
        "still again": lambda: None,
        "none": scene.instances.clear,
        "still none": lambda: None,
        "back": lambda: scene.instances.extend(there),
    }
    found = {}
    for name, change in changes.items():
        change()
        renderer.render(front_camera())
        found[name] = renderer.technique.changed
    assert [name for name, changed in found.items() if not changed] == ["nothing", "still", "still again", "still none"]
