"""`python -m benchmarks.olpv_sparse`: steps through the leaves of a sparse octree (OLPV 7.1) beside the full octree and
the uniform volume: leaves, time and memory by the number of cells."""

from __future__ import annotations

import argparse
import gc
import statistics
import sys
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass

from octolux.techniques.lpv.octree.sparse import SparseStepping
from octolux.techniques.lpv.octree.technique import OctreeLpv
from octolux.techniques.lpv.uniform.technique import UniformLpv

from . import written_tables
from .lab import device, milliseconds
from .olpv_scene import SCENES, Kept, kept
from .registry import figure

ROUNDS, WARM_UP, CELLS = 9, 2, (32, 64, 128)
_MOST_UNIFORM = 64  # what `uniform-lpv` takes
SPARSE, FULL, UNIFORM = "octree-lpv:sparse", "octree-lpv:steps,iterations=16", "uniform-lpv"
TECHNIQUES = (SPARSE, "octree-lpv:sparse,margin=2", FULL, "octree-lpv:steps", UNIFORM)
TITLES = ("technique", "n", "k", "cells", "ms", "over the full octree", "MB", "over the full octree")
_LABELS = ("LPV cells", "LPV accumulated light", "LPV merged light", "LPV tree")


@dataclass(frozen=True)
class Cost:
    """cells: that carry light.  milliseconds: median, from downsampled light to the volumes that the lookup filters.
    megabytes: what is held for it, without those volumes and the injected light, which all have."""

    technique: str
    n: int
    k: int
    cells: int
    milliseconds: float
    megabytes: float


def costs(scene: str, n: int, techniques: Sequence[str] = TECHNIQUES, rounds: int = ROUNDS) -> list[Cost]:
    """All techniques take turns. Raises NeedsData when the scene is not there."""
    made, held = [], []
    for text in techniques:
        before = _held()
        made.append(kept(scene, f"{text},n={n}", geometry=False))
        held.append(_held() - before)
    works, times = [_work(one) for one in made], [[] for _ in made]
    for number in range(WARM_UP + rounds):
        for work, series in zip(works, times, strict=True):
            took = milliseconds(work)
            if number >= WARM_UP:
                series.append(took)
    return [
        Cost(text, n, _setting(one, "iterations"), _cells(one), statistics.median(series), size / 1e6)
        for text, one, series, size in zip(techniques, made, times, held, strict=True)
    ]


def _possible(n: int) -> list[str]:
    return [text for text in TECHNIQUES if text != UNIFORM or n <= _MOST_UNIFORM]


def _setting(one: Kept, name: str) -> int:
    return one.technique.settings.as_dict()[name]


def _held() -> int:
    gc.collect()
    labels = device().memory.by_label()
    return sum(labels.get(label, 0) for label in _LABELS)


def _work(one: Kept) -> Callable[[], None]:
    technique, profiler = one.technique, one.frame.profiler

    def steps() -> None:
        with profiler.frame():
            if isinstance(technique, OctreeLpv):
                technique.stepping.run(profiler, technique.injection.injected, technique.injection.peak)
            elif isinstance(technique, UniformLpv):
                with profiler.stage("propagation") as stage:
                    injection, k = technique.injection, _setting(one, "iterations")
                    technique.propagation.run(stage, injection.injected, injection.peak, k)
                    technique.lookup.write_volumes(stage, technique.propagation.light)

    return steps


def _cells(one: Kept) -> int:
    technique = one.technique
    if not isinstance(technique, OctreeLpv):
        return _setting(one, "n") ** 3
    return technique.stepping.tree.leaves if isinstance(technique.stepping, SparseStepping) else technique.levels.cells


def rows(found: Sequence[Cost]) -> list[tuple[str, ...]]:
    """The table's cells, titles first. The full octree goes as many steps."""
    lines = [TITLES]
    full = {c.n: c for c in found if c.technique == FULL}
    for c in found:
        over = (c.milliseconds / full[c.n].milliseconds, c.megabytes / full[c.n].megabytes)
        lines.append((c.technique.partition(",iter")[0], str(c.n), str(c.k), f"{c.cells:,}", f"{c.milliseconds:.1f}",
                      f"{over[0]:.2f}", f"{c.megabytes:.1f}", f"{over[1]:.2f}"))  # fmt: skip
    return lines


@figure("olpv_sparse", group="olpv", unit="x")
def olpv_sparse() -> dict[str, float]:
    """Sparse octree over full octree and over uniform volume, 16 steps each, in the atrium: time, memory, cells."""
    ratios = {}
    for n in (32, 64):
        sparse, full, uniform = costs("atrium", n, (SPARSE, FULL, UNIFORM), rounds=5)
        for name, other in (("full", full), ("uniform", uniform)):
            ratios |= {
                f"n{n}.time_over_{name}": sparse.milliseconds / other.milliseconds,
                f"n{n}.memory_over_{name}": sparse.megabytes / other.megabytes,
                f"n{n}.cells_over_{name}": sparse.cells / other.cells,
            }
    return ratios


def main(words: Sequence[str] | None = None) -> int:
    """Exit code 0, or 2 for a wrong option, a scene that is not there, or a file that cannot be written."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks.olpv_sparse", description=__doc__)
    parser.add_argument("--scene", choices=tuple(SCENES), default="atrium")
    written_tables.add_options(parser)
    arguments = parser.parse_args(words)

    def work() -> None:
        written_tables.check(arguments)
        found = [cost for n in CELLS for cost in costs(arguments.scene, n, _possible(n))]
        table = (f"Steps through a sparse octree, {arguments.scene}", rows(found))
        written_tables.give_out(arguments, [table], {"scene": arguments.scene, "costs": [asdict(c) for c in found]})

    return written_tables.exit_code(work, arguments.scene)


if __name__ == "__main__":
    sys.exit(main())
