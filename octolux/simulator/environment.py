"""Light from the surroundings: what an equirectangular map sends from where, as irradiance and as a few lights."""

from __future__ import annotations

from functools import lru_cache
from math import pi

import numpy as np

from octolux.scene.environment import Environment

from .brdf import alpha_of, smith_visibility

_BAND = 1 << 20  # texels made at once: in float64 the largest maps would take gigabytes
LUMINANCE = np.array([0.2126, 0.7152, 0.0722])
"""Of linear Rec. 709 (ITU-R BT.709-6, 3.2)."""


def texel_directions(height: int, width: int, rotation: float = 0.0) -> np.ndarray:
    """Unit directions float64 (height, width, 3) of the texels' centres; see `scene.environment.Environment`."""
    polar = ((np.arange(height) + 0.5) / height * pi)[:, None]
    azimuth = ((np.arange(width) + 0.5) / width * 2.0 * pi - pi - rotation)[None, :]
    across = np.sin(polar)
    return np.stack(
        [across * np.sin(azimuth), np.broadcast_to(np.cos(polar), (height, width)), -across * np.cos(azimuth)], axis=-1
    )


def texel_solid_angles(height: int, width: int) -> np.ndarray:
    """Solid angle of the texels of each row, sr: float64 (height, 1), exact."""
    edges = np.cos(np.arange(height + 1) / height * pi)
    return ((edges[:-1] - edges[1:]) * 2.0 * pi / width)[:, None]


def coordinates(directions: np.ndarray, rotation: float) -> np.ndarray:
    """(u, v) in [0, 1] of directions (..., 3) of any length: float64 (..., 2)."""
    d = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    u = 0.5 + (np.arctan2(d[..., 0], -d[..., 2]) + rotation) / (2.0 * pi)
    return np.stack([u - np.floor(u), np.arccos(np.clip(d[..., 1], -1.0, 1.0)) / pi], axis=-1)


def radiance(environment: Environment, directions: np.ndarray) -> np.ndarray:
    """Nits from `directions` (..., 3): float64 (..., 3), bilinear."""
    result = np.broadcast_to(np.asarray(environment.radiance, dtype=np.float64), directions.shape)
    return result if environment.image is None else result + sampled(environment, directions)


def sampled(environment: Environment, directions: np.ndarray) -> np.ndarray:
    """The image's part of `radiance`: u repeats, v is held at the poles."""
    image = environment.image
    assert image is not None
    height, width = image.shape[:2]
    uv = coordinates(np.asarray(directions, dtype=np.float64), environment.rotation)
    x, y = uv[..., 0] * width - 0.5, np.clip(uv[..., 1] * height - 0.5, 0.0, height - 1.0)
    left, top = np.floor(x).astype(int), np.floor(y).astype(int)
    fx, fy = (x - left)[..., None], (y - top)[..., None]
    below = np.minimum(top + 1, height - 1)
    upper = image[top, left % width] * (1 - fx) + image[top, (left + 1) % width] * fx
    lower = image[below, left % width] * (1 - fx) + image[below, (left + 1) % width] * fx
    return upper * (1 - fy) + lower * fy


