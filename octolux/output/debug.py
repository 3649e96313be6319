"""Files of debug views (techniques/debug_views.py)."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ..scene.errors import OctoluxError
from ..simulator.tonemap import srgb_encode
from ..techniques.debug_views import is_picture
from . import check_writable
from .atomic import replacing

_FORMATS = (".png", ".npz")


def debug_files(pairs: Sequence[str], resume: bool) -> list[tuple[str, Path]]:
    """The files that `NAME=FILE` name. Raises OctoluxError before there is anything to write; so where a sequence is
    resumed, of which the last frame may not be rendered."""
    found = []
    if pairs and resume:
        raise OctoluxError("--debug shows what the last frame leaves, which --resume may not render. Leave one out.")
    for pair in pairs:
        name, _, path = pair.partition("=")
        if not (name and path):
            raise OctoluxError(f"--debug takes NAME=FILE, such as injected=a.npz, or list alone, not '{pair}'.")
        check_writable(Path(path), _FORMATS)
        found.append((name, Path(path)))
    return found


def write_view(view: Any, path: Path) -> None:
    """Write a picture as PNG, sRGB; or any view as NPZ: `view`, or `view_0`, `view_1`, ... of a list. Raises
    OctoluxError, also for a view that is no picture as PNG."""
    if path.suffix.lower() == ".png" and not is_picture(view):
        raise OctoluxError(f"{path}: this debug view is no picture, but numbers. Write them to a .npz file.")
    with replacing(path) as temporary:
        if path.suffix.lower() == ".png":
            Image.fromarray(np.round(255.0 * srgb_encode(view)).astype(np.uint8)).save(temporary, format="PNG")
            return
        arrays = {f"view_{i}": array for i, array in enumerate(view)} if isinstance(view, list) else {"view": view}
        with temporary.open("wb") as file:
            np.savez_compressed(file, **arrays)
