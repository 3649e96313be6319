"""How cost and memory of the octree and of the uniform volume grow with the cells n and the steps k."""

from __future__ import annotations

import gc
import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from .lab import device, milliseconds
from .olpv_scene import Kept, kept

SIZE, ROUNDS, WARM_UP = (320, 180), 7, 2
CELLS, STEPS = (16, 32, 64, 128), (1, 2, 4, 8, 16)
_OCTREES = ("octree-lpv:thesis", "octree-lpv:steps", "octree-lpv")
_MOST_UNIFORM = 64
BY_CELLS = tuple(f"{t},n={n}" for n in CELLS for t in (*_OCTREES, "uniform-lpv:thesis")
                 if "uniform" not in t or n <= _MOST_UNIFORM)  # fmt: skip
BY_STEPS = tuple(f"{t},iterations={k}" for k in STEPS for t in (*_OCTREES[:2], "uniform-lpv:thesis"))
TITLES = ("technique", "n", "k", "cells", "ms", "over n = 32", "MB")


@dataclass(frozen=True)
class Cost:
    """milliseconds: median of all the light cache's work in a frame and the lookup of 320 x 180 pixels. k: None for
    light that is gathered."""

    technique: str
    n: int
    k: int | None
    cells: int
    milliseconds: float
    megabytes: float


def swept(scene: str, techniques: Sequence[str], rounds: int = ROUNDS) -> list[Cost]:
    """Techniques of the same n or k take turns. Raises NeedsData when the scene is not there."""
    made, held = {}, {}
    for text in techniques:
        before = _held()
        made[text] = kept(scene, text, SIZE, geometry=False)
        held[text] = _held() - before
    works = {text: _refreshed(one) for text, one in made.items()}
    times: dict[str, list[float]] = {text: [] for text in techniques}
    for number in range(WARM_UP + rounds):
        for text, work in works.items():
            took = milliseconds(work)
            if number >= WARM_UP:
                times[text].append(took)
    return [_cost(text, made[text], statistics.median(times[text]), held[text]) for text in techniques]


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


def _cost(text: str, one: Kept, took: float, held: int) -> Cost:
    s, name = one.technique.settings.as_dict(), text.partition(",")[0]
    cells = one.technique.levels.cells if name.startswith("octree") else s["n"] ** 3
    k = None if s.get("propagation") == "gather" else s["iterations"]
    return Cost(name, s["n"], k, cells, took, held / 1e6)


def rows(costs: Sequence[Cost]) -> list[tuple[str, ...]]:
    """The table's cells, titles first; times also over that of n = 32 of the same technique and k."""
    lines = [TITLES]
    base = {(c.technique, c.k): c.milliseconds for c in costs if c.n == 32}
    for c in sorted(costs, key=lambda c: (c.technique, c.n, c.k or 0)):
        least = base.get((c.technique, c.k))
        over, k = f"{c.milliseconds / least:.2f}" if least else "–", "–" if c.k is None else str(c.k)
        lines.append((c.technique, str(c.n), k, f"{c.cells:,}", f"{c.milliseconds:.2f}", over,
                      f"{c.megabytes:.1f}"))  # fmt: skip
    return lines
