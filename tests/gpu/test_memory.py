"""The memory ledger: what it counts, and that nothing is left when resources go."""

from __future__ import annotations

import gc

import numpy as np
import pytest
import wgpu
from gpu_tools import front_camera, scene_of

from octolux.frame.frame import FrameSettings
from octolux.gpu.device import Device
from octolux.gpu.memory import MemoryLedger, readable, texture_bytes
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.lights import PointLight


class Thing:
    """Something that can be referenced weakly."""


def test_the_ledger_adds_up_and_empties():
    ledger, things = MemoryLedger(), [Thing() for _ in range(3)]
    for thing, label, size in zip(things, ("a", "b", "a"), (10, 100, 5), strict=True):
        ledger.add(label, thing, size)
    assert ledger.total == 115 and list(ledger.by_label().items()) == [("b", 100), ("a", 15)]
    del thing
    things.pop()
    assert ledger.by_label() == {"b": 100, "a": 10}
    things.clear()
    assert ledger.total == 0 and ledger.by_label() == {}


@pytest.mark.parametrize(("size", "format", "levels", "dimension", "expected"), [
    ((256, 256, 1), "rgba8unorm", 1, "2d", 4 << 16),
    ((256, 256, 3), "rgba8unorm-srgb", 9, "2d", 3 * 4 * sum(4**i for i in range(9))),
    ((8, 2, 1), "r32float", 4, "2d", 4 * (16 + 4 + 2 + 1)),
    ((4, 4, 4), "rgba16float", 3, "3d", 8 * (64 + 8 + 1)),
    ((5, 3, 2), "rgba32float", 1, "2d", 16 * 30),
])  # fmt: skip
def test_texture_bytes(size, format, levels, dimension, expected):
    assert texture_bytes(size, format, levels, dimension) == expected


@pytest.mark.parametrize(("size", "text"), [
    (0, "0 B"), (1023, "1023 B"), (1024, "1.0 KiB"), (128 << 20, "128.0 MiB"), (3 << 29, "1.5 GiB"),
    (1 << 50, "1024.0 TiB"),
])  # fmt: skip
def test_readable(size, text):
    assert readable(size) == text


def test_buffers_and_textures_are_counted(device):
    before = device.memory.total
    buffer = device.buffer("numbers of a test", np.zeros(5, np.float32))  # rounded up to 16 bytes
    texture = device.texture("picture of a test", (64, 32), "rgba16float", usage=wgpu.TextureUsage.COPY_SRC)
    labels = device.memory.by_label()
    assert labels["numbers of a test"] == buffer.size == 32
    assert labels["picture of a test"] == 64 * 32 * 8
    assert device.memory.total == before + 32 + 64 * 32 * 8
    del buffer, texture
    assert device.memory.total == before


def test_a_renderer_leaves_nothing_behind():
    device = Device()
    lamp = PointLight(position=(0.0, 0.0, 1.0), intensity=(1.0, 1.0, 1.0))
    scene = scene_of([quad([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)])], lights=[lamp])
    settings = FrameSettings(shadow_resolution=64, rsm_resolution=64)
    renderer = Renderer(scene, "uniform-lpv", size=(16, 16), device=device, frame_settings=settings)
    picture = renderer.render(front_camera())
    labels = device.memory.by_label()
    assert device.memory.total == sum(labels.values())
    assert labels["LPV accumulated light"] == 32**3 * 48
    assert labels["shadow maps"] == 6 * 64 * 64 * 4
    held = device.memory.total
    renderer.render(front_camera())
    assert device.memory.total == held, "a second frame needs no more memory"
    del renderer, picture
    gc.collect()
    assert device.memory.by_label() == {}
