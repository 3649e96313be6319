"""Artefacts of OLPV 6.1 and 6.2 in light that is given: jumps from cell to cell, and light behind its source."""

from __future__ import annotations

from functools import cache
from math import pi

import numpy as np

from octolux.simulator import sh

from .given_octree import border_of_levels, irradiance_of_cells, lit_technique
from .registry import at_most, figure

N = 32
THESIS, STEPS, DEFAULT = "octree-lpv:thesis", "octree-lpv:steps", "octree-lpv"
OCTREES, UNIFORMS = (THESIS, STEPS, DEFAULT), ("uniform-lpv:thesis", "uniform-lpv")
VISIBLE = 1.0 / 255.0
"""Light below this share of the brightest is not seen beside it: the step of a display."""

ELEMENTS = ((5, 13, 18), (6, 14, 15), (3, 16, 20))
"""Cells of single lit elements, at different places in their parents."""


def _unblocked(text: str) -> str:
    """Nothing blocks, and every cell can be read."""
    return f"{text},occlusion=false,cells=all" if text.startswith("octree") else text


def wall() -> np.ndarray:
    """All cells of the plane x = 1 within the outermost sending along +x, as OLPV's wall injector (figure 9)."""
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[1 : N - 1, 1 : N - 1, 1] = sh.cosine_lobe([1.0, 0.0, 0.0]) / pi
    return light


def element(cell: tuple[int, int, int]) -> np.ndarray:
    """One cell (x, y, z) sending flux 1 along +x."""
    x, y, z = cell
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[z, y, x] = sh.cosine_lobe([1.0, 0.0, 0.0]) / pi
    return light


def excess_steps(light: np.ndarray, axis: int) -> np.ndarray:
    """By how much the step from each cell to the next along `axis` is out of line with those beside it, in stops:
    |s - (s' + s'') / 2| of the steps s of log2 light, s' and s'' those before and after. nan where one of the four
    cells is not positive.

    Light that falls off smoothly has hardly any: 0.034 with the inverse square from 3 cells away on; light that doubles
    at a border on top of that has one more. light: (n, n, n). Three less along the axis: the step from cell 1 to 2 is
    the first.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        step = np.diff(np.log2(np.where(light > 0.0, light, np.nan)), axis=axis)
    before, here, after = (np.take(step, range(i, step.shape[axis] - 2 + i), axis) for i in range(3))
    return np.abs(here - 0.5 * (before + after))


def _four(flags: np.ndarray, axis: int) -> np.ndarray:
    """Whether four cells in a line all have the flag: three less along the axis."""
    count = flags.shape[axis] - 3
    return np.all([np.take(flags, range(i, count + i), axis) for i in range(4)], axis=0)


def _clear_of(light: np.ndarray) -> np.ndarray:
    """Cells more than two away from all lit ones: nearer, light of a source of the size of a cell is not smooth."""
    lit = np.pad(light[..., 0, 0] > 0.0, 2)
    near = [lit[z : z + N, y : y + N, x : x + N] for z, y, x in np.ndindex(5, 5, 5)]
    return ~np.any(near, axis=0)


def spatial_jumps(text: str, light: np.ndarray) -> dict[str, float]:
    """Largest excess step on surfaces that face -x, in visible light clear of its source: `border` where the index
    volume changes level, if there is one, and `anywhere`."""
    technique = lit_technique(_unblocked(text), light)
    read = irradiance_of_cells(technique)[..., 1, 0]
    counted = _clear_of(light)
    counted &= read > VISIBLE * read[counted].max()
    found = {"anywhere": 0.0}
    if getattr(technique.settings, "merge", "") == "index":
        found["border"] = 0.0
    for axis in range(3):
        steps, whole = excess_steps(read, axis), _four(counted, axis)
        found["anywhere"] = max(found["anywhere"], steps[whole].max(initial=0.0))
        if "border" in found:
            border = np.take(border_of_levels(technique, axis), range(1, N - 2), axis)
            found["border"] = max(found["border"], steps[whole & border].max(initial=0.0))
    return found


@cache
def largest_jumps(text: str) -> dict[str, float]:
    """Of the wall, and of all single elements: {"wall": ..., "element": ...}; across a border where there are any."""
    key = "border" if text == THESIS else "anywhere"
    elements = [spatial_jumps(text, element(cell))[key] for cell in ELEMENTS]
    return {"wall": spatial_jumps(text, wall())[key], "element": max(elements)}


def back_share(text: str) -> float:
    """Share of the irradiance on the six faces of all cells that is in cells behind the plane of an element that sends
    forwards alone: 0 in truth (OLPV 6.2, figure 16)."""
    x, y, z = ELEMENTS[0]
    x += 8
    read = irradiance_of_cells(lit_technique(_unblocked(text), element((x, y, z)))).sum(axis=(-1, -2))
    return float(read[:, :, :x].sum() / read.sum())


@figure("olpv_spatial_jumps", group="olpv", unit="stops")
def olpv_spatial_jumps() -> dict[str, float]:
    """Largest step of light between neighbouring cells out of line with the steps beside it (OLPV 6.1): across a border
    of levels in the thesis preset, anywhere in the others."""
    return {f"{text}.{case}": jump for text in (*OCTREES, *UNIFORMS) for case, jump in largest_jumps(text).items()}


@figure("olpv_spatial_default_over_thesis", group="olpv", unit="x", bound=at_most(0.25))
def olpv_spatial_default_over_thesis() -> dict[str, float]:
    """The default's largest step over that across the thesis preset's borders."""
    thesis, default = largest_jumps(THESIS), largest_jumps(DEFAULT)
    return {case: default[case] / thesis[case] for case in thesis}


@figure("olpv_back_bleeding", group="olpv", unit="share", bound={DEFAULT: at_most(1e-6)})
def olpv_back_bleeding() -> dict[str, float]:
    """Share of light that is read behind an element that sends forwards alone (OLPV 6.2, figure 16).

    The default's lobes send nothing backwards, but for float32's rounding of what is not in them.
    """
    return {text: back_share(text) for text in (*OCTREES, *UNIFORMS)}
