"""How cost and memory of the octree and of the uniform volume grow with the cells n and the steps k."""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

from octolux.compare.choices import choice
from octolux.gpu.device import DeviceError
from octolux.simulator.lpv.octree import level_sizes

from .lab import device, milliseconds
from .olpv_scene import Kept, kept

SIZE, ROUNDS, WARM_UP = (320, 180), 7, 2
CELLS, STEPS = (16, 32, 64, 128), (1, 2, 4, 8, 16)
_OCTREES = ("octree-lpv:thesis", "octree-lpv:steps", "octree-lpv")
_MOST_UNIFORM = 64
BY_CELLS = tuple(f"{t},n={n}" for n in CELLS for t in (*_OCTREES, "uniform-lpv:thesis")
                 if "uniform" not in t or n <= _MOST_UNIFORM)  # fmt: skip
BY_STEPS = tuple(f"{t},iterations={k}" for k in STEPS for t in (*_OCTREES[:2], "uniform-lpv:thesis"))
TITLES = ("technique", "n", "k", "cells", "ms", "over first", "MB")


@dataclass(frozen=True)
class Cost:
    """milliseconds: median of all the light cache's work in a frame and the lookup of 320 x 180 pixels; None, as the
    megabytes, for what a device of WebGPU's default limits does not hold. k: None for light that is gathered."""

    technique: str
    n: int
    k: int | None
    cells: int
    milliseconds: float | None
    megabytes: float | None


def swept(scene: str, techniques: Sequence[str], rounds: int = ROUNDS) -> list[Cost]:
    """All techniques take turns. Raises NeedsData when the scene is not there."""
    made, held = {}, {}
    for text in techniques:
        before = _held()
        with suppress(DeviceError):
            made[text] = kept(scene, text, SIZE, geometry=False)
            held[text] = _held() - before
    works = {text: _refreshed(one) for text, one in made.items()}
    times: dict[str, list[float]] = {text: [] for text in made}
    for number in range(WARM_UP + rounds):
        for text, work in works.items():
            took = milliseconds(work)
            if number >= WARM_UP:
                times[text].append(took)
    return [
        _cost(text, statistics.median(times[text]), held[text] / 1e6) if text in made else _cost(text, None, None)
        for text in techniques
    ]


def _held() -> int:
    """Bytes that the volumes of all renderers hold."""
    gc.collect()
    return sum(held for label, held in device().memory.by_label().items() if label.startswith("LPV"))


def _refreshed(one: Kept) -> Callable[[], None]:
    def work() -> None:
        with one.frame.profiler.frame():
            one.technique.update(one.frame)
            one.technique.shade(one.frame)

    return work


def _cost(text: str, took: float | None, held: float | None) -> Cost:
    name, s = text.partition(",")[0], choice(text).settings.as_dict()
    sizes = level_sizes(s["n"], s["coarsest"]) if name.startswith("octree") else [s["n"]]
    k = None if s.get("propagation") == "gather" else s["iterations"]
    return Cost(name, s["n"], k, sum(n**3 for n in sizes), took, held)


def rows(costs: Sequence[Cost]) -> list[tuple[str, ...]]:
    """The table's cells, titles first; times also over that of the technique's first row."""
    lines = [TITLES]
    first: dict[str, float | None] = {}
    for c in sorted(costs, key=lambda c: (c.technique, c.n, c.k or 0)):
        least, k = first.setdefault(c.technique, c.milliseconds), "–" if c.k is None else str(c.k)
        over = c.milliseconds / least if c.milliseconds and least else None
        numbers = ((c.milliseconds, ".2f"), (over, ".2f"), (c.megabytes, ".1f"))
        cells = ("–" if value is None else format(value, form) for value, form in numbers)
        lines.append((c.technique, str(c.n), k, f"{c.cells:,}", *cells))
    return lines
