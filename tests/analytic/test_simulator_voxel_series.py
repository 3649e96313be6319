"""Bounces after the last that is followed (simulator/voxels/series.py)."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.voxels.series import MOST, gain


def bounced(operator: np.ndarray, first: np.ndarray, count: int) -> np.ndarray:
    """What each bounce brings, (count, n)."""
    brought = [first]
    for _ in range(count - 1):
        brought.append(operator @ brought[-1])
    return np.array(brought)


@pytest.mark.parametrize("albedo", [0.1, 0.5, 0.85])
@pytest.mark.parametrize("count", [3, 5])
def test_a_room_of_one_albedo(albedo, count):
    """Every bounce brings its albedo of the one before: the series is exact."""
    brings = albedo ** np.arange(count)
    found = gain(np.cumsum(brings)[:, None])
    np.testing.assert_allclose(brings.sum() + brings[-1] * found, 1.0 / (1.0 - albedo))


@pytest.mark.parametrize("seed", range(5))
def test_less_is_added_than_is_missing(seed):
    """Patches of one area with albedos of their own that see one another, some more than others: from even light, sums
    that albedos weigh stay below the truth, and come nearer to it than without."""
    rng = np.random.default_rng(seed)
    n, albedo = 12, rng.uniform(0.1, 0.9, 12)
    form = rng.uniform(0.0, 1.0, (n, n)) ** 4
    form = form + form.T
    form *= 0.95 / form.sum(axis=1).max()
    operator = form * albedo  # of what patches receive
    brought = bounced(operator, np.ones(n), 4)
    truth = albedo @ np.linalg.solve(np.eye(n) - operator, np.ones(n))
    sums = np.cumsum(brought @ albedo)
    found = sums[-1] + brought[-1] @ albedo * gain(sums[:, None])[0]
    assert sums[-1] < found <= truth * (1.0 + 1e-12)
    assert truth - found < 0.25 * (truth - sums[-1])


def test_of_each_color_and_never_too_much():
    """No light, two bounces alone, and walls that reflect everything."""
    assert not gain(np.zeros((3, 3))).any() and not gain([[1.0, 2.0, 3.0], [2.0, 3.0, 4.0]]).any()
    sums = np.array([[9.0, 1.0, 0.0], [9.5, 2.0, 0.0], [9.75, 3.0, 0.0]])
    np.testing.assert_allclose(gain(sums), [1.0, MOST / (1.0 - MOST), 0.0])
