"""Parts of buildings: arched walls, columns, balustrades and curtains, each standing at the origin and facing +z."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..meshes import Mesh
from .shapes import box, grid, merge, quads, revolve

ARC_SEGMENTS = 24


def arched_wall(
    width: float, radius: float, spring: float, base: float, top: float, thickness: float, *,
    tile: float = 2.0, material: int = 0, name: str = "",
) -> Mesh:
    """A wall with one round-arched opening, centred on x = 0 and z = 0.

    width: of the wall; radius: of the arch, whose centre is at height `spring`; base, top: heights between which the
    wall stands. `base` equal to `spring` gives a bay of an arcade that rests on columns.
    """
    half, arc_x, arc_y = width / 2.0, *_arc(radius, spring)
    x = np.concatenate([[-half], arc_x, [half]])
    face = [(-half, -radius, base), (radius, half, base)]
    low, high = x[1:-2], x[2:-1]
    strips = np.stack([low, arc_y[:-1], high, arc_y[1:]], axis=1)
    outline = [[(a, y), (b, y), (b, top), (a, top)] for a, b, y in face]
    outline += [[(a, ya), (b, yb), (b, top), (a, top)] for a, ya, b, yb in strips]
    flat = np.array(outline, dtype=np.float64)
    depth = np.full((*flat.shape[:2], 1), thickness / 2.0)
    front = np.concatenate([flat, depth], axis=2)
    back = np.concatenate([flat, -depth], axis=2)[:, ::-1]
    parts = [quads(np.concatenate([front, back]), tile=tile, material=material, name=name),
             _soffit(radius, spring, base, thickness, tile, material)]
    return merge(parts, name)


def archivolt(
    radius: float, spring: float, thickness: float, *, width: float = 0.17, relief: float = 0.05,
    tile: float = 1.0, material: int = 0, name: str = "",
) -> Mesh:
    """The moulding around the front of an arch of a wall `thickness` thick: `width` broad, `relief` proud of it."""
    wall, edge = thickness / 2.0 - 0.01, thickness / 2.0 + relief
    profile = [(radius - 0.015, wall), (radius - 0.015, edge), (radius + width * 0.6, edge),
               (radius + width * 0.65, edge - relief * 0.5), (radius + width, edge - relief * 0.5),
               (radius + width, wall)]
    angle = np.linspace(np.pi, 0.0, ARC_SEGMENTS + 1)
    points = np.array([
        np.stack([r * np.cos(angle), spring + r * np.sin(angle), np.full_like(angle, z)], axis=1) for r, z in profile
    ])
    near, far = points[:-1], points[1:]
    corners = np.stack([near[:, :-1], near[:, 1:], far[:, 1:], far[:, :-1]], axis=2).reshape(-1, 4, 3)
    along = angle[0] - angle
    across = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(profile, axis=0), axis=1))])
    u, v = np.broadcast_arrays(along * radius, -across[:, None])
    uv = np.stack([u, v], axis=2)
    uvs = np.stack([uv[:-1, :-1], uv[:-1, 1:], uv[1:, 1:], uv[1:, :-1]], axis=2).reshape(-1, 4, 2)
    return quads(corners, uvs / tile, material=material, name=name)


def column(height: float, radius: float, *, material: int = 0, name: str = "") -> Mesh:
    """A round column with plinth, base, tapering shaft, bell capital and abacus; `height` includes them all."""
    r, plinth, abacus = radius, 0.14, 0.12
    block = 1.42 * r
    bell = height - abacus - 1.7 * r
    low = [(1.36 * r, plinth), (1.40 * r, plinth + 0.04), (1.36 * r, plinth + 0.08), (1.15 * r, plinth + 0.10),
           (1.12 * r, plinth + 0.12), (1.20 * r, plinth + 0.15), (1.15 * r, plinth + 0.19), (r, plinth + 0.21)]
    shaft = [(r * (1.0 - 0.14 * t**1.6), plinth + 0.21 + t * (bell - plinth - 0.21)) for t in (0.3, 0.6, 0.85, 1.0)]
    neck = [(0.96 * r, bell), (0.97 * r, bell + 0.05), (0.88 * r, bell + 0.06)]
    rise = height - abacus - bell - 0.06
    curve = [(r * (0.88 + 0.48 * t**2.2), bell + 0.06 + t * rise) for t in (0.3, 0.6, 0.8, 1.0)]
    profile = [*low, low[-1], *shaft, shaft[-1], *neck, neck[-1], *curve]
    parts = [
        box((-block, 0.0, -block), (block, plinth, block), material=material, name=name),
        revolve(profile, segments=20, material=material),
        box((-block, height - abacus, -block), (block, height, block), material=material),
    ]
    return merge(parts, name)


def balustrade(length: float, height: float, count: int, *, material: int = 0, name: str = "") -> Mesh:
    """A handrail on `count` turned balusters, `length` long in x, centred on x = 0 and z = 0."""
    turned = [(0.062, 0.10), (0.050, 0.16), (0.075, 0.30), (0.060, 0.45), (0.034, 0.62), (0.045, 0.74), (0.060, 0.80)]
    scale = (height - 0.12) / 0.80
    profile = [(r, 0.10 + (y - 0.10) * (scale * 0.80 - 0.10) / 0.70) for r, y in turned]
    baluster = revolve(profile, segments=8, material=material)
    half = length / 2.0
    parts = [box((-half, 0.0, -0.13), (half, 0.10, 0.13), material=material, name=name),
             box((-half, height - 0.12, -0.15), (half, height, 0.15), material=material)]
    step = length / count
    parts += [moved(baluster, (-half + (i + 0.5) * step, 0.0, 0.0)) for i in range(count)]
    return merge(parts, name)


def curtain(
    width: float, height: float, folds: float, *, seed: int = 0, repeats: float = 1.0, gather: float = 0.0,
    material: int = 0, name: str = "",
) -> Mesh:
    """Hanging cloth, centred on x = 0, from y = 0 down to -height, its folds deepening downwards.

    folds: waves over the width.  repeats: of the texture over the width; it repeats once over the height.
    gather: how far the cloth is drawn in at 60 % of the height, as a share of the width.
    """
    phase = np.random.default_rng(seed).uniform(0.0, 2.0 * np.pi, 3)
    s, t = np.meshgrid(np.linspace(0.0, 1.0, round(folds * 16) + 1), np.linspace(1.0, 0.0, 17))
    wave = 2.0 * np.pi * folds * s
    # The folds are irregular: their phase wanders over the width and a little over the height.
    wave = wave + 0.8 * np.sin(2.0 * np.pi * s + phase[0]) + 0.5 * t * np.sin(5.0 * s + phase[1])
    depth = (0.035 + 0.055 * np.sqrt(t)) * (1.0 + 0.25 * np.sin(3.0 * np.pi * s + phase[2]))
    waist = 1.0 - gather * np.exp(-(((t - 0.6) / 0.22) ** 2))
    x = (s - 0.5) * width * waist + 0.12 * depth * waist * np.sin(2.0 * wave)
    y = -height * t - 0.02 * np.cos(wave) * t
    points = np.stack([x, y, depth * np.sin(wave)], axis=2)
    return grid(points, np.stack([s * repeats, t], axis=2), material=material, name=name)


def moved(mesh: Mesh, offset=(0.0, 0.0, 0.0), *, quarter_turns: int = 0, name: str | None = None) -> Mesh:
    """The mesh turned about y by quarter turns (counter-clockwise seen from above), then moved by `offset` (3,)."""
    cosine, sine = ((1, 0), (0, 1), (-1, 0), (0, -1))[quarter_turns % 4]
    turn = np.array([[cosine, 0, sine], [0, 1, 0], [-sine, 0, cosine]], dtype=np.float32)
    return replace(
        mesh,
        positions=mesh.positions @ turn.T + np.asarray(offset, dtype=np.float32),
        normals=mesh.normals @ turn.T,
        tangents=np.concatenate([mesh.tangents[:, :3] @ turn.T, mesh.tangents[:, 3:]], axis=1),
        name=mesh.name if name is None else name,
    )


def _arc(radius: float, spring: float) -> tuple[np.ndarray, np.ndarray]:
    angle = np.linspace(np.pi, 0.0, ARC_SEGMENTS + 1)
    return radius * np.cos(angle), spring + radius * np.sin(angle)


def _soffit(radius: float, spring: float, base: float, thickness: float, tile: float, material: int) -> Mesh:
    """The inside of the opening: the arch and, where the wall reaches below its spring, the two jambs."""
    x, y = _arc(radius, spring)
    along = np.linspace(0.0, np.pi * radius, len(x))
    edges = [np.stack([x, y, np.full_like(x, z)], axis=1) for z in (-thickness / 2.0, thickness / 2.0)]
    uvs = np.stack(np.broadcast_arrays(along, np.array([[thickness], [0.0]])), axis=2) / tile
    # Its front is below, so the rows run from the front of the wall to the back.
    arch = grid(edges[::-1], uvs[::-1], material=material)
    if base >= spring:
        return arch
    z, r = thickness / 2.0, radius
    jambs = [[(-r, base, z), (-r, base, -z), (-r, spring, -z), (-r, spring, z)],
             [(r, base, -z), (r, base, z), (r, spring, z), (r, spring, -z)]]
    return merge([arch, quads(jambs, tile=tile, material=material)])
