"""Images: any file that Pillow reads, as uint8 RGBA; broken files are errors, missing ones get a visible stand-in."""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image as Pillow

from .errors import SceneError
from .materials import Image

MAX_PIXELS = 8192 * 8192  # 256 MiB as RGBA; the largest square that every WebGPU device can hold
# Named one by one because Pillow's full list holds formats that start other programs (EPS) or are no pictures.
FORMATS = ("PNG", "JPEG", "WEBP", "TGA", "BMP", "TIFF", "GIF", "DDS", "PPM")
# What Pillow's readers raise on broken input, beside OSError, of which its own UnidentifiedImageError is a kind.
_BROKEN = (OSError, SyntaxError, ValueError, EOFError, IndexError, KeyError, TypeError, struct.error, zlib.error)
_BOMB = (Pillow.DecompressionBombError, Pillow.DecompressionBombWarning)


Key = TypeVar("Key")


@dataclass(frozen=True)
class ImageSource:
    """An image to decode: a file or the bytes of one, what to call it, and the file and place that errors name."""

    data: Path | bytes
    name: str
    file: str
    place: str = ""


def load_image(source: str | Path | bytes, name: str) -> Image:
    """Decode a file, or the bytes of one, to uint8 RGBA (height, width, 4), row 0 at the top.

    name: what to call it in errors and in `Image.name`. 16-bit channels keep their upper 8 bits. Values are not
    converted between sRGB and linear. Raises FileNotFoundError when there is no such file, SceneError when it holds
    no picture, or one of more than MAX_PIXELS.
    """
    return _decode(ImageSource(Path(source) if isinstance(source, str) else source, name, name))


def _decode(source: ImageSource) -> Image:
    stream = io.BytesIO(source.data) if isinstance(source.data, bytes) else source.data
    try:
        with Pillow.open(stream, formats=FORMATS) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                raise _too_large(source, f"{picture.width} x {picture.height} pixels")
            return Image(_rgba(picture), source.name)
    except FileNotFoundError:
        raise
    except _BOMB as error:
        raise _too_large(source, "far too many pixels") from error
    except _BROKEN as error:
        what = "is a directory" if isinstance(error, IsADirectoryError) else "is no readable picture"
        what = f"image '{source.name}' {what}"
        raise SceneError(source.file, source.place, what, f"replace it by one of {', '.join(FORMATS)}") from error


def _too_large(source: ImageSource, size: str) -> SceneError:
    problem = f"image '{source.name}' has {size}, more than {MAX_PIXELS} in all"
    return SceneError(source.file, source.place, problem, "scale it down")


def _rgba(picture: Pillow.Image) -> np.ndarray:
    if picture.mode.startswith("I"):  # 16-bit grey; Pillow's own conversion clips it to white
        grey = np.clip(np.asarray(picture).astype(np.int64) >> 8, 0, 255).astype(np.uint8)
        return np.dstack([grey, grey, grey, np.full_like(grey, 255)])
    return np.array(picture.convert("RGBA"))


def checker(name: str) -> Image:
    """The stand-in for a missing image: magenta and black squares, (8, 8, 4)."""
    rows, columns = np.indices((8, 8))
    odd = (rows // 2 + columns // 2) % 2 == 1
    return Image(np.where(odd[..., None], (0, 0, 0, 255), (255, 0, 255, 255)).astype(np.uint8), name)


def load_images(sources: Mapping[Key, ImageSource], warnings: list[str]) -> dict[Key, Image]:
    """Decode each source once, in threads. A missing file gives the checker and a line in `warnings`.

    Raises SceneError as `load_image` does.
    """
    with ThreadPoolExecutor(max_workers=min(8, os.cpu_count() or 1)) as threads:
        decoded = dict(zip(sources, threads.map(_decode_or_none, sources.values()), strict=True))
    images = {}
    for key, image in decoded.items():
        if image is None:
            warnings.append(f"image {sources[key].data!s} is missing; a magenta checker stands in for it")
            image = checker(sources[key].name)
        images[key] = image
    return images


def _decode_or_none(source: ImageSource) -> Image | None:
    try:
        return _decode(source)
    except FileNotFoundError:
        return None
