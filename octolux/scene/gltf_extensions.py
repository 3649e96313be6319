"""What three extensions say about materials: emissive strength, texture transform, specular-glossiness."""

from __future__ import annotations

from dataclasses import dataclass, field
from math import cos, sin, sqrt
from typing import cast

import numpy as np

from .gltf_json import Fields
from .materials import Color

_DIELECTRIC = 0.04


@dataclass(frozen=True)
class UvUse:
    """Which TEXCOORD set a texture uses, and how it transforms it: offset, rotation (radians), scale.

    normal_map: whether it stands for a material with a normal map, whose meshes need exact tangents.
    """

    texcoord: int = 0
    offset: tuple[float, ...] = (0.0, 0.0)
    rotation: float = 0.0
    scale: tuple[float, ...] = (1.0, 1.0)
    normal_map: bool = field(default=False, compare=False)

    def keeps_directions(self) -> bool:
        """Whether u and v run the same ways before and after, so that tangents stay what they are."""
        return self.rotation == 0.0 and min(self.scale) > 0.0

    def apply(self, uvs: np.ndarray) -> np.ndarray:
        """float32 (vertices, 2): scaled, then rotated, then moved (KHR_texture_transform).

        Counter-clockwise as one sees it, v pointing down, which is how three.js and Blender read the extension.
        """
        if self == UvUse(self.texcoord):
            return uvs
        c, s = cos(self.rotation), sin(self.rotation)
        turn = np.array([[c, s], [-s, c]])
        return ((uvs * self.scale) @ turn.T + self.offset).astype(np.float32)


def uv_use(slot: Fields) -> UvUse:
    """What a texture slot of a material says about its coordinates. Raises SceneError."""
    texcoord = slot.integer("texCoord", 0, high=63)
    transform = slot.extension("KHR_texture_transform")
    if transform is None:
        return UvUse(texcoord)
    return UvUse(
        transform.integer("texCoord", texcoord, high=63),
        transform.numbers("offset", 2, (0.0, 0.0)),
        transform.number("rotation", 0.0),
        transform.numbers("scale", 2, (1.0, 1.0)),
    )


def emissive(fields: Fields) -> Color:
    """Nits: emissiveFactor times the strength of KHR_materials_emissive_strength. Raises SceneError."""
    extension = fields.extension("KHR_materials_emissive_strength")
    strength = extension.number("emissiveStrength", 1.0, low=0.0) if extension else 1.0
    red, green, blue = fields.numbers("emissiveFactor", 3, (0.0, 0.0, 0.0), low=0.0)
    return red * strength, green * strength, blue * strength


def from_specular_glossiness(extension: Fields) -> tuple[Color, float, float]:
    """Base colour, metallic and roughness of KHR_materials_pbrSpecularGlossiness. Raises SceneError.

    As in the appendix "Converting between workflows" of the extension's specification: metallic solves
    specular = lerp(0.04, base, metallic) and diffuse * (1 - max specular) = base * (1 - 0.04) * (1 - metallic)
    for brightness, and base is then taken from diffuse and specular in proportion.
    """
    diffuse = np.array(extension.numbers("diffuseFactor", 4, (1.0, 1.0, 1.0, 1.0), low=0.0)[:3])
    specular = np.minimum(extension.numbers("specularFactor", 3, (1.0, 1.0, 1.0), low=0.0), 1.0)
    reflected = diffuse * (1.0 - specular.max())
    metallic = _metallic(_brightness(reflected), _brightness(specular))
    from_diffuse = reflected / ((1.0 - _DIELECTRIC) * max(1.0 - metallic, 1e-6))
    from_specular = (specular - _DIELECTRIC * (1.0 - metallic)) / max(metallic, 1e-6)
    base = from_diffuse + (from_specular - from_diffuse) * metallic**2
    color = cast(Color, tuple(float(value) for value in np.clip(base, 0.0, 1.0)))
    return color, metallic, 1.0 - extension.number("glossinessFactor", 1.0, low=0.0, high=1.0)


def _metallic(reflected: float, specular: float) -> float:
    if specular <= _DIELECTRIC:
        return 0.0
    half = (reflected / (1.0 - _DIELECTRIC) + specular - 2.0 * _DIELECTRIC) / (2.0 * _DIELECTRIC)
    root = sqrt(max(half * half - (_DIELECTRIC - specular) / _DIELECTRIC, 0.0))
    return min(max(root - half, 0.0), 1.0)


def _brightness(color: np.ndarray) -> float:
    return float(np.sqrt(np.dot((0.299, 0.587, 0.114), color * color)))
