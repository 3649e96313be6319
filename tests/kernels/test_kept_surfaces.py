"""cascaded-lpv's geometry volume and reflectors: kept while nothing moves and no window does, and else made anew."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, read_buffer, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, quad
from octolux.scene.lights import PointLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.lpv.strips import unpack_planes

LAMP = PointLight(position=(0.2, 1.2, 0.9), intensity=(5.0, 6.0, 7.0))
FLOOR = quad([(-2, 0, 2), (2, 0, 2), (2, 0, -2), (-2, 0, -2)])


def scene(x: float = 0.0) -> Scene:
    """A box over a floor."""
    place = np.eye(4)
    place[:3, 3] = (x, 0.5, 0.0)
    return scene_of([FLOOR, box((-0.3,) * 3, (0.3,) * 3)], [Material(base_color=(0.5, 0.4, 0.3), specular=0.0)],
                    lights=[LAMP], instances=[Instance(0), Instance(1, transform=place)])  # fmt: skip


def renderer(device, **settings) -> Renderer:
    return Renderer(
        scene(), "cascaded-lpv", settings={"n": 16, "bounces": 2, **settings}, size=(24, 16), device=device,
        exposure=0.0, default_light=False, profile=True, frame_settings=small_settings(sky_lights=0, emitter_lights=0),
    )  # fmt: skip


def made_anew(made: Renderer, camera) -> bool:
    """Whether a frame makes the geometry volume and the reflectors."""
    made.render(camera)
    stages = set(made.profiler.last_frame()) & {"geometry volume", "reflectors"}
    assert len(stages) in (0, 2)
    return bool(stages)


def held(made: Renderer) -> list[np.ndarray]:
    """Shares, where they are, and what they reflect; a plane without a share may be anywhere."""
    way = made.technique.way
    words = read_buffer(made.device, way.geometry.packed, np.uint32).reshape(-1, 4)[: way.levels.cells]
    strips = unpack_planes(words)
    reflectors, places = way.reflectors.reflectors, way.reflectors.places
    return [strips.shares, *(np.where(strips.shares > 0.0, each, 0.0) for each in strips[1:]),
            read_buffer(made.device, reflectors), read_buffer(made.device, places)]  # fmt: skip


def same(one: list[np.ndarray], other: list[np.ndarray]) -> bool:
    return all(np.array_equal(*both) for both in zip(one, other, strict=True))


def test_surfaces_are_kept_while_nothing_moves(device):
    """Neither light nor a camera that stays in its cells does; a frame is to the bit as the first one."""
    made, camera = renderer(device), front_camera()
    first = made.render(camera).radiance
    before = held(made)
    assert not made_anew(made, camera) and np.array_equal(made.render(camera).radiance, first)
    made.scene.lights[0] = replace(LAMP, position=(-0.4, 1.0, 0.5))
    assert not made_anew(made, camera)
    assert not made_anew(made, front_camera(2.0 + 1e-4))
    assert same(before, held(made)) and all(each.any() for each in before)


@pytest.mark.parametrize("what", ["instance", "material", "camera"])
def test_surfaces_are_made_anew_when_they_or_windows_are_elsewhere(device, what):
    """And are then as they are if they are made once more, whether anything has changed or not."""
    made, camera = renderer(device), front_camera()
    assert made_anew(made, camera) and not made_anew(made, camera)
    before, windows = held(made), made.technique.cascades.windows
    if what == "instance":
        made.scene.instances[1] = scene(0.4).instances[1]
    elif what == "material":
        made.scene.materials[0] = Material(base_color=(0.1, 0.4, 0.9), specular=0.0)
    else:
        camera = front_camera(0.9)
    assert made_anew(made, camera) and (made.technique.cascades.windows != windows) == (what == "camera")
    after = held(made)
    assert not same(before, after) and not made_anew(made, camera)
    made.technique.way.surfaces.forget()
    assert made_anew(made, camera) and same(after, held(made))


def test_what_lamps_and_camera_see_is_made_anew_each_frame(device):
    made = renderer(device, surfels="lamps and camera")
    assert all(made_anew(made, front_camera()) for _ in range(3))
