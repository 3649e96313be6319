"""The page: controls on the left, the three grids and the plots of what is measured on the right."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

from bokeh.document import Document
from bokeh.layouts import column, row
from bokeh.models import Div

from octolux.simulator.laboratory import Simulation

from .controls import WIDTH, action_controls, light_controls, simulation_controls, view_controls
from .downloads import download_controls
from .grids import grids
from .laboratory import Laboratory
from .plots import plots

_STYLE = ":host { border-right: 1px solid #ddd; padding-right: 8px; }"


def fill(document: Document, simulation: Simulation) -> Laboratory:
    """Put the page for `simulation` into `document`."""
    laboratory = Laboratory(simulation)
    status = Div(name="status", sizing_mode="stretch_width", margin=(6, 5, 2, 12))

    def show() -> None:
        state = laboratory.simulation.state
        facts = f"n = {state.n}, iteration {state.iterations}, {state.propagator.name}"
        colour = "#b00020" if laboratory.failed else "#222"
        status.text = f"<span style='color: {colour}; font-size: 14px'>{facts}: {escape(laboratory.message)}</span>"

    def do(action: Callable[[], None]) -> None:
        status.text = "<span style='color: #777; font-size: 14px'>working ...</span>"
        document.add_next_tick_callback(action)  # after the browser was told

    drawn, measured = grids(laboratory), plots(laboratory)
    left = column(
        Div(text="<b style='font-size: 16px'>octolux simulate</b>", margin=(6, 5, 0, 5)),
        simulation_controls(laboratory, do), light_controls(laboratory, do), action_controls(laboratory, do),
        view_controls(laboratory), download_controls(laboratory, do), width=WIDTH, stylesheets=[_STYLE],
    )  # fmt: skip
    right = column(
        status, row(*(grid.plot for grid in drawn)), row(*measured[:3]), row(*measured[3:]), margin=(0, 0, 0, 8),
    )  # fmt: skip
    laboratory.listeners.append(show)
    for listener in laboratory.listeners:
        listener()
    document.add_root(row(left, right, name="page"))
    document.title = "octolux simulate"
    return laboratory
