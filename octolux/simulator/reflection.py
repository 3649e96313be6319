"""The GGX lobe of a surface: where it points, and how wide cells are that resolve it."""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from .brdf import alpha_of

CONE = sqrt(2.0 * pi)
"""Edge of the cells that resolve a GGX lobe, over its alpha and the length of the way. A lobe of half vectors has the
solid angle 1 / D(1) = pi alpha^2, that of directions four times as much (dl = 4 v.h dh; Walter et al. 2007, 14): a
square of 2 sqrt(pi) alpha. Cells are filtered by a tent, whose variance is h^2 / 6; that of a square is s^2 / 12."""


def reflected_direction(to_eye, normal, geometric, roughness) -> np.ndarray:
    """Unit directions (M, 3) in which the lobe is strongest: from the mirrored one towards the normal, as it is rough
    (Lagarde & de Rousiers 2014, listing 22), and above the surface itself."""
    to_eye, normal, geometric = (np.asarray(v, dtype=np.float64) for v in (to_eye, normal, geometric))
    mirrored = 2.0 * np.sum(normal * to_eye, axis=-1, keepdims=True) * normal - to_eye
    alpha = np.broadcast_to(alpha_of(roughness), mirrored.shape[:-1])[..., None]
    weight = (1.0 - alpha) * (np.sqrt(1.0 - alpha) + alpha)
    direction = normal + weight * (mirrored - normal)
    direction = direction - 2.0 * np.minimum(0.0, np.sum(direction * geometric, axis=-1, keepdims=True)) * geometric
    return direction / np.linalg.norm(direction, axis=-1, keepdims=True)
