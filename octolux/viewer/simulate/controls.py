"""The column of controls: simulation, light and occluders, actions, view, files."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from bokeh.layouts import column, row
from bokeh.models import (
    Button,
    CheckboxButtonGroup,
    Div,
    NumericInput,
    RadioButtonGroup,
    Select,
    Slider,
    Spinner,
    TextInput,
    UIElement,
)  # fmt: skip

from octolux.simulator.laboratory import PROPAGATORS, slices
from octolux.simulator.laboratory.injectors import AXES
from octolux.simulator.lpv import octree

from . import entries
from .laboratory import Laboratory
from .shapes import ShapeForm

WIDTH = 330
Do = Callable[[Callable[[], None]], None]
"""Does what a button asks for, once the page has said that it is working."""

_SIZES = ["8", "16", "32", "64", "128"]
_COARSEST = ["1", "2"]
_COMPARED = ["uniform", "analytic"]
_MERGED = "merged"


def button(
    label: str, name: str, action: Callable[[], None], do: Do, width: int = 96, kind: str = "default"
) -> Button:
    """A button that does `action`."""
    made = Button(label=label, name=name, width=width, button_type=kind)
    made.on_click(lambda: do(action))
    return made


def heading(text: str) -> Div:
    """The name of a group of controls."""
    return Div(text=f"<b style='font-size: 13px; color: #333'>{text}</b>", margin=(10, 5, 0, 5))


def simulation_controls(laboratory: Laboratory, do: Do) -> UIElement:
    """What a simulation begins with, and a button that begins anew."""
    size = Select(title="n", options=_SIZES, width=60, name="n")
    coarsest = Select(title="coarsest", options=_COARSEST, width=60, name="coarsest")
    combine = Select(title="parents", options=list(octree.COMBINATIONS), width=85, name="combine")
    threshold = NumericInput(title="threshold", mode="float", width=70, name="threshold")
    active = [i for i, name in enumerate(_COMPARED) if name in laboratory.simulation.compare]
    compared = CheckboxButtonGroup(labels=_COMPARED, active=active, width=310, name="compare")

    def settings() -> dict[str, Any]:
        state = laboratory.simulation.state
        same = len(octree.level_sizes(int(size.value), int(coarsest.value))) == state.levels
        return {
            "n": int(size.value), "coarsest": int(coarsest.value), "combine": combine.value,
            "threshold": threshold.value or 0.0, "compare": [_COMPARED[i] for i in compared.active],
            "propagator": state.propagator, "factor": state.factors if same else state.factors[0],
        }  # fmt: skip

    def show() -> None:
        state = laboratory.simulation.state
        size.update(options=sorted({*_SIZES, str(state.n)}, key=int), value=str(state.n))
        coarsest.update(options=sorted({*_COARSEST, str(state.coarsest)}, key=int), value=str(state.coarsest))
        combine.value, threshold.value = state.combine, state.threshold

    laboratory.listeners.append(show)
    return column(
        heading("Simulation"), row(size, coarsest, combine, threshold),
        Div(text="measured besides the paper's errors:", margin=(0, 5, 0, 5)), compared,
        button("Begin anew with these", "begin", lambda: laboratory.begin(settings), do, 310),
    )  # fmt: skip


def propagation_controls(laboratory: Laboratory) -> UIElement:
    """Propagator and factor, which hold from the next step on."""
    propagator = Select(title="propagator", options=list(PROPAGATORS), width=145, name="propagator")
    factor = TextInput(title="factor, or one a level", width=145, name="factor")

    def set_propagator(attr: str, old: str, new: str) -> None:
        if new != laboratory.simulation.state.propagator.name:
            laboratory.act("another propagator", lambda: laboratory.simulation.set_propagator(new))

    def set_factor(attr: str, old: str, new: str) -> None:
        if new != _factors(laboratory.simulation.state.factors):
            laboratory.act("another factor", lambda: laboratory.simulation.set_factor(entries.factor(new)))

    def show() -> None:
        state = laboratory.simulation.state
        propagator.value, factor.value = state.propagator.name, _factors(state.factors)

    show()
    laboratory.listeners.append(show)
    propagator.on_change("value", set_propagator)
    factor.on_change("value", set_factor)
    return row(propagator, factor)


def _factors(factors: tuple[float, ...]) -> str:
    return ", ".join(f"{value:g}" for value in (factors[:1] if len(set(factors)) == 1 else factors))


def light_controls(laboratory: Laboratory, do: Do) -> UIElement:
    """The form of a shape, and what is done with it."""
    form = ShapeForm(laboratory)
    told = Div(name="sets", width=WIDTH - 20)

    def show() -> None:
        state = laboratory.simulation.state
        told.text = f"in the set: light {len(state.injectors)}, occluders {len(state.occluders)}"

    laboratory.listeners.append(show)
    return column(
        heading("Light and occluders"), form.layout,
        row(
            button("Add to the set", "add", lambda: laboratory.add(form.role, form.make), do, 96),
            button("Inject it now", "inject-it", lambda: laboratory.inject(form.make), do, 96),
            button("Remove last", "remove", lambda: laboratory.remove_last(form.role), do, 96),
        ),
        told,
    )  # fmt: skip


def action_controls(laboratory: Laboratory, do: Do) -> UIElement:
    """A button for every action, and the whole algorithm."""
    rounds = Spinner(title="iterations", value=4, low=0, high=10_000, step=1, width=90, name="iterations")

    def act(name: str) -> Callable[[], None]:
        return lambda: laboratory.act(name, lambda: getattr(laboratory.simulation, name)())

    def whole() -> None:
        laboratory.act("the whole algorithm", lambda: laboratory.simulation.run(int(rounds.value or 0)))

    done = Div(name="history", width=WIDTH - 20, styles={"color": "#555"})

    def show() -> None:
        names = laboratory.simulation.undoable
        done.text = "done: " + (", ".join(names[-8:]) if names else "nothing yet")

    laboratory.listeners.append(show)
    single = [button(name.capitalize(), name, act(name), do) for name in ("inject", "downsample", "accumulate")]
    single += [button(name.capitalize(), name, act(name), do) for name in ("propagate", "merge", "clear")]
    below = Div(text="&nbsp;", height=13)
    return column(
        heading("Actions"), propagation_controls(laboratory), row(*single[:3]), row(*single[3:]),
        row(button("Step: propagate and accumulate", "step", laboratory.step, do, 310, "primary")),
        row(rounds, column(below, button("Run the whole algorithm", "run", whole, do, 200, "primary"))),
        row(button("Undo", "undo", laboratory.undo, do, 150), button("Redo", "redo", laboratory.redo, do, 150)),
        done,
    )  # fmt: skip


def view_controls(laboratory: Laboratory) -> UIElement:
    """Axis, slice, level, scale and zoom of the grids."""
    axis = RadioButtonGroup(labels=list(AXES), active=AXES.index(laboratory.view.axis), width=150, name="axis")
    scale = RadioButtonGroup(labels=list(slices.SCALES), active=0, width=150, name="scale")
    place = Slider(title="slice", start=0, end=1, value=0, step=1, width=WIDTH - 20, name="slice")
    level = Select(title="level", options=[_MERGED], value=_MERGED, width=150, name="level")
    zoom = Slider(title="curves, times", start=1, end=100, value=1, step=1, width=150, name="zoom")

    def show() -> None:
        state, view = laboratory.simulation.state, laboratory.view
        place.update(end=state.n - 1, value=view.index)
        level.options = [_MERGED, *map(str, range(state.levels))]
        level.value = _MERGED if view.level is None else str(view.level)

    def look(field: str, value: Any) -> None:
        if getattr(laboratory.view, field) != value:
            laboratory.look(**{field: value})

    laboratory.listeners.append(show)
    axis.on_change("active", lambda attr, old, new: look("axis", AXES[new]))
    scale.on_change("active", lambda attr, old, new: look("scale", slices.SCALES[new]))
    place.on_change("value", lambda attr, old, new: look("index", int(new)))
    level.on_change("value", lambda attr, old, new: look("level", None if new == _MERGED else int(new)))
    zoom.on_change("value", lambda attr, old, new: look("zoom", float(new)))
    words = [Div(text=text, width=150, height=14, margin=(5, 5, 0, 5)) for text in ("slice across", "scale")]
    return column(heading("View"), row(*words), row(axis, scale), place, row(level, zoom))
