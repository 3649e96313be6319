"""Names that the shared shaders' templates want: constants of the simulator, and what the scene's materials use."""

from __future__ import annotations

from math import pi
from typing import Any

from ..gpu_scene.clusters import CLUSTER_TRIANGLES
from ..gpu_scene.gpu_scene import GpuScene
from ..simulator import brdf, tonemap

CONSTANTS: dict[str, Any] = {
    "pi": pi,
    "min_roughness": brdf.MIN_ROUGHNESS,
    "dielectric_f0": brdf.DIELECTRIC_F0,
    "f90_offset": tonemap.F90_OFFSET,
    "start_compression": tonemap.START_COMPRESSION,
    "desaturation": tonemap.DESATURATION,
}


def surface_values(scene: GpuScene) -> dict[str, Any]:
    """For shaders/surface.wgsl and shaders/material.wgsl: only what the scene's materials have is compiled in."""
    classes = scene.textures.classes
    return {
        "cluster_bits": CLUSTER_TRIANGLES.bit_length() - 1,
        "srgb_edges": [edge for edge, srgb in classes if srgb],
        "log2_of": {edge: float(edge.bit_length() - 1) for edge, _ in classes},
        "linear_edges": [edge for edge, srgb in classes if not srgb],
        "slots": scene.used_slots,
        "wraps": scene.has_other_wraps,
        "emissive": scene.has_emission,
    }
