"""The metallic-roughness BRDF of glTF 2.0, appendix B, in its mixed form (B.3.5): one Fresnel for both lobes.

    f = (1 - F) * c_diff / pi + F * D * V

D is Trowbridge-Reitz (GGX) with alpha = roughness^2, V the height-correlated Smith visibility (Heitz 2014), which
holds the denominator 4 (n.l)(n.v), and F Schlick's approximation at the half vector. `specular` weights the dielectric
lobe as KHR_materials_specular does, F0 and F90 alike, so that 0 is a pure Lambert surface, also at grazing angles.

Known limit: F is taken at the half vector, so the diffuse part does not know what the specular part has taken at
grazing view; near the horizon a smooth white dielectric reflects more than it receives (at roughness 0.4, 1.02
times at 60 degrees and 1.23 times at 89). Each part alone does not.
"""

from __future__ import annotations

from math import pi
from typing import NamedTuple

import numpy as np

DIELECTRIC_F0 = 0.04
"""Reflectance of a dielectric of index 1.5 at normal incidence (glTF 2.0, B.3.5)."""

MIN_ROUGHNESS = 0.045
"""Roughness is raised to it: alpha^2 = 4e-6 then keeps D finite and its denominator well above the rounding of
(n.h)^2 in float32. The value is the one Frostbite and Filament use (Lagarde & de Rousiers 2014; Guy & Agopian 2018)."""


class Surface(NamedTuple):
    """What the BRDF needs of a surface; arrays broadcast: base_color (..., 3), the others (...)."""

    base_color: np.ndarray
    metallic: np.ndarray
    roughness: np.ndarray
    specular: np.ndarray


def surface(base_color, metallic=0.0, roughness=1.0, specular=1.0) -> Surface:
    """A `Surface` from numbers or arrays; base_color (..., 3), the others (...); all in [0, 1]."""
    rest = (np.asarray(value, dtype=np.float64) for value in (metallic, roughness, specular))
    return Surface(np.asarray(base_color, dtype=np.float64), *rest)


def alpha_of(roughness) -> np.ndarray:
    """GGX alpha = roughness^2 (glTF 2.0, B.2.3), roughness raised to MIN_ROUGHNESS."""
    return np.maximum(np.asarray(roughness, dtype=np.float64), MIN_ROUGHNESS) ** 2


def ggx_distribution(n_dot_h, alpha) -> np.ndarray:
    """D, 1/sr: alpha^2 / (pi ((n.h)^2 (alpha^2 - 1) + 1)^2); its integral times n.h over the hemisphere is 1."""
    n_dot_h, square = np.maximum(n_dot_h, 0.0), np.square(alpha)
    return square / (pi * np.square(n_dot_h * n_dot_h * (square - 1.0) + 1.0))


def smith_visibility(n_dot_l, n_dot_v, alpha) -> np.ndarray:
    """V = G / (4 n.l n.v), height-correlated Smith: 1/2 over the sum of n.l sqrt(a^2 + (1 - a^2) (n.v)^2) and the same
    with l and v exchanged. Zero where both cosines are."""
    square = np.square(alpha)
    from_view = n_dot_l * np.sqrt(square + (1.0 - square) * np.square(n_dot_v))
    from_light = n_dot_v * np.sqrt(square + (1.0 - square) * np.square(n_dot_l))
    total = from_view + from_light
    return np.where(total > 0.0, 0.5 / np.where(total > 0.0, total, 1.0), 0.0)


def schlick_fresnel(f0, f90, v_dot_h) -> np.ndarray:
    """F = F0 + (F90 - F0) (1 - v.h)^5 (Schlick 1994)."""
    return f0 + (f90 - f0) * np.power(1.0 - np.clip(v_dot_h, 0.0, 1.0), 5.0)


def reflectances(material: Surface) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Diffuse albedo c_diff, F0 and F90 of a `material`, each (..., 3).

    Metals have no diffuse part, their F0 is the base color and their F90 is 1; dielectrics have F0 = 0.04 specular
    and F90 = specular (KHR_materials_specular).
    """
    metallic, specular = material.metallic[..., None], material.specular[..., None]
    diffuse = material.base_color * (1.0 - metallic)
    f0 = DIELECTRIC_F0 * specular * (1.0 - metallic) + material.base_color * metallic
    f90 = np.broadcast_to(specular * (1.0 - metallic) + metallic, np.shape(f0))
    return diffuse, f0, f90


def diffuse_and_specular(material: Surface, normal, to_light, to_eye) -> tuple[np.ndarray, np.ndarray]:
    """The two parts of the BRDF, each (..., 3), 1/sr, without the cosine at the light.

    normal, to_light, to_eye: unit vectors (..., 3), broadcast. Zero where the light is not above the surface. An eye
    that is not above it, from which a shading normal leans away, counts as on its horizon (docs/conventions.md).
    """
    normal, to_light, to_eye = (np.asarray(v, dtype=np.float64) for v in (normal, to_light, to_eye))
    half = to_light + to_eye
    length = np.linalg.norm(half, axis=-1, keepdims=True)
    half = half / np.where(length > 0.0, length, 1.0)
    n_dot_l, n_dot_v = np.sum(normal * to_light, axis=-1), np.sum(normal * to_eye, axis=-1)
    above = (n_dot_l > 0.0)[..., None]
    albedo, f0, f90 = reflectances(material)
    fresnel = schlick_fresnel(f0, f90, np.sum(to_eye * half, axis=-1)[..., None])
    alpha = alpha_of(material.roughness)
    visibility = smith_visibility(np.maximum(n_dot_l, 0.0), np.maximum(n_dot_v, 0.0), alpha)
    lobe = ggx_distribution(np.sum(normal * half, axis=-1), alpha) * visibility
    return np.where(above, (1.0 - fresnel) * albedo / pi, 0.0), np.where(above, fresnel * lobe[..., None], 0.0)


def evaluate(material: Surface, normal, to_light, to_eye) -> np.ndarray:
    """The BRDF (..., 3), 1/sr, without the cosine at the light; arguments as `diffuse_and_specular`."""
    diffuse, specular = diffuse_and_specular(material, normal, to_light, to_eye)
    return diffuse + specular
