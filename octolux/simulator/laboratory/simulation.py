"""A simulation: the present state, the actions on it, and the way back."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace

import numpy as np

from octolux.scene.toml.fields import nearest
from octolux.simulator.lpv import octree

from . import measures, references, state
from .errors import SimulationError
from .history import History
from .injectors import Injector
from .propagators import PROPAGATORS, Propagator
from .state import State

HISTORY_BYTES = 2**30
LARGEST = 128
"""Cells along each side that a simulation may have: a state then takes 0.5 GiB."""


class Simulation:
    """Octree light propagation, one action at a time, with undo and redo.

    n: cells along each side, a power of two up to 128.  coarsest: of the last level; 1, or the thesis's 2.
    combine: how parents are made, "average" (Olovsson 2012, eq. 11) or "sum".  threshold: see `State`.
    propagator: a name in `PROPAGATORS`, or one of your own.  factor: propagation factor, or one for each level.
    injectors, occluders: as `set_injectors` and `set_occluders` take them.
    compare: errors that are measured besides the paper's: "uniform" (section 7) and "analytic".
    uniform_iterations: of the uniform volume; 2 n by default (Kaplanyan & Dachsbacher 2010, 3.3).

    Every action raises SimulationError, and leaves the state as it was, when it cannot be done.
    """

    def __init__(
        self, n: int = 32, *, coarsest: int = 1, combine: str = "average", threshold: float = 0.0,
        propagator: str | Propagator = "best", factor: float | Sequence[float] = 1.0,
        injectors: Iterable[Injector] = (), occluders: Iterable[Injector] = (), compare: Iterable[str] = (),
        uniform_iterations: int | None = None, history_bytes: int = HISTORY_BYTES,
    ):  # fmt: skip
        if isinstance(n, int) and n > LARGEST:
            raise SimulationError(f"n is {n}", f"give at most {LARGEST}")
        present = state.first(n, coarsest, combine, threshold, _propagator(propagator))
        present = replace(present, factors=_factors(factor, present.levels), injectors=tuple(injectors))
        present = state.with_occluders(present, tuple(occluders))
        self._history = History(present, history_bytes)
        self._references = references.References()
        self.compare = _known(compare)
        self.uniform_iterations = checked_count(2 * n if uniform_iterations is None else uniform_iterations)

    @property
    def state(self) -> State:
        """The present state; read-only."""
        return self._history.state

    @property
    def undoable(self) -> list[str]:
        """Names of the actions that can be undone, the newest last."""
        return self._history.undoable

    @property
    def redoable(self) -> list[str]:
        """Names of the actions that can be redone, the next one last."""
        return self._history.redoable

    @property
    def kept_bytes(self) -> int:
        """Memory of the present state and of all that can be undone and redone."""
        return self._history.bytes()

    def undo(self) -> str | None:
        """Take back the last action; its name, or None where there is none."""
        return self._history.undo()

    def redo(self) -> str | None:
        """Do again what was undone last; its name, or None where there is none."""
        return self._history.redo()

    def set_propagator(self, propagator: str | Propagator) -> None:
        """What the next iterations use."""
        self._act("propagator", lambda s: replace(s, propagator=_propagator(propagator)))

    def set_factor(self, factor: float | Sequence[float]) -> None:
        """The propagation factor of the next iterations, for all levels or one for each."""
        self._act("factor", lambda s: replace(s, factors=_factors(factor, s.levels)))

    def set_injectors(self, injectors: Iterable[Injector]) -> None:
        """The set that `inject` injects."""
        chosen = tuple(injectors)
        self._act("injectors", lambda s: replace(s, injectors=chosen))

    def add_injector(self, injector: Injector) -> None:
        """One more in the set that `inject` injects."""
        self.set_injectors((*self.state.injectors, injector))

    def set_occluders(self, occluders: Iterable[Injector]) -> None:
        """What blocks light: shapes on the (n + 1)^3 corners of the cells, see `occlusion`."""
        chosen = tuple(occluders)
        self._act("occluders", lambda s: state.with_occluders(s, chosen))

    def add_occluder(self, occluder: Injector) -> None:
        """One more thing that blocks light."""
        self.set_occluders((*self.state.occluders, occluder))

    def clear(self) -> None:
        """No light any more; injectors, occluders and settings stay."""
        self._act("clear", state.cleared)

    def inject(self, injector: Injector | None = None) -> None:
        """Add the light of all injectors, or of `injector` alone, to level 0 of the newest light."""
        self._act("inject", lambda s: state.injected(s, s.injectors if injector is None else (injector,)))

    def downsample(self) -> None:
        """Make the coarser levels of the newest light from level 0."""
        self._act("downsample", state.downsampled)

    def propagate(self) -> None:
        """One iteration on all levels."""
        self._act("propagate", state.propagated)

    def accumulate(self) -> None:
        """Add the newest light to the sum, and measure the errors."""
        self._act("accumulate", self._accumulated)

    def merge(self) -> None:
        """Make one volume of the sum's levels, as the index volume says."""
        self._act("merge", state.merged)

    def run(self, iterations: int, progress: Callable[[int], None] = lambda done: None) -> None:
        """The whole algorithm from the beginning: clear, inject, downsample, accumulate, `iterations` times propagate
        and accumulate, merge. One action to undo. progress: called with the number of iterations done."""
        iterations = checked_count(iterations)
        after = self._accumulated(state.downsampled(state.injected(state.cleared(self.state), self.state.injectors)))
        for done in range(iterations):
            after = self._accumulated(state.propagated(after))
            progress(done + 1)
        self._history.record(f"run {iterations}", state.merged(after))

    def view(self, name: str = "sum", level: int | None = None) -> np.ndarray:
        """Coefficients to look at, [z][y][x][4]: of "source", "target" or "sum", of one level, or (None) all of them
        merged by the index volume and read with level 0's cell size."""
        octrees = self.state.octrees()
        if name not in octrees:
            raise SimulationError(f"there is no octree '{name}'", nearest(name, octrees))
        if level is None:
            return octree.merge(octrees[name], self.state.index, self.state.combine)
        if isinstance(level, bool) or not isinstance(level, int) or not 0 <= level < self.state.levels:
            raise SimulationError(f"there is no level {level!r}", f"give 0 to {self.state.levels - 1}")
        return octrees[name][level]

    def index(self) -> np.ndarray:
        """I(x, y, z), int64 [z][y][x] of level 0's size: which level is read where (4.2)."""
        return octree.flat_index(self.state.index)

    def uniform(self) -> np.ndarray:
        """The uniform volume [z][y][x][4] that the injected light gives after `uniform_iterations` (section 7)."""
        return self._references.uniform(self.state, self.uniform_iterations)

    def analytic(self) -> np.ndarray | None:
        """The analytic solution [z][y][x][4] for the injected light (`analytic`), or None where there is none."""
        return self._references.analytic(self.state)

    def _accumulated(self, before: State) -> State:
        after = state.accumulated(before)
        uniform = self._references.uniform(after, self.uniform_iterations) if "uniform" in self.compare else None
        analytic = self._references.analytic(after) if "analytic" in self.compare else None
        return replace(after, measures=(*after.measures, measures.row(after, uniform, analytic)))

    def _act(self, name: str, action: Callable[[State], State]) -> None:
        self._history.record(name, action(self.state))


