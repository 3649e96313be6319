"""Light of flat quadrilaterals by linearly transformed cosines (Heitz, Dupuy, Hill and Neubelt 2016).

The specular lobe D V n.l of the BRDF, divided by its integral, is taken for a clamped cosine lobe whose directions a
matrix M has moved; its integral over a polygon is then that of the cosine over the polygon moved back, Lambert's
formula. M depends on roughness and n.v and was fitted by scripts/ltc_table.py; the diffuse lobe needs none.

Unlike the paper: the polygon is cut at the surface's horizon first, and the lobe is divided by what of it lies above,
so that light all around gives the BRDF's directional albedo (`environment.brdf_table`) exactly. The table holds, for
M = R L with R the rotation from the mirrored direction towards the normal by psi, L = [[a, 0, 0], [0, c, 0],
[d, 0, 1]]: a / alpha, c / alpha, d n.v / alpha, sin psi. All four are smooth, also where alpha goes to 0.
"""

from __future__ import annotations

from functools import lru_cache
from math import pi
from pathlib import Path

import numpy as np

from octolux.scene.lights import AreaLight

from . import brdf
from .direct import area_light_irradiance, clip_at_horizon
from .environment import brdf_table
from .solid_angles import polygon_moment

TABLE = Path(__file__).with_name("ltc.npz")

LEAST_COSINE = 0.03
"""n.v below it counts as it: a lobe at the horizon itself is no density."""


@lru_cache(maxsize=1)
def table() -> np.ndarray:
    """The fitted parameters: float32 (size, size, 4), [roughness][sqrt(1 - n.v)], from 0 to 1 both."""
    with np.load(TABLE) as file:
        return file["parameters"]


def nodes(size: int) -> tuple[np.ndarray, np.ndarray]:
    """Roughness of the table's rows and n.v of its columns: float64 (size,) each."""
    steps = np.linspace(0.0, 1.0, size)
    return np.maximum(steps, brdf.MIN_ROUGHNESS), np.maximum(1.0 - steps**2, LEAST_COSINE)


def parameters(roughness, n_dot_v) -> np.ndarray:
    """The table's four numbers between its nodes, float64 (..., 4)."""
    size = len(table())
    across = np.sqrt(1.0 - np.clip(n_dot_v, LEAST_COSINE, 1.0))
    rows = np.maximum(np.asarray(roughness, dtype=np.float64), brdf.MIN_ROUGHNESS)
    return _bilinear(table().astype(np.float64), rows * (size - 1), across * (size - 1))


def _bilinear(values: np.ndarray, row, column) -> np.ndarray:
    """A table (rows, columns, k) between its nodes, held at its rim: (..., k)."""
    row, column = (np.clip(v, 0, n - 1) for v, n in zip((row, column), values.shape, strict=False))
    i, j = (np.minimum(v.astype(int), n - 2) for v, n in zip((row, column), values.shape, strict=False))
    y, x = (row - i)[..., None], (column - j)[..., None]
    upper, lower = (values[k, j] * (1.0 - x) + values[k, j + 1] * x for k in (i, i + 1))
    return upper * (1.0 - y) + lower * y


def matrix(four, alpha: float, n_dot_v: float) -> np.ndarray:
    """M, float64 (3, 3), of the table's four numbers; in axes x towards the eye along the surface, z its normal."""
    cosine = max(n_dot_v, LEAST_COSINE)
    sine = np.sqrt(1.0 - min(cosine, 1.0) ** 2)
    a, c, d = four[0] * alpha, four[1] * alpha, four[2] * alpha / cosine
    turn = np.array([four[3], np.sqrt(1.0 - four[3] ** 2)])
    z = np.array([cosine * turn[0] - sine * turn[1], 0.0, cosine * turn[1] + sine * turn[0]])
    rotation = np.array([[z[2], 0.0, z[0]], [0.0, 1.0, 0.0], [-z[0], 0.0, z[2]]])
    return rotation @ np.array([[a, 0.0, 0.0], [0.0, c, 0.0], [d, 0.0, 1.0]])


def share_above(m: np.ndarray) -> float:
    """How much of the moved cosine lobe lies above the horizon z = 0: moved back, that is a half space whose boundary
    is turned by an angle t about the lobe's rim, and a cosine lobe has (1 + cos t) / 2 above it."""
    return float(0.5 * (1.0 + m[2, 2] / np.linalg.norm(m[2])))


