"""Tangents as MikkTSpace makes them, the standard that glTF and the tools which bake normal maps agree on.

From Mikkelsen, "Simulation of Wrinkled Surfaces Revisited" (thesis, Copenhagen 2008) and its reference implementation,
mikktspace.c, vectorised:

1. Vertices with equal position, normal and uv are welded.
2. Triangles that share an edge of welded vertices are neighbours. Corners around a vertex that are linked by neighbours
   of one orientation (the sign of the triangle's area in uv space) form a group.
3. A group's tangent is the sum of its triangles' directions of rising u, each projected onto the plane of the vertex
   normal, made unit length, and weighted by the triangle's angle there.
4. Triangles of which two corners lie at one place take the tangent of another triangle at the same vertex. Those that
   have an area but none in uv space join the groups of their neighbours and add nothing to them.

It differs from the reference where that gives nothing usable: where no triangle around a vertex has an area in uv
space, its (1, 0, 0) may lie along the normal, and any unit vector orthogonal to the normal stands in, with w = 1.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .triangles import any_orthogonal, unit

_TINY = float(np.finfo(np.float32).tiny)  # below FLT_MIN the reference takes a number for zero


@dataclass(frozen=True)
class TangentSpace:
    """Tangents of a mesh whose vertices are split where tangents differ.

    vertices: int64 (new vertices,), the old vertex that each is a copy of; all old ones come first, in order.
    indices: uint32 (triangles, 3), into the new vertices.
    tangents: float32 (new vertices, 4), glTF: xyz unit length and orthogonal to the normal, w = +1 or -1.
    """

    vertices: np.ndarray
    indices: np.ndarray
    tangents: np.ndarray


@dataclass(frozen=True)
class _Triangles:
    """directions: float64 (triangles, 3), rising u, unit length.

    flipped, flat: bool (triangles,): v runs against the bitangent; no area in uv space.
    """

    directions: np.ndarray
    flipped: np.ndarray
    flat: np.ndarray


def generate(positions: np.ndarray, normals: np.ndarray, uvs: np.ndarray, indices: np.ndarray) -> TangentSpace:
    """The MikkTSpace tangents of a mesh.

    positions, normals (unit length): float32 (vertices, 3); uvs: float32 (vertices, 2), v down the image as in glTF, so
    that the bitangent cross(n, t) * w points to falling v; indices: uint32 (triangles, 3).
    """
    weld = _weld(np.hstack([positions, normals, uvs]).astype(np.float32))
    whole = _whole(positions, indices)
    used = indices[whole]
    shape = _triangles(positions, uvs, used)
    across = _neighbours(weld[used])
    flipped = _orient_flat(shape, weld[used], across)
    groups = _groups(across, flipped)
    per_group = _group_tangents(shape, groups, positions, normals, used)
    vertices, split, group = _split(weld, indices, whole, groups)
    if not len(groups):
        per_group, flipped = np.zeros((1, 3)), np.zeros(1, bool)
    tangents = np.where((group >= 0)[:, None], per_group[group], 0.0)
    missing = ~tangents.any(axis=1)
    tangents[missing] = unit(any_orthogonal(normals[vertices[missing]].astype(np.float64)))
    sign = np.where(flipped[group // 3] & ~missing, -1.0, 1.0)
    return TangentSpace(vertices, split, np.column_stack([tangents, sign]).astype(np.float32))


def _weld(rows: np.ndarray) -> np.ndarray:
    """int64 (vertices,): for each row the first one that is equal to it."""
    words = (rows + np.float32(0)).view(np.uint32).astype(np.uint64)  # + 0 makes -0 the same bits as 0
    key = np.zeros(len(rows), np.uint64)
    for column in words.T:  # 64-bit FNV-1a on words (Fowler, Noll, Vo), with its prime; equal rows, equal keys
        key = (key ^ column) * np.uint64(0x100000001B3)
        key ^= key >> np.uint64(32)
    _, first, inverse = np.unique(key, return_index=True, return_inverse=True)
    found = first[inverse]
    if (rows[found] != rows).any():  # two rows share a key, or a value is not a number
        _, first, inverse = np.unique(words, axis=0, return_index=True, return_inverse=True)
        found = first[inverse.ravel()]
    return found


def _whole(positions: np.ndarray, indices: np.ndarray) -> np.ndarray:
    """bool (triangles,): which triangles have three corners at different places."""
    a, b, c = (positions[indices[:, corner]] for corner in range(3))
    return (a != b).any(axis=1) & (b != c).any(axis=1) & (c != a).any(axis=1)


def _triangles(positions: np.ndarray, uvs: np.ndarray, indices: np.ndarray) -> _Triangles:
    p, t = positions.astype(np.float64), uvs.astype(np.float64)
    a, b, c = indices.T
    e1, e2, d1, d2 = p[b] - p[a], p[c] - p[a], t[b] - t[a], t[c] - t[a]
    area = d1[:, 1] * d2[:, 0] - d1[:, 0] * d2[:, 1]  # v is turned upwards, as the reference has it
    along = e2 * d1[:, 1:] - e1 * d2[:, 1:]
    length = np.sqrt(np.einsum("ij,ij->i", along, along))
    flat = ~((np.abs(area) > _TINY) & (length > _TINY))
    directions = along * (np.where(area > 0, 1.0, -1.0) / np.where(flat, 1.0, length))[:, None]
    return _Triangles(directions, area <= 0, flat)


def _neighbours(welded: np.ndarray) -> np.ndarray:
    """int64 (3 triangles,): for edge i of triangle t, at 3 t + i from corner i to the next, the edge that runs against
    it in a neighbour; -1 where there is none. Of several, the k-th one way meets the k-th the other way."""
    start, end = welded.ravel(), np.roll(welded, -1, axis=1).ravel()
    low, high = np.minimum(start, end), np.maximum(start, end)
    key = (low * (int(high.max(initial=0)) + 1) + high) * 2 + (start > end)
    order = np.argsort(key, kind="stable")
    pair, backwards = key[order] >> 1, key[order] & 1
    first = np.flatnonzero(np.diff(pair, prepend=-1))
    size = np.diff(first, append=len(pair))
    begin, forward = np.repeat(first, size), np.repeat(size - np.add.reduceat(backwards, first), size)
    partner = np.arange(len(pair)) + np.where(backwards == 1, -forward, forward)
    end_of_partners = begin + np.where(backwards == 1, forward, np.repeat(size, size))
    matched = partner < end_of_partners
    found = np.full(len(pair), -1, np.int64)
    found[order[matched]] = order[partner[matched]]
    return found


def _orient_flat(shape: _Triangles, welded: np.ndarray, across: np.ndarray) -> np.ndarray:
    """bool (triangles,): `flipped`, where a triangle without area in uv space takes it from the group that reaches it
    first. It is the reference's one dependence on order, so the corners around such triangles are walked in its order.
    """
    if not shape.flat.any():
        return shape.flipped
    near = np.zeros(int(welded.max()) + 1, bool)
    near[welded[shape.flat]] = True
    starts = np.flatnonzero(near[welded] & ~shape.flat[:, None])
    edges, flipped, waiting = across.tolist(), shape.flipped.tolist(), shape.flat.tolist()
    grouped = bytearray(len(edges))
    for start in starts.tolist():
        if grouped[start]:
            continue
        orientation = flipped[start // 3]
        for outgoing in (True, False):
            corner = start
            while True:
                grouped[corner] = True
                corner = _beside(edges, corner, outgoing)
                if corner < 0 or grouped[corner]:
                    break
                if waiting[corner // 3]:
                    flipped[corner // 3], waiting[corner // 3] = orientation, False
                elif flipped[corner // 3] != orientation:
                    break
    return np.array(flipped)


def _beside(across: list[int], corner: int, outgoing: bool) -> int:
    """The corner at the same vertex across its outgoing or incoming edge; -1 where there is none."""
    if not outgoing:
        return across[corner - 1 if corner % 3 else corner + 2]
    edge = across[corner]
    return edge if edge < 0 else edge + 1 if edge % 3 < 2 else edge - 2


def _groups(across: np.ndarray, flipped: np.ndarray) -> np.ndarray:
    """int64 (3 triangles,): for each corner the lowest corner of its group.

    The corners around a vertex form chains, each linked to the one across its outgoing edge and the one across its
    incoming edge. The lowest of the next 2^k corners of the chain is known after k steps, one way and the other.
    """
    corners = np.arange(len(across))
    linked = np.flatnonzero((across >= 0) & (flipped[across // 3] == flipped[corners // 3]))
    target = across[linked]
    target = target - target % 3 + (target + 1) % 3
    lowest = corners
    for here, there in ((linked, target), (target, linked)):
        step = corners.copy()
        step[here] = there
        ahead = np.minimum(corners, step)
        while True:
            step = step[step]
            further = np.minimum(ahead, ahead[step])
            if np.array_equal(further, ahead):
                break
            ahead = further
        lowest = np.minimum(lowest, ahead)
    return lowest


def _group_tangents(
    shape: _Triangles, groups: np.ndarray, positions: np.ndarray, normals: np.ndarray, indices: np.ndarray
) -> np.ndarray:
    """float64 (3 triangles, 3): at the lowest corner of each group its tangent, zero where it has none."""
    total = np.zeros((len(groups), 3))
    for corner in range(3):
        here = indices[:, corner]
        normal, place = normals[here].astype(np.float64), positions[here].astype(np.float64)
        legs = [unit(_across(positions[indices[:, (corner + turn) % 3]] - place, normal)) for turn in (1, 2)]
        weight = np.arccos(np.clip(np.einsum("ij,ij->i", *legs), -1.0, 1.0))
        weight[shape.flat] = 0.0
        share = unit(_across(shape.directions, normal)) * weight[:, None]
        for axis in range(3):
            total[:, axis] += np.bincount(groups[corner::3], share[:, axis], len(groups))
    return unit(total)


def _across(vectors: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """The part of each vector that is orthogonal to the normal."""
    return vectors - normals * np.einsum("ij,ij->i", vectors, normals)[:, None]


def _split(
    weld: np.ndarray, indices: np.ndarray, whole: np.ndarray, groups: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The new vertices and indices of a TangentSpace, and int64 (new vertices,) the group of each, -1 for none."""
    group_at = np.full(len(weld), -1)
    group_at[weld[indices[whole]].ravel()[::-1]] = groups[::-1]  # of a place's groups the first writes last
    group = group_at[weld[indices]]
    group[whole] = groups.reshape(-1, 3)
    corners, group = indices.ravel().astype(np.int64), group.ravel()
    first = np.full(len(weld), -1)
    first[corners[::-1]] = group[::-1]
    other = group != first[corners]
    extra, number = np.unique(corners[other] * (len(groups) + 1) + group[other], return_inverse=True)
    corners[other] = len(weld) + number
    vertices = np.r_[np.arange(len(weld)), extra // (len(groups) + 1)]
    return vertices, corners.reshape(-1, 3).astype(np.uint32), np.r_[first, extra % (len(groups) + 1)]
