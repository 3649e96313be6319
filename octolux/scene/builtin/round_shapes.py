"""Round and prismatic solids: spheres, cylinders, tubes along a path, discs and plates with any convex outline."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..meshes import Mesh
from .shapes import grid, merge, quads, revolve

_CUBE = np.array(  # right, up and out of each face, with cross(right, up) = out
    [[[0, 0, -1], [0, 1, 0], [1, 0, 0]], [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], [[1, 0, 0], [0, 0, -1], [0, 1, 0]],
     [[1, 0, 0], [0, 0, 1], [0, -1, 0]], [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [[-1, 0, 0], [0, 1, 0], [0, 0, -1]]],
    dtype=np.float64,
)  # fmt: skip


def sphere(radius: float, *, rows: int = 14, material: int = 0, name: str = "") -> Mesh:
    """A sphere about the origin: the six faces of a cube of `rows` by `rows` quadrilaterals, equal in angle.

    It has no poles, 12 rows^2 triangles and the exact normals. Each face of the cube is one repeat of a texture.
    """
    share = np.linspace(0.0, 1.0, rows + 1)
    a, b = np.meshgrid(*[np.tan((share - 0.5) * np.pi / 2.0)] * 2)
    uvs = np.stack(np.meshgrid(share, 1.0 - share), axis=2)
    faces = []
    for right, up, out in _CUBE:
        points = a[..., None] * right + b[..., None] * up + out
        points *= radius / np.linalg.norm(points, axis=2, keepdims=True)
        faces.append(grid(points, uvs, material=material))
    return _with_normals(merge(faces, name), lambda positions: positions / radius)


def cylinder(radius: float, height: float, *, segments: int = 24, material: int = 0, name: str = "") -> Mesh:
    """A closed cylinder that stands on y = 0; `segments` is even."""
    angle = np.arange(segments) * 2.0 * np.pi / segments
    ring = np.stack([radius * np.sin(angle), np.zeros(segments), radius * np.cos(angle)], axis=1)
    side = revolve([(radius, 0.0), (radius, height)], segments=segments, material=material)
    top = ring + np.array([0.0, height, 0.0])
    caps = [polygon(top, material=material), polygon(ring[::-1], material=material)]
    return merge([side, *caps], name)


def tube(points, radius, *, sides: int = 8, material: int = 0, name: str = "") -> Mesh:
    """A round bar, cable or branch along a path, open at its ends.

    points: (n, 3).  radius: metres, one number or (n,).  The ring of each point is turned as little as possible from
    the one before, so that the tube does not twist.
    """
    points = np.asarray(points, dtype=np.float64)
    radius = np.broadcast_to(np.asarray(radius, dtype=np.float64), len(points))[:, None, None]
    along = np.gradient(points, axis=0)
    along /= np.linalg.norm(along, axis=1, keepdims=True)
    first = _across(along)
    second = np.cross(along, first)
    angle = np.linspace(0.0, 2.0 * np.pi, sides + 1)[None, :, None]
    rings = points[:, None] + radius * (np.cos(angle) * first[:, None] + np.sin(angle) * second[:, None])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    uvs = np.stack(np.broadcast_arrays(np.linspace(0.0, 1.0, sides + 1), -length[:, None]), axis=2)
    return grid(rings, uvs, closed=True, material=material, name=name)


def rounded_path(points, times: int = 2) -> np.ndarray:
    """The path with its corners cut `times` times at a quarter of each leg (Chaikin 1974); its ends stay.

    points: (n, 3).  Returns float64 (m, 3).
    """
    path = np.asarray(points, dtype=np.float64)
    for _ in range(times):
        a, b = path[:-1], path[1:]
        cut = np.stack([0.75 * a + 0.25 * b, 0.25 * a + 0.75 * b], axis=1).reshape(-1, 3)
        path = np.concatenate([path[:1], cut[1:-1], path[-1:]])
    return path


def polygon(points, *, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """A flat convex polygon with an even number of corners (n, 3), counter-clockwise seen from the front."""
    points = np.asarray(points, dtype=np.float64)
    last, i = len(points) - 1, np.arange(len(points) // 2 - 1)
    return quads(points[np.stack([i, i + 1, last - 1 - i, last - i], axis=1)], tile=tile, material=material, name=name)


def plate(outline, low: float, high: float, *, tile: float = 1.0, material: int = 0, name: str = "") -> Mesh:
    """A closed upright prism between the heights `low` and `high`.

    outline: (n, 2), x and z of a convex outline with an even number of corners, counter-clockwise seen from above.
    """
    outline = np.asarray(outline, dtype=np.float64)
    bottom, top = (np.insert(outline, 1, height, axis=1) for height in (low, high))
    following = np.roll(np.arange(len(outline)), -1)
    sides = np.stack([bottom, bottom[following], top[following], top], axis=1)
    faces = [polygon(top, tile=tile, material=material), polygon(bottom[::-1], tile=tile, material=material)]
    return merge([quads(sides, tile=tile, material=material), *faces], name)


def rounded_rectangle(
    width: float, depth: float, radius: float, segments: int = 6, *, centre: tuple[float, float] = (0.0, 0.0)
) -> np.ndarray:
    """Outline for `plate` about `centre`: `width` in x, `depth` in z, corners of `radius`: (4 segments + 4, 2)."""
    turn = np.linspace(0.0, np.pi / 2.0, segments + 1)
    angle = (np.arange(4)[:, None] * np.pi / 2.0 + turn).ravel()
    side_x, side_z = np.repeat([[1, -1, -1, 1], [-1, -1, 1, 1]], segments + 1, axis=1)
    x = centre[0] + side_x * (width / 2.0 - radius) + radius * np.cos(angle)
    z = centre[1] + side_z * (depth / 2.0 - radius) - radius * np.sin(angle)
    return np.stack([x, z], axis=1)


def _across(along: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3), each perpendicular to its direction of `along` and turned least from the one before."""
    vector = np.eye(3)[np.abs(along[0]).argmin()]
    across = np.empty_like(along)
    for i, direction in enumerate(along):
        vector = vector - direction * (vector @ direction)
        across[i] = vector = vector / np.linalg.norm(vector)
    return across


def _with_normals(mesh: Mesh, normals_at) -> Mesh:
    """The mesh with normals normals_at(positions), and its tangents made perpendicular to them."""
    normals = normals_at(mesh.positions.astype(np.float64))
    tangents = mesh.tangents.astype(np.float64)
    tangents[:, :3] -= normals * (tangents[:, :3] * normals).sum(axis=1, keepdims=True)
    tangents[:, :3] /= np.linalg.norm(tangents[:, :3], axis=1, keepdims=True)
    return replace(mesh, normals=normals.astype(np.float32), tangents=tangents.astype(np.float32))
