"""Shapes made by code. Each returns a Mesh in metres with unit normals, uvs and tangents in the dtypes Mesh asks for.

Two builders do all the work: `quads` for flat faces with hard edges and `grid` for smooth surfaces. Texture
coordinates are metres divided by `tile`, the side of one texture repeat in metres, so that neighbouring parts line up.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from ..meshes import Mesh

QUAD_TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])


def quads(corners, uvs=None, *, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """Flat quadrilaterals, each with its own four vertices.

    corners: (n, 4, 3), counter-clockwise seen from the front.  uvs: (n, 4, 2), in texture repeats, or None for the
    world position along the two axes that the face is nearest to, divided by `tile`.
    """
    corners = np.asarray(corners, dtype=np.float64)
    across, up = _quad_edges(corners)
    normals = _unit(np.cross(across, up))
    uvs = _planar_uvs(corners, normals) / tile if uvs is None else np.asarray(uvs, dtype=np.float64)
    tangents = _tangents(normals, (across, up), _quad_edges(uvs))
    indices = np.arange(len(corners))[:, None, None] * 4 + QUAD_TRIANGLES
    return _mesh(corners, np.repeat(normals, 4, axis=0), np.repeat(tangents, 4, axis=0), uvs, indices, material, name)


def grid(points, uvs, *, closed: bool = False, material: int = 0, name: str = "") -> Mesh:
    """A smooth surface through a grid of points.

    points: (rows, columns, 3); the front is the side from which rows go up while columns go right.
    uvs: (rows, columns, 2), in texture repeats.  closed: the last column meets the first one, without a seam in
    the normals.
    """
    points, uvs = np.asarray(points, dtype=np.float64), np.asarray(uvs, dtype=np.float64)
    right, up = _columns_difference(points, closed), np.gradient(points, axis=0)
    normals = _unit(np.cross(right, up))
    tangents = _tangents(normals, (right, up), (np.gradient(uvs, axis=1), np.gradient(uvs, axis=0)))
    rows, columns = points.shape[:2]
    first = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1, 1)
    indices = first + np.array([0, 1, columns + 1, columns])[QUAD_TRIANGLES]
    return _mesh(points, normals, tangents, uvs, indices, material, name)


def quad(corners, *, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """One quadrilateral: corners (4, 3), counter-clockwise seen from the front."""
    return quads([corners], tile=tile, material=material, name=name)


def box(low, high, *, inward: bool = False, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """An axis-aligned box from `low` (3,) to `high` (3,), seen from outside, or from inside when `inward`."""
    (x, y, z), (X, Y, Z) = low, high
    faces = np.array(
        [
            [[x, y, Z], [X, y, Z], [X, Y, Z], [x, Y, Z]],
            [[X, y, z], [x, y, z], [x, Y, z], [X, Y, z]],
            [[X, y, Z], [X, y, z], [X, Y, z], [X, Y, Z]],
            [[x, y, z], [x, y, Z], [x, Y, Z], [x, Y, z]],
            [[x, Y, Z], [X, Y, Z], [X, Y, z], [x, Y, z]],
            [[x, y, z], [X, y, z], [X, y, Z], [x, y, Z]],
        ]
    )
    return quads(faces[:, ::-1] if inward else faces, tile=tile, material=material, name=name)


def revolve(profile, *, segments: int = 24, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """A surface of revolution about the y axis.

    profile: (rows, 2), radius and height from bottom to top for a surface seen from outside; repeat a point to make
    a hard edge there.
    """
    profile = np.asarray(profile, dtype=np.float64)
    angle = np.linspace(0.0, 2.0 * np.pi, segments + 1)
    radius = profile[:, :1]
    height = np.broadcast_to(profile[:, 1:], (len(profile), segments + 1))
    points = np.stack([radius * np.sin(angle), height, radius * np.cos(angle)], axis=2)
    # A whole number of repeats around, so that the texture meets itself at the seam.
    around = max(1, round(2.0 * np.pi * float(radius.mean()) / tile))
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    uvs = np.stack(np.broadcast_arrays(angle / (2.0 * np.pi) * around, -along[:, None] / tile), axis=2)
    runs = _smooth_runs(profile)
    return merge([grid(points[rows], uvs[rows], closed=True, material=material, name=name) for rows in runs])


def extrude(profile, start, end, *, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """A straight moulding: an open outline drawn in the plane of y and "out", swept from `start` (3,) to `end` (3,).

    profile: (points, 2), (out, y) from bottom to top; "out" points to the right of the sweep, seen from above.
    """
    profile, start, end = (np.asarray(a, dtype=np.float64) for a in (profile, start, end))
    out = _unit(np.cross(end - start, [0.0, 1.0, 0.0]))
    offset = profile[:, :1] * out + profile[:, 1:] * np.array([0.0, 1.0, 0.0])
    near, far = start + offset, end + offset
    corners = np.stack([near[:-1], far[:-1], far[1:], near[1:]], axis=1)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    length = float(np.linalg.norm(end - start))
    u = np.broadcast_to([0.0, length, length, 0.0], (len(corners), 4))
    v = -np.stack([along[:-1], along[:-1], along[1:], along[1:]], axis=1)
    return quads(corners, np.stack([u, v], axis=2) / tile, material=material, name=name)


def merge(meshes: Sequence[Mesh], name: str | None = None) -> Mesh:
    """One mesh out of several of the same material. Raises ValueError when there is none or materials differ."""
    if len({m.material for m in meshes}) != 1:
        raise ValueError("merge needs meshes, all of the same material")
    offsets = np.cumsum([0] + [len(m.positions) for m in meshes[:-1]], dtype=np.uint32)
    return Mesh(
        positions=np.concatenate([m.positions for m in meshes]),
        normals=np.concatenate([m.normals for m in meshes]),
        uvs=np.concatenate([m.uvs for m in meshes]),
        tangents=np.concatenate([m.tangents for m in meshes]),
        indices=np.concatenate([m.indices + o for m, o in zip(meshes, offsets, strict=True)]),
        material=meshes[0].material,
        name=meshes[0].name if name is None else name,
    )


def _mesh(positions, normals, tangents, uvs, indices, material: int, name: str) -> Mesh:
    flat = {"positions": (positions, 3), "normals": (normals, 3), "tangents": (tangents, 4), "uvs": (uvs, 2)}
    arrays: dict[str, Any] = {
        key: np.ascontiguousarray(a, dtype=np.float32).reshape(-1, width) for key, (a, width) in flat.items()
    }
    return Mesh(indices=indices.reshape(-1, 3).astype(np.uint32), material=material, name=name, **arrays)


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.linalg.norm(vectors, axis=-1, keepdims=True)


def _quad_edges(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean edges across and up of quads (n, 4, k); a mean still works when two corners coincide."""
    a, b, c, d = (corners[:, i] for i in range(4))
    return (b - a + c - d) / 2, (d - a + c - b) / 2


