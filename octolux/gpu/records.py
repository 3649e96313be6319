"""Arrays of structs, or of words, in storage textures: on a software adapter a thread reads 16 bytes there in 0.7 ns,
in a storage buffer, word by word, in 1.7 ns (two cores, llvmpipe 22.3)."""

from __future__ import annotations

from typing import Any

import numpy as np
import wgpu

from .bindings import Binding
from .device import Device
from .layout import Struct

_FORMAT, _WORD_FORMAT = "rgba32uint", "r32uint"
_ROW_BITS = 12  # texels of a row: 8192 rows of 16 bytes are four times what one buffer binding holds
_PLACE = f"vec2u((%s) & {(1 << _ROW_BITS) - 1}u, (%s) >> {_ROW_BITS}u)"


def _binding(name: str, access: str, loader: str, format: str = _FORMAT) -> Binding:
    layout = {"storage_texture": {"access": f"{access}-only", "format": format, "view_dimension": "2d"}}
    return Binding(name, f"var {name}: texture_storage_2d<{format}, {access}>;", access, layout, loader=loader)


def _place(kind: Struct, word: int) -> str:
    at = f"{kind.words}u * index + {word}u"
    return _PLACE % (at, at)


def words(name: str) -> Binding:
    """Words that the shader reads with `load_NAME(index) -> u32`."""
    load = f"textureLoad({name}, {_PLACE % ('index', 'index')}).x"
    return _binding(name, "read", f"fn load_{name}(index: u32) -> u32 {{ return {load}; }}", _WORD_FORMAT)


def sampled_words(name: str) -> Binding:
    """The same as `words`, for passes whose four storage textures are taken."""
    layout = {"texture": {"sample_type": "uint", "view_dimension": "2d"}}
    load = f"fn load_{name}(index: u32) -> u32 {{ return textureLoad({name}, {_PLACE % ('index', 'index')}, 0).x; }}"
    return Binding(name, f"var {name}: texture_2d<u32>;", "read", layout, loader=load)


def words_out(name: str) -> Binding:
    """The same, that it writes with `store_NAME(index, word)`."""
    store = f"textureStore({name}, {_PLACE % ('index', 'index')}, vec4u(word, 0u, 0u, 0u));"
    return _binding(name, "write", f"fn store_{name}(index: u32, word: u32) {{ {store} }}", _WORD_FORMAT)


def records(name: str, kind: Struct) -> Binding:
    """Structs that the shader reads with `load_NAME(index)`. Their size is a multiple of 16 bytes."""
    return _binding(name, "read", kind.wgsl_loader(name, lambda word: f"textureLoad({name}, {_place(kind, word)})"))


def records_out(name: str, kind: Struct) -> Binding:
    """The same, that it writes with `store_NAME(index, value)`."""
    words = "".join(
        f"textureStore({name}, {_place(kind, i)}, {word}); " for i, word in enumerate(kind.wgsl_words("value"))
    )
    return _binding(name, "write", f"fn store_{name}(index: u32, value: {kind.name}) {{ {words}}}")


def record_texture(device: Device, label: str, kind: Struct, count: int, data: np.ndarray | None = None) -> Any:
    """Room for `count` structs, or more, of zeros or beginning with `data` (kind.dtype, 1D)."""
    return _texture(device, label, _FORMAT, count * kind.words, data)


def word_texture(device: Device, label: str, count: int, data: np.ndarray | None = None) -> Any:
    """Room for `count` words, or more, of zeros or beginning with `data` (uint32, 1D)."""
    return _texture(device, label, _WORD_FORMAT, count, data)


def _texture(device: Device, label: str, format: str, texels: int, data: np.ndarray | None) -> Any:
    rows = -(-max(1, texels) // (1 << _ROW_BITS))
    usage = wgpu.TextureUsage.STORAGE_BINDING | wgpu.TextureUsage.TEXTURE_BINDING
    usage |= wgpu.TextureUsage.COPY_DST | wgpu.TextureUsage.COPY_SRC
    made = device.texture(label, (1 << _ROW_BITS, rows), format, usage=usage)
    if data is not None and data.size:
        _write(device, made, (16 if format == _FORMAT else 4) << _ROW_BITS, data)
    return made


def _write(device: Device, texture: Any, row_bytes: int, data: np.ndarray) -> None:
    """Whole rows, the last filled up with zeros."""
    rows = -(-data.nbytes // row_bytes)
    padded = np.zeros(rows * row_bytes, np.uint8)
    padded[: data.nbytes] = data.view(np.uint8)
    layout = {"bytes_per_row": row_bytes, "rows_per_image": rows}
    device.queue.write_texture({"texture": texture}, padded, layout, (1 << _ROW_BITS, rows, 1))


def write_records(device: Device, texture: Any, data: np.ndarray) -> None:
    """Write structs (1D) over the first ones of a texture that has room for them."""
    if len(data):
        _write(device, texture, 16 << _ROW_BITS, data)


def read_records(device: Device, texture: Any, kind: Struct, count: int) -> np.ndarray:
    """The first `count` structs (kind.dtype)."""
    return device.read_texture(texture, np.uint32, 4).reshape(-1)[: count * kind.size // 4].view(kind.dtype)


def read_words(device: Device, texture: Any, count: int) -> np.ndarray:
    """The first `count` words, uint32."""
    return device.read_texture(texture, np.uint32, 1).reshape(-1)[:count]
