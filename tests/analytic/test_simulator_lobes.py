"""Gaussian lobes of voxels (simulator/voxels/lobes.py) against closed forms."""

from __future__ import annotations

import numpy as np
from gpu_tools import random_directions

from octolux.simulator.voxels.facing import FacingVoxels
from octolux.simulator.voxels.lobes import LEAST, LobeVoxels, lobes_of, shares_of_ways
from octolux.simulator.voxels.surfaces import DIRECTIONS

RADIANCE = np.array([3.0, 1.0, 0.25])
COUNT = 500


def inside_ball(rng: np.random.Generator, count: int = COUNT) -> np.ndarray:
    """Mean vectors, no longer than 1."""
    return random_directions(rng, count) * rng.random((count, 1))


def seen(facing: np.ndarray, comes_from: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Radiance that is seen from v, over the mean of all ways."""
    against = np.maximum(v @ DIRECTIONS.T, 0.0)
    sent = np.sum(against * shares_of_ways(facing, comes_from), axis=1)
    return sent / np.sum(against * facing, axis=1) * facing.sum(axis=1)


def test_all_light_is_sent_by_what_faces_there():
    rng = np.random.default_rng(1)
    facing = rng.random((COUNT, 6)) * (rng.random((COUNT, 6)) < 0.5)
    facing[:, 0] += 0.1
    shares = shares_of_ways(facing, inside_ball(rng))
    np.testing.assert_allclose(shares.sum(axis=1), 1.0, rtol=1e-12)
    assert (shares >= 0.0).all() and not shares[facing == 0.0].any()


def test_even_light_stays_even():
    rng = np.random.default_rng(2)
    facing = rng.random((COUNT, 6)) + 0.01
    np.testing.assert_allclose(seen(facing, np.zeros((COUNT, 3)), random_directions(rng, COUNT)), 1.0, rtol=1e-12)


def test_a_curtain_sends_from_each_side_what_that_receives():
    """Across an axis, seen from both sides: E(n) - E(-n) is the light's mean along n, and together they are twice the
    mean of both; nothing goes through of light from one direction, but for what rounding is allowed."""
    rng = np.random.default_rng(3)
    light = inside_ball(rng)
    facing = np.tile([0.0, 0.0, 0.8, 0.8, 0.0, 0.0], (COUNT, 1))
    shares = shares_of_ways(facing, light)
    both = np.abs(light[:, 1]) + 0.5 * (1.0 - np.linalg.norm(light, axis=1))
    clear = both > 4.0 * LEAST
    np.testing.assert_allclose((shares[:, 2] - shares[:, 3])[clear], (light[:, 1] / both)[clear], atol=LEAST / 0.004)
    beam = shares_of_ways(facing[:1], np.array([[0.6, 0.8, 0.0]]))[0]
    np.testing.assert_allclose(beam[3] / beam[2], LEAST / 0.8, rtol=1e-9)


def test_a_ball_sends_back_to_the_light():
    """Light along an axis meets the one of six sides that faces it: from there 6 times the mean is seen of all."""
    axis = np.array([[0.0, 0.0, 1.0]])
    np.testing.assert_allclose(seen(np.ones((1, 6)), axis, axis), 6.0, rtol=6 * LEAST)


def both(depth: int, cells: np.ndarray, normals: np.ndarray, flux: np.ndarray, to_light: np.ndarray):
    """The same surfaces of unit area, as axial intensities and as lobes."""
    n = 2**depth
    facing, axial = np.zeros((n, n, n, 6)), np.zeros((n, n, n, 6, 3))
    light, moment = np.zeros((n, n, n, 3)), np.zeros((n, n, n, 3))
    along = np.maximum(normals @ DIRECTIONS.T, 0.0)
    x, y, z = cells.T
    facing[z, y, x], axial[z, y, x] = along, along[..., None] * flux[:, None]
    light[z, y, x], moment[z, y, x] = lobes_of(normals, flux, to_light)
    return FacingVoxels(facing, axial), LobeVoxels(facing, light, moment)


def test_flat_walls_send_what_axial_intensities_send():
    """Under a beam a wall of any slope: voxels of one normal. Light is the sum of the six."""
    rng = np.random.default_rng(4)
    cells = np.argwhere(np.ones((8, 8, 8)))
    for normal in random_directions(rng, 5):
        each = [np.broadcast_to(v, (len(cells), 3)) for v in (normal, RADIANCE, random_directions(rng, 1)[0])]
        axial, lobes = both(3, cells, *each)
        for level in range(3):
            given = rng.uniform(0, 8, (COUNT, 3)), float(level), random_directions(rng, COUNT)
            for found, expected in zip(lobes(*given), axial(*given), strict=True):
                np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(lobes.levels[0][1], axial.levels[0][1].sum(axis=3), rtol=1e-12)


def test_a_furnace_is_even_on_all_levels():
    """Surfaces at random of one radiance, lit from everywhere: what is read has that radiance."""
    rng = np.random.default_rng(5)
    cells = np.unique(rng.integers(0, 16, (400, 3)), axis=0)
    normals = random_directions(rng, len(cells))
    _, lobes = both(4, cells, normals, np.broadcast_to(RADIANCE, normals.shape), np.zeros_like(normals))
    for level in (0.0, 0.5, 1.0, 2.0, 3.0):
        radiance, opacity = lobes(rng.uniform(0, 16, (COUNT, 3)), level, random_directions(rng, COUNT))
        np.testing.assert_allclose(radiance, opacity[:, None] * RADIANCE, rtol=1e-12, atol=1e-12)
        assert opacity.max() > 0.1
