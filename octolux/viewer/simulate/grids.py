"""The three grids: source, target and sum, each cell's intensity as its polar curve, with what the pointer is over."""

from __future__ import annotations

from typing import Any

import numpy as np
from bokeh.models import ColumnDataSource, FixedTicker, HoverTool, Range1d
from bokeh.plotting import figure

from octolux.simulator import sh as harmonics
from octolux.simulator.laboratory import Simulation, slices
from octolux.simulator.laboratory.files import COEFFICIENTS
from octolux.simulator.laboratory.pictures import BLOCK, BORDER, LIGHT, NEGATIVE
from octolux.simulator.laboratory.state import OCTREES

from .laboratory import Laboratory, View

TOOLS = "pan,wheel_zoom,box_zoom,reset,save"
"""Of every drawing on the page."""

_FINE = 32
"""Cells along a side up to which curves are drawn with all their points; above, with half."""

_KINDS = ("curves", "negative", "cells", "borders", "blocks")

_HOVER = [
    ("cell x, y, z", "@x, @y, @z"), ("level", "@level"), ("flux", "@{flux}{%.4g} W"), ("largest", "@{peak}{%.4g} W/sr"),
    *((name, f"@{{{name}}}{{%.4g}}") for name in COEFFICIENTS),
]  # fmt: skip
_PRINTED = {f"@{{{name}}}": "printf" for name in ("flux", "peak", *COEFFICIENTS)}


