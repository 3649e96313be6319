"""The state of a simulation, and the actions on it: each takes a state and gives a new one (Olovsson 2012, 4.2, 5.1).

States are never changed, so keeping old ones is what undo needs; they share the arrays that an action left alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from octolux.simulator.lpv import octree

from . import injectors as shapes
from . import occlusion
from .errors import SimulationError
from .propagators import Propagator

Levels = tuple[np.ndarray, ...]

OCTREES = ("source", "target", "sum")
"""What there is to look at."""

BRIGHTEST = 1e100
"""Largest coefficient that a step may make; a factor above 1 / gain grows for ever, and float64 ends at 1e308."""


@dataclass(frozen=True, eq=False)
class State:
    """Everything there is at a moment. Arrays are read-only; a tuple of them is an octree, level 0 first.

    n, coarsest: cells along each side of the finest and the coarsest level.  combine: "sum" or "average" (`octree`).
    threshold: a contribution counts for the index volume when its band 0 is above this share of the largest of S_0.
    factors: the propagation factor of each level.
    source, target, sum: S_(i-1), S_i and the light accumulated so far, [z][y][x][4].
    index: the hierarchical index volume, [z][y][x] int64.  geometry: blocking, on (n / 2^i + 1)^3 corners [z][y][x][4].
    injected: S_0 of level 0.  merged: M of the last merge, read with level 0's cell size, or None.
    iterations: steps since the light was cleared.  measures: what was measured after each accumulation (`measures`).
    """

    n: int
    coarsest: int
    combine: str
    threshold: float
    propagator: Propagator
    factors: tuple[float, ...]
    injectors: tuple[shapes.Injector, ...]
    occluders: tuple[shapes.Injector, ...]
    source: Levels
    target: Levels
    sum: Levels
    index: Levels
    geometry: Levels
    injected: np.ndarray
    merged: np.ndarray | None
    iterations: int
    measures: tuple[dict[str, float], ...] = ()

    @property
    def levels(self) -> int:
        """l, how many levels there are."""
        return len(self.source)

    @property
    def current(self) -> Levels:
        """The newest light: S_i, in the target once a step was made, in the source before."""
        return self.target if self.iterations else self.source

    @property
    def occluded(self) -> bool:
        """Whether anything blocks light."""
        return bool(self.geometry[0].any())

    def arrays(self) -> list[np.ndarray]:
        """Every array of the state, also those shared with others."""
        merged = [] if self.merged is None else [self.merged]
        return [*self.source, *self.target, *self.sum, *self.index, *self.geometry, self.injected, *merged]

    def octrees(self) -> dict[str, Levels]:
        """The octrees of `OCTREES` by name."""
        return dict(zip(OCTREES, (self.source, self.target, self.sum), strict=True))


def first(n: int, coarsest: int, combine: str, threshold: float, propagator: Propagator) -> State:
    """A dark, empty state. Raises SimulationError."""
    try:
        sizes = octree.level_sizes(n, coarsest)
    except (TypeError, ValueError, AttributeError) as error:
        raise SimulationError(f"{error}", "give a power of two, such as 32") from error
    if combine not in octree.COMBINATIONS:
        raise SimulationError(f"combine is '{combine}'", f"give one of {', '.join(octree.COMBINATIONS)}")
    dark = _frozen(np.zeros((size, size, size, 4)) for size in sizes)
    corners = _frozen(np.zeros((size + 1,) * 3 + (4,)) for size in sizes)
    index = _frozen(octree.index_levels(n, coarsest))
    return State(
        n, coarsest, combine, checked_share(threshold), propagator, (1.0,) * len(sizes), (), (),
        dark, dark, dark, index, corners, dark[0], None, 0,
    )  # fmt: skip


def checked_share(threshold: float) -> float:
    if not isinstance(threshold, int | float) or isinstance(threshold, bool) or not 0.0 <= threshold < 1.0:
        raise SimulationError(f"threshold is {threshold!r}", "give a share of the injected light, from 0 to below 1")
    return float(threshold)


def cleared(state: State) -> State:
    """No light, an index volume as it begins; injectors, occluders and settings stay."""
    dark = _frozen(np.zeros_like(level) for level in state.source)
    index = _frozen(octree.index_levels(state.n, state.coarsest))
    return replace(
        state, source=dark, target=dark, sum=dark, index=index, injected=dark[0], merged=None, iterations=0,
        measures=(),
    )  # fmt: skip


def injected(state: State, chosen: Iterable[shapes.Injector]) -> State:
    """The newest light of level 0 plus what `chosen` give; the index volume is 0 where that is (4.2, injection)."""
    light = sum((shapes.light(injector, state.n) for injector in chosen), np.zeros_like(state.injected))
    state = replace(state, injected=_fixed(state.injected + light))
    current = (_fixed(state.current[0] + light), *state.current[1:])
    return replace(_with_current(state, current), index=_marked(state, (light,)))


def downsampled(state: State) -> State:
    """All coarser levels of the newest light anew from level 0 (4.2, eq. 11, or sums)."""
    current = _frozen(octree.build_levels(state.current[0], state.combine, state.coarsest))
    return replace(_with_current(state, current), index=_marked(state, current))


def propagated(state: State) -> State:
    """One iteration on every level: the newest light becomes the source, what it sends the target (4.2, propagation).

    Nothing blocks in the first one (Kaplanyan & Dachsbacher 2010, 3.3: no self-shadowing).
    """
    source = state.current
    blocks = state.iterations > 0 and state.occluded
    target = _frozen(
        state.propagator.step(level, factor, corners if blocks else None)
        for level, factor, corners in zip(source, state.factors, state.geometry, strict=True)
    )  # fmt: skip
    if max(float(np.abs(level).max()) for level in target) > BRIGHTEST:
        raise SimulationError("light grows without bound", "lower the propagation factor, or the multipliers")
    return replace(
        state, source=source, target=target, index=_marked(state, target), iterations=state.iterations + 1
    )  # fmt: skip


def accumulated(state: State) -> State:
    """The newest light added to the sum; doing it after injection and after each step gives S_A (3.2.3)."""
    return replace(state, sum=_frozen(a + b for a, b in zip(state.sum, state.current, strict=True)))


def merged(state: State) -> State:
    """M(x, y, z) = S(x, y, z), from the sum by the index volume (4.2, merging)."""
    return replace(state, merged=_fixed(octree.merge(state.sum, state.index, state.combine)))


def with_occluders(state: State, occluders: tuple[shapes.Injector, ...]) -> State:
    """Other occluders; those that share a corner add up."""
    corners = sum((shapes.blocking(one, state.n) for one in occluders), np.zeros_like(state.geometry[0]))
    return replace(state, occluders=occluders, geometry=_frozen(occlusion.levels(corners, state.levels)))


def _with_current(state: State, current: Levels) -> State:
    return replace(state, target=current) if state.iterations else replace(state, source=current)


def _marked(state: State, contributions: Levels) -> Levels:
    """The index volume after `contributions`; "non-zero" is relative to the largest band 0 of S_0."""
    limit = state.threshold * float(np.abs(state.injected[..., 0]).max())
    return _frozen(octree.mark(state.index, as_averages(contributions, state.combine), limit))


def as_averages(levels: Sequence[np.ndarray], combine: str) -> list[np.ndarray]:
    """`levels` as they would be had parents been averaged: sums hold 8 times as much on each coarser level, which is
    divided out (exactly), so that numbers of all levels compare."""
    return [level * (8.0**-i if combine == "sum" else 1.0) for i, level in enumerate(levels)]


def _fixed(array: Any) -> np.ndarray:
    array = np.asarray(array)
    array.setflags(write=False)
    return array


def _frozen(arrays: Iterable[np.ndarray]) -> Levels:
    return tuple(_fixed(array) for array in arrays)
