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
    u, v = np.meshgrid((np.arange(width) + 0.5) / width, (np.arange(height) + 0.5) / height)
    return directions_of(np.stack([u, v], axis=-1), rotation)


def directions_of(uv: np.ndarray, rotation: float) -> np.ndarray:
    """Unit directions float64 (..., 3) of (u, v) in [0, 1], (..., 2): the inverse of `coordinates`."""
    polar, azimuth = uv[..., 1] * pi, uv[..., 0] * 2.0 * pi - pi - rotation
    across = np.sin(polar)
    return np.stack([across * np.sin(azimuth), np.cos(polar), -across * np.cos(azimuth)], axis=-1)


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


def distant_lights(image: np.ndarray, count: int, rotation: float) -> tuple[np.ndarray, np.ndarray]:
    """The map as at most `count` distant lights: directions towards them, float64 (n, 3), and illuminance on a plane
    that faces each, lux, (n, 3).

    Points of a golden-ratio lattice are moved to where the map's light is, by inverting its distribution over rows and
    then along the row (Pharr, Jakob and Humphreys 2016, 14.2.4); each light stands for the texels nearest to it, at
    the centre of their light, so that what the lights bring in all is what the map brings. A black map gives none.

    Median cuts (Debevec 2005) run along rows and columns: lights of an even sky then stand in rows about the axes,
    as walls do, and of 32 none was seen from the middle of a courtyard a third of which is sky.
    """
    power = image.astype(np.float64) * texel_solid_angles(*image.shape[:2])[..., None]
    light = power @ LUMINANCE
    if not (count and light.sum() > 0):
        return np.zeros((0, 3)), np.zeros((0, 3))
    directions = texel_directions(image.shape[0], image.shape[1], rotation).reshape(-1, 3)
    points = directions_of(_warped_lattice(light, count), rotation)
    nearest = np.argmax(directions @ points.T, axis=1)
    centres = _sums(nearest, directions * light.reshape(-1, 1), count)
    length = np.linalg.norm(centres, axis=1)
    shines = length > 0
    return centres[shines] / length[shines, None], _sums(nearest, power.reshape(-1, 3), count)[shines]


def _warped_lattice(light: np.ndarray, count: int) -> np.ndarray:
    """float64 (count, 2): (u, v) in [0, 1] of the map, as densely as it shines: light is (height, width)."""
    along = (np.arange(count) + 0.5) / count
    around = (0.5 + np.arange(count) * (1.0 + 5.0**0.5) / 2.0) % 1.0
    v = _inverted(light.sum(axis=1), along)
    rows = np.minimum((v * len(light)).astype(int), len(light) - 1)
    u = np.array([_inverted(light[row], [turn])[0] for row, turn in zip(rows, around, strict=True)])
    return np.stack([u, v], axis=1)


def _inverted(density: np.ndarray, shares) -> np.ndarray:
    """Where in [0, 1] the given shares of a piecewise constant density lie before a point."""
    running = np.concatenate([[0.0], np.cumsum(density)])
    return np.interp(np.asarray(shares) * running[-1], running, np.linspace(0.0, 1.0, len(running)))


def _sums(owner: np.ndarray, values: np.ndarray, count: int) -> np.ndarray:
    """float64 (count, 3): sums of the rows of `values` (n, 3) of each owner."""
    return np.stack([np.bincount(owner, column, count) for column in values.T], axis=1)


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