def checked_count(iterations: int) -> int:
    """`iterations` as it is. Raises SimulationError unless it is a whole number from 0 to 10,000."""
    if isinstance(iterations, bool) or not isinstance(iterations, int) or not 0 <= iterations <= 10_000:
        raise SimulationError(f"the number of iterations is {iterations!r}", "give a whole number from 0 to 10000")
    return iterations


def _propagator(propagator: str | Propagator) -> Propagator:
    if isinstance(propagator, Propagator):
        return propagator
    if propagator not in PROPAGATORS:
        raise SimulationError(f"there is no propagator '{propagator}'", nearest(str(propagator), PROPAGATORS))
    return PROPAGATORS[propagator]


def _factors(factor: float | Sequence[float], levels: int) -> tuple[float, ...]:
    values = np.asarray(factor)
    if values.dtype.kind not in "iuf" or not np.isfinite(values).all() or (values < 0.0).any():
        raise SimulationError(f"the propagation factor is {factor!r}", "give a number of at least 0, or one a level")
    if values.shape not in ((), (levels,)):
        raise SimulationError(f"there are {values.size} factors for {levels} levels", f"give {levels}, or one")
    return tuple(np.broadcast_to(values, (levels,)).astype(np.float64).tolist())


def _known(compare: Iterable[str]) -> frozenset[str]:
    chosen = frozenset([compare] if isinstance(compare, str) else compare)
    for name in sorted(map(str, chosen - references.NAMES)):
        raise SimulationError(f"nothing to compare with is called '{name}'", nearest(name, sorted(references.NAMES)))
    return chosen
