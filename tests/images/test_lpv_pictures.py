"""What holds for the pictures of each light propagation volume: the same bits, no light from nothing, empty scenes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, small_settings

from octolux.gpu.device import Device
from octolux.renderer import Renderer
from octolux.scene.lights import PointLight
from octolux.scene.load import load_scene
from octolux.scene.scene import Scene
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings
from octolux.techniques.lpv.octree.settings import OctreeLpvSettings

SETTINGS = {"octree-lpv": OctreeLpvSettings, "cascaded-lpv": CascadedLpvSettings}
WAYS = [(name, preset) for name, settings in SETTINGS.items() for preset in ("default", *settings.PRESETS)]
LAMP = PointLight(position=(0.2, 1.2, 0.3), intensity=(5.0, 6.0, 7.0))


def renderer(device, scene, technique, preset) -> Renderer:
    return Renderer(
        scene, technique, preset=preset, settings={"n": 16}, size=(48, 36), device=device, exposure=0.0,
        anti_aliasing="off", default_light=False, frame_settings=small_settings(sky_lights=0, emitter_lights=0),
    )  # fmt: skip


@pytest.mark.parametrize("technique, preset", WAYS)
def test_the_same_bits(device, technique, preset):
    """In a second frame, after another scene's, and on a device of its own."""
    scene = load_scene("cornell-box")
    made = renderer(device, scene, technique, preset)
    first = made.render()
    made.scene = load_scene("furnace")
    made.render(front_camera(0.5))
    made.scene = scene
    for again in (made.render(), renderer(Device(), scene, technique, preset).render()):
        assert np.array_equal(first.radiance, again.radiance) and np.array_equal(first.display, again.display)
    assert first.layers["indirect"].any()


@pytest.mark.parametrize("technique, preset", WAYS)
def test_nothing_shines(device, technique, preset):
    scene = load_scene("cornell-box")
    scene.lights, scene.materials = [], [replace(m, emissive=(0.0, 0.0, 0.0)) for m in scene.materials]
    picture = renderer(device, scene, technique, preset).render()
    assert picture.mask.any() and not picture.radiance.any()


@pytest.mark.parametrize("technique, preset", WAYS)
@pytest.mark.parametrize("lights", [[], [LAMP]], ids=["dark", "lit"])
def test_an_empty_scene(device, technique, preset, lights):
    picture = renderer(device, Scene(lights=lights, exposure=0.0), technique, preset).render(front_camera())
    assert not picture.mask.any() and not picture.radiance.any()
