"""Files of debug views (techniques/debug_views.py)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ..scene.errors import OctoluxError
from ..simulator.tonemap import srgb_encode
from ..techniques.debug_views import DebugViews
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


def check_views(views: DebugViews, files: Sequence[tuple[str, Path]]) -> None:
    """Raise OctoluxError, before anything is rendered, for a view that there is not, and for numbers as PNG."""
    for name, path in files:
        if not views.is_picture(name) and path.suffix.lower() == ".png":
            raise OctoluxError(f"{path}: this debug view is no picture, but numbers. Write them to a .npz file.")


def write_views(views: DebugViews, files: Sequence[tuple[str, Path]]) -> Iterator[Path]:
    """Write them, as far as the paths are asked for. Raises OctoluxError for what cannot be written."""
    for name, path in files:
        _write(views[name], path)
        yield path


def _write(view: Any, path: Path) -> None:
    """A picture as PNG, sRGB; or any view as NPZ: `view`, or `view_0`, `view_1`, ... of a list."""
    with replacing(path) as temporary:
        if path.suffix.lower() == ".png":
            Image.fromarray(np.round(255.0 * srgb_encode(view)).astype(np.uint8)).save(temporary, format="PNG")
            return
        arrays = {f"view_{i}": array for i, array in enumerate(view)} if isinstance(view, list) else {"view": view}
        with temporary.open("wb") as file:
            np.savez_compressed(file, **arrays)
