"""Materials on the device: one table, and the texture arrays it refers to."""

from __future__ import annotations

from collections.abc import Sequence
from math import log2
from typing import Any

import numpy as np

from ..gpu.device import Device
from ..scene.materials import IDENTITY_UV, Material, Texture
from .structs import MATERIAL
from .textures import TextureArrays

_SLOTS = (
    ("base_color_texture", True), ("metallic_roughness_texture", False),
    ("normal_texture", False), ("emissive_texture", True),
)  # fmt: skip
# Draw buckets: bit 0 alpha-masked or blended, bit 1 single-sided (its back faces are culled for the camera).
MASKED, SINGLE_SIDED = 1, 2
BUCKETS = 4
ALPHA_MODES = {"opaque": 0, "mask": 1, "blend": 2}


class MaterialTable:
    """`values` says what the materials make use of: shaders are made for these, and anew when they change.

    bucket: int64 (materials,), in which draw bucket what has the material is drawn.  glowing: bool (materials,),
    whether it emits light.
    """

    def __init__(self, device: Device):
        self.device = device
        self._materials: tuple[Material, ...] | None = None
        self._slots: tuple[tuple[str, bool], ...] = _SLOTS
        self._images: tuple[tuple[Any, bool], ...] | None = None
        self.buffer: Any = None
        self.textures: TextureArrays
        self.values: dict[str, Any] = {}
        self.bucket = np.zeros(0, np.int64)
        self.glowing = np.zeros(0, bool)

    def sync(self, materials: Sequence[Material], normal_maps: bool = True) -> bool:
        """Upload the table if a material was replaced, textures if other images are used; returns whether any was.
        Without `normal_maps` materials are as if they had none."""
        slots = tuple((slot, srgb) for slot, srgb in _SLOTS if normal_maps or slot != "normal_texture")
        if self._materials is not None and _same(self._materials, materials) and slots == self._slots:
            return False
        self._materials, self._slots = None, slots  # until all of these are on the device
        uses = [(t, srgb) for m in materials for slot, srgb in slots if (t := getattr(m, slot))]
        images = tuple((used.image, srgb) for used, srgb in uses)
        if self._images is None or not _same_images(self._images, images):
            self.textures, self._images = TextureArrays(self.device, uses), images
        self._write(materials)
        self.values = self._values(materials, [used for used, _ in uses])
        cut = np.array([m.alpha_mode != "opaque" for m in materials], dtype=np.int64)
        single = np.array([not m.double_sided for m in materials], dtype=np.int64)
        self.bucket = cut * MASKED + single * SINGLE_SIDED
        self.glowing = np.array([max(m.emissive) > 0 for m in materials], dtype=bool)
        self._materials = tuple(materials)
        return True

    def _write(self, materials: Sequence[Material]) -> None:
        table = MATERIAL.array(max(1, len(materials)))
        for row, material in zip(table, materials, strict=False):
            for name in ("base_color", "alpha", "emissive", "alpha_cutoff", "metallic", "roughness", "specular"):
                row[name] = getattr(material, name)
            row["normal_scale"], row["alpha_mode"] = material.normal_scale, ALPHA_MODES[material.alpha_mode]
            row["unlit"], row["double_sided"] = material.unlit, material.double_sided
            for slot, srgb in self._slots:
                texture = getattr(material, slot)
                row[slot] = self.textures.packed_reference(texture, srgb)
                row[f"{slot}_u"], row[f"{slot}_v"] = _transform_rows(texture)
        if self.buffer is None or self.buffer.size != table.nbytes:
            self.buffer = self.device.buffer("materials", table)
        else:
            self.device.write(self.buffer, table)

    def _values(self, materials: Sequence[Material], used: list[Texture]) -> dict[str, Any]:
        classes = self.textures.classes
        return {
            "srgb_edges": [edge for edge, srgb in classes if srgb],
            "linear_edges": [edge for edge, srgb in classes if not srgb],
            "log2_of": {edge: float(edge.bit_length() - 1) for edge, _ in classes},
            "slots": {slot for m in materials for slot, _ in self._slots if getattr(m, slot)},
            "wraps": any(t.wrap != ("repeat", "repeat") for t in used),
            "uv_transforms": any(t.transform != IDENTITY_UV for t in used),
            "emissive": any(max(m.emissive) > 0 or m.unlit for m in materials),
            "unlit": any(m.unlit for m in materials),
            "cut": any(m.alpha_mode != "opaque" for m in materials),
            "blended": any(m.alpha_mode == "blend" for m in materials),
        }


def _transform_rows(texture: Texture | None) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The rows of a texture's transform; behind the first, log2 of how much it stretches a pixel's footprint."""
    a, b, c, d, e, f = texture.transform if texture else IDENTITY_UV
    stretch = max(a * a + d * d, b * b + e * e)
    return (a, b, c, 0.5 * log2(max(stretch, 1e-30))), (d, e, f, 0.0)


def _same(a: Sequence[Any], b: Sequence[Any]) -> bool:
    return len(a) == len(b) and all(x is y for x, y in zip(a, b, strict=True))


def _same_images(a: tuple[tuple[Any, bool], ...], b: tuple[tuple[Any, bool], ...]) -> bool:
    return len(a) == len(b) and all(x is y and s == t for (x, s), (y, t) in zip(a, b, strict=True))
