"""`python -m benchmarks.comparison_references [VIEW ...]`: trace our references of the comparison set anew.

Each becomes an NPZ by light paths (docs/compare.md) and a JSON that says how it was made and how noisy it is.
"""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from octolux.compare.choices import choice
from octolux.compare.reference import Reference
from octolux.compare.rendering import Studio
from octolux.output import write_json
from octolux.output.atomic import replacing
from octolux.scene.errors import OctoluxError

from .comparison_set import LIGHTS, REFERENCES, SIZE, View, scene_of, views
from .lab import device
from .registry import NeedsData

_PATHS = {"first_bounce": "first-bounce", "all_indirect": "all"}

KEPT_BITS = 6
"""Bits of the mantissa that are kept of a half float's ten: a rounding error of at most 2^-7, 0.8 %, of a pixel whose
noise is many times that; the files are half as large."""

GRID = 64.0
"""Positions are kept in steps of 1 / 64 m, which half floats hold without error up to 32 m from the origin."""


def compact(picture: np.ndarray) -> np.ndarray:
    """float16 of the same shape, rounded to KEPT_BITS of the mantissa. Raises OctoluxError where it is too bright."""
    dropped = 10 - KEPT_BITS
    with np.errstate(over="ignore"):
        bits = np.asarray(picture, np.float32).astype(np.float16).view(np.uint16)
    # Adding half a step carries into the exponent where it must.
    kept = ((bits + (1 << (dropped - 1))) & np.uint16(0xFFFF ^ ((1 << dropped) - 1))).view(np.float16)
    if not np.isfinite(kept).all():
        raise OctoluxError("A reference is brighter than half floats are, 65504 nits: dim the scene's lights.")
    return kept


def traced(view: View, studio: Studio, light: str, samples: int) -> Reference:
    """Two halves of `samples` paths through each pixel."""
    words = f"path-tracer:reference,materials=diffuse,paths={_PATHS[light]}"
    return studio.reference(choice(words), 2 * samples)


def make(view: View, folder: Path, size: tuple[int, int] = SIZE) -> dict[str, Any]:
    """Trace and write both files of a view to `folder`; the facts that the JSON holds."""
    start = time.perf_counter()
    counts = dict(zip(LIGHTS, view.samples or (), strict=True))
    studio = Studio(scene_of(view), device(), size, view.camera, progress=lambda text: print(text, file=sys.stderr))
    found = {light: traced(view, studio, light, counts[light]) for light in LIGHTS}
    whole = found["all_indirect"]
    assert whole.position is not None
    arrays = {"direct": compact(whole.pictures["direct"]), "mask": whole.mask}
    arrays["position"] = (np.round(whole.position * GRID) / GRID).astype(np.float16)
    for light, one in found.items():
        for seed, half in zip("AB", one.halves["indirect"], strict=True):
            arrays[f"seed{seed}_{light}"] = compact(half)
    with replacing(folder / f"{view.name}.npz") as path, path.open("wb") as file:
        np.savez_compressed(file, **arrays)  # type: ignore[arg-type]  # NumPy 2.4's stubs: its other option
    facts = {
        "scene": view.scene, "camera": view.camera, "size": list(size),
        "settings": {light: one.facts["settings"] for light, one in found.items()},
        "mean_nits": {light: float(one.pictures["indirect"][one.mask].mean()) for light, one in found.items()},
        "relative_noise": {light: one.noise("indirect") for light, one in found.items()},
        "relative_noise_of_mean": {light: noise_of_mean(one) for light, one in found.items()},
        "adapter": device().adapter_name, "seconds": round(time.perf_counter() - start),
    }  # fmt: skip
    write_json(facts, folder / f"{view.name}.json")
    return facts


def noise_of_mean(reference: Reference) -> float | None:
    """Relative standard error of the mean over the picture: the noise of a pixel over the root of their number."""
    noise = reference.noise("indirect")
    return None if noise is None else float(noise / np.sqrt(reference.mask.sum()))


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a view that is not in the set, has another program's reference, or cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.comparison_references", description=__doc__)
    parser.add_argument("names", nargs="*", metavar="VIEW", help="all with references of ours by default")
    names = parser.parse_args(words).names
    try:
        wanted = views(names)
        foreign = [view.name for view in wanted if view.samples is None]
        if names and foreign:
            raise OctoluxError(f"{', '.join(foreign)}: the reference is another program's. Leave it out.")
        REFERENCES.mkdir(exist_ok=True)
        for view in wanted:
            if view.samples is None:
                continue
            try:
                print(view.name, make(view, REFERENCES)["relative_noise"], flush=True)
            except NeedsData as missing:
                print(f"{view.name}: left alone, needs OCTOLUX_DATA ({missing})")
    except OctoluxError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    sys.exit(main())
