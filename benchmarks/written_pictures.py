"""Small valid pictures in every format that octolux reads."""

from __future__ import annotations

import io
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image as Pillow


def pixels(size: int = 24) -> np.ndarray:
    """uint8 (size, size, 3): a pattern that no coder makes trivial."""
    rows, columns = np.indices((size, size))
    return np.stack([rows * 10 % 256, columns * 9 % 256, rows * columns % 251], axis=-1).astype(np.uint8)


def picture(kind: str, **options: Any) -> bytes:
    """A picture of 24 x 24 in a format of Pillow's."""
    stream = io.BytesIO()
    Pillow.fromarray(pixels()).save(stream, kind, **options)
    return stream.getvalue()


def hdr(width: int = 32, height: int = 16) -> bytes:
    """A Radiance picture, each channel of a row one literal and one run."""
    rows = b""
    for row in range(height):
        rows += bytes((2, 2, width >> 8, width & 255))
        for channel in range(4):
            first = bytes(128 if channel == 3 else (row * 9 + i) % 256 for i in range(width // 2))
            rows += bytes((len(first),)) + first + bytes((128 + width - len(first), 129))
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y %d +X %d\n" % (height, width) + rows


def exr() -> bytes:
    """An OpenEXR picture, compressed."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sky.exr"
        with OpenEXR.File(header, {"RGB": pixels().astype(np.float32) / 64}) as file:
            file.write(str(path))
        return path.read_bytes()
