"""Figure 5 of Kaplanyan & Dachsbacher 2010, drawn anew: the polar curve of every cell's intensity, scheme by scheme."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from octolux.scene.errors import OctoluxError

from .comparison import ANGLES, Solution, compare, settings
from .lights import Setting

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = {"DOM8": "#2a9134", "DOM4": "#2b59c3", "LPV": "#d1242f"}
"""As in the paper; the analytic solution is grey."""
_MOST_BANDS, _LEAST_SIZE, _MOST_SIZE = 256, 4, 64
_REACH = 0.48  # of a cell: the longest radius of a curve


def flatland_figure(
    bands: Sequence[int] = (2, 4, 16), size: tuple[int, int] = (12, 9), iterations: int | None = None,
) -> tuple[Figure, list[dict[str, Any]]]:  # fmt: skip
    """The figure, one row for each setting and one column for each number of bands, and the errors of all schemes.

    The radius is the square root of the intensity, so the area of a curve is the flux through the cell. Each cell has
    its own scale. Three cells of each panel in which LPV keeps the direction that DOM4 loses most have a yellow ground.
    Raises OctoluxError for numbers out of range.
    """
    from matplotlib.figure import Figure

    _check(bands, size, iterations)
    solutions = compare(bands, size, iterations)
    rows = settings(size)
    figure = Figure(figsize=(5.0 * len(bands), 5.0 * size[1] / size[0] * len(rows) + 1.0), layout="constrained")
    axes = figure.subplots(len(rows), len(bands), squeeze=False)
    for row, setting in zip(axes, rows, strict=True):
        for panel, count in zip(row, bands, strict=True):
            found = [s for s in solutions if s.setting == setting and getattr(s.basis, "bands", None) == count]
            _panel(panel, setting, {s.scheme.name: s for s in found if s.scheme.name in COLOURS})
            panel.set_title(f"{setting.name}, {found[0].basis.label}", fontsize=11)
    handles = [axes[0, 0].fill([], [], color="0.75", label="analytic")[0]]
    handles += [axes[0, 0].plot([], [], color=colour, label=name)[0] for name, colour in COLOURS.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=4, frameon=False)
    return figure, [solution.errors() for solution in solutions]


def _check(bands: Sequence[int], size: tuple[int, int], iterations: int | None) -> None:
    if not bands or not all(1 <= b <= _MOST_BANDS for b in bands) or len(set(bands)) != len(bands):
        raise OctoluxError(f"flatland: bands are different numbers from 1 to {_MOST_BANDS}, not {list(bands)}.")
    if not all(_LEAST_SIZE <= s <= _MOST_SIZE for s in size):
        raise OctoluxError(
            f"flatland: a grid has {_LEAST_SIZE} to {_MOST_SIZE} cells on a side, not {size[0]} x {size[1]}."
        )
    if iterations is not None and iterations < 0:
        raise OctoluxError(f"flatland: the number of iterations is 0 or more, not {iterations}.")


def _panel(axes: Axes, setting: Setting, solutions: dict[str, Solution]) -> None:
    """Grid, lights, and the curves of every cell of one setting and basis."""
    truth = setting.intensity(ANGLES)
    for x, y in _highlights(setting, truth, solutions):
        axes.fill([x, x + 1, x + 1, x], [y, y, y + 1, y + 1], color="#fff3b0", zorder=0)
    everything = np.stack([truth, *(s.intensity for s in solutions.values())])
    largest = np.sqrt(np.maximum(0.0, everything).max(axis=(0, -1)))
    scale = _REACH / np.where(largest > 0.0, largest, 1.0)[..., None]
    for x, y in _polylines(setting, np.sqrt(truth) * scale):
        axes.fill(x, y, color="0.75", linewidth=0.0, zorder=1)
    for name, solution in solutions.items():
        # The curves of all cells are one line with gaps: so it is drawn many times sooner.
        radius = scale * np.sqrt(np.maximum(0.0, solution.intensity))
        curves = [np.vstack([curve.T, [np.nan, np.nan]]) for curve in _polylines(setting, radius)]
        axes.plot(*np.concatenate(curves).T, color=COLOURS[name], linewidth=0.8, zorder=2)
    for light in setting.lights:
        axes.plot(*light.ends().T, color="black", linewidth=2.5, zorder=3, solid_capstyle="butt")
    axes.set(xlim=(0, setting.width), ylim=(0, setting.height), aspect="equal")
    axes.set_xticks(range(setting.width + 1), labels=[])
    axes.set_yticks(range(setting.height + 1), labels=[])
    axes.grid(color="0.88", linewidth=0.6)
    axes.tick_params(length=0)


def _polylines(setting: Setting, radius: np.ndarray) -> list[np.ndarray]:
    """The closed curve (2, n) of every cell, around its centre."""
    turned = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=-1)
    points = setting.centres()[..., None, :] + radius[..., None] * turned
    closed = np.concatenate([points, points[..., :1, :]], axis=-2)
    return [curve.T for curve in closed.reshape(-1, closed.shape[-2], 2)]


def _highlights(setting: Setting, truth: np.ndarray, solutions: dict[str, Solution]) -> list[tuple[int, int]]:
    """The three lit cells (x, y) where DOM4's net flux is turned away most in excess of LPV's."""
    ways = np.exp(1j * ANGLES)
    net = (truth * ways).sum(axis=-1)

    def turned(name: str) -> np.ndarray:
        return np.abs(np.angle((solutions[name].intensity * ways).sum(axis=-1) * np.conj(net)))

    excess = np.where(setting.lit() | (np.abs(net) == 0.0), -np.inf, turned("DOM4") - turned("LPV"))
    order = np.argsort(excess, axis=None, kind="stable")[::-1][:3]
    return [(int(i % setting.width), int(i // setting.width)) for i in order if excess.flat[i] > 0.0]
