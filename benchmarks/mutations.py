"""`python -m benchmarks.mutations K FOLDER`: write case K, a valid scene with one to four faults, into a folder.

Case K is the same in every run: all choices come from `random.Random(K)`. Its original is one of `originals`; its
faults are in the main file or in one of those that it names.
"""

from __future__ import annotations

import sys
from pathlib import Path

from .faults import ANY, PICTURES, TEXT, Dice, Fault, flip, large_png, number_in_text, truncate
from .faults_gltf import in_glb, in_json
from .originals import ORIGINALS, files_of

MAIN_SHARE = 0.6  # of the faults that are in the main file, where there are others
_MOST_FAULTS = 4
_TEXTS = (".obj", ".mtl", ".toml", ".off", ".stl", ".ply", ".dae", ".fbx", ".ase", ".x", ".x3d", ".ac", ".ppm", ".hdr")


def faults_of(suffix: str) -> tuple[Fault, ...]:
    """What may be done to a file of this kind; what stands often is done often."""
    if suffix == ".gltf":
        return (in_json,) * 8 + (flip, truncate, number_in_text)
    if suffix == ".glb":
        return (in_glb,)
    own = (PICTURES[suffix],) * 5 if suffix in PICTURES else ()
    own += (large_png,) if suffix == ".png" else ()
    return own + (TEXT * 2 if suffix in _TEXTS else ()) + ANY


def original_of(case: int, with_data: bool = True) -> int:
    """Which of ORIGINALS a case damages. with_data: whether those that need the data folder are among them."""
    shares = [o.share if with_data or not o.needs_data else 0 for o in ORIGINALS]
    return Dice(case).choices(range(len(shares)), shares)[0]


def mutated(case: int, with_data: bool = True) -> dict[str, bytes]:
    """The files of a case by name. Raises NeedsData when its original is not there."""
    number = original_of(case, with_data)
    files, dice = dict(files_of(number)), Dice(f"{case} faults")
    main = ORIGINALS[number].main
    others = [name for name in files if name != main]
    name = main if not others or dice.random() < MAIN_SHARE else dice.choice(others)
    for _ in range(dice.choice((1, 1, 1, 2, _MOST_FAULTS))):
        if files[name]:
            files[name] = dice.choice(faults_of(Path(name).suffix.lower()))(dice, files[name])
    return files


def write_case(case: int, folder: Path, with_data: bool = True) -> Path:
    """Write the files of a case into a folder; returns the main one. Raises NeedsData."""
    for name, content in mutated(case, with_data).items():
        (folder / name).write_bytes(content)
    return folder / ORIGINALS[original_of(case, with_data)].main


if __name__ == "__main__":
    target = Path(sys.argv[2])
    target.mkdir(parents=True, exist_ok=True)
    print(write_case(int(sys.argv[1]), target))
