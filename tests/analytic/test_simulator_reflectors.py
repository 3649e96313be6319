"""Reflectors of the geometry volume (simulator/lpv/reflectors.py): closed forms."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.environment import LUMINANCE
from octolux.simulator.grid import Grid
from octolux.simulator.lpv.geometry import inject_surfels
from octolux.simulator.lpv.reflectors import MOST_WALLS, inject_places, inject_reflectors, merge_reflectors

GRID = Grid((0.0, 0.0, 0.0), 0.5, 4)


def sphere(count: int, centre, radius: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Surfels (position, normal, area) of a sphere: bands of equal height have equal areas (Archimedes)."""
    height = (np.arange(count) + 0.5) / count * 2.0 - 1.0
    angle = (np.arange(count) + 0.5) / count * 2.0 * np.pi
    z, phi = np.meshgrid(height, angle, indexing="ij")
    ring = np.sqrt(1.0 - z**2)
    normal = np.stack([ring * np.cos(phi), ring * np.sin(phi), z], axis=-1).reshape(-1, 3)
    return centre + radius * normal, normal, np.full(count**2, 4 * np.pi * radius**2 / count**2)


def test_a_sphere_faces_every_way_by_its_cross_section():
    """pi r^2 towards each of the six axes; the midpoint rule in both angles errs with 1 / count^2."""
    position, normal, area = sphere(400, (0.75, 0.75, 1.25), 0.2)
    shares, tints = inject_reflectors(position, normal, area, np.full((len(area), 3), 0.5), GRID, 0.0)
    np.testing.assert_allclose(shares[2, 1, 1], np.pi * 0.2**2 / 0.25, rtol=1e-4)
    assert tints[2, 1, 1] == pytest.approx([2 * np.pi * 0.04 / 0.25] * 3 + [4 * np.pi * 0.04 / 0.25])
    assert np.count_nonzero(shares) == 6


def test_both_directions_together_are_what_the_geometry_volume_blocks():
    rng = np.random.default_rng(1)
    position, normal = rng.uniform(0, 2, (200, 3)), rng.normal(size=(200, 3))
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    area, offset = rng.uniform(0, 0.01, 200), -(2.0**-8)
    shares, _ = inject_reflectors(position, normal, area, np.ones((200, 3)), GRID, offset)
    np.testing.assert_allclose(shares[..., ::2] + shares[..., 1::2], inject_surfels(position, normal, area, GRID))


def test_a_wall_is_in_the_cell_before_it_or_behind_it():
    wall = [[0.75, 0.75, 1.0]], [[0.0, 0.0, 1.0]], [0.25], [[0.1, 0.2, 0.3]]
    for offset, layer in ((0.5, 2), (-(2.0**-8), 1)):
        shares, _ = inject_reflectors(*wall, GRID, offset)
        assert shares[layer, 1, 1].tolist() == [0, 0, 0, 0, 1, 0] and np.count_nonzero(shares) == 1


def test_shares_are_the_most_of_any_buffer_and_albedos_the_mean_of_all():
    """Two lamps see parts of a wall, the second the more and the redder."""
    one = inject_reflectors([[0.2] * 3], [[1.0, 0.0, 0.0]], [0.05], [[0.0, 0.6, 0.0]], GRID, 0.0)
    two = inject_reflectors([[0.3] * 3], [[1.0, 0.0, 0.0]], [0.15], [[0.8, 0.2, 0.0]], GRID, 0.0)
    cell = merge_reflectors([one, two])[0, 0, 0]
    assert cell[:2].ravel() == pytest.approx([0.15 / 0.25] + [0.0] * 7)
    mean = np.array([0.6, 0.3, 0.0])
    assert cell[2] == pytest.approx([*mean, mean @ LUMINANCE])


def test_more_than_a_wall_closes_a_cell_but_counts_in_the_mean():
    surfels = [[0.2] * 3] * 2, [[1.0, 0.0, 0.0]] * 2, [0.25 * 3, 0.25 * 2 * MOST_WALLS], [[0.5] * 3, [1.0] * 3]
    cell = merge_reflectors([inject_reflectors(*surfels, GRID, 0.0)])[0, 0, 0]
    assert cell[0, 0] == 1.0
    assert cell[2, 0] == pytest.approx((0.5 * 3 + MOST_WALLS) / (3 + MOST_WALLS))


def test_places_are_those_of_the_surfaces():
    """By area, of what has been moved into the cell before it: three parts a tenth of a cell behind its lower side, one
    a tenth above. Elsewhere 0."""
    position = np.array([[0.7, 0.8, 0.95], [0.7, 0.8, 1.05]])
    area, normal = [0.03, 0.01], np.tile([0.0, 0.0, 1.0], (2, 1))
    places = inject_places(position, normal, area, GRID, 0.5)
    np.testing.assert_allclose(places[2, 1, 1], [-0.1, 0.1, -0.5 - 0.75 * 0.1 + 0.25 * 0.1], rtol=1e-12)
    assert np.count_nonzero(places) == 3
    behind = inject_places(position, normal, area, GRID, -(2.0**-8))
    np.testing.assert_allclose(behind[1:3, 1, 1, 2], [0.4, -0.4], rtol=1e-12)


def test_surfels_beyond_the_grid_have_no_place():
    assert not inject_places(np.full((1, 3), -0.3), [[1.0, 0.0, 0.0]], [0.1], GRID, 0.5).any()
