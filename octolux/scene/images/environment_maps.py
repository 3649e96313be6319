"""Pictures of the surroundings: Radiance HDR, OpenEXR, and 8-bit pictures, as float32 radiance."""

from __future__ import annotations

import io
import os
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

from ...simulator.tonemap import srgb_decode
from ..errors import SceneError
from ..files import check_ordinary, read_file
from .decode import FORMATS, load_image
from .radiance_hdr import HdrFault, read_hdr

MOST_PIXELS = 16384 * 8192  # 1.6 GB as float32 RGB
_BAND = 1 << 18
_REMEDY = "give an equirectangular .hdr or .exr file"


def load_environment_map(path: Path, scale: float, file: Path, place: str, warnings: list[str]) -> np.ndarray:
    """float32 (height, width, 3), linear Rec. 709, row 0 at the top: the picture's values times `scale`.

    .hdr and .pic, .exr (channels R, G, B or Y of the first part), else what `images` reads, decoded from sRGB to
    [0, 1]. Texels that are negative or not a number become 0, infinite ones the largest finite value; `warnings` says
    how many. file, place: what errors name. Raises SceneError: no such file, no picture, one of more than MOST_PIXELS
    (found in its header), or without a finite value.
    """
    readers = {".hdr": _hdr, ".pic": _hdr, ".exr": _exr}
    try:
        pixels = readers.get(path.suffix.lower(), _pillow)(path)
    except FileNotFoundError as error:
        raise SceneError(file, place, f"there is no file '{path}'", _REMEDY) from error
    except (HdrFault, OSError) as error:
        reason = error.strerror or "it is no picture" if isinstance(error, OSError) else error
        raise SceneError(file, place, f"'{path}' cannot be read: {reason}", _REMEDY) from error
    return _repaired(pixels, scale, SceneError(file, place, f"'{path}' holds no finite value", _REMEDY), path, warnings)


def _hdr(path: Path) -> np.ndarray:
    return read_hdr(read_file(path), MOST_PIXELS)


def _exr(path: Path) -> np.ndarray:
    import OpenEXR

    check_ordinary(path)
    with path.open("rb"):
        pass  # OpenEXR's own error does not say why a file cannot be opened
    try:
        with _quiet():
            header = OpenEXR.File(str(path), header_only=True).header()
        low, high = (np.asarray(corner, np.int64) for corner in header["dataWindow"])
        width, height = (high - low + 1).tolist()
        if not 0 < width * height <= MOST_PIXELS:
            raise HdrFault(f"has {width} x {height} pixels, of at most {MOST_PIXELS}")
        with _quiet() as said:
            channels = OpenEXR.File(str(path), separate_channels=True).channels()
        if said.getvalue():  # it prints a warning and goes on when pixels cannot be decoded
            raise HdrFault("its pixels are damaged")
    except (RuntimeError, ValueError, KeyError, TypeError, MemoryError) as error:
        raise error if isinstance(error, HdrFault) else HdrFault("it is no readable OpenEXR file") from error
    return _joined(channels)


@contextmanager
def _quiet() -> Iterator[io.StringIO]:
    """Keeps from the user what OpenEXR prints: to Python's standard output, which is given, and to standard error."""
    said = io.StringIO()
    try:
        kept, nothing = os.dup(2), os.open(os.devnull, os.O_WRONLY)
    except OSError:  # a program without standard error
        with redirect_stdout(said):
            yield said
        return
    try:
        os.dup2(nothing, 2)
        with redirect_stdout(said):
            yield said
    finally:
        os.dup2(kept, 2)
        os.close(kept)
        os.close(nothing)


def _joined(channels: dict[str, Any]) -> np.ndarray:
    for names in (("R", "G", "B"), ("Y", "Y", "Y")):
        planes = [channels[name].pixels for name in names if name in channels]
        if len(planes) == 3 and len({plane.shape for plane in planes}) == 1:
            return np.stack([np.asarray(plane, np.float32) for plane in planes], axis=-1)
    raise HdrFault(f"it has the channels {', '.join(sorted(channels))}, not R, G and B or Y of one size")


def _pillow(path: Path) -> np.ndarray:
    try:
        pixels = load_image(path, path.name).pixels
    except SceneError as error:
        raise HdrFault(f"it is neither .hdr, .exr nor one of {', '.join(FORMATS)} ({error.problem})") from error
    decoded, table = np.empty((*pixels.shape[:2], 3), np.float32), srgb_decode(np.arange(256) / 255).astype(np.float32)
    step = max(1, _BAND // pixels.shape[1])  # rows at once, for indices take eight bytes a channel
    for top in range(0, len(pixels), step):
        np.take(table, pixels[top : top + step, :, :3], out=decoded[top : top + step], mode="clip")
    return decoded


def _repaired(pixels: np.ndarray, scale: float, empty: SceneError, path: Path, warnings: list[str]) -> np.ndarray:
    """The pixels times `scale`, every one finite and not negative. Raises `empty` when none is finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        scaled = np.multiply(pixels, np.float32(scale), out=pixels if pixels.flags.writeable else None)
    scaled = np.ascontiguousarray(scaled, np.float32)
    if scaled.min() >= 0 and scaled.max() < np.inf:  # neither holds where one is not a number
        return scaled
    good = np.isfinite(scaled) & (scaled >= 0)
    finite = scaled[np.isfinite(scaled)]
    if not finite.size:
        raise empty
    texels = int((~good).any(axis=-1).sum())
    warnings.append(f"{path}: {texels} texels are negative or not finite; they are clamped")
    return np.nan_to_num(scaled, nan=0.0, posinf=max(float(finite.max()), 0.0), neginf=0.0).clip(min=0.0)
