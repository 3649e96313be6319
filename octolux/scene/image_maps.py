"""Images made of other images: alpha from a mask, normals from heights; and how to tell normals from heights."""

from __future__ import annotations

import numpy as np
from PIL import Image as Pillow

from .materials import Image

_LUMINANCE = np.array([0.2126, 0.7152, 0.0722])  # Rec. 709


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
    return np.rint(mask.pixels[..., :3] @ _LUMINANCE).astype(np.uint8)


def is_normal_map(image: Image) -> bool:
    """Whether an image in a `bump` slot holds tangent-space normals: those are bluish, heights are grey.

    Black pixels are not counted: they fill the unused parts of atlases.
    """
    colors = image.pixels[..., :3].reshape(-1, 3)
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
    normals = image.pixels[..., :3].astype(np.float32) / 127.5 - 1.0
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
    h = height.pixels[..., :3].astype(np.float32) @ _LUMINANCE.astype(np.float32) / 255.0 * multiplier
    slope_right = (np.roll(h, -1, axis=1) - np.roll(h, 1, axis=1)) / 2.0
    slope_up = (np.roll(h, 1, axis=0) - np.roll(h, -1, axis=0)) / 2.0
    normals = np.dstack([-slope_right, -slope_up, np.ones_like(h)])
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    pixels = np.rint(normals * 127.5 + 127.5).astype(np.uint8)
    return Image(np.dstack([pixels, np.full(h.shape, 255, np.uint8)]), height.name)
