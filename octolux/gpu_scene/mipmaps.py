"""Mip maps: box-filtered in linear light, on the CPU, and kept from one run to the next."""

from __future__ import annotations

import numpy as np
from PIL import Image as PillowImage

from ..scene.images import cache as image_cache
from ..scene.materials import Image
from ..simulator.tonemap import srgb_decode

SIZE_CLASSES = (256, 512, 1024, 2048)
_LUT_SIZE = 1 << 14  # fine enough that 8-bit sRGB codes survive: its steepest slope is 12.92 codes per linear code


def size_class(image: Image) -> int:
    """The edge length, a power of two, at which `image` is stored: the next above its longer side, 2048 at most."""
    longer = max(image.size)
    return next((size for size in SIZE_CLASSES if size >= longer), SIZE_CLASSES[-1])


_DECODE = srgb_decode(np.arange(256) / 255).astype(np.float32)
_THRESHOLDS = srgb_decode((np.arange(255) + 0.5) / 255)
_ENCODE = np.searchsorted(_THRESHOLDS, np.arange(_LUT_SIZE) / (_LUT_SIZE - 1)).astype(np.uint8)


def _decode(pixels: np.ndarray, srgb: bool) -> np.ndarray:
    linear = pixels.astype(np.float32) * np.float32(1 / 255)
    if srgb:
        linear[..., :3] = _DECODE[pixels[..., :3]]
    return linear


def _encode(linear: np.ndarray, srgb: bool) -> np.ndarray:
    encoded = (linear * 255 + 0.5).astype(np.uint8)
    if srgb:
        encoded[..., :3] = _ENCODE[(linear[..., :3] * (_LUT_SIZE - 1) + 0.5).astype(np.int32)]
    return encoded


def _resized(pixels: np.ndarray, size: int) -> np.ndarray:
    """Each channel alone: Pillow weights the colours of RGBA by alpha, and loses those of what is transparent."""
    channels = [PillowImage.fromarray(np.ascontiguousarray(pixels[..., i])) for i in range(4)]
    return np.stack([np.asarray(c.resize((size, size), PillowImage.Resampling.BICUBIC)) for c in channels], axis=-1)


def mip_chain(image: Image, size: int, srgb: bool) -> list[np.ndarray]:
    """The image as `size` x `size`, and each half down to 1 x 1: uint8 arrays (edge, edge, 4), not to be written to.

    Level 0 keeps the file's bytes when the size fits. Averages are taken in linear light where `srgb` says so. Chains
    of images from files are kept in the cache (`image_cache`).
    """
    if not image.key:
        return _made(image, size, srgb)
    name = f"{image.key}-{size}-{'srgb' if srgb else 'linear'}.mips"
    edges = [size >> level for level in range(size.bit_length())]
    kept = image_cache.read(name, sum(4 * edge * edge for edge in edges))
    if kept is None:
        levels = _made(image, size, srgb)
        image_cache.write(name, b"".join(level.tobytes() for level in levels))
        return levels
    ends = np.cumsum([4 * edge * edge for edge in edges])
    return [np.frombuffer(kept[end - 4 * edge * edge : end], np.uint8).reshape(edge, edge, 4)
            for edge, end in zip(edges, ends.tolist(), strict=True)]  # fmt: skip


def _made(image: Image, size: int, srgb: bool) -> list[np.ndarray]:
    pixels = image.pixels
    if pixels.shape[:2] != (size, size):
        pixels = _resized(pixels, size)
    levels, linear = [np.ascontiguousarray(pixels)], _decode(pixels, srgb)
    while size > 1:
        size //= 2
        # Two slices added twice is four times faster than a mean over reshaped axes.
        columns = linear[:, 0::2] + linear[:, 1::2]
        linear = (columns[0::2] + columns[1::2]) * np.float32(0.25)
        levels.append(_encode(linear, srgb))
    return levels