def density(m: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """The lobe, 1/sr, at unit directions (n, 3): section 3 of the paper, eq. 1; zero below the horizon, integral 1."""
    moved = directions @ np.linalg.inv(m).T
    square = np.sum(moved * moved, axis=-1)
    lobe = np.maximum(moved[:, 2], 0.0) / (pi * abs(np.linalg.det(m)) * square * square)
    return np.where(directions[:, 2] > 0.0, lobe, 0.0) / share_above(m)


def polygon_moment_of_lobe(m: np.ndarray, vertices: np.ndarray) -> np.ndarray:
    """What of the cosine lobe's moment the convex polygon `vertices` (K, 3) takes, moved back, over what lies above
    the horizon: (3,), whose z is the integral of the lobe over the polygon as the point at the origin sees it. The
    polygon is counter-clockwise seen from where it shines to."""
    above = clip_at_horizon(vertices, np.array([0.0, 0.0, 1.0]))
    moved = clip_at_horizon(above @ np.linalg.inv(m).T, np.array([0.0, 0.0, 1.0]))
    return -polygon_moment(moved) / pi / share_above(m)


def lobe_axes(normal: np.ndarray, to_eye: np.ndarray) -> np.ndarray:
    """Rows x, y, z of the lobe's axes (`matrix`) for unit vectors, float64 (3, 3)."""
    along = to_eye - normal * (normal @ to_eye)
    if np.linalg.norm(along) < 1e-9:
        along = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    x = along / np.linalg.norm(along)
    return np.stack([x, np.cross(normal, x), normal])


def radiance(light: AreaLight, position, normal, to_eye, material: brdf.Surface) -> np.ndarray:
    """Radiance (3,), nits, that one point sends to unit `to_eye` (3,) under the light, unshadowed: what the GPU does.

    Diffuse: exact irradiance times what Fresnel leaves. Specular: the lobe's integral over the light times the
    lobe's directional albedo times Fresnel. Fresnel is that of light from the mean direction of what each lobe takes;
    the usual one, averaged over the whole lobe, would be several times too large for a light beside a lobe that looks
    to the horizon.
    """
    position, normal, to_eye = (np.asarray(v, dtype=np.float64) for v in (position, normal, to_eye))
    irradiance = area_light_irradiance(light, position, normal)
    if not irradiance.any():
        return np.zeros(3)
    axes = lobe_axes(normal, to_eye)
    vertices, view = (np.asarray(light.corners, dtype=np.float64) - position) @ axes.T, axes @ to_eye
    cosine = max(float(view[2]), 0.0)
    m = matrix(parameters(material.roughness, cosine), float(brdf.alpha_of(material.roughness)), cosine)
    taken = polygon_moment_of_lobe(m, vertices)
    towards = -polygon_moment(clip_at_horizon(vertices, np.array([0.0, 0.0, 1.0])))
    albedo, f0, f90 = brdf.reflectances(material)
    specular = lobe_albedo(material.roughness, cosine) * max(float(taken[2]), 0.0) * np.asarray(light.radiance)
    diffuse = albedo / pi * irradiance
    return (1.0 - _fresnel(f0, f90, view, towards)) * diffuse + _fresnel(f0, f90, view, m @ taken) * specular


def _fresnel(f0: np.ndarray, f90: np.ndarray, view: np.ndarray, towards: np.ndarray) -> np.ndarray:
    """Schlick's (3,) for light from the direction `towards` (3,), of any length; 0 is the view's own direction."""
    half = towards / max(np.linalg.norm(towards), 1e-300) + view
    return brdf.schlick_fresnel(f0, f90, view @ half / np.linalg.norm(half))


def lobe_albedo(roughness, n_dot_v: float) -> float:
    """Integral of D V n.l: what a surface with a Fresnel of 1 reflects of even light (`environment.brdf_table`)."""
    even = brdf_table()[..., :2].sum(axis=-1, keepdims=True).astype(np.float64)
    row = max(float(roughness), brdf.MIN_ROUGHNESS) * len(even) - 0.5
    return float(_bilinear(even, row, n_dot_v * len(even) - 0.5)[0])


def quadrature(light: AreaLight, position, normal, to_eye, material: brdf.Surface, steps: int = 256) -> np.ndarray:
    """The same with the BRDF itself, by the midpoint rule over `steps` x `steps` parts of a parallelogram: (3,).

    The parts must be small against the lobe, alpha, as seen from the point. Raises ValueError for other shapes.
    """
    position, normal, to_eye = (np.asarray(v, dtype=np.float64) for v in (position, normal, to_eye))
    a, b, c, d = (np.asarray(corner, dtype=np.float64) for corner in light.corners)
    if np.abs(a - b + c - d).max() > 1e-9 * np.abs(c - a).max():
        raise ValueError("the quadrature is that of a parallelogram")
    s, t = np.meshgrid(*[(np.arange(steps) + 0.5) / steps] * 2)
    to_light = a + s[..., None] * (b - a) + t[..., None] * (d - a) - position
    square = np.sum(to_light * to_light, axis=-1)
    l = to_light / np.sqrt(square)[..., None]  # noqa: E741
    area = np.cross(b - a, d - a)
    solid_angle = np.maximum(-(l @ area), 0.0) / square / steps**2
    weight = np.maximum(l @ normal, 0.0) * solid_angle
    reflected = brdf.evaluate(material, normal, l, to_eye) * weight[..., None]
    return reflected.sum(axis=(0, 1)) * np.asarray(light.radiance)
