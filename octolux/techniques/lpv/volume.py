"""What every technique with a volume around the scene begins with: its grid, and the lights' VPLs to inject."""

from __future__ import annotations

from math import pi

import numpy as np

from ...frame.frame import Frame
from ...scene.lights import DirectionalLight
from ...simulator.grid import Grid
from .injection import VplSource


def scene_grid(frame: Frame, n: int) -> Grid:
    """The default volume of n^3 cells: the scene's bounding cube and a cell on each side."""
    low, high = frame.world_box
    if not np.any(high > low):  # an empty scene: any box will do
        high = low + 1.0
    return Grid.around(low, high, n)


def vpl_sources(frame: Frame, grid: Grid, injection: str) -> list[VplSource]:
    """The VPLs of each light. injection: "flux" keeps it, 1/pi; in the "thesis" the factor is 1. There a directional
    light's flux is I A w with the texel weight w = texel area over cell area (OLPV 3.2.2): ours holds I A times the
    texel's area, so 1 / cell area is left."""
    sources = []
    lights = zip(frame.vpl_ranges, frame.vpl_widths, frame.lights.total_flux, frame.lights.lights, strict=True)
    for (first, count), width, flux, light in lights:
        factor = 1.0 / pi
        if injection == "thesis":
            factor = 1.0 / grid.cell_size**2 if isinstance(light, DirectionalLight) else 1.0
        sources.append(VplSource(first, count, flux, factor, width))
    return sources
