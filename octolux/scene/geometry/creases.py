"""Normals for models that have none: smooth over gentle bends, split where faces meet at a sharp one."""

from __future__ import annotations

from math import cos, radians

import numpy as np

from .triangles import face_vectors, smooth_normals, unit

# Faces that turn by more than this from each other keep an edge between them: halfway between a cylinder of 8 sides
# (45 degrees), the coarsest that is drawn to look round, and one of 6 (60), whose sides are meant to be flat.
CREASE = radians(52.5)
_HUB = 64  # Work grows with the square of the faces at a vertex; a hub of more is smooth all around.


def creased(
    positions: np.ndarray, indices: np.ndarray, attributes: tuple[np.ndarray | None, ...] = (), limit: float = CREASE
) -> tuple[np.ndarray, np.ndarray, np.ndarray, list[np.ndarray | None]]:
    """Positions, normals and indices with unit normals, and `attributes` for the vertices that these have.

    positions: float32 (vertices, 3); indices: uint32 (triangles, 3); attributes: arrays of `vertices` rows, or None.
    The normal of a triangle's corner is the area-weighted mean of the faces around its vertex that are within `limit`,
    radians, of the triangle's own. Where corners of a vertex differ it is split, one vertex for each corner.
    """
    corners = indices.ravel().astype(np.int64)
    normals, split = _corner_normals(positions, indices, corners, cos(limit))
    shared = smooth_normals(positions, indices)
    apart = np.flatnonzero(split[corners])
    new_indices = corners.copy()
    new_indices[apart] = len(positions) + np.arange(len(apart))
    source = np.concatenate([np.arange(len(positions)), corners[apart]])
    all_normals = np.concatenate([shared, normals[apart].astype(np.float32)])
    # Vertices that were split are used no more; leave them out.
    used = np.zeros(len(source), bool)
    used[new_indices] = True
    number = np.cumsum(used) - 1
    keep = source[used]
    final = number[new_indices].astype(np.uint32).reshape(-1, 3)
    return positions[keep], all_normals[used], final, [None if a is None else a[keep] for a in attributes]


def _corner_normals(
    positions: np.ndarray, indices: np.ndarray, corners: np.ndarray, least: float
) -> tuple[np.ndarray, np.ndarray]:
    """float64 (corners, 3) unit normals, and bool (vertices,): whether corners of the vertex differ.

    Corners are sorted by vertex, and each is compared with the k-th of its vertex, for all k.
    """
    faces = face_vectors(positions, indices)
    directions = unit(faces)
    order = np.argsort(corners, kind="stable")
    face, vertex = order // 3, corners[order]
    counts = np.bincount(corners, minlength=len(positions))
    first = np.concatenate([[0], np.cumsum(counts)[:-1]])[vertex]
    count = np.where(counts <= _HUB, counts, 0)[vertex]
    total, split = np.zeros((len(corners), 3)), np.zeros(len(positions), bool)
    for k in range(int(count.max(initial=0))):
        here = np.flatnonzero(count > k)
        other = face[first[here] + k]
        near = np.einsum("ij,ij->i", directions[face[here]], directions[other]) >= least
        # A face without area has no direction; it neither gives nor splits.
        flat = ~(directions[other].any(axis=1) & directions[face[here]].any(axis=1))
        total[here[near]] += faces[other[near]]
        split[vertex[here[~near & ~flat]]] = True
    normals = np.empty_like(total)
    normals[order] = total
    return unit(normals, fallback=(0.0, 1.0, 0.0)), split
