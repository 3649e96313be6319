"""The device: adapter choice, resources with their memory accounted, and clear errors."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any

import numpy as np
import wgpu
from wgpu.backends.wgpu_native import extras

from ..scene.errors import OctoluxError
from .limits import DEFAULT_LIMITS
from .memory import MemoryLedger, readable, texture_bytes

OPTIONAL_FEATURES = ("timestamp-query",)
_NO_ADAPTER = (
    "No graphics adapter was found. octolux draws through Vulkan, Metal or DirectX 12. On Linux without a GPU driver "
    "install Mesa's software adapter: sudo apt-get install mesa-vulkan-drivers"
)


class DeviceError(OctoluxError):
    """The graphics device is missing, lost, or out of memory."""


def adapters() -> list[Any]:
    """All adapters octolux can draw with, best first: discrete, integrated, virtual, then software."""
    with _quiet_search():
        found = wgpu.gpu.enumerate_adapters_sync()
    order = {"DiscreteGPU": 0, "IntegratedGPU": 1, "VirtualGPU": 2, "CPU": 3}
    usable = [a for a in found if a.info["backend_type"] not in ("OpenGL", "OpenGLES")]
    return sorted(usable, key=lambda a: order.get(a.info["adapter_type"], 4))


@contextmanager
def _quiet_search() -> Iterator[None]:
    """Look for adapters without noise: OpenGL ones cannot run our passes, and Mesa's window code complains on stderr
    when a machine without a desktop has no XDG_RUNTIME_DIR."""
    with suppress(RuntimeError):  # wgpu's instance exists already where the program around us made it
        extras.set_instance_extras(backends=["Vulkan", "Metal", "DX12"])
    missing = "XDG_RUNTIME_DIR" not in os.environ
    if missing:
        os.environ["XDG_RUNTIME_DIR"] = tempfile.gettempdir()
    try:
        yield
    finally:
        if missing:
            del os.environ["XDG_RUNTIME_DIR"]


def _choose(wanted: str | None) -> Any:
    found = adapters()
    if not found:
        raise DeviceError(_NO_ADAPTER)
    if wanted is None:
        return found[0]
    matching = [a for a in found if wanted.lower() in a.summary.lower()]
    if not matching:
        names = "; ".join(a.summary for a in found)
        raise DeviceError(f"No adapter's name contains '{wanted}'. There are: {names}.")
    return matching[0]


class Device:
    """A graphics device with WebGPU's default limits.

    Parameters
    ----------
    adapter: part of an adapter's name, case-insensitive; by default the environment variable OCTOLUX_ADAPTER,
        else the best adapter there is.

    Raises DeviceError when no adapter fits.
    """

    def __init__(self, adapter: str | None = None):
        chosen = _choose(adapter or os.environ.get("OCTOLUX_ADAPTER"))
        features = [f for f in OPTIONAL_FEATURES if f in chosen.features]
        self.wgpu = chosen.request_device_sync(required_features=features, required_limits=DEFAULT_LIMITS)
        self.queue = self.wgpu.queue
        self.features = frozenset(features)
        info = chosen.info
        self.adapter_name = f"{info['device']} ({info['description']}, {info['backend_type']})"
        self.memory = MemoryLedger()
        self.uploaded_bytes = 0  # since the start, into buffers and textures
        self._fence = self.wgpu.create_buffer(size=4, usage=wgpu.BufferUsage.COPY_SRC)

    def wait(self) -> None:
        """Block until all submitted work is done (`on_submitted_work_done_sync` raises in wgpu 0.32)."""
        self.queue.read_buffer(self._fence)

    @contextmanager
    def guard(self) -> Iterator[None]:
        """Turn wgpu's out-of-memory and device-lost errors into DeviceError; other errors are bugs and pass."""
        try:
            yield
        except wgpu.GPUError as error:
            # wgpu reports a texture that does not fit as a validation error
            if isinstance(error, wgpu.GPUOutOfMemoryError) or "not enough memory" in str(error).lower():
                used = readable(self.memory.total)
                raise DeviceError(
                    f"The graphics device {self.adapter_name} is out of memory; octolux holds {used}. "
                    "Try a smaller --size, fewer lights, or lower shadow resolution and grid size."
                ) from error
            if "lost" not in str(error).lower():
                raise
            raise DeviceError(
                f"The graphics device {self.adapter_name} was lost (driver reset, sleep or a pass that ran too long). "
                "Start again; if it happens again, try a smaller --size."
            ) from error

    def buffer(self, label: str, data: np.ndarray | None = None, size: int = 0, usage: int = 0) -> Any:
        """A storage buffer that can be copied to and from, holding `data` or `size` zero bytes."""
        bytes_needed = max(16, -(-(data.nbytes if data is not None else size) // 16) * 16)
        limit = DEFAULT_LIMITS["max-storage-buffer-binding-size"]
        if bytes_needed > limit:
            raise DeviceError(
                f"'{label}' needs {readable(bytes_needed)}; one binding holds {readable(limit)}. "
                "Use a smaller scene, fewer lights or a lower resolution."
            )
        usage |= wgpu.BufferUsage.STORAGE | wgpu.BufferUsage.COPY_DST | wgpu.BufferUsage.COPY_SRC
        with self.guard():
            made = self.wgpu.create_buffer(label=label, size=bytes_needed, usage=usage)
            if data is not None and data.nbytes:
                self.write(made, data)
        self.memory.add(label, made, bytes_needed)
        return made

    def uniform(self, label: str, data: np.ndarray) -> Any:
        """A uniform buffer that holds `data`."""
        return self.buffer(label, data, usage=wgpu.BufferUsage.UNIFORM)

    def write(self, buffer: Any, data: np.ndarray, offset: int = 0) -> None:
        """Write `data` into `buffer`; its bytes are padded with zeros to a multiple of four."""
        raw = np.ascontiguousarray(data).tobytes()
        if raw:  # wgpu refuses to write nothing
            self.queue.write_buffer(buffer, offset, raw + bytes(-len(raw) % 4))
            self.uploaded_bytes += len(raw)

    def write_layer(self, texture: Any, pixels: np.ndarray, *, layer: int = 0, level: int = 0) -> None:
        """Write `pixels` (height, width, channels) into one layer and mip level of a texture."""
        height, width = pixels.shape[:2]
        layout = {"bytes_per_row": pixels.strides[0], "rows_per_image": height}
        place = {"texture": texture, "mip_level": level, "origin": (0, 0, layer)}
        self.queue.write_texture(place, pixels, layout, (width, height, 1))
        self.uploaded_bytes += pixels.nbytes

    def texture(
        self, label: str, size: tuple[int, ...], format: str, *, usage: int, mip_levels: int = 1, dimension: str = "2d"
    ) -> Any:
        """A texture of `size` (width, height[, layers or depth])."""
        extent = (size[0], size[1], size[2] if len(size) > 2 else 1)
        with self.guard():
            made = self.wgpu.create_texture(
                label=label, size=extent, format=format, usage=usage, mip_level_count=mip_levels, dimension=dimension
            )
        self.memory.add(label, made, texture_bytes(extent, format, mip_levels, dimension))
        return made

    def read_texture(self, texture: Any, dtype: Any, channels: int) -> np.ndarray:
        """The texels of a 2D texture, level 0, as an array (height, width, channels)."""
        width, height = texture.size[:2]
        row = width * channels * np.dtype(dtype).itemsize
        padded = -(-row // 256) * 256  # rows of copies are multiples of 256 bytes
        strip = max(1, DEFAULT_LIMITS["max-storage-buffer-binding-size"] // padded)
        read = [self._read_rows(texture, top, min(strip, height - top), row) for top in range(0, height, strip)]
        return np.frombuffer(b"".join(read), dtype).reshape(height, width, channels)

    def _read_rows(self, texture: Any, top: int, height: int, row: int) -> bytes:
        with self.guard():
            layout = {"bytes_per_row": row, "rows_per_image": height}
            origin = {"texture": texture, "origin": (0, top, 0)}
            return bytes(self.queue.read_texture(origin, layout, (texture.size[0], height, 1)))
