"""KHR_texture_basisu: KTX 2 pictures of Basis Universal (ETC1S or UASTC), decoded by the package opengl-basisu.

It has no wheel for Linux on ARM and is not installed there; without it the plain images that a file may hold beside
these stand in. The decoder makes what the header says; so the header is read here first (KTX 2.0, section 3).
"""

from __future__ import annotations

import struct
from functools import partial
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..files import read_file
from ..images.cache import content_key
from ..images.decode import MAX_PIXELS, ImageSource
from ..images.lazy import LazyImage
from ..materials import Image

try:
    import opengl_basisu
except ImportError:  # no wheel for this system
    opengl_basisu = None  # type: ignore[assignment]

NAME = "KHR_texture_basisu"
_MAGIC = b"\xabKTX 20\xbb\r\n\x1a\n"
# After the magic: vkFormat, typeSize, width, height, depth, layers, faces, levels, supercompression; then offsets and
# lengths of three tables; then offset, length and uncompressed length of level 0.
_HEADER = struct.Struct("<9I4I2Q3Q")
_BLOCK_BYTES = 16  # of UASTC, for 4 x 4 pixels


def is_available() -> bool:
    """Whether the decoder is installed."""
    return opengl_basisu is not None


def load_ktx2(source: ImageSource) -> Image:
    """A KTX 2 picture as RGBA, its largest level. Raises FileNotFoundError, or SceneError when it is broken."""
    encoded = source.data if isinstance(source.data, bytes) else _read(source, source.data)
    size = _size(source, encoded)
    image = LazyImage(size, content_key("ktx2", encoded), partial(_decode, source, encoded), source.name)
    image.pixels  # noqa: B018  decoded now, so that broken data is found
    return image


def _read(source: ImageSource, path: Path) -> bytes:
    try:
        return read_file(path)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        raise _broken(source, str(error)) from error


def _size(source: ImageSource, encoded: bytes) -> tuple[int, int]:
    """Width and height, checked together with all that the decoder allocates by."""
    if encoded[: len(_MAGIC)] != _MAGIC or len(encoded) < len(_MAGIC) + _HEADER.size:
        raise _broken(source, "it does not begin as KTX 2 files do")
    header = _HEADER.unpack_from(encoded, len(_MAGIC))
    width, height, depth, layers, faces, levels = header[2:8]
    if not width or not height or depth or layers > 1 or faces != 1 or not levels:
        raise _broken(source, "it is not one picture of two dimensions")
    if width * height > MAX_PIXELS:
        raise _broken(source, f"it has {width} x {height} pixels, more than {MAX_PIXELS} in all")
    offset, length, uncompressed = header[-3:]
    if offset + length > len(encoded):
        raise _broken(source, "it ends within its pixels")
    if uncompressed > -(-width // 4) * -(-height // 4) * _BLOCK_BYTES:
        raise _broken(source, f"{uncompressed} bytes are too many for {width} x {height} pixels")
    return width, height


def _decode(source: ImageSource, encoded: bytes) -> np.ndarray:
    try:
        return opengl_basisu.open(encoded).transcode(opengl_basisu.Target.RGBA8).data
    except (opengl_basisu.BasisuError, IndexError) as error:
        raise _broken(source, str(error)) from error


def _broken(source: ImageSource, reason: str) -> SceneError:
    problem = f"image '{source.name}' is no readable KTX 2 picture of Basis Universal: {reason}"
    return SceneError(source.file, source.place, problem, "replace it, or export the model with PNG or JPEG")
