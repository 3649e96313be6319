"""Files a picture is written to; each appears whole or not at all."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NamedTuple

from ..picture import Picture
from ..scene.errors import OctoluxError
from . import exr, npz, png
from .atomic import replacing
from .options import FileOptions


class Format(NamedTuple):
    """write(picture, path, options) raises OSError; complete(path, (width, height), options) never raises."""

    write: Callable[[Picture, Path, FileOptions], None]
    complete: Callable[[Path, tuple[int, int], FileOptions], bool]


FORMATS: dict[str, Format] = {
    ".png": Format(png.write, png.complete),
    ".exr": Format(exr.write, exr.complete),
    ".npz": Format(npz.write, npz.complete),
}


def check_writable(path: Path, suffixes: Iterable[str]) -> None:
    """Raise OctoluxError unless `path` has one of the suffixes and its folder can be written to."""
    if path.suffix.lower() not in suffixes:
        raise OctoluxError(f"{path}: files of the kind '{path.suffix}' are not written. Use {' or '.join(suffixes)}.")
    folder = path.parent
    if not folder.is_dir():
        raise OctoluxError(f"{path}: there is no folder '{folder}'. Make it first: mkdir -p '{folder}'.")
    if path.is_dir() or not os.access(folder, os.W_OK):
        raise OctoluxError(f"{path}: cannot be written. Check the name and the permissions of '{folder}'.")


def write_picture(picture: Picture, path: str | Path, options: FileOptions | None = None) -> None:
    """Write a PNG (for display, sRGB), an EXR or an NPZ (all layers, float32, linear). Raises OctoluxError."""
    path = Path(path)
    check_writable(path, FORMATS)
    with replacing(path) as temporary:
        FORMATS[path.suffix.lower()].write(picture, temporary, options or FileOptions())


def complete(path: Path, size: tuple[int, int], options: FileOptions) -> bool:
    """Whether `path` is a whole file of a picture of `size` (width, height), written with such options."""
    return path.is_file() and FORMATS[path.suffix.lower()].complete(path, size, options)


def write_json(data: dict[str, Any], path: str | Path) -> None:
    """Write `data` as JSON. Raises OctoluxError."""
    path = Path(path)
    check_writable(path, [".json"])
    with replacing(path) as temporary:
        temporary.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8")
