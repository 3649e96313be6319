"""What every technique with a volume around the scene begins with: its grid, and the lights' VPLs to inject."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...frame.frame import Frame
from ...frame.vpl_sources import VplSource, vpl_sources
from ...scene.lights import DirectionalLight
from ...simulator.grid import Grid


def scene_grid(frame: Frame, n: int) -> Grid:
    """The default volume of n^3 cells: the scene's bounding cube and a cell on each side."""
    low, high = frame.world_box
    if not np.any(high > low):  # an empty scene: any box will do
        high = low + 1.0
    return Grid.around(low, high, n)


def injected_sources(frame: Frame, grid: Grid, injection: str) -> list[VplSource]:
    """The VPLs of each light. injection: "flux" keeps it, 1/pi; in the "thesis" the factor is 1. There a directional
    light's flux is I A w with the texel weight w = texel area over cell area (OLPV 3.2.2): ours holds I A times the
    texel's area, so 1 / cell area is left."""
    sources = vpl_sources(frame)
    if injection == "flux":
        return sources
    factors = [1.0 / grid.cell_size**2 if isinstance(x, DirectionalLight) else 1.0 for x in frame.lights.lights]
    return [replace(source, intensity_per_flux=f) for source, f in zip(sources, factors, strict=True)]
