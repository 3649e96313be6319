"""What one open page works on: a simulation, the way it is looked at, and the actions of the buttons."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from octolux.scene.errors import OctoluxError
from octolux.simulator.laboratory import Simulation
from octolux.simulator.laboratory.injectors import Injector, light


@dataclass(frozen=True)
class View:
    """axis, index: of the slice, in cells of level 0. level: None is all, merged. scale, zoom: of the curves."""

    axis: str = "z"
    index: int = 0
    level: int | None = None
    scale: str = "linear"
    zoom: float = 1.0


@dataclass
class Laboratory:
    """`act` does something to the simulation or the view, and `listeners` hear of it.

    message: what was done last, or what could not be; failed: which of the two.
    """

    simulation: Simulation

    def __post_init__(self) -> None:
        self.view = View(index=self.simulation.state.n // 2)
        self.message, self.failed = "ready", False
        self.listeners: list[Callable[[], None]] = []

    def act(self, name: str, action: Callable[[], Any]) -> None:
        """Do it, keep its name or its error as the message, and tell all listeners. Only OctoluxErrors are caught."""
        try:
            said = action()
            self.message, self.failed = said if isinstance(said, str) else name, False
        except OctoluxError as error:
            self.message, self.failed = str(error), True
        for listener in self.listeners:
            listener()

    def look(self, **changes: Any) -> None:
        """Change fields of the view."""
        self.view = replace(self.view, **changes)
        level = "all levels" if self.view.level is None else f"level {self.view.level}"
        self.act(f"looking at {self.view.axis} = {self.view.index}, {level}", lambda: None)

    def begin(self, settings: Callable[[], dict[str, Any]]) -> None:
        """A new, dark simulation of those settings (`Simulation`), with the same injectors and occluders; the old one
        cannot be brought back."""

        def anew() -> None:
            old = self.simulation.state
            self.simulation = Simulation(**settings(), injectors=old.injectors, occluders=old.occluders)
            n = self.simulation.state.n
            self.view = replace(self.view, index=self.view.index * n // old.n, level=None)

        self.act("a new simulation", anew)

    def inject(self, injector: Callable[[], Injector]) -> None:
        """Add the light of one injector that `injector` makes."""
        self.act("injected", lambda: self.simulation.inject(injector()))

    def add(self, role: str, shape: Callable[[], Injector]) -> None:
        """Put the shape that `shape` makes into the set of injectors (role "light") or occluders ("blocking")."""

        def added() -> str:
            made = shape()
            if role == "blocking":
                self.simulation.add_occluder(made)
                return "an occluder more"
            light(made, self.simulation.state.n)  # refuses at once what lies outside
            self.simulation.add_injector(made)
            return "an injector more"

        self.act("added", added)

    def remove_last(self, role: str) -> None:
        """Take the newest injector or occluder out of its set."""
        state = self.simulation.state
        if role == "blocking":
            self.act("an occluder less", lambda: self.simulation.set_occluders(state.occluders[:-1]))
        else:
            self.act("an injector less", lambda: self.simulation.set_injectors(state.injectors[:-1]))

    def step(self, times: int = 1) -> None:
        """Propagate and accumulate, `times` times."""

        def steps() -> None:
            for _ in range(times):
                self.simulation.propagate()
                self.simulation.accumulate()

        self.act("propagated and accumulated", steps)

    def undo(self) -> None:
        self.act("undo", lambda: _told("took back", self.simulation.undo(), "nothing to undo"))

    def redo(self) -> None:
        self.act("redo", lambda: _told("did again", self.simulation.redo(), "nothing to redo"))


def _told(what: str, name: str | None, nothing: str) -> str:
    return nothing if name is None else f"{what}: {name}"
