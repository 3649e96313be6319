"""Files a picture is written to. Each is written beside its place and moved there, so that no half file is left."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import OpenEXR
from PIL import Image

from .picture import Picture
from .scene.errors import OctoluxError

# Layers as EXR channels: radiance is the picture itself, R G B; others are named layer.R and so on, or by the layer
# alone when it has one channel.
_RGB, _XYZ = ("R", "G", "B"), ("X", "Y", "Z")
_CHANNELS = {"normal": _XYZ, "position": _XYZ}


def _write_png(picture: Picture, path: Path) -> None:
    Image.fromarray(picture.display[..., :3]).save(path, format="PNG")


def _write_exr(picture: Picture, path: Path) -> None:
    channels: dict[str, np.ndarray] = {}
    for name, data in picture.layers.items():
        if name == "radiance":
            channels.update(zip(_RGB, np.moveaxis(data, -1, 0), strict=True))
        elif data.ndim == 2:
            channels[name] = data
        else:
            suffixes = _CHANNELS.get(name, _RGB)
            channels.update({f"{name}.{s}": data[..., i] for i, s in enumerate(suffixes)})
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    contiguous = {name: np.ascontiguousarray(data) for name, data in channels.items()}
    try:
        OpenEXR.File(header, contiguous).write(str(path))
    except RuntimeError as error:  # OpenEXR's name for a full disk and the like
        raise OSError(str(error)) from error


WRITERS: dict[str, Callable[[Picture, Path], None]] = {".png": _write_png, ".exr": _write_exr}


def check_writable(path: Path, suffixes: list[str]) -> None:
    """Raise OctoluxError unless `path` has one of the suffixes and its folder can be written to."""
    if path.suffix.lower() not in suffixes:
        raise OctoluxError(f"{path}: files of the kind '{path.suffix}' are not written. Use {' or '.join(suffixes)}.")
    folder = path.parent
    if not folder.is_dir():
        raise OctoluxError(f"{path}: there is no folder '{folder}'. Make it first: mkdir -p '{folder}'.")
    if path.is_dir() or not os.access(folder, os.W_OK):
        raise OctoluxError(f"{path}: cannot be written. Check the name and the permissions of '{folder}'.")


def _replace(path: Path, write: Callable[[Path], object]) -> None:
    try:
        handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-", suffix=path.suffix)
        os.close(handle)
    except OSError as error:
        raise OctoluxError(f"{path}: cannot be written: {error.strerror or error}. Choose another folder.") from error
    try:
        write(Path(name))
        os.chmod(name, 0o666 & ~_umask())  # mkstemp's files are private
        os.replace(name, path)
    except OSError as error:
        raise OctoluxError(f"{path}: cannot be written: {error.strerror or error}. Is the disk full?") from error
    finally:
        Path(name).unlink(missing_ok=True)


def _umask() -> int:
    mask = os.umask(0)
    os.umask(mask)
    return mask


def write_picture(picture: Picture, path: str | Path) -> None:
    """Write a PNG (display, 8 bit sRGB) or an EXR (all layers, float32, linear). Raises OctoluxError."""
    path = Path(path)
    check_writable(path, list(WRITERS))
    _replace(path, lambda temporary: WRITERS[path.suffix.lower()](picture, temporary))


def write_json(data: dict[str, Any], path: str | Path) -> None:
    """Write `data` as JSON. Raises OctoluxError."""
    path = Path(path)
    check_writable(path, [".json"])
    _replace(path, lambda temporary: temporary.write_text(json.dumps(data, indent=1) + "\n", encoding="utf-8"))
