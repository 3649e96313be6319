"""Morph targets and linear blend skinning, on the host: meshes in a pose (glTF 2.0, sections 3.7.2.2 and 3.7.3.3).

Arrays are float32 and without loops over vertices. Where single precision leaves a normal or tangent without a
direction, it stays that of the modelled mesh.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..meshes import Deformable, Mesh

Pose = tuple[np.ndarray, np.ndarray, np.ndarray]


def deformed(mesh: Mesh, weights: Sequence[float] = (), palette: np.ndarray | None = None) -> Mesh:
    """The mesh with positions, normals and tangents of a pose; its other arrays are shared.

    weights: one for each morph target, or none for 0.
    palette: float64 (joints, 4, 4), the mesh space of the modelled pose to that of this one, or None without a skin.

    Each vertex moves by the mean of its joints' matrices. Its normal goes by the cofactors of that mean, which is the
    inverse transpose but for a factor: right for any scale, and without a division for matrices that flatten. Tangents
    go by the mean itself, as edges do, and are then made orthogonal to the normal. Raises ValueError for a mesh that
    nothing deforms.
    """
    if mesh.deformable is None:
        raise ValueError(f"mesh '{mesh.name}' has neither a skin nor morph targets")
    base = mesh.deformable
    with np.errstate(over="ignore", invalid="ignore", under="ignore"):
        positions, normals, tangents = _morphed(base, weights)
        if palette is not None and base.joints is not None and base.weights is not None:
            positions, normals, tangents = _skinned(_blended(palette, base.joints, base.weights),
                                                    (positions, normals, tangents))
        normals = _unit(normals, base.normals)
        along = tangents[:, :3]
        along = along - normals * np.einsum("ij,ij->i", normals, along)[:, None]
        tangents[:, :3] = _unit(along, base.tangents[:, :3])
    return replace(mesh, positions=positions, normals=normals, tangents=tangents)


def _morphed(base: Deformable, weights: Sequence[float]) -> Pose:
    """Copies of the modelled arrays with the weighted displacements added."""
    positions, normals, tangents = base.positions.copy(), base.normals.copy(), base.tangents.copy()
    for weight, target in zip(weights, base.targets, strict=False):
        if not weight:
            continue
        for array, shift in ((positions, target.positions), (normals, target.normals),
                             (tangents[:, :3], target.tangents)):
            if shift is not None:
                array += np.float32(weight) * shift
    return positions, normals, tangents


def _blended(palette: np.ndarray, joints: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """float32 (3, 4, vertices): the weighted mean of each vertex's joints' matrices. Vertices stand last, so that what
    follows works on whole rows of them."""
    rows = np.ascontiguousarray(palette[:, :3, :].reshape(-1, 12).T, dtype=np.float32)
    blended = np.zeros((12, len(joints)), np.float32)
    for column in range(joints.shape[1]):
        blended += rows[:, joints[:, column]] * weights[:, column]
    return blended.reshape(3, 4, -1)


def _skinned(blended: np.ndarray, pose: Pose) -> Pose:
    linear = blended[:, :3]
    positions, normals, tangents = (np.ascontiguousarray(array.T) for array in pose)
    cofactors = np.stack([np.cross(linear[1], linear[2], axis=0), np.cross(linear[2], linear[0], axis=0),
                          np.cross(linear[0], linear[1], axis=0)])
    # Mirrored: the cofactors would turn the normal inside out, and the bitangent changes sides.
    sign = np.where(np.einsum("jn,jn->n", linear[0], cofactors[0]) < 0, np.float32(-1), np.float32(1))
    moved = np.einsum("ijn,jn->in", linear, positions) + blended[:, 3]
    along = np.vstack([np.einsum("ijn,jn->in", linear, tangents[:3]), (tangents[3] * sign)[None]])
    across = np.einsum("ijn,jn->in", cofactors, normals) * sign
    return tuple(np.ascontiguousarray(array.T) for array in (moved, across, along))  # type: ignore[return-value]


def _unit(vectors: np.ndarray, fallback: np.ndarray) -> np.ndarray:
    """float32 (n, 3) at unit length; where that is not to be had, `fallback`."""
    # Scaled by the largest component first: squares of small numbers are 0 in single precision.
    largest = np.abs(vectors).max(axis=1, keepdims=True, initial=0.0)
    scaled = vectors / largest
    result = scaled / np.sqrt(np.einsum("ij,ij->i", scaled, scaled))[:, None]
    good = np.isfinite(result).all(axis=1, keepdims=True)
    return result if good.all() else np.where(good, result, fallback)
