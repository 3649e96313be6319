"""Traits of a surface: what light volumes ask of it besides its light, in one word a surfel.

albedo: diffuse, linear Rec. 709, 8 bits a channel, r lowest. The square root is stored, so that codes are dense where
albedos are dark: the error is at most ROOT_STEP (2 sqrt(albedo) + ROOT_STEP), 1/255 for white and 1/1000 for 0.06.
size: of the object, m: the longest edge of its instance's box in the world. Seven bits of its logarithm, 2^(1/8) off at
most. moving: its instance moves (gpu_scene/history.py). The highest bit.

shaders/traits.wgsl holds the same in WGSL, with the constants of TRAIT_VALUES.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from ..gpu.bindings import Binding, storage_words, texture
from ..gpu_scene.clusters import CLUSTER_TRIANGLES
from ..gpu_scene.packing import pack_colors
from ..gpu_scene.structs import INSTANCE, ITEM

if TYPE_CHECKING:
    from .frame import CameraSees, Frame

ROOT_STEP = 0.5 / 255
STEPS_PER_OCTAVE = 4
SMALLEST_SIZE = -16  # log2 of metres: from 15 micrometres to 55 km in 128 steps
TRAIT_VALUES: dict[str, Any] = {
    "steps_per_octave": float(STEPS_PER_OCTAVE), "smallest_size": float(SMALLEST_SIZE),
    "cluster_triangles": CLUSTER_TRIANGLES,
}  # fmt: skip
"""For the templates of shaders/traits.wgsl and shaders/pixel_traits.wgsl."""
PIXEL_STRUCTS = (ITEM, INSTANCE)


def pixel_bindings() -> list[Binding]:
    """What shaders/pixel_traits.wgsl needs, for a pass without the scene's own bind group: ids and G-buffer of the
    camera's picture as `id_map` and `surface_map`, and two tables of the scene. Structs: PIXEL_STRUCTS."""
    return [
        texture("id_map", "uint"), texture("surface_map", "uint"),
        storage_words("items", ITEM), storage_words("instances", INSTANCE),
    ]  # fmt: skip


def pixel_resources(frame: Frame, seen: CameraSees | None = None) -> dict[str, Any]:
    """What to bind there, of this frame, or of the layer `seen` of it."""
    tables, layer = frame.gpu_scene.resources, seen or frame.targets
    return {
        "id_map": layer.ids, "surface_map": layer.surface,
        "items": tables["items"], "instances": tables["instances"],
    }  # fmt: skip


def pack_traits(albedo, size, moving) -> np.ndarray:
    """uint32 (n,) from albedo (n, 3) in [0, 1], size (n,) in metres, and moving (n,), bool."""
    colors = pack_colors(np.concatenate([albedo, np.zeros((len(albedo), 1))], axis=1))
    with np.errstate(divide="ignore"):
        octaves = np.log2(np.asarray(size, dtype=np.float64)) - SMALLEST_SIZE
    codes = np.clip(np.floor(STEPS_PER_OCTAVE * octaves + 0.5), 0, 127).astype(np.uint32)
    return colors | codes << np.uint32(24) | np.asarray(moving).astype(np.uint32) << np.uint32(31)


def unpack_traits(words) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """albedo float64 (n, 3), size float64 (n,) in metres and moving bool (n,), from uint32 (n,)."""
    words = np.asarray(words, dtype=np.uint32)
    roots = (words[:, None] >> np.array([0, 8, 16], np.uint32) & 255) / 255.0
    octaves = (words >> np.uint32(24) & 127) / STEPS_PER_OCTAVE
    return roots**2, 2.0 ** (octaves + SMALLEST_SIZE), words >> np.uint32(31) == 1
