"""The actions of a script: what `do` may name, and which keys each takes."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import PurePath
from typing import Any, NamedTuple

from octolux.scene.toml.fields import Table, nearest

from . import results, slices
from .errors import SimulationError
from .pictures import slice_figure
from .propagators import PROPAGATORS
from .simulation import Simulation
from .state import OCTREES
from .tables import factor, whole

MOST_TIMES = 10_000


class Action(NamedTuple):
    """perform: does it, and gives the bytes of the file it makes, if it makes one.  file: the name of that."""

    perform: Callable[[Simulation], bytes | None]
    file: str | None = None


def read_action(table: Table, injectors: int) -> Action:
    """The action that a table [[action]] asks for, of a script with so many injectors. Raises SceneError."""
    name = table.choice("do", list(ACTIONS))
    keys, read = ACTIONS[name]
    table.allow(("do", *keys))
    if "injector" in table:
        whole(table, "injector", low=1, high=injectors)
    return read(table)


def _plain(method: Callable[[Simulation], Any]) -> Callable[[Table], Action]:
    """An action without keys."""

    def perform(simulation: Simulation) -> None:
        method(simulation)

    return lambda table: Action(perform)


def _inject(table: Table) -> Action:
    number = whole(table, "injector", None)

    def perform(simulation: Simulation) -> None:
        simulation.inject(None if number is None else simulation.state.injectors[number - 1])

    return Action(perform)


def _step(table: Table) -> Action:
    times = whole(table, "times", 1, low=1, high=MOST_TIMES)

    def perform(simulation: Simulation) -> None:
        for _ in range(times):
            simulation.propagate()
            simulation.accumulate()

    return Action(perform)


def _run(table: Table) -> Action:
    iterations = whole(table, "iterations", low=0, high=MOST_TIMES)
    return Action(lambda simulation: simulation.run(iterations))


def _back(method: Callable[[Simulation], str | None], name: str) -> Callable[[Table], Action]:
    def read(table: Table) -> Action:
        times = whole(table, "times", 1, low=1, high=MOST_TIMES)

        def perform(simulation: Simulation) -> None:
            for done in range(times):
                if method(simulation) is None:
                    raise SimulationError(f"there is nothing to {name} after {done} of {times}", "lower 'times'")

        return Action(perform)

    return read


def _set(table: Table) -> Action:
    propagator = table.choice("propagator", list(PROPAGATORS), None) if "propagator" in table else None
    factors = factor(table)
    if propagator is None and factors is None:
        raise table.error("", "sets nothing", "give 'propagator', 'factor' or both")

    def perform(simulation: Simulation) -> None:
        if propagator is not None:
            simulation.set_propagator(propagator)
        if factors is not None:
            simulation.set_factor(factors)

    return Action(perform)


def _picture(table: Table) -> Action:
    level = whole(table, "level", None, low=0)
    options = {
        "axis": table.choice("axis", list(slices.AXES), "z"), "index": whole(table, "slice", None, low=0),
        "level": level, "scale": table.choice("scale", slices.SCALES, "linear"),
        "zoom": table.number("zoom", 1.0, above=0.0), "names": _octrees(table),
    }  # fmt: skip
    return Action(lambda simulation: results.png(slice_figure(simulation, **options)), _file(table, ".png"))


def _octrees(table: Table) -> list[str]:
    """Which octrees a picture shows: those of `show`, or all."""
    names = table.texts("show") or list(OCTREES)
    for name in names:
        if name not in OCTREES:
            raise table.error("show", f"there is no octree '{name}'", nearest(name, OCTREES))
    return names


def _save(table: Table) -> Action:
    return Action(lambda simulation: results.state_npz(simulation.state), _file(table, ".npz"))


def _file(table: Table, suffix: str) -> str:
    """The name of a file in the output folder."""
    name = table.text("file")
    if PurePath(name).name != name or "\\" in name or "\0" in name or name.startswith("."):
        raise table.error("file", f"'{name}' is not a plain file name", "leave folders out; --out names the folder")
    if PurePath(name).suffix.lower() != suffix:
        raise table.error("file", f"'{name}' is not written", f"end the name with {suffix}")
    return name


ACTIONS: dict[str, tuple[tuple[str, ...], Callable[[Table], Action]]] = {
    "inject": (("injector",), _inject),
    "downsample": ((), _plain(Simulation.downsample)),
    "propagate": ((), _plain(Simulation.propagate)),
    "accumulate": ((), _plain(Simulation.accumulate)),
    "step": (("times",), _step),
    "merge": ((), _plain(Simulation.merge)),
    "clear": ((), _plain(Simulation.clear)),
    "run": (("iterations",), _run),
    "undo": (("times",), _back(Simulation.undo, "undo")),
    "redo": (("times",), _back(Simulation.redo, "redo")),
    "set": (("propagator", "factor"), _set),
    "picture": (("file", "axis", "slice", "level", "scale", "zoom", "show"), _picture),
    "save": (("file",), _save),
}
"""By name: the keys besides `do`, and how it is read."""
