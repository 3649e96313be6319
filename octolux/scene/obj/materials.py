"""Materials of OBJ models: what an MTL entry means in the metallic-roughness model.

Decisions, for MTL says less than a renderer needs:

- `Kd` is linear. Where there is a `map_Kd` it replaces `Kd`: the specification multiplies them and three.js does so,
  but exporters write a default `Kd` (0.588 from 3ds Max, 0 from Maya) beside maps that hold the whole colour, and
  Blender, 3ds Max and Sketchfab therefore let the map replace it. The same holds for `map_Ke` and `Ke`.
- `Ks` is taken as reflectance at normal incidence: F0 = 0.04 * specular, so specular = min(1, max(Ks) / 0.04).
  Materials with mirror reflection (`illum` 3, 5, 8) and Ks above Kd are metals with F0 = Ks.
- `Ns`, a Blinn-Phong exponent, is alpha = sqrt(2 / (Ns + 2)) (Walter et al., "Microfacet Models for Refraction through
  Rough Surfaces", EGSR 2007, section 5.2, matches lobes so) and roughness = sqrt(alpha) (glTF 2.0, appendix B.2.1).
- `d` is opacity and wins over `Tr` = 1 - d. A `Tr` of 1 alone is read as opaque, as its writers mean it.
- `map_d` is a mask: its alpha channel when it has one, else its luminance, goes into the base colour's alpha.
- Coloured `bump` images are tangent-space normals, grey ones heights. Green points down in those that 3ds Max and
  CryEngine write, and is turned up; see `image_maps.with_green_up`.
- All surfaces are double sided.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from math import sqrt
from pathlib import Path

import numpy as np

from ..images.cache import content_key
from ..images.decode import ImageSource, load_images
from ..images.lazy import LazyImage
from ..materials import AlphaMode, Color, Image, Material, Texture
from .image_maps import is_normal_map, normals_from_height, with_alpha, with_green_up
from .mtl import MapLine, MtlEntry

DEFAULT = Material(name="default", base_color=(0.6, 0.6, 0.6), specular=0.0, double_sided=True)
_MIRRORS = (3, 5, 8)
_REFRACTIVE = (4, 6, 7, 9)


def find_file(folder: Path, written: str) -> Path:
    """The file that a model in `folder` names: backslashes and letter case as other systems treat them, and beside the
    model, or in `textures` there, when it was written on another computer.

    Returns the path as written when there is no such file.
    """
    path = folder / written.replace("\\", "/")
    if _exists(path):
        return path
    for guess in (path, folder / path.name, folder / "textures" / path.name):
        found = Path(guess.anchor)
        for part in guess.parts[1:] if guess.anchor else guess.parts:
            found = _child(found, part)
        if _exists(found):
            return found
    return path


def _exists(path: Path) -> bool:
    try:
        return path.exists()
    except (OSError, ValueError):  # longer than the file system allows, or with a zero byte in it
        return False


def _child(folder: Path, name: str) -> Path:
    if _exists(folder / name):
        return folder / name
    try:
        matches = sorted(entry for entry in folder.iterdir() if entry.name.lower() == name.lower())
    except OSError:  # no such folder, or one that may not be listed
        matches = []
    return matches[0] if matches else folder / name


def convert(entries: Iterable[tuple[MtlEntry, Path]], warnings: list[str]) -> list[Material]:
    """One material for each entry, whose files are looked up in the folder beside it. Images are decoded once each.

    What is guessed or left out is added to `warnings`. Raises SceneError for broken images.
    """
    entries = list(entries)
    files = {(folder, line.file) for entry, folder in entries for line in entry.maps.values()}
    paths = {key: find_file(*key) for key in sorted(files)}
    images = load_images({path: ImageSource(path, path.name, str(path)) for path in paths.values()}, warnings)
    made = _ImageMaker({key: images[path] for key, path in paths.items()})
    return [_material(entry, folder, made, warnings) for entry, folder in entries]


class _ImageMaker:
    """Combines decoded images, and hands out the same object when asked for the same combination again."""

    def __init__(self, images: dict[tuple[Path, str], Image]):
        self.images = images
        self.made: dict[tuple, Image] = {}

    def base_color(self, folder: Path, color: MapLine | None, mask: MapLine | None) -> Image | None:
        plain = self.images[folder, color.file] if color else None
        if mask is None:
            return plain
        key = (folder, color and color.file, mask.file)
        if key not in self.made:
            alpha = self.images[folder, mask.file]
            first = plain or alpha
            content = content_key("alpha", first.key, alpha.key, "masked" if plain else "white")
            self.made[key] = LazyImage(first.size, content, lambda: with_alpha(plain, alpha).pixels, first.name)
        return self.made[key]

    def normal(self, folder: Path, line: MapLine, green_up: bool) -> Image:
        """`green_up`: what an image of normals is taken to be when its content does not tell."""
        key = (folder, line.file, line.bump_multiplier, green_up)
        if key not in self.made:
            image = self.images[folder, line.file]
            content = content_key("normal", image.key, f"{line.bump_multiplier} {green_up}")
            make = partial(_normals, image, line.bump_multiplier, green_up)
            self.made[key] = LazyImage(image.size, content, make, image.name)
        return self.made[key]


def _normals(image: Image, multiplier: float, green_up: bool) -> np.ndarray:
    if is_normal_map(image):
        return with_green_up(image, green_up).pixels
    return normals_from_height(image, multiplier).pixels


def _material(entry: MtlEntry, folder: Path, made: _ImageMaker, warnings: list[str]) -> Material:
    maps = entry.maps
    mask = maps.get("map_d")
    base = _texture(made.base_color(folder, maps.get("map_kd"), mask), maps.get("map_kd") or mask)
    bump = maps.get("norm") or maps.get("bump")
    emissive_map = maps.get("map_ke")
    color, metallic, specular = _reflectance(entry)
    alpha = opacity(entry)
    mode: AlphaMode = "mask" if mask else "blend" if alpha < 1.0 else "opaque"
    if entry.numbers.get("illum") in _REFRACTIVE:
        warnings.append(f"material '{entry.name}' refracts light (illum {entry.numbers['illum']:g}); drawn without")
    return Material(
        name=entry.name,
        base_color=(1.0, 1.0, 1.0) if "map_kd" in maps else color,
        alpha=alpha,
        base_color_texture=base,
        metallic=metallic,
        roughness=roughness(entry.numbers.get("ns", 0.0)),
        specular=specular,
        normal_texture=_texture(made.normal(folder, bump, "norm" in maps), bump) if bump else None,
        emissive=(1.0, 1.0, 1.0) if emissive_map else entry.colors.get("ke", (0.0, 0.0, 0.0)),
        emissive_texture=_texture(made.images[folder, emissive_map.file], emissive_map) if emissive_map else None,
        alpha_mode=mode,
        double_sided=True,
    )


def _texture(image: Image | None, line: MapLine | None) -> Texture | None:
    if image is None:
        return None
    return Texture(image, ("clamp_to_edge", "clamp_to_edge") if line and line.clamp else ("repeat", "repeat"))


def _reflectance(entry: MtlEntry) -> tuple[Color, float, float]:
    """Base colour, metallic and specular from Kd, Ks and illum."""
    diffuse = entry.colors.get("kd", DEFAULT.base_color)
    mirror = entry.colors.get("ks", (0.0, 0.0, 0.0))
    red, green, blue = (min(value, 1.0) for value in mirror)
    if entry.numbers.get("illum") in _MIRRORS and sum(mirror) > sum(diffuse):
        return (red, green, blue), 1.0, 1.0
    return diffuse, 0.0, min(1.0, max(mirror) / 0.04)


def roughness(exponent: float) -> float:
    """glTF roughness of a Blinn-Phong exponent, both unitless: (2 / (Ns + 2))^(1/4)."""
    return sqrt(sqrt(2.0 / (max(exponent, 0.0) + 2.0)))


def opacity(entry: MtlEntry) -> float:
    """Opacity in [0, 1] from `d`, or else from `Tr`."""
    transparency = entry.numbers.get("tr", 0.0)
    guessed = 1.0 if transparency >= 1.0 else 1.0 - transparency
    return min(max(entry.numbers.get("d", guessed), 0.0), 1.0)
