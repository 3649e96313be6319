"""Alpha-masked textures: a twig with leaves and a lattice of laths, drawn from a fixed seed."""

from __future__ import annotations

from math import pi

import numpy as np

from ..materials import Image, Texture
from .textures import color_texture


def twig(seed: int, color, *, size: int = 256, leaves: int = 11) -> Texture:
    """A twig that grows from the middle of the lower edge upwards, with pointed leaves; colour sRGB, alpha 0 or 255.

    color: mean linear albedo (3,) of the leaves.
    """
    rng = np.random.default_rng(seed)
    centre = (np.arange(size) + 0.5) / size
    x, y = np.meshgrid(centre - 0.5, 1.0 - centre)
    albedo = np.broadcast_to(np.asarray(color), (size, size, 3)).copy()
    stem = (np.abs(x - 0.03 * np.sin(5.0 * y)) < 0.012) & (y < 0.8)
    covered = stem.copy()
    albedo[stem] = (0.16, 0.11, 0.06)
    for number in range(leaves):
        share = number / (leaves - 1)
        side = 0.0 if number == leaves - 1 else (-1.0) ** number
        angle = side * rng.uniform(0.7, 1.15) * (1.0 - 0.35 * share)
        foot = (0.03 * np.sin(4.0 * share), 0.06 + 0.64 * share)
        along, across = _leaf_axes(x - foot[0], y - foot[1], angle)
        length = rng.uniform(0.27, 0.35)
        half = 0.26 * length * np.sin(pi * np.clip(along / length, 0.0, 1.0) ** 0.8)
        leaf = (along > 0.0) & (along < length) & (np.abs(across) < half)
        vein = np.clip(np.abs(across) / 0.006, 0.55, 1.0)
        tone = rng.uniform(0.8, 1.2) * (0.85 + 0.3 * along / length) * vein
        albedo[leaf] = (np.asarray(color) * tone[..., None])[leaf]
        covered |= leaf
    return _masked(albedo, covered, "twig")


def lattice(seed: int, color, *, size: int = 256, lath: float = 0.3) -> Texture:
    """Crossed diagonal laths, one mesh of the lattice for each repeat; `lath` is the width of a lath as a share of the
    distance between two. color: linear albedo (3,)."""
    rng = np.random.default_rng(seed)
    centre = (np.arange(size) + 0.5) / size
    column, row = np.meshgrid(centre, centre)
    over, under = (np.abs((column + sign * row) % 1.0 - 0.5) < lath / 2.0 for sign in (1.0, -1.0))
    tone = np.where(over, 1.0, 0.82) * (1.0 + 0.05 * rng.standard_normal((size, size)))
    return _masked(np.asarray(color) * tone[..., None], over | under, "lattice")


def _leaf_axes(x: np.ndarray, y: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates along and across a leaf that leans by `angle` (radians) from upwards to the right."""
    return x * np.sin(angle) + y * np.cos(angle), x * np.cos(angle) - y * np.sin(angle)


def _masked(albedo: np.ndarray, covered: np.ndarray, name: str) -> Texture:
    pixels = color_texture(albedo, name).image.pixels.copy()
    pixels[..., 3] = np.where(covered, 255, 0)
    return Texture(Image(pixels, name))
