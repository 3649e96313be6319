"""Rays marched through cells that hold surfaces (simulator/lpv/glossy.py) against closed forms."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.brdf import alpha_of
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import glossy
from octolux.simulator.lpv.geometry import BEHIND
from octolux.simulator.lpv.glossy import FORGETS, LEFT, MET, NEAR, Surfaces
from octolux.simulator.lpv.injection import inject
from octolux.simulator.reflection import CONE, reflected_direction

N, H = 16, 0.25
GRID = Grid((0.0, 0.0, 0.0), H, N)
L = np.array([3.0, 1.0, 0.25])  # W/(m^2 sr)
SAMPLES = 8  # surfels along each edge of a cell
MOST_LOST = 0.15  # of even light: less is not seen as darkness


def square(axis: int, place: float, facing: float, low: float = 0.0, high: float = N) -> tuple[np.ndarray, np.ndarray]:
    """Surfels (points in cells, normals) of a square across `axis` at `place`, `low` to `high` along the others."""
    middle = np.arange(low + 0.5 / SAMPLES, high, 1.0 / SAMPLES)
    points = np.empty((len(middle), len(middle), 3))
    points[..., axis] = place
    points[..., (axis + 1) % 3], points[..., (axis + 2) % 3] = np.meshgrid(middle, middle)
    return points.reshape(-1, 3), np.tile(facing * np.eye(3)[axis], (points.size // 3, 1))


def room(low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
    """Surfels of a cube's six walls, facing inwards."""
    walls = [square(axis, p, f, low, high) for axis in range(3) for p, f in ((low, 1.0), (high, -1.0))]
    points, normals = zip(*walls, strict=True)
    return np.concatenate(points), np.concatenate(normals)


def surfaces(points, normals, radiance=L, *, known: bool = True, blocks: bool = True) -> list[Surfaces]:
    """All levels down to 4^3 cells. radiance: (3,), or (M, 3) of each surfel.  known: their areas are; blocks: their
    planes do."""
    area = np.full(len(points), 1.0 / SAMPLES**2)
    light = inject(H * points, normals, pi * np.broadcast_to(radiance, points.shape) * area[:, None] * H**2, GRID)
    towards = np.stack([np.maximum(normals, 0.0), np.maximum(-normals, 0.0)], axis=-1).reshape(-1, 6) ** 2
    squares = summed(points + 0.5 * normals, towards * area[:, None])
    behind = points - BEHIND * normals
    sums = summed(behind, np.abs(normals) * area[:, None])
    moments = summed(behind, np.abs(normals) * area[:, None] * (behind % 1.0))
    if not known:
        squares[:] = 0.0
    result: list[Surfaces] = []
    for i in range(3):
        n = N >> i
        if i:
            light = light.reshape(n, 2, n, 2, n, 2, 3, 4).sum(axis=(1, 3, 5))
            z, y, x = np.indices((2 * n,) * 3) % 2
            moments = 0.25 * 0.5 * (moments + sums * np.stack([x, y, z], axis=-1))
            sums, moments = (v.reshape(n, 2, n, 2, n, 2, 3).sum(axis=(1, 3, 5)) for v in (0.25 * sums, moments))
        made = glossy.surface_light(light, glossy.coarser_squares(squares, i) if i else squares, H * 2**i)
        plane = moments / np.where(sums > 0.0, sums, 1.0)
        blocked = np.minimum(1.0, sums) if blocks else np.zeros_like(sums)
        result.append(Surfaces(*made, blocked, plane, (0, 0, 0), np.zeros(3), np.full(3, n)))
    return result


def summed(points, values) -> np.ndarray:
    cells = np.floor(points).astype(int)
    kept = np.all((cells >= 0) & (cells < N), axis=-1)
    result = np.zeros((N, N, N, values.shape[1]))
    x, y, z = cells[kept].T
    np.add.at(result, (z, y, x), values[kept])
    return result


