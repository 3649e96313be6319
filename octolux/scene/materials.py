"""Materials: metallic-roughness as in glTF 2.0, section 3.9, and the images they use. Plain data, no GPU."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

Wrap = Literal["repeat", "mirrored_repeat", "clamp_to_edge"]
AlphaMode = Literal["opaque", "mask", "blend"]
Color = tuple[float, float, float]
UvTransform = tuple[float, float, float, float, float, float]
IDENTITY_UV: UvTransform = (1.0, 0.0, 0.0, 0.0, 1.0, 0.0)


@dataclass(frozen=True, eq=False)
class Image:
    """Pixels as stored in a file: uint8 (height, width, 4), row 0 at the top. Whether they are sRGB or linear is
    decided by the material slot that uses them (glTF 2.0, section 3.9.2)."""

    pixels: np.ndarray
    name: str = ""

    def __post_init__(self) -> None:
        p = self.pixels
        if p.dtype != np.uint8 or p.ndim != 3 or p.shape[2] != 4 or 0 in p.shape:
            raise ValueError(f"image '{self.name}': expected uint8 (height, width, 4), got {p.dtype} {p.shape}")

    @property
    def size(self) -> tuple[int, int]:
        """Width and height, pixels."""
        height, width = self.pixels.shape[:2]
        return width, height

    @property
    def key(self) -> str:
        """Names the content for the cache of processed textures; "" for images that are not from a file."""
        return ""


@dataclass(frozen=True, eq=False)
class Texture:
    """An image and how its coordinates wrap outside [0, 1]; (u, v) = (0, 0) is the image's upper left corner (glTF).

    transform: rows (a, b, c), (d, e, f): the image is read at (a u + b v + c, d u + e v + f).
    """

    image: Image
    wrap: tuple[Wrap, Wrap] = ("repeat", "repeat")
    transform: UvTransform = IDENTITY_UV


@dataclass(frozen=True, eq=False, kw_only=True)
class Material:
    """A surface. Colours are linear Rec. 709; textures multiply the factor beside them.

    base_color: diffuse albedo of a dielectric, F0 of a metal; unitless, in [0, 1].
    specular: weight of the dielectric specular lobe; 1 = F0 of 0.04 as in glTF, 0 = pure Lambert.
    metallic_roughness_texture: roughness in G, metallic in B (glTF).
    normal_texture: tangent-space normals, green up (glTF); normal_scale multiplies x and y.
    emissive: emitted radiance in nits (cd/m^2), of the front face, and of the back too where it is double-sided.
    alpha_mode: "mask" cuts where alpha is below alpha_cutoff; "blend" lets a share of 1 - alpha of the light through.
    unlit: shown in its base colour whatever the light and the exposure; it reflects and emits no light.
    """

    name: str = ""
    base_color: Color = (1.0, 1.0, 1.0)
    alpha: float = 1.0
    base_color_texture: Texture | None = None
    metallic: float = 0.0
    roughness: float = 1.0
    metallic_roughness_texture: Texture | None = None
    specular: float = 1.0
    normal_texture: Texture | None = None
    normal_scale: float = 1.0
    emissive: Color = (0.0, 0.0, 0.0)
    emissive_texture: Texture | None = None
    alpha_mode: AlphaMode = "opaque"
    alpha_cutoff: float = 0.5
    double_sided: bool = False
    unlit: bool = False
