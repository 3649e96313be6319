"""One estimate gives way to another by equal factors."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.blending import RATIO, moved_share

SHARES = np.linspace(0.0, 1.0, 41)


def between(one: float, other: float) -> np.ndarray:
    return other + moved_share(one, other, SHARES) * (one - other)


@pytest.mark.parametrize(("one", "other"), [(2.0, 2.0), (3.0, 2.0), (0.2, 3.0), (1.0, RATIO), (0.0, 0.0), (5.0, 4.997)])
def test_geometric_mean(one, other):
    """A ratio next to 1 is as good as 1: their means differ by half the square of the difference at most."""
    np.testing.assert_allclose(between(one, other), one**SHARES * other ** (1.0 - SHARES), rtol=1e-6)


@pytest.mark.parametrize(("one", "other"), [(1.0, 0.0), (0.0, 1.0), (1.0, 1e-3), (1e-3, 1.0)])
def test_beyond_the_ratio(one, other):
    """From one end to the other, always further, whatever the ratio: it has all of each at its end."""
    found = between(one, other)
    np.testing.assert_allclose(found[[0, -1]], [other, one], atol=1e-12)
    assert np.all(np.diff(found) * (one - other) > 0.0)
    assert np.abs(np.diff(found)).max() <= np.log(RATIO) * RATIO / (RATIO - 1.0) * np.diff(SHARES)[0]


def test_changes_by_equal_factors():
    """A 40th of the share is a 40th of the logarithm, where a mean by shares changes by as much as 15 % at once."""
    factors = between(7.0, 1.0)[1:] / between(7.0, 1.0)[:-1]
    np.testing.assert_allclose(factors, 7.0 ** (1.0 / 40.0), rtol=1e-12)