def _columns_difference(points: np.ndarray, closed: bool) -> np.ndarray:
    if not closed:
        return np.gradient(points, axis=1)
    ring = points[:, :-1]
    difference = np.roll(ring, -1, axis=1) - np.roll(ring, 1, axis=1)
    return np.concatenate([difference, difference[:, :1]], axis=1)


def _smooth_runs(profile: np.ndarray) -> list[slice]:
    """Slices of a profile between repeated points."""
    breaks = np.flatnonzero((np.diff(profile, axis=0) == 0).all(axis=1)) + 1
    edges = [0, *breaks.tolist(), len(profile)]
    return [slice(a, b) for a, b in pairwise(edges)]


def _planar_uvs(corners: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """World metres on the axis plane nearest to each face, upright and unmirrored seen from the front."""
    axis = np.abs(normals).argmax(axis=1)
    facing = np.sign(np.take_along_axis(normals, axis[:, None], axis=1))
    x, y, z = (corners[..., i] for i in range(3))
    upright = np.where((axis == 0)[:, None], -facing * z, facing * x)
    level = (axis == 1)[:, None]
    return np.stack([np.where(level, x, upright), np.where(level, facing * z, -y)], axis=2)


def _tangents(normals, edges, uv_edges) -> np.ndarray:
    """glTF tangents (..., 4): xyz along growing u, orthogonal to the normal; w so that cross(n, t) * w points to
    the top of the image, where v is small."""
    (right, up), (du, dv) = edges, uv_edges
    determinant = du[..., :1] * dv[..., 1:] - du[..., 1:] * dv[..., :1]
    along_u = (right * dv[..., 1:] - up * du[..., 1:]) * np.sign(determinant)
    tangent = _unit(along_u - normals * (along_u * normals).sum(axis=-1, keepdims=True))
    # A uv map is unmirrored when v shrinks while u grows counter-clockwise, that is with a negative determinant.
    return np.concatenate([tangent, np.where(determinant < 0, 1.0, -1.0)], axis=-1)
