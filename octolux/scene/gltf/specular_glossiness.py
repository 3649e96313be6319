"""Specular-glossiness materials (KHR_materials_pbrSpecularGlossiness) made metallic and rough, factors and textures.

As in the appendix "Converting between workflows" of the extension's specification: metallic solves
specular = lerp(0.04, base, metallic) and diffuse * (1 - max specular) = base * (1 - 0.04) * (1 - metallic)
for brightness, and base is then taken from diffuse and specular in proportion.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from PIL import Image as Pillow

from ...simulator.tonemap import srgb_decode, srgb_encode
from ..images.cache import content_key
from ..images.lazy import LazyImage
from ..materials import Image

_DIELECTRIC = 0.04
_LUMA = np.array([0.299, 0.587, 0.114])  # of the appendix's perceived brightness
_LINEAR = srgb_decode(np.arange(256) / 255.0).astype(np.float32)
_ROWS_OF = 1 << 18  # texels converted at once, so that intermediate arrays stay at a few MB


def base_and_metallic(diffuse: np.ndarray, specular: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Base colour (..., 3) and metallic (...) of linear diffuse and specular colours (..., 3); all in [0, 1]."""
    specular = np.minimum(specular, 1.0)
    reflected = diffuse * (1.0 - specular.max(axis=-1, keepdims=True))
    metallic = _metallic(_brightness(reflected), _brightness(specular))
    part = metallic[..., None]
    from_diffuse = reflected / ((1.0 - _DIELECTRIC) * np.maximum(1.0 - part, 1e-6))
    from_specular = (specular - _DIELECTRIC * (1.0 - part)) / np.maximum(part, 1e-6)
    base = from_diffuse + (from_specular - from_diffuse) * part**2
    return np.clip(base, 0.0, 1.0), metallic


def _metallic(reflected: np.ndarray, specular: np.ndarray) -> np.ndarray:
    half = (reflected / (1.0 - _DIELECTRIC) + specular - 2.0 * _DIELECTRIC) / (2.0 * _DIELECTRIC)
    root = np.sqrt(np.maximum(half * half - (_DIELECTRIC - specular) / _DIELECTRIC, 0.0))
    return np.where(specular <= _DIELECTRIC, 0.0, np.clip(root - half, 0.0, 1.0))


def _brightness(color: np.ndarray) -> np.ndarray:
    return np.sqrt((color * color) @ _LUMA.astype(color.dtype))


def convert_images(
    diffuse: Image | None, specular_glossiness: Image, factors: tuple[float, ...]
) -> tuple[Image, Image]:
    """The base colour image (sRGB, with the diffuse alpha) and the metallic-roughness image of a material (roughness
    in G, metallic in B). The smaller image is resampled to the width and the height of the larger one.

    diffuse: sRGB, None is white.  specular_glossiness: specular sRGB in RGB, glossiness in A.
    factors: diffuse red, green, blue; specular red, green, blue; glossiness.
    """
    name = diffuse.name if diffuse else specular_glossiness.name
    sizes = [image.size for image in (diffuse, specular_glossiness) if image]
    size = max(width for width, _ in sizes), max(height for _, height in sizes)
    described = ("white" if diffuse is None else diffuse.key, specular_glossiness.key, repr(factors))
    both = cache(lambda: _converted(diffuse, specular_glossiness, factors, size))
    return (
        LazyImage(size, content_key("base", *described), lambda: both()[0], name),
        LazyImage(size, content_key("rough", *described), lambda: both()[1], specular_glossiness.name),
    )


def _converted(
    diffuse: Image | None, specular_glossiness: Image, factors: tuple[float, ...], size: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray]:
    width, height = size
    white = np.full((1, 1, 4), 255, np.uint8)
    upper = _resized(white if diffuse is None else diffuse.pixels, size)
    lower = _resized(specular_glossiness.pixels, size)
    base, rough = np.empty_like(upper), np.zeros_like(lower)
    base[..., 3], rough[..., 3] = upper[..., 3], 255
    tint, shine = np.array(factors[:3], np.float32), np.array(factors[3:6], np.float32)
    for start in range(0, height, step := max(1, _ROWS_OF // width)):
        rows = slice(start, start + step)
        color, metallic = base_and_metallic(_LINEAR[upper[rows, :, :3]] * tint, _LINEAR[lower[rows, :, :3]] * shine)
        base[rows, :, :3] = np.rint(srgb_encode(color) * 255.0)
        rough[rows, :, 2] = np.rint(metallic * 255.0)
        rough[rows, :, 1] = np.rint(255.0 - lower[rows, :, 3] * np.float32(factors[6]))
    return base, rough


def _resized(pixels: np.ndarray, size: tuple[int, int]) -> np.ndarray:
    """Each channel by itself: Pillow would weight colours with what it takes for alpha, and here may be glossiness."""
    if pixels.shape[1::-1] == size:
        return pixels
    channels = (Pillow.fromarray(np.ascontiguousarray(pixels[..., index])) for index in range(4))
    return np.dstack([np.asarray(channel.resize(size, Pillow.Resampling.BILINEAR)) for channel in channels])
