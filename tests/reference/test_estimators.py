"""The comparison of estimators itself: it passes on equal expectations, also with rare bright paths, and sees 1 %."""

from __future__ import annotations

import numpy as np
import pytest
from estimators import assert_ratio_of_means, assert_same_expectation, block_means, z_scores

SHAPE = (16, 48, 64, 3)


def batches(seed: int, scale: float = 1.0, samples: int = 16) -> np.ndarray:
    """Means of `samples` paths of which one in ten is bright: mean `scale`, relative deviation 3 / sqrt(samples)."""
    rng = np.random.default_rng(seed)
    return rng.binomial(samples, 0.1, SHAPE) / samples * 10.0 * scale


def test_equal_expectations_pass():
    for seed in range(5):
        assert_same_expectation(batches(seed), batches(100 + seed, samples=64))
        assert_same_expectation(batches(seed), np.ones(SHAPE[1:]))
    assert_ratio_of_means(batches(1), batches(2))


def test_a_bias_fails():
    """A block's standard error is 3 / sqrt(16 * 64 * 16) = 2.3 %: 5 % everywhere, or 30 % in a block, shows."""
    with pytest.raises(AssertionError, match="mean t"):
        assert_same_expectation(batches(1, scale=1.05), batches(2))
    biased = batches(3)
    biased[:, 8:16, 8:16] *= 1.3
    with pytest.raises(AssertionError, match="largest"):
        assert_same_expectation(biased, np.ones(SHAPE[1:]))


def test_a_variance_that_is_not_there_fails():
    """Batches that are not independent look better than they are."""
    with pytest.raises(AssertionError, match="largest"):
        assert_same_expectation(np.repeat(batches(4)[:1], 16, axis=0) + 1e-9 * batches(5), np.ones(SHAPE[1:]))


def test_ratio_of_means():
    with pytest.raises(AssertionError, match="ratio of means"):
        assert_ratio_of_means(batches(1, scale=1.02), batches(2))
    with pytest.raises(AssertionError, match="too few samples"):
        assert_ratio_of_means(batches(1)[:, :4, :4], batches(2)[:, :4, :4])


def test_z_scores():
    found = z_scores(
        np.array([3.0, 1.0, 2.0]), np.array([3.0, 0.0, 0.0]), np.array([1.0, 1.0, 1.0]), np.array([1.0, 0, 0])
    )
    assert found.tolist() == [1.0, 0.0, np.inf]


def test_blocks_outside_the_mask_do_not_count():
    mask = np.ones((16, 16), bool)
    mask[3, 3] = False
    picture = np.arange(16.0 * 16 * 3).reshape(1, 16, 16, 3)
    found = block_means(picture, mask)
    assert found.shape == (1, 3, 3)
    assert np.array_equal(found[0, 0], picture[0, :8, 8:].mean(axis=(0, 1)))
