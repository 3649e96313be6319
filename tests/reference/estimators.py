"""Whether two Monte Carlo estimators have the same expectation.

A picture's estimator is given as K independent batches (K, height, width, 3), each the mean of many paths. Over a block
of 8 x 8 pixels a batch's mean is a mean of 64 times its samples a pixel, so near a normal distribution even where
single paths are rarely bright. The difference of two such means over its estimated standard error is then Student's t;
with unequal variances its degrees of freedom nu lie between K - 1 and 2 K - 2 (Welch 1947). t^2 has the F distribution
with 1 and nu degrees of freedom, so that over N blocks

    mean of t^2 = nu / (nu - 2) +- sqrt(2 nu^2 (nu - 1) / ((nu - 2)^2 (nu - 4)) / N)

and the largest |t| exceeds x with a probability of at most N P(|t_nu| > x). Tests allow FOUR_SIGMA for the mean, a
CHANCE of 1e-4 for the largest, and take the nu that is further from a failure.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
from scipy import stats

BLOCK = 8
FOUR_SIGMA = 4.0
CHANCE = 1e-4
MEAN_RATIO = 0.01


def z_scores(image_a: np.ndarray, var_a: np.ndarray, image_b: np.ndarray, var_b: np.ndarray) -> np.ndarray:
    """(a - b) / sqrt(var_a + var_b), element by element; var: variances of the means. 0 where both agree exactly
    and have no variance, infinite where they differ without one."""
    difference, error = image_a - image_b, np.sqrt(var_a + var_b)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(difference == 0, 0.0, difference / error)


def block_means(batches: np.ndarray, mask: np.ndarray | None = None, block: int = BLOCK) -> np.ndarray:
    """Means over blocks of `block` x `block` pixels of (K, height, width, 3): (K, blocks, 3). Only whole blocks
    whose pixels are all in `mask` (height, width) count."""
    count, height, width, channels = batches.shape
    rows, columns = height // block, width // block
    whole = np.ones((height, width), bool) if mask is None else mask
    keep = whole[: rows * block, : columns * block].reshape(rows, block, columns, block).all(axis=(1, 3))
    cut = batches[:, : rows * block, : columns * block].reshape(count, rows, block, columns, block, channels)
    return cut.mean(axis=(2, 4))[:, keep]


def mean_and_variance(batches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Of independent estimates (K, ...): their mean and the variance of that mean, (...)."""
    return batches.mean(axis=0), batches.var(axis=0, ddof=1) / len(batches)


def assert_ratio_of_means(a: np.ndarray, b: np.ndarray) -> None:
    """Means of whole pictures within 1 %. Batches (K, ...); the samples have to be so many that the ratio's own
    standard error is a third of that, or the test would say nothing."""
    (mean_a, var_a), (mean_b, var_b) = (mean_and_variance(x.reshape(len(x), -1).mean(axis=1)) for x in (a, b))
    error = sqrt(var_a / mean_a**2 + var_b / mean_b**2)
    assert 3.0 * error < MEAN_RATIO, f"too few samples: the ratio is uncertain by {error:.2%}"
    assert abs(mean_a / mean_b - 1.0) < MEAN_RATIO, f"ratio of means {mean_a / mean_b:.4f} +- {error:.4f}"


def assert_same_expectation(a: np.ndarray, b: np.ndarray, mask: np.ndarray | None = None, block: int = BLOCK) -> None:
    """Batches of pictures `a` and `b`, or one exact picture `b` (height, width, 3): the t values of their blocks are
    distributed as those of two estimators of the same picture. See the top of this file."""
    exact = b.ndim == 3
    count = len(a) if exact else min(len(a), len(b))
    low, high = count - 1, count - 1 if exact else 2 * count - 2
    blocks_a, blocks_b = block_means(a, mask, block), block_means(b[None] if exact else b, mask, block)
    (mean_a, var_a) = mean_and_variance(blocks_a)
    mean_b, var_b = (blocks_b[0], np.zeros_like(var_a)) if exact else mean_and_variance(blocks_b)
    t = z_scores(mean_a, var_a, mean_b, var_b)
    for channel in range(3):
        lit = (var_a + var_b)[:, channel] + np.abs(mean_a - mean_b)[
            :, channel
        ] > 0  # what is black in both says nothing
        _assert_student(t[lit, channel], low, high, "RGB"[channel])


def _assert_student(t: np.ndarray, low: int, high: int, name: str) -> None:
    assert len(t) >= 16, f"only {len(t)} blocks"
    most = float(stats.t.isf(CHANCE / len(t) / 2.0, low))
    assert np.abs(t).max() < most, f"{name}: largest |t| is {np.abs(t).max():.2f}, at most {most:.2f}"
    square = float(np.mean(t * t))
    largest = low / (low - 2) + FOUR_SIGMA * _spread(low, len(t))
    smallest = high / (high - 2) - FOUR_SIGMA * _spread(high, len(t))
    assert smallest < square < largest, f"{name}: mean t^2 is {square:.2f}, not {smallest:.2f} to {largest:.2f}"


def _spread(nu: int, blocks: int) -> float:
    """Standard deviation of the mean of t^2 over independent blocks."""
    return sqrt(2.0 * nu**2 * (nu - 1) / ((nu - 2) ** 2 * (nu - 4)) / blocks)
