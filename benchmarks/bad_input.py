"""Broken scene files: one clear error each, and nothing else."""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path

from .lab import data
from .program import octolux
from .registry import at_least, at_most, figure

_MODELS = {".obj", ".gltf", ".glb"}


def broken_files() -> list[Path]:
    """Every model in scenes/broken. Raises NeedsData when the folder is not there."""
    return sorted(p for p in data("scenes", "broken").rglob("*") if p.suffix in _MODELS)


def faults(file: Path) -> list[str]:
    """What is wrong with how `octolux render FILE` refuses the file; nothing when all is as it should be."""
    with tempfile.TemporaryDirectory() as folder:
        done = octolux("render", file, "--out", "picture.png", "--out", "picture.exr", folder=Path(folder))
        left = [p.name for p in Path(folder).iterdir()]
    lines = done.stderr.splitlines()
    checks = {
        f"exit code {done.returncode}": done.returncode == 2,
        f"{len(lines)} lines on stderr": len(lines) == 1,
        "no line that starts with 'error:'": any(line.startswith("error:") for line in lines),
        "the file is not named": file.name in done.stderr,
        "a traceback": "Traceback" not in done.stderr,
        f"wrote {left}": not left,
        "something on stdout": not done.stdout,
    }
    return [fault for fault, good in checks.items() if not good]


@figure("broken_files", group="bad_input", unit="files", bound={"refused_badly": at_most(0), "tried": at_least(1)})
def refused() -> dict[str, float]:
    """Files of scenes/broken not refused with exit code 2 and one line that names them, nothing written."""
    files = broken_files()
    found = {file: faults(file) for file in files}
    for file, wrong in found.items():
        if wrong:
            print(f"{file.name}: {'; '.join(wrong)}", file=sys.stderr)
    return {"refused_badly": float(sum(map(bool, found.values()))), "tried": float(len(files))}
