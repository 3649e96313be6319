"""What extensions say about materials: emissive strength, texture transform, specular, specular-glossiness."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from math import cos, sin

import numpy as np

from ..geometry.triangles import LARGEST_UV, usable_uvs
from ..materials import IDENTITY_UV, Color, UvTransform
from .json import Fields
from .specular_glossiness import base_and_metallic


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

    def matrix(self) -> np.ndarray:
        """float64 (3, 3), acting on columns (u, v, 1): scales, then turns, then moves (KHR_texture_transform).

        Counter-clockwise as one sees it, v pointing down, which is how three.js and Blender read the extension.
        """
        c, s = cos(self.rotation), sin(self.rotation)
        linear = np.array([[c, s], [-s, c]]) * self.scale
        return np.vstack([np.column_stack([linear, self.offset]), (0.0, 0.0, 1.0)])

    def apply(self, uvs: np.ndarray) -> np.ndarray:
        """float32 (vertices, 2): the coordinates at which a texture is read."""
        if self == UvUse(self.texcoord):
            return usable_uvs(uvs)
        matrix = self.matrix()
        return usable_uvs((usable_uvs(uvs) @ matrix[:2, :2].T + matrix[:2, 2]).astype(np.float32))

    def after(self, baked: UvUse) -> UvTransform:
        """What is left to do where `baked`, which can be undone, has been applied."""
        if (self.offset, self.rotation, self.scale) == (baked.offset, baked.rotation, baked.scale):
            return IDENTITY_UV
        a, b, c, d, e, f = (self.matrix() @ np.linalg.inv(baked.matrix()))[:2].ravel().tolist()
        return a, b, c, d, e, f


def baked_use(uses: Mapping[str, UvUse]) -> UvUse:
    """The transform that the uvs of a material's meshes get, by what its texture slots use: that of the normal map,
    which tangents follow, or else of the first; none where it cannot be undone for the other slots."""
    normal_map = "normalTexture" in uses
    chosen = uses["normalTexture"] if normal_map else next(iter(uses.values()), UvUse())
    if not np.isfinite(np.linalg.cond(chosen.matrix())) or 0.0 in chosen.scale:
        chosen = UvUse(chosen.texcoord)
    return replace(chosen, normal_map=normal_map)


def uv_use(slot: Fields) -> UvUse:
    """What a texture slot of a material says about its coordinates. Raises SceneError."""
    texcoord = slot.integer("texCoord", 0, high=63)
    transform = slot.extension("KHR_texture_transform")
    if transform is None:
        return UvUse(texcoord)
    offset, scale = transform.numbers("offset", 2, (0.0, 0.0)), transform.numbers("scale", 2, (1.0, 1.0))
    if max(map(abs, (*offset, *scale))) > LARGEST_UV:
        raise transform.error(f"its 'offset' or 'scale' is beyond {LARGEST_UV:g}")
    return UvUse(transform.integer("texCoord", texcoord, high=63), offset, transform.number("rotation", 0.0), scale)


def emissive(fields: Fields) -> Color:
    """Nits: emissiveFactor times the strength of KHR_materials_emissive_strength. Raises SceneError."""
    extension = fields.extension("KHR_materials_emissive_strength")
    strength = extension.number("emissiveStrength", 1.0, low=0.0) if extension else 1.0
    red, green, blue = fields.numbers("emissiveFactor", 3, (0.0, 0.0, 0.0), low=0.0)
    return red * strength, green * strength, blue * strength


def specular(fields: Fields, warnings: list[str]) -> float:
    """Weight of the dielectric lobe: the specularFactor of KHR_materials_specular, which scales F0 and F90 alike.

    Its colour and textures are left out with a warning. So is KHR_materials_ior altogether: that changes F0 alone, and
    no weight of the whole lobe does the same at all angles. Raises SceneError.
    """
    extension = fields.extension("KHR_materials_specular")
    if extension is None:
        return 1.0
    for key in ("specularColorFactor", "specularTexture", "specularColorTexture"):
        if key in extension:
            warnings.append(f"{fields.place}: {key} of KHR_materials_specular is left out")
    return extension.number("specularFactor", 1.0, low=0.0, high=1.0)


def specular_glossiness_factors(extension: Fields) -> tuple[float, ...]:
    """Diffuse red, green, blue, specular red, green, blue, and glossiness, all in [0, 1]. Raises SceneError."""
    diffuse = extension.numbers("diffuseFactor", 4, (1.0, 1.0, 1.0, 1.0), low=0.0)[:3]
    colors = diffuse + extension.numbers("specularFactor", 3, (1.0, 1.0, 1.0), low=0.0)
    return *(min(value, 1.0) for value in colors), extension.number("glossinessFactor", 1.0, low=0.0, high=1.0)


def from_specular_glossiness(extension: Fields) -> tuple[Color, float, float]:
    """Base colour, metallic, roughness of KHR_materials_pbrSpecularGlossiness without textures. Raises SceneError."""
    factors = specular_glossiness_factors(extension)
    base, metallic = base_and_metallic(np.array(factors[:3]), np.array(factors[3:6]))
    red, green, blue = (float(value) for value in base)
    return (red, green, blue), float(metallic), 1.0 - factors[6]
