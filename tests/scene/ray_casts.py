"""Rays against all triangles of a scene, for tests of where walls, cameras and lights are."""

from __future__ import annotations

import numpy as np

from octolux.scene.scene import Scene


def world_triangles(scene: Scene) -> np.ndarray:
    """Corners (triangles, 3, 3) of all instances in world space, float64."""
    parts = []
    for instance in scene.instances:
        mesh = scene.meshes[instance.mesh]
        corners = mesh.positions[mesh.indices].astype(np.float64)
        parts.append(corners @ instance.transform[:3, :3].T + instance.transform[:3, 3])
    return np.concatenate(parts)


def first_hit(corners: np.ndarray, origin, direction) -> tuple[float, float]:
    """Distance to the first triangle and direction times its normal (Moeller and Trumbore); infinity when none."""
    origin, direction = np.asarray(origin, dtype=np.float64), np.asarray(direction, dtype=np.float64)
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, e2)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / np.einsum("ij,ij->i", e1, p)
        u = np.einsum("ij,ij->i", origin - a, p) * inverse
        q = np.cross(origin - a, e1)
        v, t = q @ direction * inverse, np.einsum("ij,ij->i", e2, q) * inverse
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-6)
    if not hit.any():
        return np.inf, 0.0
    first = np.flatnonzero(hit)[t[hit].argmin()]
    return float(t[first]), float(direction @ np.cross(e1[first], e2[first]))


def sphere_directions(count: int) -> np.ndarray:
    """Unit vectors (count, 3) spread evenly (Fibonacci lattice)."""
    i = np.arange(count) + 0.5
    y, angle = 1.0 - 2.0 * i / count, np.pi * (1.0 + np.sqrt(5.0)) * i
    level = np.sqrt(1.0 - y * y)
    return np.stack([level * np.cos(angle), y, level * np.sin(angle)], axis=1)
