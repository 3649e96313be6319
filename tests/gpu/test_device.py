"""Choosing an adapter, the limits asked for, and errors for people."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
import wgpu

from octolux.gpu import device as device_module
from octolux.gpu.device import Device, DeviceError, adapters
from octolux.gpu.limits import DEFAULT_LIMITS


def test_adapters_are_ordered_and_can_draw():
    found = adapters()
    order = {"DiscreteGPU": 0, "IntegratedGPU": 1, "VirtualGPU": 2, "CPU": 3}
    ranks = [order.get(a.info["adapter_type"], 4) for a in found]
    assert found and ranks == sorted(ranks)
    assert not [a for a in found if a.info["backend_type"].startswith("OpenGL")]


def test_the_search_leaves_the_environment_alone(monkeypatch):
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    adapters()
    assert "XDG_RUNTIME_DIR" not in device_module.os.environ


def test_an_adapter_by_part_of_its_name(device):
    name = adapters()[0].info["device"]
    assert Device(name[: len(name) // 2].upper()).adapter_name == device.adapter_name


@pytest.mark.parametrize("how", ["argument", "environment"])
def test_an_unknown_adapter_names_those_there_are(monkeypatch, how):
    if how == "environment":
        monkeypatch.setenv("OCTOLUX_ADAPTER", "Voodoo 2")
    with pytest.raises(DeviceError) as caught:
        Device("Voodoo 2" if how == "argument" else None)
    assert "'Voodoo 2'" in str(caught.value)
    assert all(a.summary in str(caught.value) for a in adapters())


def test_no_adapter_at_all(monkeypatch):
    monkeypatch.setattr(wgpu.gpu, "enumerate_adapters_sync", list)
    with pytest.raises(DeviceError, match="sudo apt-get install mesa-vulkan-drivers"):
        Device()


def test_opengl_adapters_are_left_out_and_discrete_ones_come_first(monkeypatch):
    kinds = [("CPU", "Vulkan"), ("Unknown", "Vulkan"), ("DiscreteGPU", "OpenGL"), ("IntegratedGPU", "Metal"),
             ("DiscreteGPU", "D3D12")]  # fmt: skip
    fakes = [SimpleNamespace(info={"adapter_type": t, "backend_type": b}) for t, b in kinds]
    monkeypatch.setattr(wgpu.gpu, "enumerate_adapters_sync", lambda: fakes)
    assert [a.info["backend_type"] for a in adapters()] == ["D3D12", "Metal", "Vulkan", "Vulkan"]
    assert adapters()[2].info["adapter_type"] == "CPU"


def test_limits_are_webgpu_s_defaults(device):
    """No more is asked for than every user's adapter has (WebGPU, section 3.6.2)."""
    actual = device.wgpu.limits
    assert {name: actual[name] for name in DEFAULT_LIMITS} == DEFAULT_LIMITS
    known = {
        "max-texture-dimension-2d": 8192, "max-texture-array-layers": 256, "max-bind-groups": 4,
        "max-sampled-textures-per-shader-stage": 16, "max-storage-textures-per-shader-stage": 4,
        "max-storage-buffers-per-shader-stage": 8, "max-storage-buffer-binding-size": 134217728,
        "max-compute-invocations-per-workgroup": 256, "max-compute-workgroup-storage-size": 16384,
    }  # fmt: skip
    assert {name: DEFAULT_LIMITS[name] for name in known} == known


def test_too_large_a_buffer(device):
    with pytest.raises(DeviceError, match=r"'cells' needs 128\.0 MiB; one binding holds 128\.0 MiB"):
        device.buffer("cells", size=(128 << 20) + 1)


def test_buffers_hold_their_data(device):
    data = np.arange(7, dtype=np.uint8)  # padded to four bytes, and the buffer to sixteen
    buffer = device.buffer("bytes", data)
    assert buffer.size == 16
    assert bytes(device.queue.read_buffer(buffer))[:8] == bytes([*range(7), 0])
    assert not np.frombuffer(device.queue.read_buffer(device.buffer("zeros", size=100)), np.uint8).any()
    device.write(buffer, np.zeros(0))
    device.write(buffer, np.array([7], np.uint32), offset=4)
    assert np.frombuffer(device.queue.read_buffer(buffer), np.uint32)[1] == 7


def raising(error):
    def create(**_):
        raise error

    return create


def test_out_of_memory(device, monkeypatch):
    monkeypatch.setattr(device.wgpu, "create_buffer", raising(wgpu.GPUOutOfMemoryError("")), raising=False)
    with pytest.raises(DeviceError, match=r"is out of memory; octolux holds .*smaller --size") as caught:
        device.buffer("anything", size=16)
    assert device.adapter_name in str(caught.value)


def test_a_texture_that_does_not_fit(device, monkeypatch):
    monkeypatch.setattr(device.wgpu, "create_texture", raising(wgpu.GPUOutOfMemoryError("")), raising=False)
    held = device.memory.total
    with pytest.raises(DeviceError, match="out of memory"):
        device.texture("anything", (4, 4), "rgba8unorm", usage=wgpu.TextureUsage.COPY_SRC)
    assert device.memory.total == held


def test_a_lost_device(device, monkeypatch):
    lost = wgpu.GPUInternalError("Parent device is lost")
    monkeypatch.setattr(device.wgpu, "create_buffer", raising(lost), raising=False)
    with pytest.raises(DeviceError, match=r"was lost \(driver reset.*Start again"):
        device.buffer("anything", size=16)


def test_other_errors_are_bugs_and_pass(device):
    with pytest.raises(wgpu.GPUValidationError), device.guard():
        raise wgpu.GPUValidationError("a binding has the wrong type")


@pytest.mark.parametrize(("width", "height"), [(1, 1), (7, 3), (64, 2), (160, 1)])
def test_textures_are_read_back_at_any_size(device, width, height):
    usage = wgpu.TextureUsage.COPY_SRC | wgpu.TextureUsage.COPY_DST
    texture = device.texture("picture", (width, height), "rgba8unorm", usage=usage)
    data = np.random.default_rng(0).integers(0, 256, (height, width, 4)).astype(np.uint8)
    layout = {"bytes_per_row": width * 4, "rows_per_image": height}
    device.queue.write_texture({"texture": texture}, data, layout, (width, height, 1))
    assert np.array_equal(device.read_texture(texture, np.uint8, 4), data)
