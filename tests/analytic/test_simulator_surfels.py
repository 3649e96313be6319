"""Samples of a scene's triangles (simulator/surfels.py): as many as areas say, exactly so for walls across an axis."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.surfels import lattice_samples


def areas(corners: np.ndarray) -> np.ndarray:
    return 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)


def places(corners: np.ndarray, numbers: np.ndarray, weights: np.ndarray) -> np.ndarray:
    edges = corners[numbers, 1:] - corners[numbers, :1]
    return corners[numbers, 0] + np.einsum("mi,mij->mj", weights, edges)


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("flipped", [False, True])
def test_each_square_of_a_wall_has_its_samples(axis, flipped):
    """Of a wall of two triangles across an axis, every square of the lattice one, in its middle; it stands for
    that."""
    flat = np.array([[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [0.0, 3.0]])
    wall = np.zeros((4, 3))
    wall[:, [(axis + 1) % 3, (axis + 2) % 3]] = flat
    wall[:, axis] = 0.7
    corners = wall[[[0, 1, 2], [0, 2, 3]]]
    if flipped:
        corners = corners[:, ::-1]
    numbers, weights, share = lattice_samples(corners, np.zeros(3), 0.25)
    found = places(corners, numbers, weights)
    np.testing.assert_allclose(found[:, axis], 0.7)
    lines = np.rint(found[:, [(axis + 1) % 3, (axis + 2) % 3]] / 0.25 - 0.5).astype(int)  # but for ASIDE
    assert len(np.unique(lines, axis=0)) == len(lines) == 16 * 12
    np.testing.assert_allclose(share * areas(corners)[numbers], 0.25**2)


def test_samples_stand_for_the_whole_area():
    """Of many small triangles anywhere, at any slant: their areas together, to the noise of as many samples, each of
    which stands for up to sqrt(3) times a square of the lattice."""
    rng = np.random.default_rng(1)
    corners = rng.uniform(0.0, 20.0, (20000, 1, 3)) + rng.normal(size=(20000, 3, 3)) * 0.05
    numbers, weights, share = lattice_samples(corners, [0.3, -0.2, 0.1], 0.1)
    sampled = share * areas(corners)[numbers]
    assert np.all(sampled <= 3**0.5 * 0.01 * (1 + 1e-9)) and np.all(sampled >= 0.01 * (1 - 1e-9))
    total = areas(corners).sum()
    assert abs(sampled.sum() - total) < 5.0 * np.sqrt(np.sum(sampled**2))
    assert np.all(weights >= 0.0) and np.all(weights.sum(axis=1) <= 1.0)


def test_large_and_many_triangles_come_in_parts():
    """More candidates than are tried at a time give what each triangle gives alone."""
    rng = np.random.default_rng(2)
    corners = rng.uniform(0.0, 3.0, (12, 3, 3))
    numbers, weights, share = lattice_samples(corners, np.zeros(3), 0.002)
    assert len(numbers) > 1 << 22
    for one in (0, 7, 11):
        _, alone, part = lattice_samples(corners[one : one + 1], np.zeros(3), 0.002)
        np.testing.assert_array_equal(alone, weights[numbers == one])
        np.testing.assert_array_equal(part, share[numbers == one])


def test_no_triangles_and_none_with_area():
    for corners in (np.zeros((0, 3, 3)), np.ones((2, 3, 3))):
        numbers, weights, share = lattice_samples(corners, np.zeros(3), 0.1)
        assert numbers.shape == (0,) and weights.shape == (0, 2) and share.shape == (0,)
