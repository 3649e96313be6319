"""Images: any file that Pillow reads, as uint8 RGBA; broken files are errors, missing ones get a visible stand-in."""

from __future__ import annotations

import io
import os
import struct
import zlib
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

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


def load_image(source: str | Path | bytes, name: str) -> Image:
    """Decode a file, or the bytes of one, to uint8 RGBA (height, width, 4), row 0 at the top.

    name: what to call it in errors and in `Image.name`. 16-bit channels keep their upper 8 bits. Values are not
    converted between sRGB and linear. Raises FileNotFoundError when there is no such file, SceneError when it holds
    no picture, or one of more than MAX_PIXELS.
    """
    stream = io.BytesIO(source) if isinstance(source, bytes) else source
    try:
        with Pillow.open(stream, formats=FORMATS) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                raise _too_large(name, f"{picture.width} x {picture.height} pixels")
            return Image(_rgba(picture), name)
    except FileNotFoundError:
        raise
    except _BOMB as error:
        raise _too_large(name, "far too many pixels") from error
    except _BROKEN as error:
        what = "is a directory" if isinstance(error, IsADirectoryError) else "cannot be read as a picture"
        raise SceneError(name, "", what, f"replace it by a valid file of {', '.join(FORMATS)}") from error


def _too_large(name: str, size: str) -> SceneError:
    return SceneError(name, "", f"the picture has {size}, more than {MAX_PIXELS}", "scale it down")


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


def load_images(paths: Iterable[Path], warnings: list[str]) -> dict[Path, Image]:
    """Decode each of `paths` once, in threads. A missing file gives the checker and a line in `warnings`.

    Raises SceneError as `load_image` does.
    """
    unique = list(dict.fromkeys(paths))
    with ThreadPoolExecutor(max_workers=min(8, os.cpu_count() or 1)) as threads:
        images = dict(zip(unique, threads.map(_load_or_none, unique), strict=True))
    for path in unique:
        if images[path] is None:
            warnings.append(f"image {path} is missing; a magenta checker stands in for it")
    return {path: image or checker(str(path)) for path, image in images.items()}


def _load_or_none(path: Path) -> Image | None:
    try:
        return load_image(path, str(path))
    except FileNotFoundError:
        return None
