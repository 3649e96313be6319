"""Kernels of the octree beside the uniform volume's on the same injected light: the ratios of OLPV 6.3, taken alone."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from octolux.techniques.lpv.propagation import Propagation

from .lab import device, interleaved, submitted
from .olpv_scene import Kept, kept
from .registry import at_most, figure

OCTREE, UNIFORM = "octree-lpv:thesis", "uniform-lpv:thesis"
PAIRS = 41


def propagation(one: Kept, times: int = 1) -> Callable[[], None]:
    """All steps and the sum, from injected light to accumulated light, and the index volume where there is one; so many
    times in one submission."""
    technique: Any = one.technique
    made = technique.stepping.propagation if hasattr(technique, "stepping") else technique.propagation

    def work() -> None:
        with submitted() as stage:
            for _ in range(times):
                made.run(stage, technique.injection.injected, technique.injection.peak, technique.settings.iterations)

    return work


def update(one: Kept) -> Callable[[], None]:
    """All steps from clearing to merge, submitted at once."""

    def work() -> None:
        with one.frame.profiler.frame():
            one.technique.update(one.frame)

    return work


def downsampled_and_merged(one: Kept) -> Callable[[], None]:
    """Downsampling, propagation with its index writes, and merge, submitted at once."""
    technique: Any = one.technique

    def work() -> None:
        with one.frame.profiler.frame():
            with one.frame.profiler.stage("downsampling") as stage:
                technique.downsampling.run(stage, technique.injection.injected)
            technique.stepping.run(one.frame.profiler, technique.injection.injected, technique.injection.peak)

    return work


def _times(found: dict[str, float]) -> dict[str, float]:
    return {"ratio": found["ratio"], "octree_ms": found["first"], "uniform_ms": found["second"]}


_UNITS = {"ratio": "x", "octree_ms": "ms", "uniform_ms": "ms"}


def plain_propagation(one: Kept, copied: bool = False) -> Callable[[], None]:
    """The octree's steps without index writes; and the copy of the finest level into textures."""
    technique: Any = one.technique
    s = technique.settings
    made = Propagation(
        device(), technique.levels.sizes, evaluation=s.evaluation, reprojection=s.reprojection, gain=s.gain,
        cell_format=s.cell_format,
    )  # fmt: skip

    def work() -> None:
        with submitted() as stage:
            made.run(stage, technique.injection.injected, technique.injection.peak, s.iterations)
            if copied:
                technique.stepping.lookup.write_volumes(stage, made.light)

    return work


_AT_ONCE = 8


@figure("olpv_propagation", group="olpv", unit={**_UNITS, "alone_ratio": "x"}, bound={"ratio": at_most(0.33)})
def olpv_propagation() -> dict[str, float]:
    """Propagation at 32^3, octree k = 4 with index writes over uniform k = 16 (thesis: 0.40; cells: 0.286).

    Eight to a submission, as what a submission and waiting for it cost belongs to the frame; alone_ratio: one to each.
    """
    octree, uniform = (kept("atrium", text) for text in (OCTREE, UNIFORM))
    found = interleaved(propagation(octree, _AT_ONCE), propagation(uniform, _AT_ONCE), PAIRS)
    alone = interleaved(propagation(octree), propagation(uniform), PAIRS)
    per_run = {"ratio": found["ratio"], **{k: found[k] / _AT_ONCE for k in ("first", "second")}}
    return {**_times(per_run), "alone_ratio": alone["ratio"]}


@figure("olpv_octree_work", group="olpv", unit="share", bound={"thesis": at_most(0.15)})
def olpv_octree_work() -> dict[str, float]:
    """Downsampling, index volume and merge over propagation: what the octree adds to its steps.

    The time of all of them over that of steps without index writes, less one; `steps` blends and has no index. The
    merge writes the textures that the lookup filters, into which a uniform volume copies its light in a pass of its
    own: that copy, which the octree is spared, is added to the other side.
    """
    found = {}
    for preset in ("thesis", "steps"):
        octree = kept("atrium", f"octree-lpv:{preset}")
        times = interleaved(downsampled_and_merged(octree), plain_propagation(octree, copied=True), PAIRS)
        found[preset] = times["ratio"] - 1.0
    return found


@figure("olpv_clear_to_merge", group="olpv", unit="x", bound=at_most(0.8))
def olpv_clear_to_merge() -> dict[str, float]:
    """All steps from clearing to merge, octree k = 4 over uniform k = 16, three point lights in the atrium; also with
    a geometry volume in both, as the thesis measured its 0.90."""
    found = {}
    for name, geometry in (("light", False), ("light_and_geometry", True)):
        octree, uniform = (kept("atrium", text, geometry=geometry) for text in (OCTREE, UNIFORM))
        found[name] = interleaved(update(octree), update(uniform), PAIRS)["ratio"]
    return found
