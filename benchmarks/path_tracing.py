"""The path tracer beside Mitsuba's: whole pictures of Crytek Sponza, of equal size and samples, in turn."""

from __future__ import annotations

import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from octolux.export.mitsuba import write_mitsuba
from octolux.renderer import Renderer
from octolux.scene.scene import Scene
from octolux.simulator.environment import LUMINANCE

from .lab import device, interleaved
from .mitsuba_variant import mitsuba
from .registry import aim, figure
from .scenes_on_disk import load

SIZE, SAMPLES, PAIRS = (320, 180), 8, 3


@cache
def scene() -> Scene:
    """Under its sun and sky. Materials are opaque: Mitsuba lets light through cut ones in `volpath` alone."""
    given = load("crytek_sponza")
    return replace(given, materials=[replace(m, alpha_mode="opaque") for m in given.materials])


@figure("paths_and_mitsuba", group="raytracing",
        unit={"paths": "M samples/s", "paths_mitsuba": "M samples/s", "ratio": "", "mean_ratio": ""},
        bound={"ratio": aim(">= 1")})  # fmt: skip
def paths_and_mitsuba() -> dict[str, float]:
    """Samples per second, paths of any length, beside Mitsuba's LLVM variant (`path`, all cores), in turn.

    ratio: of speeds.  mean_ratio: of the pictures' mean luminance; both estimate the same light, but for how rough
    surfaces reflect.
    """
    pictures: dict[str, np.ndarray] = {}
    times = interleaved(_ours(pictures), _theirs(pictures), PAIRS)
    count = SIZE[0] * SIZE[1] * SAMPLES
    means = {name: float((picture @ LUMINANCE).mean()) for name, picture in pictures.items()}
    return {
        "paths": count / times["first"] / 1e3, "paths_mitsuba": count / times["second"] / 1e3,
        "ratio": 1.0 / times["ratio"], "mean_ratio": means["ours"] / means["theirs"],
    }  # fmt: skip


def _ours(pictures: dict[str, np.ndarray]) -> Callable[[], Any]:
    renderer = Renderer(scene(), "path-tracer", settings={"samples": SAMPLES}, size=SIZE, anti_aliasing="off",
                        device=device())  # fmt: skip

    def work() -> None:
        pictures["ours"] = renderer.render(scene().cameras[0]).radiance.astype(np.float64)

    return work


def _theirs(pictures: dict[str, np.ndarray]) -> Callable[[], Any]:
    mi = mitsuba()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "scene.xml"
        write_mitsuba(scene(), path, scene().cameras[0], SIZE, SAMPLES)
        loaded = mi.load_file(str(path))
    integrator = mi.load_dict({"type": "path", "max_depth": -1})

    def work() -> None:
        pictures["theirs"] = np.array(mi.render(loaded, integrator=integrator, spp=SAMPLES), dtype=np.float64)

    return work
