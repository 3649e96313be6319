"""What loaders compute when a file leaves it out: normals and tangents; and which triangles have an area.

All functions are vectorised over vertices and triangles and compute in float64.
positions, normals: float32 (vertices, 3); uvs: float32 (vertices, 2); indices: uint32 (triangles, 3).
"""

from __future__ import annotations

import numpy as np

# Twice a triangle's area over its longest edge squared. Products of float32 coordinates carry rounding of about 1e-16
# in float64, so that below this the direction of the normal is noise.
FLATNESS = 1e-12

LARGEST_UV = float(1 << 24)
"""From here on a float32 has no fraction, so that a texture coordinate says nothing; their squares are still finite."""


def face_vectors(positions: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """float64 (triangles, 3): the normals of the triangles, each as long as twice its area."""
    a, b, c = (positions[indices[:, corner]].astype(np.float64) for corner in range(3))
    return np.cross(b - a, c - a)


def has_area(positions: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """bool (triangles,): which triangles have an area; the others have no normal and reflect no light.

    Loaders keep triangles without area beside others, so that counts are those of the file, and raise when there are
    no others.
    """
    a, b, c = (positions[indices[:, corner]].astype(np.float64) for corner in range(3))
    longest = np.max([_squared(b - a), _squared(c - a), _squared(c - b)], axis=0, initial=0.0)
    area = np.sqrt(_squared(np.cross(b - a, c - a)))
    return (area > FLATNESS * longest) & (longest > 0)


def smooth_normals(positions: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """float32 (vertices, 3): the area-weighted mean of the normals around each vertex, unit length; +y where none."""
    faces = face_vectors(positions, indices)
    return unit(_scatter(faces, indices, len(positions)), fallback=(0.0, 1.0, 0.0)).astype(np.float32)


def repair_normals(positions: np.ndarray, normals: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """`normals` at unit length; those that are zero or not finite are replaced by smooth ones."""
    normals = normals.astype(np.float64)
    with np.errstate(invalid="ignore"):
        lengths = np.sqrt(_squared(normals))
    bad = ~np.isfinite(lengths) | (lengths < 1e-6)
    if bad.any():
        normals[bad] = smooth_normals(positions, indices)[bad]
    return unit(normals, fallback=(0.0, 1.0, 0.0)).astype(np.float32)


def usable_uvs(uvs: np.ndarray) -> np.ndarray:
    """float32 (vertices, 2): `uvs`, 0 where they are not finite or beyond LARGEST_UV."""
    with np.errstate(invalid="ignore"):
        usable = np.abs(uvs) < LARGEST_UV
    return uvs if usable.all() else np.where(usable, uvs, np.float32(0.0))


def flat(positions: np.ndarray, uvs: np.ndarray, indices: np.ndarray) -> tuple[np.ndarray, ...]:
    """Give each triangle its own three vertices and its own normal.

    Returns positions, normals, uvs and indices in the shapes of this module, with 3 * triangles vertices.
    """
    corners = indices.ravel()
    normals = unit(face_vectors(positions, indices), fallback=(0.0, 1.0, 0.0)).astype(np.float32)
    own = np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)
    return positions[corners], np.repeat(normals, 3, axis=0), uvs[corners], own


def tangents(positions: np.ndarray, normals: np.ndarray, uvs: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """float32 (vertices, 4): glTF tangents, xyz along increasing u, w the sign of the bitangent cross(n, t) * w.

    Each triangle's tangent and bitangent (Lengyel, "Computing Tangent Space Basis Vectors for an Arbitrary Mesh",
    2001) are added up per vertex, weighted by area; the tangent is then made orthogonal to the normal. The bitangent
    points towards decreasing v, for v runs down the image and glTF's green points up. Where the uvs give no
    direction, any unit vector orthogonal to the normal stands in, with w = 1.
    """
    tangent, bitangent = _triangle_tangents(positions, uvs, indices)
    tangent = _scatter(tangent, indices, len(positions))
    bitangent = _scatter(bitangent, indices, len(positions))
    normal = normals.astype(np.float64)
    across = tangent - normal * np.sum(normal * tangent, axis=1, keepdims=True)
    usable = _squared(across) > 1e-12 * np.maximum(_squared(tangent), 1e-300)
    across = np.where(usable[:, None], across, any_orthogonal(normal))
    sign = np.where(usable & (np.sum(np.cross(normal, across) * bitangent, axis=1) < 0), -1.0, 1.0)
    return np.column_stack([unit(across, fallback=(1.0, 0.0, 0.0)), sign]).astype(np.float32)


def _triangle_tangents(positions: np.ndarray, uvs: np.ndarray, indices: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Per triangle float64 (triangles, 3): directions of rising u and of falling v, as long as twice its area."""
    p = positions[indices].astype(np.float64)
    t = uvs[indices].astype(np.float64)
    (e1, e2), (d1, d2) = (p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]), (t[:, 1] - t[:, 0], t[:, 2] - t[:, 0])
    determinant = d1[:, 0] * d2[:, 1] - d2[:, 0] * d1[:, 1]
    handed = np.sign(determinant)[:, None]
    along_u = (e1 * d2[:, 1:] - e2 * d1[:, 1:]) * handed
    along_v = (e2 * d1[:, :1] - e1 * d2[:, :1]) * handed
    area = np.sqrt(_squared(np.cross(e1, e2)))[:, None]
    return unit(along_u) * area, -unit(along_v) * area


def _scatter(values: np.ndarray, indices: np.ndarray, count: int) -> np.ndarray:
    """Add each triangle's (triangles, 3) vector to its three vertices: float64 (count, 3)."""
    corners = indices.ravel()
    columns = [np.bincount(corners, np.repeat(values[:, axis], 3), count) for axis in range(3)]
    return np.column_stack(columns)


def unit(vectors: np.ndarray, fallback: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> np.ndarray:
    """float64 (n, 3) at unit length; `fallback` where the length is zero."""
    lengths = np.sqrt(_squared(vectors))[:, None]
    return np.where(lengths > 0, vectors / np.where(lengths > 0, lengths, 1.0), fallback)


def any_orthogonal(normals: np.ndarray) -> np.ndarray:
    """A vector orthogonal to each normal: its cross product with the axis that it is least along."""
    axes = np.eye(3)[np.argmin(np.abs(normals), axis=1)]
    return np.cross(axes, normals)


def _squared(vectors: np.ndarray) -> np.ndarray:
    return np.einsum("ij,ij->i", vectors, vectors)
