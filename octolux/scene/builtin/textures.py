"""Procedural, tileable textures: stone, floor, plaster and woven cloth, computed from a fixed seed."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..materials import Image, Texture


@dataclass(frozen=True, eq=False)
class Surface:
    """The two maps of a surface: its colour and the normals of its relief."""

    base_color: Texture
    normal: Texture


def masonry(seed: int, color, *, size: int = 512, courses: int = 4, blocks: int = 2) -> Surface:
    """Ashlar: `courses` rows of `blocks` stones in running bond with mortar between them.

    color: mean linear albedo (3,). One repeat is twice as wide as a stone when `blocks` is 2.
    """
    rng = np.random.default_rng(seed)
    row, column = _pixel_grid(size)
    course = np.floor(row * courses).astype(int)
    along = column * blocks + 0.5 * (course % 2)
    stone = course * blocks + np.floor(along).astype(int) % blocks
    joint = np.minimum(_to_joint(along) / blocks, _to_joint(row * courses) / courses)
    # 0 in the mortar, 1 on the stone, with worn, uneven edges.
    face = np.clip((joint - 0.0035 + 0.002 * _noise(rng, size, 2.0)) / 0.006, 0.0, 1.0)
    grain, stains = _noise(rng, size, 1.2), _noise(rng, size, 2.0)
    value = 1.0 + 0.13 * rng.standard_normal(courses * blocks)[stone] + 0.05 * grain + 0.08 * stains
    warmth = 0.05 * rng.standard_normal(courses * blocks)[stone]
    albedo = np.asarray(color) * np.stack([value + warmth, value, value - warmth], axis=2)
    albedo *= (0.62 + 0.38 * face)[..., None]
    relief = 0.25 * face + 0.012 * grain + 0.12 * stains
    return Surface(color_texture(albedo, "masonry"), normal_texture(relief, 4.0, "masonry normals"))


def tiles(seed: int, light, dark, *, size: int = 512, count: int = 4) -> Surface:
    """A chequered floor of `count` by `count` polished tiles, `count` even; `light` and `dark` are linear albedos."""
    rng = np.random.default_rng(seed)
    row, column = _pixel_grid(size)
    cell_row, cell_column = (np.floor(a * count).astype(int) for a in (row, column))
    joint = np.minimum(_to_joint(row * count), _to_joint(column * count)) / count
    face = np.clip((joint - 0.0015) / 0.003, 0.0, 1.0)
    chequer = ((cell_row + cell_column) % 2)[..., None]
    tone = 0.07 * rng.standard_normal((count, count))[cell_row, cell_column]
    veins = np.exp(-8.0 * np.abs(_noise(rng, size, 1.8)))
    albedo = np.where(chequer, light, dark) * (0.95 + tone + 0.04 * _noise(rng, size, 1.0) + 0.12 * veins)[..., None]
    albedo *= (0.5 + 0.5 * face)[..., None]
    relief = 0.25 * face + 0.03 * _noise(rng, size, 2.0)
    return Surface(color_texture(albedo, "tiles"), normal_texture(relief, 3.0, "tile normals"))


def plaster(seed: int, color, *, size: int = 256, strength: float = 3.0) -> Surface:
    """Rough-cast or dressed stone without joints: cloudy colour `color` (linear, 3) and a soft relief."""
    rng = np.random.default_rng(seed)
    clouds, grain = _noise(rng, size, 1.8), _noise(rng, size, 1.0)
    albedo = np.asarray(color) * (1.0 + 0.07 * clouds + 0.03 * grain)[..., None]
    relief = 0.2 * clouds + 0.02 * grain
    return Surface(color_texture(albedo, "plaster"), normal_texture(relief, strength, "plaster normals"))


def cloth(seed: int, color, trim, *, size: int = 256) -> Surface:
    """Woven cloth of linear colour `color` with a small lozenge pattern, and bands of `trim` at the lower end.

    Made for one repeat over the height of a curtain.
    """
    rng = np.random.default_rng(seed)
    row, column = _pixel_grid(size)
    lozenge = (np.abs(column * 4 % 1 - 0.5) + np.abs(row * 8 % 1 - 0.5)) < 0.16
    band = ((row > 0.90) & (row < 0.945)) | ((row > 0.96) & (row < 0.975))
    tone = (1.0 + 0.05 * _noise(rng, size, 1.2) + 0.35 * lozenge)[..., None]
    albedo = np.where(band[..., None], trim, np.asarray(color) * tone)
    weave = 0.5 * np.sin(np.pi * size / 4 * column) * np.sin(np.pi * size / 4 * row)
    return Surface(color_texture(albedo, "cloth"), normal_texture(0.03 * weave, 2.0, "cloth normals"))


def planks(seed: int, color, *, size: int = 512, rows: int = 8) -> Surface:
    """A wooden floor of `rows` boards that run along u, each ending somewhere; `color` is the mean linear albedo."""
    rng = np.random.default_rng(seed)
    row, column = _pixel_grid(size)
    board = np.floor(row * rows).astype(int)
    end = rng.random(rows)[board]
    joint = np.minimum(_to_joint(row * rows) / rows, _to_joint(column - end))
    face = np.clip((joint - 0.0008) / 0.002, 0.0, 1.0)
    # Grain: noise stretched sixteen times along the board, from another place in each.
    source = _noise(rng, size, 1.3)
    place = (np.arange(size) // 16 + (rng.random(rows)[board] * size).astype(int)) % size
    grain = source[np.arange(size)[:, None], place]
    value = 0.97 + 0.10 * rng.standard_normal(rows)[board] + 0.09 * grain
    albedo = np.asarray(color) * (value * (0.45 + 0.55 * face))[..., None]
    return Surface(color_texture(albedo, "planks"), normal_texture(0.15 * face + 0.01 * grain, 2.0, "plank normals"))


def carpet(seed: int, color, *, size: int = 256) -> Surface:
    """Loop-pile carpet tiles, one repeat a tile: flecked colour `color` (linear, 3), seams at the edges."""
    rng = np.random.default_rng(seed)
    row, column = _pixel_grid(size)
    fleck = rng.standard_normal((size, size))
    seam = np.clip(np.minimum(_to_joint(row), _to_joint(column)) / 0.006, 0.0, 1.0)
    value = (0.98 + 0.12 * fleck + 0.06 * _noise(rng, size, 1.5)) * (0.75 + 0.25 * seam)
    loops = np.abs(np.sin(np.pi * 64 * column) * np.sin(np.pi * 64 * row))
    albedo = np.asarray(color) * np.clip(value, 0.1, None)[..., None]
    return Surface(color_texture(albedo, "carpet"), normal_texture(0.06 * loops, 2.0, "carpet normals"))


def color_texture(albedo: np.ndarray, name: str) -> Texture:
    """A linear albedo (height, width, 3) as an opaque sRGB texture."""
    linear = np.clip(albedo, 0.0, 1.0)
    encoded = np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1.0 / 2.4) - 0.055)
    return _texture(encoded, name)


def normal_texture(height: np.ndarray, strength: float, name: str) -> Texture:
    """Tangent-space normals, green up, of a tileable height field (rows, columns), row 0 at the top.

    strength: heights are multiplied by it and then count in hundredths of a repeat.
    """
    scale = strength * 0.01 * height.shape[0] / 2.0
    to_right = (np.roll(height, -1, axis=1) - np.roll(height, 1, axis=1)) * scale
    downwards = (np.roll(height, -1, axis=0) - np.roll(height, 1, axis=0)) * scale
    normals = np.stack([-to_right, downwards, np.ones_like(height)], axis=2)
    normals /= np.linalg.norm(normals, axis=2, keepdims=True)
    return _texture(0.5 + 0.5 * normals, name)


def _texture(values: np.ndarray, name: str) -> Texture:
    pixels = np.full((*values.shape[:2], 4), 255, dtype=np.uint8)
    pixels[..., :3] = np.round(values * 255.0)
    return Texture(Image(pixels, name))


def _pixel_grid(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Row and column of every pixel centre in [0, 1)."""
    centre = (np.arange(size) + 0.5) / size
    row, column = np.meshgrid(centre, centre, indexing="ij")
    return row, column


def _to_joint(position: np.ndarray) -> np.ndarray:
    """Distance to the nearest whole number."""
    return np.abs(position - np.round(position))


def _noise(rng: np.random.Generator, size: int, slope: float) -> np.ndarray:
    """Tileable noise (size, size) with mean 0 and deviation 1 whose spectrum falls as frequency^-slope."""
    spectrum = np.fft.rfft2(rng.standard_normal((size, size)))
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)) * size
    frequency[0, 0] = np.inf
    noise = np.fft.irfft2(spectrum * frequency**-slope, s=(size, size))
    return noise / noise.std()
