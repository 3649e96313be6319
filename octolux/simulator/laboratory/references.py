"""What a simulation is measured against: a uniform volume, and the analytic solution."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from octolux.simulator import sh as harmonics

from . import state as actions
from .state import State

NAMES = frozenset({"uniform", "analytic"})
MOST_SOURCES = 8192
"""Cells with light for which the analytic solution is worked out; its time grows with them times n^3."""


def uniform_volume(state: State, iterations: int) -> np.ndarray:
    """S_A [z][y][x][4] after `iterations` steps of level 0 alone, with the state's injected light, propagator, factor
    and occluders: the traditional volume of Olovsson 2012, 7."""
    finest = actions.first(state.n, state.n, state.combine, state.threshold, state.propagator)
    finest = replace(
        finest, factors=state.factors[:1], geometry=state.geometry[:1], injected=state.injected,
        source=(state.injected,),
    )  # fmt: skip
    finest = actions.accumulated(finest)
    for _ in range(iterations):
        finest = actions.accumulated(actions.propagated(finest))
    return finest.sum[0]


def analytic_volume(injected: np.ndarray) -> np.ndarray:
    """The light that sources at the centres of the cells of `injected` [z][y][x][4] give every cell, in a vacuum.

    A source of intensity I(w) gives a plane across the ray at r cells the irradiance I / r^2 per square of a cell.
    A cell that light crosses holds that light's flux through its cross-section, as the accumulated sum of a propagation
    does, so with w the direction from source to cell

        S(p) = sum over the sources q of I_q(w) / |p - q|^2 * b(w),    S_0(q) in addition where p = q,

    b the SH basis: light from one direction. I_q is read as a dominant lobe, which is exact for the cosine lobes and
    isotropic sources that are injected.
    """
    z, y, x = np.indices(injected.shape[:3])
    places = np.stack([x, y, z], axis=-1).astype(np.float64)
    result = injected.copy()
    for q in np.argwhere(injected[..., 0] != 0.0):
        way = places - places[tuple(q)]
        square = np.sum(way * way, axis=-1)
        square[tuple(q)] = np.inf
        direction = way / np.sqrt(square)[..., None]
        intensity = harmonics.evaluate_dominant_lobe(injected[tuple(q)], direction)
        result += (intensity / square)[..., None] * harmonics.basis(direction)
    return result


def has_analytic(state: State) -> bool:
    """Whether there is an analytic solution: nothing blocks, no light is negative, and the sources are not too many."""
    band0 = state.injected[..., 0]
    return not state.occluded and bool((band0 >= 0.0).all()) and int(np.count_nonzero(band0)) <= MOST_SOURCES


class References:
    """The last reference of each kind, kept as long as what it was made from stays the same."""

    def __init__(self) -> None:
        self._kept: dict[str, tuple[tuple[object, ...], np.ndarray]] = {}

    def uniform(self, state: State, iterations: int) -> np.ndarray:
        """`uniform_volume`, made once."""
        made_from = (state.injected, state.propagator, state.geometry[0], state.factors[0], iterations)
        return self._get("uniform", made_from, lambda: uniform_volume(state, iterations))

    def analytic(self, state: State) -> np.ndarray | None:
        """`analytic_volume`, made once; None where `has_analytic` is false."""
        if not has_analytic(state):
            return None
        return self._get("analytic", (state.injected,), lambda: analytic_volume(state.injected))

    def _get(self, name: str, made_from: tuple[object, ...], make: Callable[[], np.ndarray]) -> np.ndarray:
        if name in self._kept:
            former, reference = self._kept[name]
            if len(former) == len(made_from) and all(
                a is b or (isinstance(a, int | float) and a == b) for a, b in zip(former, made_from, strict=True)
            ):
                return reference
        reference = make()
        reference.setflags(write=False)
        self._kept[name] = (made_from, reference)
        return reference
