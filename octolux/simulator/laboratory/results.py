"""What a simulation leaves behind: the whole state as NPZ, the errors as CSV, pictures as PNG; all as bytes."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from .pictures import error_figure, slice_figure
from .simulation import Simulation
from .state import State

FILES = ("state.npz", "errors.csv", "errors.png", "slices.png")
"""What every script writes."""

_DOTS_PER_INCH = 110


def final_files(simulation: Simulation) -> dict[str, bytes]:
    """The contents of `FILES` for the present state. The slice is through the middle of z, merged, linear."""
    rows = simulation.state.measures
    contents = (state_npz(simulation.state), errors_csv(rows), png(error_figure(rows)), png(slice_figure(simulation)))
    return dict(zip(FILES, contents, strict=True))


def settings(state: State) -> dict[str, Any]:
    """What the state was made with, as plain data."""
    return {
        "n": state.n, "coarsest": state.coarsest, "combine": state.combine, "threshold": state.threshold,
        "propagator": state.propagator.name, "factors": list(state.factors), "iterations": state.iterations,
        "injectors": list(map(repr, state.injectors)), "occluders": list(map(repr, state.occluders)),
    }  # fmt: skip


def state_npz(state: State) -> bytes:
    """Every array by name: source_0 ... for each level, likewise target, sum, index and geometry; injected; merged, if
    there is one; and `settings` as JSON text."""
    octrees = {**state.octrees(), "index": state.index, "geometry": state.geometry}
    arrays = {f"{name}_{i}": level for name, levels in octrees.items() for i, level in enumerate(levels)}
    arrays["injected"] = state.injected
    if state.merged is not None:
        arrays["merged"] = state.merged
    arrays["settings"] = np.array(json.dumps(settings(state)))
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **arrays)  # type: ignore[arg-type]  # NumPy's stubs: its other option
    return buffer.getvalue()


def errors_csv(rows: Sequence[dict[str, float]]) -> bytes:
    """A line for each row of `Simulation.state.measures`, all digits; a column that a row lacks is empty there."""
    columns = list(dict.fromkeys(name for row in rows for name in row))
    buffer = io.StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns or ["iteration"])
    writer.writerows([format(row[name], ".17g") if name in row else "" for name in columns] for row in rows)
    return buffer.getvalue().encode()


def png(figure: Figure) -> bytes:
    """The figure as a PNG."""
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DOTS_PER_INCH)
    return buffer.getvalue()
