"""PNG: the picture for display."""

from __future__ import annotations

import struct
from pathlib import Path

import numpngw
import numpy as np
from PIL import Image

from ..picture import Picture
from .options import FileOptions

_HEADER = struct.Struct(">16xIIBB")  # signature, length and name of the first chunk; width, height, bits, colour type
_COLOUR_TYPES = {3: 2, 4: 6}  # by number of channels (PNG specification, third edition, table 8)
_UP = 2  # of the filters the fastest; the best of the others saves a fifth and takes twice as long


def write(picture: Picture, path: Path, options: FileOptions) -> None:
    """Write sRGB, or with options.alpha sRGB and straight alpha. Raises OSError."""
    if options.alpha:
        pixels = picture.cutout(options.bits)
    else:
        pixels = (picture.display if options.bits == 8 else picture.display16())[..., :3]
    if options.bits == 8:
        Image.fromarray(np.ascontiguousarray(pixels)).save(path, format="PNG")
    else:  # Pillow has no 16-bit colour
        with path.open("wb") as file:
            numpngw.write_png(file, np.ascontiguousarray(pixels), filter_type=_UP)


def complete(path: Path, size: tuple[int, int], options: FileOptions) -> bool:
    """Whether `path` is a whole PNG of `size` (width, height) and of the options' kind."""
    try:
        with path.open("rb") as file:
            kind = _HEADER.unpack(file.read(_HEADER.size))
        if kind != (*size, options.bits, _COLOUR_TYPES[4 if options.alpha else 3]):
            return False
        with Image.open(path) as image:
            image.verify()  # checksums of all chunks, to the last one
        with Image.open(path) as image:
            image.load()  # all rows
    except (OSError, SyntaxError, ValueError, struct.error):  # Pillow's errors for broken files, and ours
        return False
    return True


def read_display(path: Path) -> np.ndarray:
    """uint8 (height, width, 3) of a PNG with 8 bits and no alpha."""
    with Image.open(path) as image:
        return np.asarray(image.convert("RGB"))