def rays(count: int, low: float, high: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """From anywhere between `low` and `high` along each axis, in any direction."""
    rng = np.random.default_rng(seed)
    v = rng.normal(size=(count, 3))
    return rng.uniform(low, high, (count, 3)), v / np.linalg.norm(v, axis=1, keepdims=True)


def least_cover(rate: np.ndarray) -> np.ndarray:
    """What a tent's samples, `rate` cells apart, add up to at least of its integral, wherever the first lies."""
    offsets = np.arange(-1.0, 1.0, 1.0 / 64)[:, None] * rate
    samples = offsets[..., None] + rate[:, None] * np.arange(-64, 65)
    inside = np.maximum(0.0, 1.0 - np.abs(samples)).sum(axis=-1) * rate
    return np.minimum(1.0, inside.min(axis=0))


@pytest.mark.parametrize("place", [12.0, 12.05, 12.3, 12.45, 12.5, 12.95])
@pytest.mark.parametrize("known", [True, False])
def test_a_wall_that_fills_the_view_shows_its_radiance(place, known):
    """Wherever it lies in its cells, at every slant, with and without its area, and when its light is gathered from
    coarser cells: but for what samples of a tent lack, and what is no longer followed."""
    start, towards = rays(400, 3.0, 8.0)
    towards[:, 0] = np.abs(towards[:, 0])
    hits = start + towards * ((place - start[:, 0]) / towards[:, 0])[:, None]
    inside = np.all((hits[:, 1:] > 2.0) & (hits[:, 1:] < N - 2.0), axis=-1)  # where neither filters nor lobes end
    levels = surfaces(*square(0, place, -1.0), known=known)
    for roughness in (0.0, 0.5):
        found = glossy.march(levels, start[inside], towards[inside], roughness, 0)
        share = found.radiance / L
        least = least_cover(towards[inside, 0] / np.abs(towards[inside]).max(axis=-1))
        assert np.all(share <= 1.0 + 1e-9)
        assert np.all(share >= least[:, None] - LEFT - 1e-9), (share[:, 0] - least).min()
    assert inside.sum() > 40 and least.mean() > 0.98


def test_a_wall_across_the_way_is_covered_by_its_light_alone():
    """Without planes: a tent's samples, one a cell, add up to 1, wherever they lie. SHORT moves none of them."""
    start, _ = rays(50, 3.0, 8.0)
    levels = surfaces(*square(2, 12.3, -1.0), blocks=False)
    found = glossy.march(levels, start, np.tile([0.0, 0.0, 1.0], (50, 1)), 0.0, 0)
    np.testing.assert_allclose(found.radiance, np.tile(L, (50, 1)), rtol=LEFT + 1e-9)


@pytest.mark.parametrize("low", [2.0, 2.3, 2.6])
def test_white_furnace(low):
    """In a room whose walls all have the radiance L no ray brings more, whatever corners it sees; and on average little
    less (measured: 2.3 % at most), from half a cell off the walls on, where looked up points lie. What is lost goes out
    where walls meet: a step reads one cell, and a ray may leave between two."""
    start, towards = rays(2000, low + 0.5, N - low - 0.5)
    levels = surfaces(*room(low, N - low))
    for roughness, step in ((0.0, 1.0), (0.0, 0.5), (0.6, 1.0)):
        found = glossy.march(levels, start, towards, roughness, 0, step=step).radiance / L
        assert found.max() <= 1.0 + 1e-9
        assert found.mean() >= 1.0 - MOST_LOST, found.mean()


def test_white_furnace_at_a_slant():
    """A room turned against the cells, whose walls are stairs of planes (measured: 1.8 % are lost)."""
    c, s = np.cos(0.6), np.sin(0.6)
    turn = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ np.array([[1, 0, 0], [0, c, s], [0, -s, c]])
    points, normals = room(3.0, N - 3.0)
    start, towards = rays(2000, 5.0, N - 5.0)
    levels = surfaces((points - 8.0) @ turn.T + 8.0, normals @ turn.T)
    found = glossy.march(levels, (start - 8.0) @ turn.T + 8.0, towards, 0.0, 0).radiance / L
    assert found.max() <= 1.0 + 1e-9
    assert found.mean() >= 1.0 - MOST_LOST, found.mean()


def test_no_light_is_created():
    """Of any light and any surfaces a ray brings at most the brightest cell's radiance."""
    rng = np.random.default_rng(3)
    area = rng.uniform(0.0, 1.0, (N, N, N, 6)) * (rng.random((N, N, N, 1)) < 0.2)
    light = sh.cosine_lobe([0.0, 0.0, 1.0]) * (rng.random((N, N, N, 3, 1)) * (area.sum(axis=-1) > 0)[..., None, None])
    made = glossy.surface_light(light, area, H)
    brightest = made[0].max(axis=(0, 1, 2))
    blocked, plane = rng.random((2, N, N, N, 3))
    level = Surfaces(*made, blocked * (area.sum(axis=-1) > 0)[..., None], plane, (0, 0, 0), np.zeros(3), np.full(3, N))
    start, towards = rays(2000, 0.0, N)
    found = glossy.march([level], start, towards, 0.0, 0).radiance
    assert np.all(found <= brightest + 1e-12) and found.max() > 0.5 * brightest.min()


@pytest.mark.parametrize("step", [1.0, 0.5, 0.25])
def test_a_gradient_is_seen_where_it_lies(step):
    """A wall whose radiance grows along y by g a cell: what a ray brings is that of a place at most 5/2 cells before
    the plane on its way, whatever the step: the wall's light is a cell before it at most, a tent reaches one cell
    farther and half a cell is looked ahead; and by half a cell of the cells' size along y."""
    points, normals = square(0, 12.3, -1.0)
    g = 0.1
    levels = surfaces(points, normals, g * points[:, 1:2] * np.ones(3))
    start, towards = rays(300, 4.0, 8.0)
    towards[:, 0] = np.abs(towards[:, 0]) + 0.3
    towards /= np.linalg.norm(towards, axis=1, keepdims=True)
    slope = towards[:, 1] / towards[:, 0]
    hit = start + towards * ((12.3 - start[:, 0]) / towards[:, 0])[:, None]
    inside = np.all((hit[:, 1:] > 3.0) & (hit[:, 1:] < N - 3.0), axis=-1)
    found = glossy.march(levels, start, towards, 0.0, 0, step=step).radiance[:, 0]
    error = np.abs(found - g * hit[:, 1])[inside]
    assert np.all(error <= g * (2.5 * np.abs(slope[inside]) + 0.5) + LEFT * g * N) and inside.sum() > 100


def test_behind_a_surface_that_shows_its_back_it_is_dark():
    """A wall that faces away, lit or not, hides the lit one behind it."""
    one, other = square(0, 9.4, 1.0), square(0, 13.4, -1.0)
    levels = surfaces(*(np.concatenate(pair) for pair in zip(one, other, strict=True)))
    start, towards = rays(300, 3.0, 6.0)
    towards[:, 0] = np.abs(towards[:, 0])
    hits = start + towards * ((9.4 - start[:, 0]) / towards[:, 0])[:, None]
    inside = np.all((hits[:, 1:] > 0.5) & (hits[:, 1:] < N - 0.5), axis=-1)
    found = glossy.march(levels, start[inside], towards[inside], 0.0, 0)
    # What surrounds the start counts as met, less and less in the three steps to the wall at least.
    assert found.radiance.max() == 0.0 and found.left.max() <= MET * NEAR * FORGETS**3 and inside.sum() > 50


def test_the_other_side_of_a_thin_wall_does_not_shine_through():
    """Its surfaces are in the next cell, a hundred times as bright, within reach of the filter."""
    dark, bright = square(0, 12.3, -1.0), square(0, 12.4, 1.0)
    radiance = np.repeat([[0.01, 0.01, 0.01], [1.0, 1.0, 1.0]], len(dark[0]), axis=0)
    levels = surfaces(*(np.concatenate(pair) for pair in zip(dark, bright, strict=True)), radiance)
    start, towards = rays(300, 4.0, 9.0)
    towards[:, 0] = np.abs(towards[:, 0])
    hits = start + towards * ((12.3 - start[:, 0]) / towards[:, 0])[:, None]
    inside = np.all((hits[:, 1:] > 2.0) & (hits[:, 1:] < N - 2.0), axis=-1)
    found = glossy.march(levels, start[inside], towards[inside], 0.0, 0)
    assert found.radiance.max() <= 0.01 * (1.0 + 1e-9) and found.radiance.mean() > 0.0098 and inside.sum() > 50


def test_what_leaves_the_volume_sees_nothing():
    start, towards = rays(50, 4.0, 8.0)
    found = glossy.march(surfaces(*square(0, 12.3, -1.0)), start, -np.abs(towards), 0.0, 0)
    assert (found.radiance == 0.0).all() and (found.left == 1.0).all()


def test_few_cells_are_gone_through():
    """The wall is beyond four cells, and within twelve."""
    start = np.tile([3.0, 8.0, 8.0], (1, 1))
    levels = surfaces(*square(0, 12.3, -1.0))
    for cells, share in ((4, 0.0), (12, 1.0)):
        found = glossy.march(levels, start, [[1.0, 0.0, 0.0]], 0.0, 0, cells=cells)
        np.testing.assert_allclose(found.radiance[0], share * L, rtol=LEFT + 1e-9)
        assert found.steps[0] <= cells


def test_lobes_are_resolved_by_cells_of_their_width():
    """A tent of cells of CONE alpha d has the variance of a square that holds the lobe's solid angle, 4 pi alpha^2."""
    alpha = float(alpha_of(0.3))
    square_variance = 4.0 * pi * alpha**2 / 12.0
    assert (CONE * alpha) ** 2 / 6.0 == pytest.approx(square_variance)


def test_reflected_directions():
    """Mirrors reflect, rough surfaces towards their normal, and none below the surface."""
    _, normal = rays(500, 0, 1, seed=1)
    _, to_eye = rays(500, 0, 1, seed=2)
    _, tilt = rays(500, 0, 1, seed=4)
    to_eye *= np.sign(np.sum(to_eye * normal, axis=-1, keepdims=True))
    mirror = reflected_direction(to_eye, normal, normal, 0.0)
    half = mirror + to_eye
    np.testing.assert_allclose(np.cross(half, normal), 0.0, atol=2 * float(alpha_of(0.0)))
    geometric = normal + 0.8 * tilt
    geometric /= np.linalg.norm(geometric, axis=-1, keepdims=True)
    for roughness in (0.0, 0.5, 1.0):
        found = reflected_direction(to_eye, normal, geometric, roughness)
        assert np.all(np.sum(found * geometric, axis=-1) >= -1e-12)
        np.testing.assert_allclose(np.linalg.norm(found, axis=-1), 1.0)
    np.testing.assert_allclose(reflected_direction(to_eye, normal, normal, 1.0), normal)


def test_the_papers_mean():
    """In even light of intensity I from everywhere: I / (d^2) averaged over d of 1, 2, 3 and 4 cells."""
    light = np.zeros((N, N, N, 3, 4))
    light[..., 0] = L / sh.Y0
    start, towards = rays(20, 5.0, 11.0)
    found = glossy.paper_light(light, start, towards, 4, H)
    np.testing.assert_allclose(found, np.tile(L * (1 + 1 / 4 + 1 / 9 + 1 / 16) / 4 / H**2, (20, 1)))
