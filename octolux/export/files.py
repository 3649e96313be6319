"""The files beside an exported scene: each is written once, under the name that the scene then uses."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from pathlib import Path

import numpy as np
import OpenEXR
from PIL import Image as Pillow

from ..output.atomic import replacing
from ..scene.errors import OctoluxError


class FileFolder:
    """A folder that is made at the first file. `name(...)` gives names relative to the folder's parent.

    All methods raise OctoluxError when a file cannot be written; it then is as it was.
    """

    def __init__(self, path: Path):
        self.path = path
        self._written: dict[Hashable, str] = {}

    def once(self, key: Hashable, name: str, write: Callable[[Path], None]) -> str:
        """The relative name of the file of `key`; `write(path)` makes it when it is asked for the first time."""
        if key not in self._written:
            try:
                self.path.mkdir(exist_ok=True)
            except OSError as error:
                problem = f"{self.path}: no folder can be made there: {error.strerror or error}."
                raise OctoluxError(f"{problem} Choose another name for the scene.") from error
            with replacing(self.path / name) as temporary:
                write(temporary)
            self._written[key] = f"{self.path.name}/{name}"
        return self._written[key]

    def png(self, key: Hashable, name: str, pixels: np.ndarray) -> str:
        """uint8 (height, width) or (height, width, 3 or 4)."""
        return self.once(key, name, lambda path: Pillow.fromarray(pixels).save(path, format="PNG"))

    def exr(self, key: Hashable, name: str, pixels: np.ndarray) -> str:
        """float32 (height, width, 3), linear."""
        return self.once(key, name, lambda path: write_exr(path, pixels))


def write_exr(path: Path, pixels: np.ndarray) -> None:
    """float32 (height, width, 3) as R, G, B. Raises OSError."""
    channels = {name: np.ascontiguousarray(pixels[..., i], np.float32) for i, name in enumerate("RGB")}
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    try:
        OpenEXR.File(header, channels).write(str(path))
    except RuntimeError as error:  # OpenEXR's name for a full disk and the like
        raise OSError(str(error)) from error
