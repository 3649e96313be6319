"""NumPy's NPZ: the layers by their names, as numpy.load gives them back."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from ..picture import Picture
from .options import LAYERS, FileOptions


def write(picture: Picture, path: Path, options: FileOptions) -> None:
    """Write the layers of options.layers, compressed. Raises OSError."""
    layers = {name: data for name, data in picture.layers.items() if options.wants(name)}
    with path.open("wb") as file:
        np.savez_compressed(file, **layers)  # type: ignore[arg-type]  # NumPy 2.4's stubs: its other option


def complete(path: Path, size: tuple[int, int], options: FileOptions) -> bool:
    """Whether `path` is a whole NPZ of `size` (width, height) that holds every layer of the options."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as layers:
            wanted = [name for name in LAYERS if options.wants(name)]
            return all(layers[name].shape[:2] == size[::-1] for name in wanted)
    except (OSError, EOFError, KeyError, ValueError, zipfile.BadZipFile, zlib.error):
        return False
