"""Numbers the volumes' shaders are made with. All come from the simulator, which derives them."""

from __future__ import annotations

from collections.abc import Sequence
from math import pi, sqrt
from typing import Any

import numpy as np

from ...gpu.bindings import Binding, uniform
from ...gpu.layout import Struct
from ...simulator import sh
from ...simulator.grid import Grid
from ...simulator.lpv import formats, strips, transfer

GRID = Struct("Grid", origin="vec3f", cell_size="f32", n="u32")

SH_CONSTANTS: dict[str, Any] = {
    "sh_y0": sh.Y0,
    "sh_y1": sh.Y1,
    "sh_cosine_lobe_0": sh.COSINE_LOBE_0,
    "sh_cosine_lobe_1": sh.COSINE_LOBE_1,
}

STRIP_VALUES: dict[str, Any] = {"strip_steps": strips.STEPS, "strip_bits": strips.BITS}
"""For gathering/planes.wgsl, which reads the words of strips.pack_planes, and pack_strips.wgsl, which makes them."""

# The rest of a dominant lobe is isotropic; of the lobe a face gets the share max(0, d.m) / sum of max(0, d.m).
_FAR, _SIDE = transfer.MOMENTS[0, 0], transfer.MOMENTS[0, 1]  # travelling along +x: far face +x, side face +y
MOMENT_FAR, MOMENT_SIDE_TRAVEL, MOMENT_SIDE_NORMAL = float(_FAR[0]), float(_SIDE[0]), float(_SIDE[1])


def storage_scale(peak: float) -> float:
    """What W/sr are multiplied by for storage, from the largest injected band-0 coefficient (storage_scale.wgsl)."""
    return float(2.0 ** np.clip(3 - np.floor(np.log2(peak)), -126, 126)) if peak > 0 else 1.0


def grids_binding(count: int) -> Binding:
    """Nested grids, the finest first; one alone is an array as well."""
    return uniform("grids", f"array<Grid, {count}>")


def pack_grids(grids: Sequence[Grid]) -> Any:
    return np.concatenate([pack_grid(grid).view(np.uint8) for grid in grids]).view(GRID.dtype)


def pack_grid(grid: Grid) -> Any:
    return GRID.pack(origin=grid.origin, cell_size=grid.cell_size, n=grid.n)


def flux_weights(evaluation: str) -> dict[str, Any]:
    """How the flux through a face follows from a cell's four numbers e (constant part, vector part), travelling
    along d towards a far face, or a side face with normal s:

        far  = outside_far * e0 + clamp(far0 * e0 + far_d * e.d)
        side = outside_side * e0 + clamp(side0 * e0 + side_d * e.d + side_s * e.s)

    "signed" and "clamped": e are the SH coefficients, all inside. "dominant_lobe": e0 is the isotropic part's flux per
    steradian and e the lobe's flux over its normaliser (propagation.wgsl, `to_emission`).
    """
    far, side = transfer.SOLID_ANGLE_FAR, transfer.SOLID_ANGLE_SIDE
    if evaluation == "dominant_lobe":
        return {
            "outside_far": far, "outside_side": side, "far0": 0.0, "side0": 0.0, "far_d": MOMENT_FAR,
            "side_d": MOMENT_SIDE_TRAVEL, "side_s": MOMENT_SIDE_NORMAL, "clamped": True,
        }  # fmt: skip
    to_side = transfer.CENTRE_DIRECTIONS[0, 1]  # (2, 1, 0) / sqrt(5)
    return {
        "outside_far": 0.0, "outside_side": 0.0, "far0": far * sh.Y0, "side0": side * sh.Y0, "far_d": far * sh.Y1,
        "side_d": side * sh.Y1 * float(to_side[0]), "side_s": side * sh.Y1 * float(to_side[1]),
        "clamped": evaluation == "clamped",
    }  # fmt: skip


def lobe_weights(reprojection: str) -> dict[str, float]:
    """Direction of the lobe that flux through a side face becomes: side_along * d + side_across * s."""
    if reprojection == "face":
        return {"side_along": 0.0, "side_across": 1.0}
    return {"side_along": 2.0 / sqrt(5.0), "side_across": 1.0 / sqrt(5.0)}


def propagation_values(evaluation: str, reprojection: str, gain: float) -> dict[str, Any]:
    """All of propagation.wgsl's numbers. A lobe of flux 1 has the coefficients cosine_lobe / pi."""
    return {
        "evaluation": evaluation, **flux_weights(evaluation), **lobe_weights(reprojection), **SH_CONSTANTS,
        "lobe0": gain * sh.COSINE_LOBE_0 / pi, "lobe1": gain * sh.COSINE_LOBE_1 / pi,
        "moment_far": MOMENT_FAR, "moment_side_d": MOMENT_SIDE_TRAVEL, "moment_side_s": MOMENT_SIDE_NORMAL,
        "solid_angle": 4.0 * pi, **formats.BYTE_CELLS,
    }  # fmt: skip
