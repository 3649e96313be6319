"""Images: any file that Pillow reads, as uint8 RGBA; broken files are errors, missing ones get a visible stand-in."""

from __future__ import annotations

import io
import os
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TypeVar

import numpy as np
from PIL import Image as Pillow

from ..errors import SceneError
from ..files import read_file
from ..materials import Image
from .cache import content_key, is_known_good, remember_good
from .lazy import LazyImage

MAX_PIXELS = 8192 * 8192  # 256 MiB as RGBA; the largest square that every WebGPU device can hold
# Named one by one because Pillow's full list holds formats that start other programs (EPS) or are no pictures.
FORMATS = ("PNG", "JPEG", "WEBP", "TGA", "BMP", "TIFF", "GIF", "DDS", "PPM")
_BAND = 1 << 22  # pixels converted at once, so that what a picture of MAX_PIXELS takes beside itself stays small
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
    converted between sRGB and linear. A file that the cache knows to be good is decoded when its pixels are first asked
    for. Raises FileNotFoundError when there is no such file, SceneError when it holds no picture, or one of more than
    MAX_PIXELS.
    """
    return _load(ImageSource(Path(source) if isinstance(source, str) else source, name, name))


def _load(source: ImageSource) -> Image:
    try:
        encoded = source.data if isinstance(source.data, bytes) else read_file(source.data)
    except FileNotFoundError:
        raise
    except (OSError, ValueError) as error:
        raise _unreadable(source, error) from error
    key = content_key(encoded)
    with _opened(source, encoded) as picture:
        image = LazyImage(picture.size, key, partial(_decoded, source, encoded), source.name)
    if not key or not is_known_good(key):
        image.pixels  # noqa: B018  decoded now, so that broken files are found
        remember_good(key)
    return image


@contextmanager
def _opened(source: ImageSource, encoded: bytes) -> Iterator[Pillow.Image]:
    """The picture, of which no more than the header need be read. Raises SceneError, also for what happens within."""
    try:
        with Pillow.open(io.BytesIO(encoded), formats=FORMATS) as picture:
            if picture.width * picture.height > MAX_PIXELS:
                raise _too_large(source, f"{picture.width} x {picture.height} pixels")
            yield picture
    except SceneError:
        raise
    except _BOMB as error:
        raise _too_large(source, "far too many pixels") from error
    except Exception as error:  # Pillow's readers raise nearly anything: NotImplementedError, KeyError, struct.error
        raise _unreadable(source, error) from error


def _decoded(source: ImageSource, encoded: bytes) -> np.ndarray:
    with _opened(source, encoded) as picture:
        return _rgba(picture)


def from_pillow(picture: Pillow.Image, name: str) -> Image:
    """A Pillow image as it is. Raises SceneError when it has more than MAX_PIXELS or cannot be decoded."""
    source = ImageSource(b"", name, name)
    if picture.width * picture.height > MAX_PIXELS:
        raise _too_large(source, f"{picture.width} x {picture.height} pixels")
    try:
        return Image(_rgba(picture), name)
    except Exception as error:
        raise _unreadable(source, error) from error


def _unreadable(source: ImageSource, error: Exception) -> SceneError:
    what = "is a directory" if isinstance(error, IsADirectoryError) else "is no readable picture"
    what = f"image '{source.name}' {what}"
    return SceneError(source.file, source.place, what, f"replace it by one of {', '.join(FORMATS)}")


def _too_large(source: ImageSource, size: str) -> SceneError:
    problem = f"image '{source.name}' has {size}, more than {MAX_PIXELS} in all"
    return SceneError(source.file, source.place, problem, "scale it down")


def _rgba(picture: Pillow.Image) -> np.ndarray:
    """uint8 (height, width, 4), converted in bands of rows."""
    width, height = picture.size
    step = max(1, _BAND // width)
    if step >= height:
        return _converted(picture)
    pixels = np.empty((height, width, 4), np.uint8)
    for top in range(0, height, step):
        bottom = min(top + step, height)
        pixels[top:bottom] = _converted(picture.crop((0, top, width, bottom)))
    return pixels


def _converted(picture: Pillow.Image) -> np.ndarray:
    if picture.mode.startswith("I"):  # 16-bit grey; Pillow's own conversion clips it to white
        grey = np.clip(np.asarray(picture).astype(np.int64) >> 8, 0, 255).astype(np.uint8)
        return np.dstack([grey, grey, grey, np.full_like(grey, 255)])
    return np.array(picture.convert("RGBA"))


def checker(name: str) -> Image:
    """The stand-in for a missing image: magenta and black squares, (8, 8, 4)."""
    rows, columns = np.indices((8, 8))
    odd = (rows // 2 + columns // 2) % 2 == 1
    return Image(np.where(odd[..., None], (0, 0, 0, 255), (255, 0, 255, 255)).astype(np.uint8), name)


def load_images(
    sources: Mapping[Key, ImageSource], warnings: list[str], load: Callable[[ImageSource], Image] = _load
) -> dict[Key, Image]:
    """Decode each source once, in threads. A missing file gives the checker and a line in `warnings`.

    load: decodes one; raises FileNotFoundError when there is no such file. Raises SceneError as `load_image` does.
    """
    with ThreadPoolExecutor(max_workers=min(8, os.cpu_count() or 1)) as threads:
        decoded = dict(zip(sources, threads.map(partial(_load_or_none, load), sources.values()), strict=True))
    images = {}
    for key, image in decoded.items():
        if image is None:
            warnings.append(f"image {sources[key].data!s} is missing; a magenta checker stands in for it")
            image = checker(sources[key].name)
        images[key] = image
    return images


def _load_or_none(load: Callable[[ImageSource], Image], source: ImageSource) -> Image | None:
    try:
        return load(source)
    except FileNotFoundError:
        return None
