"""What tests of the device share: running passes outside a frame, reading buffers back, and small scenes."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from octolux.frame.frame import FrameSettings
from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.device import Device
from octolux.gpu.passes import ComputePass
from octolux.gpu.profiler import Profiler, Stage
from octolux.picture import Picture
from octolux.scene.cameras import Camera
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene

TESTS = Path(__file__).parent


@contextmanager
def one_stage(device: Device) -> Iterator[Stage]:
    """A stage to record passes in; they have run when the block ends."""
    profiler = Profiler(device, "off")
    with profiler.frame(), profiler.stage("test") as stage:
        yield stage


def read_buffer(device: Device, buffer: Any, dtype: Any = np.float32) -> np.ndarray:
    return np.frombuffer(device.queue.read_buffer(buffer), dtype)


def run_kernel(device: Device, file: str, inputs: np.ndarray, outputs: int, **values: Any) -> np.ndarray:
    """Run a kernel of tests/kernels: `inputs` (threads, k) float32, flat in `given`; returns (threads, outputs)."""
    data = np.ascontiguousarray(inputs, dtype=np.float32)
    given, result = device.buffer("given", data), device.buffer("result", size=len(data) * outputs * 4)
    kernel = ComputePass(
        device, file, str(TESTS / "kernels" / file), [storage("given", "f32"), storage_rw("result", "f32", "write")],
        workgroup=(64, 1, 1), threads=len(data), **values,
    )  # fmt: skip
    with one_stage(device) as stage:
        kernel.run(stage, (len(data),), given=given, result=result)
    return read_buffer(device, result)[: len(data) * outputs].reshape(len(data), outputs)


def random_directions(rng: np.random.Generator, count: int) -> np.ndarray:
    """Unit vectors (count, 3), uniform on the sphere."""
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def largest_cell_error(measured: np.ndarray, expected: np.ndarray) -> float:
    """Largest difference of SH arrays (..., rgb, 4), relative to the largest coefficient of its cell."""
    peak = np.abs(expected).max(axis=(-2, -1), keepdims=True)
    difference = np.abs(measured.astype(np.float64) - expected)
    assert np.all(difference[np.broadcast_to(peak, difference.shape) == 0] == 0), "light in a cell that should be dark"
    return float((difference / np.where(peak > 0, peak, 1)).max())


def material_of(picture: Picture) -> dict[str, np.ndarray]:
    """What the G-buffer holds of each pixel's material, as the shaders unpack it: float64."""
    s = picture._surface.astype(np.uint32)
    base = np.stack([s[..., 2] & 0xFFFF, s[..., 2] >> 16, s[..., 3] & 0xFFFF], axis=-1) / 65535.0
    return {
        "base_color": base, "metallic": (s[..., 3] >> 24) / 255.0, "roughness": ((s[..., 3] >> 16) & 255) / 255.0,
        "specular": (s[..., 1] >> 24) / 255.0,
    }  # fmt: skip


def scene_of(meshes: list[Mesh], materials: list[Material] | None = None, **rest: Any) -> Scene:
    """A scene with each mesh placed once, where it was made."""
    scene = Scene(meshes=meshes, materials=materials or [Material(specular=0.0)], exposure=0.0, **rest)
    scene.instances = scene.instances or [Instance(i) for i in range(len(meshes))]
    return scene


def small_settings(**changes: Any) -> FrameSettings:
    """Settings for tiny pictures: small shadow maps, few sky lights."""
    small = {"shadow_resolution": 64, "rsm_resolution": 32, "sky_lights": 8, "coarse_resolution": 64}
    return FrameSettings(**{**small, **changes})


def front_camera(distance: float = 2.0, **rest: Any) -> Camera:
    """A camera on +z that looks at the origin."""
    return Camera.look_at((0.0, 0.0, distance), (0.0, 0.0, 0.0), **rest)
