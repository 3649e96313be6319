"""Images made of other images: alpha from a mask, normals from heights; and how to tell normals from heights."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from PIL import Image as Pillow

from ..materials import Image

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Rec. 709
# Pixels worked on at once, and looked at to tell what an image holds: a square of 2048. Without such a bound an image
# of the largest size would take gigabytes.
_BAND = 1 << 22


def with_alpha(base: Image | None, mask: Image) -> Image:
    """`base` (white when None) whose alpha is the mask's alpha, or its luminance when the mask is opaque everywhere.

    The mask is resampled to the size of `base`.
    """
    alpha = _mask_values(mask)
    if base is None:
        base = Image(np.full((*alpha.shape, 4), 255, np.uint8), mask.name)
    height, width = base.pixels.shape[:2]
    if alpha.shape != (height, width):
        resized = Pillow.fromarray(alpha).resize((width, height), Pillow.Resampling.BILINEAR)
        alpha = np.asarray(resized)
    return Image(np.dstack([base.pixels[..., :3], alpha]), base.name)


def _mask_values(mask: Image) -> np.ndarray:
    alpha = mask.pixels[..., 3]
    if alpha.min() < 255:
        return alpha
    luminance = np.empty(alpha.shape, np.uint8)
    for rows in _bands(mask):
        luminance[rows] = np.rint(mask.pixels[rows, :, :3] @ _LUMINANCE)
    return luminance


def _bands(image: Image) -> Iterator[slice]:
    """The rows of an image, in bands of about _BAND pixels."""
    width, height = image.size
    step = max(1, _BAND // width)
    return (slice(top, min(top + step, height)) for top in range(0, height, step))


def _sample(image: Image) -> np.ndarray:
    """Rows of an image in groups of neighbours, evenly spread, of about _BAND pixels: all rows where it has no more."""
    width, height = image.size
    if width * height <= _BAND:
        return image.pixels
    group = min(64, height)
    count = max(1, _BAND // (width * group))
    tops = np.linspace(0, height - group, count).astype(int)
    return np.concatenate([image.pixels[top : top + group] for top in tops])


def is_normal_map(image: Image) -> bool:
    """Whether an image in a `bump` slot holds tangent-space normals: those are bluish, heights are grey.

    Black pixels are not counted: they fill the unused parts of atlases.
    """
    colors = _sample(image)[..., :3].reshape(-1, 3)
    used = colors[colors.max(axis=1) > 16]
    if not len(used):
        return False
    red, green, blue = used.mean(axis=0)
    return bool(abs(red - 128) < 40 and abs(green - 128) < 40 and blue - max(red, green) > 30)


def with_green_up(image: Image, otherwise: bool) -> Image:
    """A map of normals as glTF wants it, its green turned over when it points down.

    Normals come from a height, whose slopes p to the right and q upwards have dp/dy = dq/dx; with green pointing down
    the two sides have opposite signs, which their correlation shows. `otherwise` says whether green points up where it
    shows nothing (within 0.1 of zero).
    """
    normals = _sample(image)[..., :3].astype(np.float32) / 127.5 - 1.0
    outwards = np.maximum(normals[..., 2], 0.1)
    p, q = normals[..., 0] / outwards, normals[..., 1] / outwards
    change_up = np.roll(p, 1, axis=0) - np.roll(p, -1, axis=0)
    change_right = np.roll(q, -1, axis=1) - np.roll(q, 1, axis=1)
    scale = float(np.sqrt((change_up**2).sum() * (change_right**2).sum()))
    correlation = float((change_up * change_right).sum()) / scale if scale > 0 else 0.0
    if correlation > 0.1 or (otherwise and correlation > -0.1):
        return image
    pixels = image.pixels.copy()
    pixels[..., 1] = 255 - pixels[..., 1]
    return Image(pixels, image.name)


def normals_from_height(height: Image, multiplier: float = 1.0) -> Image:
    """Tangent-space normals (green up) of a grey height map, by central differences that wrap around.

    The slope is multiplier * (difference of heights in [0, 1]) per pixel; MTL names no unit of height.
    """
    pixels = np.full(height.pixels.shape, 255, np.uint8)
    for rows in _bands(height):
        around = np.arange(rows.start - 1, rows.stop + 1) % len(pixels)
        pixels[rows, :, :3] = _normals_of(height.pixels[around, :, :3], multiplier)
    return Image(pixels, height.name)


def _normals_of(heights: np.ndarray, multiplier: float) -> np.ndarray:
    """uint8 (rows, width, 3) for uint8 (rows + 2, width, 3), which has a row more above and below."""
    h = heights.astype(np.float32) @ _LUMINANCE.astype(np.float32) / 255.0 * multiplier
    slope_right = (np.roll(h, -1, axis=1) - np.roll(h, 1, axis=1))[1:-1] / 2.0
    slope_up = (h[:-2] - h[2:]) / 2.0
    normals = np.dstack([-slope_right, -slope_up, np.ones_like(slope_up)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return np.rint(normals * 127.5 + 127.5).astype(np.uint8)