class Grid:
    """One of them. `plot` is what is put on the page. The three share their ranges, so they zoom together."""

    def __init__(self, name: str, x_range: Range1d, y_range: Range1d):
        self.name = name
        self.plot = figure(
            title=name, tools=TOOLS, active_scroll=None, x_range=x_range, y_range=y_range, width=410, height=430,
            toolbar_location="above", min_border_left=58, name=f"grid-{name}",
        )  # fmt: skip
        self._sources = {key: ColumnDataSource(name=key) for key in _KINDS}
        self._draw()

    def _draw(self) -> None:
        s, plot = self._sources, self.plot
        s["curves"].data = {"u": [], "v": []}
        s["negative"].data = s["borders"].data = {"u0": [], "v0": [], "u1": [], "v1": []}
        s["blocks"].data = {"u": [], "v": [], "size": []}
        s["cells"].data = {key: [] for key in ("left", "right", "bottom", "top", *_COLUMNS)}
        ends = {"x0": "u0", "y0": "v0", "x1": "u1", "y1": "v1"}
        plot.scatter("u", "v", size="size", marker="square", color=BLOCK, line_color=None, source=s["blocks"])
        plot.patch(
            "u", "v", fill_color=LIGHT, fill_alpha=0.33, line_color=LIGHT, line_width=0.8, source=s["curves"]
        )  # fmt: skip
        plot.segment(**ends, color=NEGATIVE, line_width=1.2, source=s["negative"])
        plot.segment(**ends, color=BORDER, line_width=1.6, source=s["borders"])
        cells = plot.quad(
            "left", "right", "top", "bottom", fill_alpha=0.0, line_alpha=0.0, hover_fill_color=LIGHT,
            hover_fill_alpha=0.12, hover_line_color=LIGHT, hover_line_alpha=0.8, source=s["cells"],
        )  # fmt: skip
        plot.add_tools(HoverTool(renderers=[cells], tooltips=_HOVER, formatters=_PRINTED, point_policy="follow_mouse"))
        # Made once: another ticker has Bokeh search all models of the page anew, half a second for the twelve here.
        self._labels, self._lines = FixedTicker(), FixedTicker()
        plot.axis.ticker, plot.grid.ticker = self._labels, self._lines
        plot.grid.grid_line_color = "#e4e4e4"
        plot.title.text_font_size = "14px"
        plot.toolbar.logo = None

    def show(self, simulation: Simulation, view: View) -> None:
        """Draw the slice of `view`. Raises SimulationError."""
        n = simulation.state.n
        volume = simulation.view(self.name, view.level)
        cell = n // volume.shape[0]
        index = slices.cut(simulation.index(), view.axis, view.index)
        plane = slices.cut(volume, view.axis, view.index // cell)
        samples = slices.SAMPLES if n // cell <= _FINE else slices.SAMPLES // 2
        curves, negative = slices.polar_curves(plane, view.axis, cell, view.scale, view.zoom, samples=samples)
        merged = view.level is None
        self._sources["curves"].data = _with_gaps(curves)
        both = negative & np.roll(negative, -1, axis=1)
        self._sources["negative"].data = _ends(np.stack([curves, np.roll(curves, -1, axis=1)], axis=2)[both])
        self._sources["borders"].data = _ends(slices.level_borders(index) if merged else np.zeros((0, 2, 2)))
        self._sources["cells"].data = _cells(plane, view, cell, index if merged else None)
        self._sources["blocks"].data = _blocks(simulation, view)
        self.plot.title.text = f"{self.name}, {'merged' if merged else f'level {view.level}'}"
        self.plot.xaxis.axis_label, self.plot.yaxis.axis_label = slices.plane_names(view.axis)
        self._labels.ticks = list(range(0, n + 1, max(cell, n // 16)))
        self._lines.ticks = list(range(0, n + 1, cell))


_COLUMNS = ("x", "y", "z", "level", "flux", "peak", *COEFFICIENTS)


def grids(laboratory: Laboratory) -> list[Grid]:
    """The three, kept up to date by `laboratory`."""
    ranges = Range1d(), Range1d()
    made = [Grid(name, *ranges) for name in OCTREES]
    fitted: list[int] = []

    def show() -> None:
        n = laboratory.simulation.state.n
        for grid in made:
            grid.show(laboratory.simulation, laboratory.view)
        if fitted != [n]:
            fitted[:] = [n]
            for limits in ranges:
                limits.update(start=0, end=n, reset_start=0, reset_end=n)

    laboratory.listeners.append(show)
    return made


def _with_gaps(curves: np.ndarray) -> dict[str, np.ndarray]:
    """Closed curves (K, samples, 2) as the points of one patch, with NaN between them."""
    gap = np.full((len(curves), 1, 2), np.nan)
    u, v = np.concatenate([curves, gap], axis=1).reshape(-1, 2).T
    return {"u": u, "v": v}


def _ends(segments: np.ndarray) -> dict[str, np.ndarray]:
    """Segments (K, 2, 2) [end][u, v] by column."""
    return {f"{axis}{end}": segments[:, end, i] for end in (0, 1) for i, axis in enumerate("uv")}


def _cells(plane: np.ndarray, view: View, cell: int, index: np.ndarray | None) -> dict[str, Any]:
    """What the pointer tells of each lit cell of `plane` [v][u][4]; index: which level each is read from, if merged."""
    lit = np.argwhere(plane.any(axis=-1))
    values = plane[tuple(lit.T)]
    v, u = lit.T
    place = dict(zip(slices.plane_names(view.axis), (u, v), strict=True))
    place[view.axis] = np.full(len(lit), view.index // cell)
    around = np.abs(values @ harmonics.basis(slices.directions(view.axis)).T)
    level = np.full(len(lit), view.level) if index is None else index[v, u]
    return {
        "left": u * cell, "right": (u + 1) * cell, "bottom": v * cell, "top": (v + 1) * cell, **place,
        "level": level, "flux": harmonics.flux(values), "peak": around.max(axis=-1, initial=0.0),
        **dict(zip(COEFFICIENTS, values.T, strict=True)),
    }  # fmt: skip


def _blocks(simulation: Simulation, view: View) -> dict[str, np.ndarray]:
    """Corners beside the slice that block, as squares as large as they block in all directions together."""
    corners = simulation.state.geometry[0]
    plane = np.maximum(*(slices.cut(corners, view.axis, i) for i in (view.index, view.index + 1)))[..., 0]
    v, u = np.nonzero(plane)
    share = plane[v, u] / plane.max() if len(u) else np.zeros(0)
    return {"u": u, "v": v, "size": 9.0 * np.sqrt(share)}
