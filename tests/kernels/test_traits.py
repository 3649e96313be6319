"""Traits of surfaces in one word (frame/traits.py): of VPLs and of pixels, and what is left of them after packing."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import TESTS, front_camera, material_of, one_stage, read_buffer, scene_of, small_settings

from octolux.frame import traits
from octolux.frame.structs import VPL
from octolux.gpu.bindings import storage_rw
from octolux.gpu.passes import ComputePass
from octolux.gpu.records import read_records, read_words
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box
from octolux.scene.lights import PointLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

WALL = (0.02, 0.5, 0.9)
ALBEDOS = np.array([WALL, (0.6, 0.3, 0.1), (0.5, 0.5, 0.5)])
MATERIALS = [Material(base_color=WALL, double_sided=True), Material(base_color=(0.6, 0.3, 0.1)),
             Material(base_color=(1.0, 1.0, 1.0), metallic=0.5)]  # fmt: skip
SIZES = [3.0, 0.3, 1.1]
LAMP = PointLight(position=(0.1, 1.2, 1.0), intensity=(10.0, 10.0, 10.0))


def test_packing_errs_as_it_says():
    rng = np.random.default_rng(1)
    albedo, size = rng.random((10000, 3)), np.exp2(rng.uniform(-15, 15, 10000))
    moving = rng.random(10000) < 0.5
    a, s, m = traits.unpack_traits(traits.pack_traits(albedo, size, moving))
    assert np.all(np.abs(a - albedo) <= traits.ROOT_STEP * (2 * np.sqrt(albedo) + traits.ROOT_STEP) + 1e-15)
    assert np.abs(np.log2(s / size)).max() <= 0.5 / traits.STEPS_PER_OCTAVE + 1e-12
    assert np.array_equal(m, moving)


def test_sizes_beyond_the_range_are_its_ends():
    _, size, moving = traits.unpack_traits(traits.pack_traits(np.ones((3, 3)), [0.0, 1e-9, 1e9], [True, False, True]))
    assert size.tolist() == [2.0**-16, 2.0**-16, 2.0**15.75] and moving.tolist() == [True, False, True]


class Surfaces(NoTechnique):
    """A technique that looks at the VPLs, their surfaces, and the pixels'."""

    needs = frozenset({"rsm", "surfaces"})

    def update(self, frame) -> None:
        self.frame = frame

    @property
    def of_vpls(self) -> tuple[np.ndarray, np.ndarray]:
        """VPLs and the traits of their surfaces."""
        count = sum(count for _, count in self.frame.vpl_ranges)
        vpls = read_records(self.device, self.frame.vpls, VPL, count)
        return vpls, read_words(self.device, self.frame.vpl_surfaces, count)

    def of_pixels(self) -> np.ndarray:
        """uint32 (pixels, 6): what the test kernel writes."""
        result = self.device.buffer("result", size=24 * int(np.prod(self.frame.pixels)))
        kernel = ComputePass(
            self.device, "pixel traits", str(TESTS / "kernels" / "pixel_traits.wgsl"),
            [*traits.pixel_bindings(), storage_rw("result", "u32", "write")], structs=traits.PIXEL_STRUCTS,
            **traits.TRAIT_VALUES,
        )  # fmt: skip
        with one_stage(self.device) as stage:
            kernel.run(stage, self.frame.pixels, **traits.pixel_resources(self.frame), result=result)
        return read_buffer(self.device, result, np.uint32).reshape(-1, 6)


def block(x: float) -> np.ndarray:
    transform = np.eye(4)
    transform[0, 3] = x
    return transform


@pytest.fixture(scope="module")
def seen(device):
    """A room with two blocks in it, of which the first moves: the picture, and what the technique saw."""
    low, high = np.array([-1.5, -1.5, -1.5]), np.array([1.5, 1.5, 1.5])
    meshes = [box(low, high, inward=True), box((-0.1, -0.15, -0.1), (0.1, 0.15, 0.1), material=1),
              box((-0.55, -0.4, -0.2), (0.55, 0.4, 0.2), material=2)]  # fmt: skip
    scene = scene_of(meshes, MATERIALS, lights=[LAMP], instances=[Instance(0), Instance(1, block(-0.5)),
                                                                  Instance(2, block(0.4))])  # fmt: skip
    renderer = Renderer(scene, "none", size=(48, 32), device=device, default_light=False, exposure=0.0,
                        frame_settings=small_settings(sky_lights=0, emitter_lights=0))  # fmt: skip
    renderer.technique = Surfaces(device, Settings())
    renderer.render(front_camera(1.4))
    scene.instances[1] = replace(scene.instances[1], transform=block(-0.6))
    picture = renderer.render(front_camera(1.4))
    return picture, renderer.technique


def expected(objects: np.ndarray, albedo: np.ndarray) -> np.ndarray:
    return traits.pack_traits(albedo, np.array(SIZES)[objects], objects == 1)


def test_traits_of_vpls(seen):
    """Where a VPL lies tells whose it is: the room's walls are 1.5 m away in one direction."""
    vpls, words = seen[1].of_vpls
    position = vpls["position"].astype(np.float64)
    on_wall = np.abs(np.abs(position).max(axis=1) - 1.5) < 1e-4
    objects = np.where(on_wall, 0, np.where(position[:, 0] < -0.3, 1, 2))
    assert vpls["area"].all() and np.all(np.bincount(objects, minlength=3) >= 20)
    assert np.array_equal(words, expected(objects, ALBEDOS[objects]))


def test_traits_of_pixels(seen):
    """The same word, from the G-buffer's 16 bits of albedo and the triangle's number."""
    picture, technique = seen
    result = technique.of_pixels()
    m = material_of(picture)
    albedo = (m["base_color"] * (1.0 - m["metallic"][..., None])).reshape(-1, 3)
    objects = picture.layers["object_id"].ravel().astype(int) - 1
    assert np.all(np.bincount(objects, minlength=3) > 20)
    assert np.array_equal(result[:, 0], expected(objects, albedo))
    unpacked, size, moving = traits.unpack_traits(result[:, 0])
    np.testing.assert_allclose(result[:, 1:4].view(np.float32), unpacked, rtol=1e-6)
    np.testing.assert_allclose(result[:, 4].view(np.float32), size, rtol=1e-6)
    assert np.array_equal(result[:, 5] == 1, moving)


def test_where_nothing_is_seen_there_are_none(device):
    """A white surface has all bits of its albedo."""
    scene = scene_of([box((-0.2, -0.2, -0.2), (0.2, 0.2, 0.2))], lights=[LAMP])
    renderer = Renderer(scene, "none", size=(16, 16), device=device, default_light=False, exposure=0.0,
                        frame_settings=small_settings(sky_lights=0, emitter_lights=0))  # fmt: skip
    renderer.technique = Surfaces(device, Settings())
    depth = renderer.render(front_camera()).layers["depth"].ravel()
    vpls, words = renderer.technique.of_vpls
    for packed, there in ((renderer.technique.of_pixels()[:, 0], depth > 0), (words, vpls["area"] > 0)):
        assert np.array_equal(packed > 0, there) and 0 < there.sum() < len(there)
        assert np.all(packed[there] & 0xFFFFFF == 0xFFFFFF)
