"""Saves figures of papers, made anew, into docs/images: the ones named on the command line, else all."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
from PIL import Image

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))  # benchmarks is not installed

from benchmarks.registry import NeedsData  # noqa: E402

FOLDER = ROOT / "docs" / "images"


def save(figures: Mapping[str, Callable[[], np.ndarray]], stem: str, number: str) -> int:
    """Exit code 0, or 2 for a figure that is not here or data that is not there.

    figures: what makes each, uint8 (height, width, 3).  stem, number: what its name is appended to, in the name of its
    file and as a paper counts it.
    """
    wanted = sys.argv[1:] or list(figures)
    if unknown := [name for name in wanted if name not in figures]:
        print(f"error: There is no figure {', '.join(unknown)}. There are: {', '.join(figures)}.", file=sys.stderr)
        return 2
    for name in wanted:
        path = FOLDER / f"{stem}{name}.jpg"
        try:
            Image.fromarray(figures[name]()).save(path, quality=85, optimize=True)
        except NeedsData as missing:
            print(f"error: figure {number}{name} needs OCTOLUX_DATA ({missing})", file=sys.stderr)
            return 2
        print(f"{path.relative_to(ROOT)}: {path.stat().st_size / 1000:.0f} kB")
    return 0
