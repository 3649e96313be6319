"""glTF materials, textures, samplers and images (glTF 2.0, sections 3.8 and 3.9).

Occlusion textures are not read: they stand for the light that octolux computes.
"""

from __future__ import annotations

from pathlib import Path
from typing import cast

from .gltf_accessors import Accessors
from .gltf_container import read_uri
from .gltf_extensions import UvUse, emissive, from_specular_glossiness, uv_use
from .gltf_json import Fields
from .images import ImageSource, load_images
from .materials import AlphaMode, Color, Image, Material, Texture, Wrap

_WRAPS: dict[int, Wrap] = {10497: "repeat", 33648: "mirrored_repeat", 33071: "clamp_to_edge"}
_ALPHA: dict[str, AlphaMode] = {"OPAQUE": "opaque", "MASK": "mask", "BLEND": "blend"}
DEFAULT = Material(name="default", metallic=1.0)  # section 5.19: every property at its default


class MaterialReader:
    """Reads the materials of one file; images that no material uses are not decoded."""

    def __init__(self, root: Fields, accessors: Accessors, warnings: list[str]):
        self.accessors, self.warnings = accessors, warnings
        self.textures = root.children("textures", "texture")
        self.samplers = root.children("samplers", "sampler")
        self.image_fields = root.children("images", "image")
        self.materials = root.children("materials", "material")
        self.images: dict[int, Image] = {}

    def read(self) -> tuple[list[Material], list[UvUse]]:
        """All materials, the default one behind them, and what each does with its coordinates. Raises SceneError."""
        slots = [slot for fields in self.materials for slot in _slots(fields).values()]
        used = {source for slot in slots if (source := self._source(slot)) is not None}
        sources = {number: self._image_source(self.image_fields[number]) for number in sorted(used)}
        self.images = load_images(sources, self.warnings)
        materials = [self._material(fields) for fields in self.materials]
        return [*materials, DEFAULT], [*(self._uv_use(fields) for fields in self.materials), UvUse()]

    def _source(self, slot: Fields) -> int | None:
        """The image of a texture slot; None, with a warning, when only an extension would give one."""
        index = slot.index("index", len(self.textures), "texture")
        if index is None:
            raise slot.error("'index' is missing")
        texture = self.textures[index]
        webp = texture.extension("EXT_texture_webp")
        count = len(self.image_fields)
        source = webp.index("source", count, "image") if webp else texture.index("source", count, "image")
        if source is None:
            line = f"{texture.place}: it names no image that octolux can read; left out"
            if line not in self.warnings:
                self.warnings.append(line)
        return source

    def _image_source(self, fields: Fields) -> ImageSource:
        view = fields.index("bufferView", len(self.accessors.views), "bufferView")
        data = read_uri(fields, fields.string("uri")) if view is None else self.accessors.view(view)
        name = fields.string("name", "") or (data.name if isinstance(data, Path) else fields.place)
        return ImageSource(data, name, str(fields.file), fields.place)

    def _material(self, fields: Fields) -> Material:
        slots = _slots(fields)
        color, alpha, metallic, roughness = self._surface(fields)
        normal = slots.get("normalTexture")
        mode = fields.string("alphaMode", "OPAQUE")
        if mode not in _ALPHA:
            raise fields.error(f"'alphaMode' is '{mode}', must be OPAQUE, MASK or BLEND")
        return Material(
            name=fields.string("name", "") or fields.place,
            base_color=color,
            alpha=alpha,
            base_color_texture=self._texture(slots.get("diffuseTexture") or slots.get("baseColorTexture")),
            metallic=metallic,
            roughness=roughness,
            metallic_roughness_texture=self._texture(slots.get("metallicRoughnessTexture")),
            normal_texture=self._texture(normal),
            normal_scale=normal.number("scale", 1.0) if normal else 1.0,
            emissive=emissive(fields),
            emissive_texture=self._texture(slots.get("emissiveTexture")),
            alpha_mode=_ALPHA[mode],
            alpha_cutoff=fields.number("alphaCutoff", 0.5, low=0.0),
            double_sided=fields.boolean("doubleSided", False),
        )

    def _surface(self, fields: Fields) -> tuple[Color, float, float, float]:
        """Base colour, alpha, metallic and roughness."""
        older = fields.extension("KHR_materials_pbrSpecularGlossiness")
        if older is not None:
            if "specularGlossinessTexture" in older:
                self.warnings.append(f"{older.place}: its specularGlossinessTexture is left out")
            color, metallic, roughness = from_specular_glossiness(older)
            return color, min(older.numbers("diffuseFactor", 4, (1.0,) * 4)[3], 1.0), metallic, roughness
        pbr = fields.child("pbrMetallicRoughness") or Fields(fields.file, fields.place, {})
        red, green, blue, alpha = pbr.numbers("baseColorFactor", 4, (1.0, 1.0, 1.0, 1.0), low=0.0)
        metallic = pbr.number("metallicFactor", 1.0, low=0.0, high=1.0)
        return (red, green, blue), min(alpha, 1.0), metallic, pbr.number("roughnessFactor", 1.0, low=0.0, high=1.0)

    def _texture(self, slot: Fields | None) -> Texture | None:
        source = self._source(slot) if slot else None
        if slot is None or source is None:
            return None
        texture = self.textures[slot.integer("index")]
        sampler = texture.index("sampler", len(self.samplers), "sampler")
        wrap = _wrap(self.samplers[sampler]) if sampler is not None else ("repeat", "repeat")
        return Texture(self.images[source], cast(tuple[Wrap, Wrap], wrap))

    def _uv_use(self, fields: Fields) -> UvUse:
        """A mesh here has one set of uvs: the one that the material's first texture asks for."""
        wanted = [uv_use(slot) for slot in _slots(fields).values()]
        if len(set(wanted)) > 1:
            line = "its textures use different coordinates; those of the first are taken for all"
            self.warnings.append(f"{fields.place}: {line}")
        return wanted[0] if wanted else UvUse()


def _slots(fields: Fields) -> dict[str, Fields]:
    """The texture slots that a material fills, by name, the base colour's first."""
    older = fields.extension("KHR_materials_pbrSpecularGlossiness")
    pbr = None if older else fields.child("pbrMetallicRoughness")
    owners = [(older, "diffuseTexture"), (pbr, "baseColorTexture"), (pbr, "metallicRoughnessTexture")]
    owners += [(fields, "normalTexture"), (fields, "emissiveTexture")]
    found = {key: owner.child(key) for owner, key in owners if owner is not None}
    return {key: slot for key, slot in found.items() if slot is not None}


def _wrap(sampler: Fields) -> tuple[Wrap, ...]:
    modes = [sampler.integer(key, 10497) for key in ("wrapS", "wrapT")]
    for mode in modes:
        if mode not in _WRAPS:
            raise sampler.error(f"wrap mode {mode} is none of {', '.join(map(str, _WRAPS))}")
    return tuple(_WRAPS[mode] for mode in modes)
