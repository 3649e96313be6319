"""glTF materials, textures, samplers and images (glTF 2.0, sections 3.8 and 3.9).

Occlusion textures are not read: they stand for the light that octolux computes.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import cast

from ..images.decode import ImageSource, load_images
from ..materials import AlphaMode, Color, Image, Material, Texture, UvTransform, Wrap
from .accessors import Accessors
from .basisu import NAME as BASIS
from .basisu import is_available, load_ktx2
from .container import read_uri
from .extensions import (
    UvUse,
    baked_use,
    emissive,
    from_specular_glossiness,
    specular,
    specular_glossiness_factors,
    uv_use,
)  # fmt: skip
from .json import Fields
from .specular_glossiness import convert_images

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
        self.chosen: dict[int, int | None] = {}  # the image of each texture
        self.converted: dict[tuple, tuple[Image, Image]] = {}
        self.basis: set[int] = set()  # which images are for KHR_texture_basisu

    def read(self) -> tuple[list[Material], list[UvUse]]:
        """All materials, the default one behind them, and what each does with its coordinates. Raises SceneError."""
        slots = [slot for fields in self.materials for slot in _slots(fields).values()]
        used = {number for slot in slots if (number := self._image(slot)) is not None}
        sources = {number: self._image_source(self.image_fields[number]) for number in sorted(used)}
        basis = {number: sources.pop(number) for number in sorted(self.basis & used)}
        self.images = load_images(sources, self.warnings) | load_images(basis, self.warnings, load_ktx2)
        materials = [self._material(fields) for fields in self.materials]
        return [*materials, DEFAULT], [*(baked_use(_uses(fields)) for fields in self.materials), UvUse()]

    def _image(self, slot: Fields) -> int | None:
        """The image of a texture slot; None, with a warning, when only an extension would give one."""
        index = slot.index("index", len(self.textures), "texture")
        if index is None:
            raise slot.error("'index' is missing")
        texture = self.textures[index]
        if index not in self.chosen:
            self.chosen[index] = self._choose(texture)
        return self.chosen[index]

    def _choose(self, texture: Fields) -> int | None:
        count = len(self.image_fields)
        plain = texture.index("source", count, "image")
        webp, basis = texture.extension("EXT_texture_webp"), texture.extension(BASIS)
        found = basis.index("source", count, "image") if basis else None
        if basis and found is not None:
            if is_available():
                self.basis.add(found)
                return found
            if plain is None:
                raise basis.error("it needs the package opengl-basisu", "pip install opengl-basisu")
            self.warnings.append(f"{texture.place}: {BASIS} needs the package opengl-basisu; its plain image is taken")
        source = webp.index("source", count, "image") if webp else plain
        if source is None:
            self.warnings.append(f"{texture.place}: it names no image that octolux can read; left out")
        return source

    def _image_source(self, fields: Fields) -> ImageSource:
        view = fields.index("bufferView", len(self.accessors.views), "bufferView")
        data = read_uri(fields, fields.string("uri")) if view is None else self.accessors.view(view)
        name = fields.string("name", "") or (data.name if isinstance(data, Path) else fields.place)
        return ImageSource(data, name, str(fields.file), fields.place)

    def _material(self, fields: Fields) -> Material:
        older = fields.extension("KHR_materials_pbrSpecularGlossiness")
        textures = self._textures(fields)
        slots = _slots(fields)
        surface = _older_surface(older, textures) if older else _surface(fields)
        color, alpha, metallic, roughness = surface
        if older and "specularGlossinessTexture" in textures:
            self._convert(older, textures)
        mode = fields.string("alphaMode", "OPAQUE")
        if mode not in _ALPHA:
            raise fields.error(f"'alphaMode' is '{mode}', must be OPAQUE, MASK or BLEND")
        return Material(
            name=fields.string("name", "") or fields.place,
            base_color=color,
            alpha=alpha,
            base_color_texture=textures.get("diffuseTexture") or textures.get("baseColorTexture"),
            metallic=metallic,
            roughness=roughness,
            metallic_roughness_texture=textures.get("metallicRoughnessTexture"),
            specular=specular(fields, self.warnings),
            normal_texture=textures.get("normalTexture"),
            normal_scale=slots["normalTexture"].number("scale", 1.0) if "normalTexture" in slots else 1.0,
            emissive=emissive(fields),
            emissive_texture=textures.get("emissiveTexture"),
            alpha_mode=_ALPHA[mode],
            alpha_cutoff=fields.number("alphaCutoff", 0.5, low=0.0),
            double_sided=fields.boolean("doubleSided", False),
            unlit=fields.extension("KHR_materials_unlit") is not None,
        )

    def _textures(self, fields: Fields) -> dict[str, Texture]:
        """The textures of a material by slot, each with what its coordinates differ from those of the meshes."""
        uses = _uses(fields)
        baked = baked_use(uses)
        sets = sorted({use.texcoord for use in uses.values()})
        if len(sets) > 1:
            listed = " and ".join(f"TEXCOORD_{number}" for number in sets)
            line = f"its textures use {listed}; TEXCOORD_{baked.texcoord} is taken for all"
            self.warnings.append(f"{fields.place}: {line}")
        found = {key: self._texture(slot, uses[key].after(baked)) for key, slot in _slots(fields).items()}
        return {key: texture for key, texture in found.items() if texture}

    def _texture(self, slot: Fields, transform: UvTransform) -> Texture | None:
        source = self._image(slot)
        if source is None:
            return None
        texture = self.textures[slot.integer("index")]
        sampler = texture.index("sampler", len(self.samplers), "sampler")
        wrap = _wrap(self.samplers[sampler]) if sampler is not None else ("repeat", "repeat")
        return Texture(self.images[source], cast(tuple[Wrap, Wrap], wrap), transform)

    def _convert(self, older: Fields, textures: dict[str, Texture]) -> None:
        """Put textures of base colour and of metal and roughness in the place of diffuse and specular-glossiness."""
        shine, diffuse = textures.pop("specularGlossinessTexture"), textures.get("diffuseTexture")
        if diffuse and diffuse.transform != shine.transform:
            self.warnings.append(
                f"{older.place}: its two textures have different transforms; the diffuse one's is taken"
            )
        place = diffuse or shine
        image, factors = diffuse.image if diffuse else None, specular_glossiness_factors(older)
        key = (image, shine.image, factors)
        if key not in self.converted:
            self.converted[key] = convert_images(image, shine.image, factors)
        base, rough = self.converted[key]
        textures["diffuseTexture"] = replace(place, image=base)
        textures["metallicRoughnessTexture"] = replace(place, image=rough)


def _surface(fields: Fields) -> tuple[Color, float, float, float]:
    """Base colour, alpha, metallic and roughness."""
    pbr = fields.child("pbrMetallicRoughness") or Fields(fields.file, fields.place, {})
    red, green, blue, alpha = pbr.numbers("baseColorFactor", 4, (1.0, 1.0, 1.0, 1.0), low=0.0)
    metallic = pbr.number("metallicFactor", 1.0, low=0.0, high=1.0)
    return (red, green, blue), min(alpha, 1.0), metallic, pbr.number("roughnessFactor", 1.0, low=0.0, high=1.0)


def _older_surface(older: Fields, textures: dict[str, Texture]) -> tuple[Color, float, float, float]:
    """The same of KHR_materials_pbrSpecularGlossiness; the factors are in the converted textures where there are."""
    alpha = min(older.numbers("diffuseFactor", 4, (1.0,) * 4, low=0.0)[3], 1.0)
    color, metallic, roughness = from_specular_glossiness(older)
    if "specularGlossinessTexture" in textures:
        return (1.0, 1.0, 1.0), alpha, 1.0, 1.0
    return color, alpha, metallic, roughness


def _uses(fields: Fields) -> dict[str, UvUse]:
    return {key: uv_use(slot) for key, slot in _slots(fields).items()}


def _slots(fields: Fields) -> dict[str, Fields]:
    """The texture slots that a material fills, by name, the base colour's first."""
    older = fields.extension("KHR_materials_pbrSpecularGlossiness")
    pbr = None if older else fields.child("pbrMetallicRoughness")
    owners = [
        (older, "diffuseTexture"),
        (older, "specularGlossinessTexture"),
        (pbr, "baseColorTexture"),
        (pbr, "metallicRoughnessTexture"),
    ]
    owners += [(fields, "normalTexture"), (fields, "emissiveTexture")]
    found = {key: owner.child(key) for owner, key in owners if owner is not None}
    return {key: slot for key, slot in found.items() if slot is not None}


def _wrap(sampler: Fields) -> tuple[Wrap, ...]:
    modes = [sampler.integer(key, 10497) for key in ("wrapS", "wrapT")]
    for mode in modes:
        if mode not in _WRAPS:
            raise sampler.error(f"wrap mode {mode} is none of {', '.join(map(str, _WRAPS))}")
    return tuple(_WRAPS[mode] for mode in modes)
