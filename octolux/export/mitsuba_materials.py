"""Materials as BSDFs and textures of Mitsuba 3.

Lambert is `diffuse`, exactly; all else is `principled`, which is near (docs/export.md says how near). Both sides
reflect, as in octolux.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..scene.materials import Color, Image, Material, Texture
from ..simulator.tonemap import srgb_decode
from .files import FileFolder

Description = dict[str, Any]
WRAP_MODES = {"repeat": "repeat", "mirrored_repeat": "mirror", "clamp_to_edge": "clamp"}
EXACT = "octolux_gltf"
"""The name of a BSDF that takes `principled`'s parameters, reflects on both sides and is simulator/brdf.py's."""

VERTEX_COLORS: Description = {"type": "mesh_attribute", "name": "vertex_color"}


class MaterialWriter:
    """BSDFs and emitters of materials; their textures go into `files`, what cannot be said goes into `warnings`.

    exact: use the BSDF `octolux_gltf`, which Mitsuba does not have, in place of `principled`.
    """

    def __init__(self, files: FileFolder, warnings: list[str], exact: bool = False):
        self.files, self.warnings, self.exact = files, warnings, exact
        self._numbers: dict[int, tuple[int, Image]] = {}

    def bsdf(self, material: Material, vertex_colors: bool = False) -> Description:
        """The BSDF of a material; with `vertex_colors`, of meshes that have them, already times the base colour."""
        if material.unlit:
            self._warn(material, "unlit: Mitsuba has no such thing, it is left black")
            return {"type": "diffuse", "reflectance": rgb((0.0, 0.0, 0.0))}
        if vertex_colors and material.base_color_texture is not None:
            self._warn(material, "vertex colours of a textured material are left out")
            vertex_colors = False
        color = VERTEX_COLORS if vertex_colors else self._base_color(material)
        result = self._opaque(material, color)
        opacity = self._opacity(material)
        return result if opacity is None else {"type": "mask", "opacity": opacity, "bsdf": result}

    def _opaque(self, material: Material, color: Description) -> Description:
        lambert = material.specular == 0 and material.metallic == 0
        if lambert:
            result: Description = {"type": "diffuse", "reflectance": color}
        else:
            result = {
                "type": EXACT if self.exact else "principled", "base_color": color,
                "roughness": self._channel(material, "roughness", 1),
                "metallic": self._channel(material, "metallic", 2),
                "specular": 0.5 * material.specular,  # Disney's scale: 0.5 is an F0 of 0.04
            }  # fmt: skip
        if material.normal_texture is not None:
            result = {"type": "normalmap", "normalmap": self._normals(material), "bsdf": result}
        return result if self.exact and not lambert else {"type": "twosided", "bsdf": result}

    def emitter(self, material: Material) -> Description | None:
        """The emitter of a shape of this material, which shines to its front; None where it is dark."""
        if material.unlit or max(material.emissive) <= 0:
            return None
        texture = material.emissive_texture
        radiance = rgb(material.emissive) if texture is None else self._color_texture(texture, material.emissive)
        return {"type": "area", "radiance": radiance}

    def is_transparent(self, material: Material) -> bool:
        return not material.unlit and material.alpha_mode != "opaque"

    def _base_color(self, material: Material) -> Description:
        texture = material.base_color_texture
        return rgb(material.base_color) if texture is None else self._color_texture(texture, material.base_color)

    def _color_texture(self, texture: Texture, factor: Color) -> Description:
        """A texture of colours: as it is, or times a factor as linear numbers."""
        number = self._number(texture.image)
        if factor == (1.0, 1.0, 1.0):
            pixels = np.ascontiguousarray(texture.image.pixels[..., :3])
            file = self.files.png((number, "color"), f"image-{number}.png", pixels)
            return self._bitmap(texture, file, raw=False)
        name = f"image-{number}-times-" + "-".join(f"{c:.6g}" for c in factor) + ".exr"
        linear = srgb_decode(texture.image.pixels[..., :3] / 255.0) * np.asarray(factor)
        return self._bitmap(texture, self.files.exr((number, factor), name, linear.astype(np.float32)), raw=True)

    def _channel(self, material: Material, name: str, index: int) -> float | Description:
        """A factor, or one channel of the metallic-roughness texture times the factor."""
        texture, factor = material.metallic_roughness_texture, float(getattr(material, name))
        if texture is None or factor == 0.0:
            return factor
        number = self._number(texture.image)
        pixels = np.rint(texture.image.pixels[..., index] * factor).astype(np.uint8)
        key = (number, name, factor)
        return self._bitmap(texture, self.files.png(key, f"image-{number}-{name}-{factor:.6g}.png", pixels), raw=True)

    def _normals(self, material: Material) -> Description:
        texture, scale = material.normal_texture, material.normal_scale
        assert texture is not None
        number = self._number(texture.image)
        pixels = np.ascontiguousarray(texture.image.pixels[..., :3])
        if scale != 1.0:
            normals = pixels / 127.5 - 1.0
            normals[..., :2] *= scale
            normals /= np.maximum(np.linalg.norm(normals, axis=-1, keepdims=True), 1e-6)
            pixels = np.rint(normals * 127.5 + 127.5).astype(np.uint8)
        key = (number, "normal", scale)
        return self._bitmap(texture, self.files.png(key, f"image-{number}-normal-{scale:.6g}.png", pixels), raw=True)

    def _opacity(self, material: Material) -> float | Description | None:
        """What of the light is stopped: 0 or 1 where the material is cut out, its alpha where it is blended."""
        if not self.is_transparent(material):
            return None
        cut, texture = material.alpha_mode == "mask", material.base_color_texture
        alpha = np.asarray(255.0 if texture is None else texture.image.pixels[..., 3]) / 255.0 * material.alpha
        opacity = (alpha >= material.alpha_cutoff).astype(np.float64) if cut else alpha
        if texture is None:
            return float(opacity)
        number = self._number(texture.image)
        key = (number, material.alpha_mode, material.alpha, material.alpha_cutoff)
        name = f"image-{number}-{'-'.join(f'{k:.6g}' if isinstance(k, float) else str(k) for k in key[1:])}.png"
        bitmap = self._bitmap(texture, self.files.png(key, name, np.rint(opacity * 255.0).astype(np.uint8)), raw=True)
        return bitmap | {"filter_type": "nearest"} if cut else bitmap

    def _bitmap(self, texture: Texture, file: str, raw: bool) -> Description:
        if texture.wrap[0] != texture.wrap[1]:
            self._note(f"image '{texture.image.name}': it wraps as {texture.wrap[0]} in both directions")
        a, b, c, d, e, f = texture.transform
        to_uv = np.array([[a, b, 0.0, c], [d, e, 0.0, f], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
        moved = {} if np.array_equal(to_uv, np.eye(4)) else {"to_uv": to_uv}
        return {"type": "bitmap", "filename": file, "raw": raw, "wrap_mode": WRAP_MODES[texture.wrap[0]], **moved}

    def _number(self, image: Image) -> int:
        """Images are numbered as they are met; they are kept, since their addresses tell them apart."""
        return self._numbers.setdefault(id(image), (len(self._numbers), image))[0]

    def _warn(self, material: Material, what: str) -> None:
        self._note(f"material '{material.name}': {what}")

    def _note(self, line: str) -> None:
        if line not in self.warnings:
            self.warnings.append(line)


def rgb(values: Color) -> Description:
    red, green, blue = (float(v) for v in values)
    return {"type": "rgb", "value": (red, green, blue)}
