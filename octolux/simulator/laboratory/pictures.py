"""Pictures of a simulation: slices of source, target and sum side by side, and the errors by iteration.

Figures are matplotlib's own, made without its global state, so that several can be drawn at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection, PolyCollection
from matplotlib.figure import Figure

from . import slices
from .simulation import Simulation
from .state import OCTREES

LIGHT, NEGATIVE, BORDER, BLOCK = "#c2570c", "#2563ab", "#111111", "#8a8a8a"

_OWN, _UNIFORM = "against its own downsampling (6.2)", "against uniform, downsampled (7)"
_MERGED = "merged against uniform"

PANELS: dict[str, dict[str, str]] = {
    "mean absolute error, W/sr": {"e_abs": _OWN, "corrected_e_abs": _UNIFORM, "merged_abs": _MERGED},
    "mean relative error": {"e_rel": _OWN, "corrected_e_rel": _UNIFORM, "merged_rel": _MERGED},
    "largest absolute error, W/sr": {"max_abs": _OWN, "corrected_max_abs": _UNIFORM},
    "relative error against the analytic solution": {"analytic_rel": "merged", "analytic_uniform_rel": "level 0"},
    "flux, W": {"step_flux": "of the step, level 0", "sum_flux": "of the sum, merged"},
    "centre of mass, cells": {
        f"{name}_centre_{axis}": f"{name}, {axis}" for name in ("step", "sum") for axis in slices.AXES
    },
}  # fmt: skip
"""The panels of the error plot: title, and columns of `State.measures` with what they are called."""


def slice_figure(
    simulation: Simulation, axis: str = "z", index: int | None = None, level: int | None = None,
    scale: str = "linear", zoom: float = 1.0, names: Sequence[str] = OCTREES,
) -> Figure:  # fmt: skip
    """The octrees `names` side by side, each cell's intensity as its polar curve in the slice plane (OLPV, figure 9).

    index: of the slice, in cells of level 0; the middle by default.  level: one level, or None: merged, with borders
    between levels drawn.  scale: "linear" or "log".  zoom: of the curves; each octree's largest intensity fills a cell
    at 1. Raises SimulationError.
    """
    n = simulation.state.n
    index = n // 2 if index is None else index
    figure = Figure(figsize=(4.6 * len(names), 5.0), layout="constrained")
    for position, name in enumerate(names, 1):
        axes = figure.add_subplot(1, len(names), position)
        volume = simulation.view(name, level)
        cell = n // volume.shape[0]
        slices.cut(simulation.index(), axis, index)  # refuses an index outside level 0
        plane = slices.cut(volume, axis, index // cell)
        curves, negative = slices.polar_curves(plane, axis, cell, scale, zoom)
        _grid(axes, n, cell)
        _curves(axes, curves, negative)
        if level is None:
            borders = slices.level_borders(slices.cut(simulation.index(), axis, index))
            axes.add_collection(LineCollection(list(borders), colors=BORDER, linewidths=1.4, zorder=4))
        _blocks(axes, simulation, axis, index)
        axes.set_title(f"{name}, {'merged' if level is None else f'level {level}'}", fontsize=10)
        u, v = slices.plane_names(axis)
        axes.set_xlabel(u)
        axes.set_ylabel(v)
    state = simulation.state
    figure.suptitle(
        f"{axis} = {index}, iteration {state.iterations}, {state.propagator.name}, {scale} scale", fontsize=11
    )  # fmt: skip
    return figure


def error_figure(rows: Sequence[dict[str, float]]) -> Figure:
    """What was measured after each accumulation, against its iteration (OLPV, figures 11 and 15)."""
    figure = Figure(figsize=(15.0, 8.0), layout="constrained")
    for position, (title, columns) in enumerate(PANELS.items(), 1):
        axes = figure.add_subplot(2, 3, position)
        for number, (column, label) in enumerate(columns.items()):
            points = [(row["iteration"], row[column]) for row in rows if column in row]
            if points:
                style = "-o" if number < 3 else "--s"
                axes.plot(*zip(*points, strict=True), style, markersize=3, linewidth=1.2, label=label)
        axes.set_title(title, fontsize=10)
        axes.set_xlabel("iteration")
        if not title.startswith("centre"):
            axes.set_ylim(0.0, 1.05 * axes.get_ylim()[1])
        axes.grid(alpha=0.3)
        if axes.lines:
            axes.legend(fontsize=8)
        else:
            axes.text(0.5, 0.5, "not measured", ha="center", transform=axes.transAxes, color="0.5")
    return figure


def _grid(axes: Axes, n: int, cell: int) -> None:
    axes.set_xlim(0, n)
    axes.set_ylim(0, n)
    axes.set_aspect("equal")
    ends = range(0, n + 1, cell)
    lines = [np.array(line) for e in ends for line in ([(e, 0), (e, n)], [(0, e), (n, e)])]
    axes.add_collection(LineCollection(lines, colors="0.85", linewidths=0.5, zorder=1))


def _curves(axes: Axes, curves: np.ndarray, negative: np.ndarray) -> None:
    """Light filled in one colour; the parts where the intensity is negative as lines in another."""
    axes.add_collection(
        PolyCollection(list(curves), facecolors=LIGHT + "55", edgecolors=LIGHT, linewidths=0.6, zorder=3)
    )  # fmt: skip
    if negative.any():
        both = negative & np.roll(negative, -1, axis=1)
        segments = np.stack([curves, np.roll(curves, -1, axis=1)], axis=2)[both]
        axes.add_collection(LineCollection(list(segments), colors=NEGATIVE, linewidths=0.9, zorder=3.5))


def _blocks(axes: Axes, simulation: Simulation, axis: str, index: int) -> None:
    """Corners of cells that block, beside the slice, as squares as large as they block in all directions together."""
    corners = simulation.state.geometry[0]
    if not simulation.state.occluded:
        return
    plane: Any = np.maximum(slices.cut(corners, axis, index), slices.cut(corners, axis, index + 1))[..., 0]
    v, u = np.nonzero(plane)
    axes.scatter(u, v, s=60.0 * plane[v, u] / plane.max(), c=BLOCK, marker="s", zorder=2, linewidths=0)