def reduced(image: np.ndarray, most: int) -> np.ndarray:
    """The map halved, by means of 2 x 2 texels, until it is at most `most` wide; solid angles weigh the rows."""
    while image.shape[1] > most and image.shape[0] > 1:
        rows, columns = (edge // 2 for edge in image.shape[:2])
        weight = texel_solid_angles(*image.shape[:2])[: 2 * rows, :, None]
        upper, lower = weight[0::2], weight[1::2]
        half = np.empty((rows, columns, 3), np.float32)
        step = max(1, _BAND // columns)
        for band in (slice(top, top + step) for top in range(0, rows, step)):
            part = image[2 * band.start : 2 * min(band.stop, rows), : 2 * columns]
            mean = (part[0::2] * upper[band] + part[1::2] * lower[band]) / (2.0 * (upper[band] + lower[band]))
            half[band] = mean[:, 0::2] + mean[:, 1::2]
        image = half
    return image


def total_map(environment: Environment, most: int, least: tuple[int, int] = (32, 64)) -> np.ndarray:
    """The whole environment as a map, float32 (height, width, 3), at most `most` wide, not turned."""
    constant = np.asarray(environment.radiance, dtype=np.float32)
    if environment.image is None:
        return np.broadcast_to(constant, (*least, 3)).copy()
    return reduced(environment.image, most) + constant


def irradiance_map(image: np.ndarray, height: int, width: int) -> np.ndarray:
    """Irradiance (lux) on planes that face the directions of a `height` x `width` map, unshadowed: float32
    (height, width, 3); the integral of radiance * max(0, n.w), as a sum over all texels of `image`."""
    directions = texel_directions(*image.shape[:2]).reshape(-1, 3).astype(np.float32)
    power = (image * texel_solid_angles(*image.shape[:2])[..., None]).reshape(-1, 3).astype(np.float32)
    normals = texel_directions(height, width).reshape(-1, 3).astype(np.float32)
    return (np.maximum(normals @ directions.T, 0.0) @ power).reshape(height, width, 3)


def median_cut(image: np.ndarray, count: int, rotation: float) -> tuple[np.ndarray, np.ndarray]:
    """The map as `count` distant lights: directions towards them, float64 (n, 3), and illuminance on a plane that faces
    each, lux, (n, 3). Regions are cut where they halve their light (Debevec 2005, "A Median Cut Algorithm for Light
    Probe Sampling"); the next to be cut is always the one with most light, so that any number may be asked for.

    What the lights bring in all is what the map brings. A black map gives none.
    """
    power = image.astype(np.float64) * texel_solid_angles(*image.shape[:2])[..., None]
    light = power @ LUMINANCE
    if not light.sum() > 0:
        return np.zeros((0, 3)), np.zeros((0, 3))
    regions = [(0, image.shape[0], 0, image.shape[1])]
    while len(regions) < count:
        regions.sort(key=lambda r: -light[r[0] : r[1], r[2] : r[3]].sum())
        halves = next((h for r in regions if (h := _halved(light, r))), None)
        if halves is None:
            break
        regions.remove(halves[0])
        regions += halves[1:]
    directions = texel_directions(image.shape[0], image.shape[1], rotation)
    found = []
    for top, bottom, left, right in regions:
        weight = light[top:bottom, left:right, None]
        centre = (directions[top:bottom, left:right] * weight).sum(axis=(0, 1))
        length = np.linalg.norm(centre)
        if length > 0:
            found.append((centre / length, power[top:bottom, left:right].sum(axis=(0, 1))))
    return np.array([d for d, _ in found]), np.array([p for _, p in found])


def _halved(light: np.ndarray, region: tuple[int, int, int, int]) -> tuple | None:
    """The region and its two halves, cut across its longer side (on the sphere); None where it is one texel."""
    top, bottom, left, right = region
    inside = light[top:bottom, left:right]
    latitude = (top + bottom) / 2.0 / light.shape[0] * pi
    wide = (right - left) * 2.0 * np.sin(latitude) / light.shape[1] > (bottom - top) / light.shape[0]
    if (wide and right - left > 1) or bottom - top == 1:
        if right - left == 1:
            return None
        cut = left + _middle(inside.sum(axis=0))
        return region, (top, bottom, left, cut), (top, bottom, cut, right)
    cut = top + _middle(inside.sum(axis=1))
    return region, (top, cut, left, right), (cut, bottom, left, right)


def _middle(light: np.ndarray) -> int:
    """How many entries to take from the front so that they hold half of the light; one at least stays on each side."""
    running = np.cumsum(light)
    return int(np.clip(np.argmin(np.abs(running - 0.5 * running[-1])) + 1, 1, len(light) - 1))


@lru_cache(maxsize=1)
def brdf_table(size: int = 32) -> np.ndarray:
    """What the BRDF reflects of even light: float32 (size, size, 3), [roughness][n.v] at (i + 0.5) / size.

    The specular lobe's directional albedo is x F0 + y F90 (Karis 2013, "Real Shading in Unreal Engine 4", split sum);
    the diffuse lobe is left 1 - ((1 - z) F0 + z F90) of its albedo, since Fresnel is taken at the half vector.
    """
    steps = (np.arange(size) + 0.5) / size
    table = np.zeros((size, size, 3))
    for column, n_dot_v in enumerate(steps):
        view = np.array([np.sqrt(1.0 - n_dot_v * n_dot_v), 0.0, n_dot_v])
        table[:, column, 2] = _mean_grazing(view)
        for row, roughness in enumerate(steps):
            table[row, column, :2] = _lobe_albedo(view, alpha_of(roughness))
    return table.astype(np.float32)


def _stratified() -> tuple[np.ndarray, np.ndarray]:
    """Midpoints in [0, 1) and of angles in [0, pi): the other half circle is its mirror image."""
    steps = (np.arange(64) + 0.5) / 64
    return tuple(np.meshgrid(steps, steps * pi, indexing="ij"))  # type: ignore[return-value]


def _mean_grazing(view: np.ndarray) -> float:
    """Schlick's (1 - v.h)^5 averaged over light directions, weighted by their cosine."""
    square, around = _stratified()
    sine = np.sqrt(square)
    light = np.stack([sine * np.cos(around), sine * np.sin(around), np.sqrt(1.0 - square)], axis=-1)
    half = light + view
    v_dot_h = (half @ view) / np.linalg.norm(half, axis=-1)
    return float(((1.0 - v_dot_h) ** 5).mean())


def _lobe_albedo(view: np.ndarray, alpha) -> tuple[float, float]:
    """Factors of F0 and F90, over half vectors spaced in D (n.h): narrow lobes are met as well as wide ones. The cube
    crowds them where n.h falls to 0: spaced evenly, the midpoint rule lost up to 4 % of the light at grazing angles."""
    across, around = _stratified()
    rest, weight = (1.0 - across) ** 3, 3.0 * (1.0 - across) ** 2
    cosine = np.sqrt(rest / (1.0 + (alpha * alpha - 1.0) * (1.0 - rest)))
    sine = np.sqrt(1.0 - cosine * cosine)
    v_dot_h = sine * np.cos(around) * view[0] + cosine * view[2]
    n_dot_l = 2.0 * v_dot_h * cosine - view[2]
    lit = (n_dot_l > 0) & (v_dot_h > 0)
    # D V n.l dl / (D n.h dh), where dl = 4 v.h dh
    value = smith_visibility(np.maximum(n_dot_l, 0), view[2], alpha) * n_dot_l * 4.0 * v_dot_h / cosine
    value = np.where(lit, value * weight, 0.0)
    grazing = (1.0 - np.clip(v_dot_h, 0.0, 1.0)) ** 5
    return float((value * (1.0 - grazing)).mean()), float((value * grazing).mean())
