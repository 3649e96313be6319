"""Names that the shared shaders' templates want: constants of the simulator, and what the scene's materials use."""

from __future__ import annotations

from math import pi
from typing import Any

import numpy as np

from ..gpu_scene.clusters import CLUSTER_TRIANGLES
from ..gpu_scene.gpu_scene import GpuScene
from ..simulator import brdf, environment, tonemap


def wgsl_matrix(matrix: np.ndarray) -> str:
    """A 3 x 3 matrix as a WGSL expression; WGSL lists columns."""
    return f"mat3x3f({', '.join(repr(float(v)) for v in matrix.T.ravel())})"


CONSTANTS: dict[str, Any] = {
    "pi": pi,
    "min_roughness": brdf.MIN_ROUGHNESS,
    "dielectric_f0": brdf.DIELECTRIC_F0,
    "f90_offset": tonemap.F90_OFFSET,
    "start_compression": tonemap.START_COMPRESSION,
    "desaturation": tonemap.DESATURATION,
    "agx_inset": wgsl_matrix(tonemap.AGX_INSET),
    "agx_outset": wgsl_matrix(tonemap.AGX_OUTSET),
    "agx_ev": tonemap.AGX_EV,
    "agx_curve": tonemap.AGX_CURVE,
    "agx_power": tonemap.AGX_POWER,
    "aces_input": wgsl_matrix(tonemap.ACES_INPUT),
    "aces_output": wgsl_matrix(tonemap.ACES_OUTPUT),
    "aces_numerator": tonemap.ACES_NUMERATOR,
    "aces_denominator": tonemap.ACES_DENOMINATOR,
    "brdf_table_size": len(environment.brdf_table()),
}


def surface_values(scene: GpuScene) -> dict[str, Any]:
    """For shaders/surface.wgsl and shaders/material.wgsl: only what the scene's materials have is compiled in."""
    return {"cluster_bits": CLUSTER_TRIANGLES.bit_length() - 1, **scene.values}
