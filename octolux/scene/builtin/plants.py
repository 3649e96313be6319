"""Trees, shrubs and hedges: branches are tubes, leaves are quadrilaterals with an alpha-masked picture of a twig."""

from __future__ import annotations

import numpy as np

from ..meshes import Mesh
from .round_shapes import rounded_path, tube
from .shapes import box, merge, quads

UP = np.array([0.0, 1.0, 0.0])


def twigs(feet, directions, lengths, rng: np.random.Generator, *, material: int = 0, name: str = "") -> Mesh:
    """One square quadrilateral for each twig, turned about its own axis by chance.

    feet: (n, 3), where a twig begins; directions: (n, 3), where it grows to, of any length; lengths: (n,), metres.
    """
    feet, along = np.asarray(feet, dtype=np.float64), np.asarray(directions, dtype=np.float64)
    along = along / np.linalg.norm(along, axis=1, keepdims=True)
    side = np.cross(along, rng.standard_normal(along.shape))
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    lengths = np.asarray(lengths)[:, None]
    half, up = 0.5 * lengths * side, lengths * along
    corners = np.stack([feet - half, feet + half, feet + half + up, feet - half + up], axis=1)
    uvs = np.broadcast_to([(0.0, 1.0), (1.0, 1.0), (1.0, 0.0), (0.0, 0.0)], (len(feet), 4, 2))
    return quads(corners, uvs, material=material, name=name)


def tree(seed: int, *, bark: int, leaf: int) -> list[Mesh]:
    """A broad-leaved tree about 4.8 m high, its trunk at the origin, with one strong bough level along +x at 2.5 m.

    Returns the wood and about 6000 twigs.
    """
    rng = np.random.default_rng(seed)
    trunk = np.array([(0.0, -0.1, 0.0), (0.03, 0.9, 0.02), (-0.04, 1.9, 0.03), (0.05, 2.9, -0.04), (0.0, 3.9, 0.02)])
    wood = [tube(rounded_path(trunk), np.linspace(0.19, 0.05, len(rounded_path(trunk))), sides=12, material=bark)]
    boughs = [np.array([(0.0, 2.25, 0.0), (0.5, 2.48, 0.02), (1.3, 2.52, 0.05), (2.2, 2.62, 0.1)])]
    for number in range(11):
        azimuth = 2.4 * number + 1.2  # the golden angle spreads them around
        rise = rng.uniform(0.2, 0.5) + 0.06 * number
        start = np.array([0.0, 1.95 + 0.17 * number, 0.0])
        length = rng.uniform(1.9, 2.5) * (1.0 - 0.045 * number)
        out = np.array([np.cos(azimuth) * np.cos(rise), np.sin(rise), np.sin(azimuth) * np.cos(rise)])
        boughs.append(start + np.linspace(0.0, 1.0, 4)[:, None] * length * out + _sag(length))
    feet, directions = [], []
    for number, bough in enumerate(boughs):
        path = rounded_path(bough)
        thick = 0.085 if number == 0 else 0.05
        wood.append(tube(path, np.linspace(thick, 0.2 * thick, len(path)), sides=8, material=bark))
        for _ in range(8):
            share = rng.uniform(0.3, 1.0)
            foot = path[int(share * (len(path) - 1))]
            branch = foot + np.linspace(0.0, 1.0, 3)[:, None] * (rng.normal(0.0, 0.42, 3) + 0.3 * UP)
            wood.append(tube(branch, np.linspace(0.018, 0.006, 3), sides=5, material=bark))
            feet.append(branch[-1] + (branch[0] - branch[-1]) * rng.random((62, 1)) + rng.normal(0.0, 0.11, (62, 3)))
            directions.append(rng.normal(0.0, 1.0, (62, 3)) + 0.25 * UP)
    count = sum(map(len, feet))
    leaves = twigs(np.concatenate(feet), np.concatenate(directions), rng.uniform(0.19, 0.33, count), rng,
                   material=leaf, name="leaves")
    return [merge(wood, "wood"), leaves]


def shrub(seed: int, count: int, radius: float, *, bark: int, leaf: int) -> list[Mesh]:
    """A round shrub on y = 0, of `count` twigs that grow outwards from a bundle of stems."""
    rng = np.random.default_rng(seed)
    outwards = rng.standard_normal((count, 3))
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    middle = np.array([0.0, 0.95 * radius, 0.0])
    feet = middle + outwards * radius * rng.uniform(0.45, 0.85, (count, 1)) * (1.0, 0.9, 1.0)
    feet[:, 1] = np.maximum(feet[:, 1], 0.03)
    directions = outwards + rng.normal(0.0, 0.45, (count, 3)) + 0.35 * UP
    stems = [tube([(0.0, -0.05, 0.0), middle * 0.6 + 0.2 * radius * out, middle + 0.7 * radius * out], 0.012, sides=5,
                  material=bark) for out in outwards[:14] * (1.0, 0.3, 1.0)]
    leaves = twigs(feet, directions, rng.uniform(0.16, 0.26, count), rng, material=leaf, name="leaves")
    return [merge(stems, "stems"), leaves]


def hedge(
    seed: int, length: float, width: float, height: float, density: float, *, core: int, leaf: int,
) -> list[Mesh]:
    """A clipped hedge along x, centred on x = 0 and z = 0: twigs on the faces of a box, `density` to the square metre,
    and a dark core that stands for the inside, which no light reaches."""
    rng = np.random.default_rng(seed)
    size = np.array([length, height, width])
    # Each twig on one of five faces, by their areas; none below.
    normals = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
    areas = np.array([height * width, height * width, length * width, length * height, length * height])
    count = round(density * float(areas.sum()))
    out = normals[rng.choice(5, count, p=areas / areas.sum())]
    inside = (rng.random((count, 3)) - 0.5) * size
    feet = np.where(out != 0.0, out * (size / 2.0 - rng.uniform(0.05, 0.14, (count, 1))), inside)
    feet[:, 1] += height / 2.0
    directions = out + rng.normal(0.0, 0.6, (count, 3)) + 0.3 * UP
    half = size / 2.0 - 0.12
    return [
        box((-half[0], 0.0, -half[2]), (half[0], height - 0.12, half[2]), material=core, name="core"),
        twigs(feet, directions, rng.uniform(0.17, 0.26, count), rng, material=leaf, name="leaves"),
    ]


def _sag(length: float) -> np.ndarray:
    """How far the four points of a bough hang below its chord and rise again towards its end."""
    return np.array([(0.0, 0.0, 0.0), (0.0, -0.02, 0.0), (0.0, 0.0, 0.0), (0.0, 0.08, 0.0)]) * length
