"""Two runs of the program write the same bytes."""

from __future__ import annotations

import tempfile
from pathlib import Path

from .program import octolux
from .registry import at_least, figure

_SCENES = ("cornell-box", "atrium")


def written(scene: str, folder: Path) -> dict[str, bytes]:
    """The files that a process of its own writes for two frames of `scene`. Raises RuntimeError when it fails."""
    files = {suffix: folder / f"picture.{suffix}" for suffix in ("png", "exr")}
    outputs = [word for file in files.values() for word in ("--out", file)]
    done = octolux("render", scene, "--size", "200x120", "--frames", "2", *outputs)
    if done.returncode:
        raise RuntimeError(done.stderr.strip())
    return {suffix: file.read_bytes() for suffix, file in files.items()}


def same_bytes(scene: str) -> dict[str, float]:
    """1 for each kind of file that two processes write alike."""
    with tempfile.TemporaryDirectory() as first, tempfile.TemporaryDirectory() as second:
        runs = [written(scene, Path(folder)) for folder in (first, second)]
    return {suffix: float(runs[0][suffix] == runs[1][suffix]) for suffix in runs[0]}


@figure("same_bytes", group="determinism", unit="1 = yes", bound=at_least(1.0))
def two_runs() -> dict[str, float]:
    """Two processes render the same scene: do PNG (display) and EXR (every layer) have the same bytes?"""
    return {f"{scene}_{suffix}": same for scene in _SCENES for suffix, same in same_bytes(scene).items()}
