"""The samplers of paths: low-discrepancy points, and directions against their densities.

Chi-square tests have a significance of 1e-3 for all of this file together; seeds are fixed.
"""

from __future__ import annotations

from math import sqrt

import numpy as np
import pytest
from chi_square import TOGETHER, HemisphereBins, p_value
from gpu_tools import TESTS, one_stage, random_directions, read_buffer
from scipy import stats

from octolux.frame.shader_values import CONSTANTS
from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.passes import ComputePass
from octolux.simulator import brdf

ROW = 1 << 15
ROUNDING = 2.0**-23
DRAWS = 1 << 17
# Of pixels 2, of pairs and seeds 6, of the cosine and of triangles 1 each, of half vectors 9.
CHI_SQUARE_TESTS = 19
SIGNIFICANCE = TOGETHER / CHI_SQUARE_TESTS


def run(device, mode: str, inputs: np.ndarray, outputs: int) -> np.ndarray:
    data = np.ascontiguousarray(inputs, dtype=np.float32)
    given, result = device.buffer("given", data), device.buffer("result", size=len(data) * outputs * 4)
    kernel = ComputePass(
        device, "samplers", str(TESTS / "kernels" / "samplers.wgsl"),
        [storage("given", "f32"), storage_rw("result", "f32", "write")], workgroup=(64, 1, 1), threads=len(data),
        mode=mode, outputs=outputs, row=ROW, **CONSTANTS,
    )  # fmt: skip
    with one_stage(device) as stage:
        kernel.run(stage, (min(len(data), ROW), -(-len(data) // ROW)), given=given, result=result)
    return read_buffer(device, result)[: len(data) * outputs].reshape(len(data), outputs).astype(np.float64)


def points(device, x=0, y=0, index=0, seed=0, pair=0) -> np.ndarray:
    """Arguments broadcast; (..., 2)."""
    given = np.stack(np.broadcast_arrays(x, y, index, seed, pair), axis=-1)
    return run(device, "points", given.reshape(-1, 5), 2).reshape(*given.shape[:-1], 2)


def is_net(block: np.ndarray) -> bool:
    """Whether each elementary interval of area 1 / n holds one of the n = 2^k points (Niederreiter 1992, 4.1)."""
    k = len(block).bit_length() - 1
    for across in range(k + 1):
        cells = np.floor(block * [1 << across, 1 << (k - across)]).astype(int)
        if len(set(map(tuple, cells))) < len(block):
            return False
    return True


def test_points_of_a_pair_are_nets(device):
    """Every prefix of 2^k points, and every later block of as many: a (0,2)-sequence in base 2."""
    pixels = np.arange(6)[:, None, None]
    found = points(device, x=37 * pixels, y=5, seed=pixels, pair=np.arange(3)[:, None], index=np.arange(1024))
    assert found.min() >= 0 and found.max() < 1
    for sequence in found.reshape(-1, 1024, 2):
        assert all(is_net(sequence[: 1 << k]) for k in range(11))
        assert all(is_net(sequence[at : at + 64]) for at in range(0, 1024, 64))


def test_points_are_the_same_again_and_others_by_seed(device):
    index = np.arange(64)
    first, again = (points(device, x=3, y=4, index=index, seed=9) for _ in range(2))
    assert np.array_equal(first, again)
    for other in ({"seed": 8}, {"x": 4}, {"y": 3}, {"pair": 1}, {"x": 4, "y": 3}):
        changed = points(device, **{"x": 3, "y": 4, "index": index, "seed": 9, **other})
        assert np.mean(changed == first) < 0.05, other


def test_pixels_have_points_of_their_own(device):
    """Seeds of 32 bits, 65536 of them: half a coincidence is expected; more than five have a chance of 1.4e-5."""
    x, y = np.meshgrid(np.arange(256), np.arange(256))
    found = np.concatenate([points(device, x=x, y=y, index=i).reshape(-1, 2) for i in (0, 1)], axis=1)
    assert len(np.unique(found, axis=0)) >= len(found) - 5
    # First points are even over the pixels, and those of neighbours independent.
    counts = np.histogram2d(*found[:, :2].T, bins=16, range=[(0, 1)] * 2)[0]
    assert p_value(counts, np.full((16, 16), 1 / 256)) > SIGNIFICANCE
    row = found[:, 0].reshape(256, 256)
    counts = np.histogram2d(row[:, ::2].ravel(), row[:, 1::2].ravel(), bins=16, range=[(0, 1)] * 2)[0]
    assert p_value(counts, np.full((16, 16), 1 / 256)) > SIGNIFICANCE


@pytest.mark.parametrize("kind", ["pair", "x", "y", "seed", "pair, second", "far pair"])
def test_sequences_are_independent(device, kind):
    """The number of a pixel's pair against the same number of another pair, pixel or seed, over 4096 samples of each of
    16 pixels. Each is even by itself, so that a joint histogram has (8 - 1)^2 degrees of freedom."""
    index, pixel = np.arange(4096), np.arange(16)[:, None] * 7
    one = {"x": pixel, "y": 11, "index": index, "seed": 5, "pair": 2}
    name = kind.split(", ")[0].split()[-1]
    other = {**one, name: one[name] + (40 if kind == "far pair" else 1)}
    channel = int(kind == "pair, second")
    a, b = points(device, **one)[..., channel], points(device, **other)[..., channel]
    counts = np.zeros((8, 8))
    for mine, theirs in zip(a, b, strict=True):
        counts += np.histogram2d(mine, theirs, bins=8, range=[(0, 1)] * 2)[0]
    statistic = np.sum((counts - 1024.0) ** 2 / 1024.0)
    assert stats.chi2.sf(statistic, 49) > SIGNIFICANCE


def even(seed: int) -> np.ndarray:
    """Independent draws in the samplers' steps of 2^-24."""
    return np.random.default_rng(seed).integers(0, 1 << 24, (DRAWS, 2)) / (1 << 24)


def test_bases_are_orthonormal_and_right_handed(device):
    n = np.concatenate([np.eye(3), -np.eye(3), [[1e-4, 0, -1]], random_directions(np.random.default_rng(0), 5000)])
    n /= np.linalg.norm(n, axis=1, keepdims=True)
    found = run(device, "basis", n, 9)
    t, b = found[:, :3], found[:, 3:6]
    # Towards n.z = -1 the divisor 1 - |n.z| never is small: the sign takes the other pole.
    for products in ((t * t).sum(1) - 1, (b * b).sum(1) - 1, (t * b).sum(1), (t * n).sum(1), (b * n).sum(1)):
        assert np.abs(products).max() <= 8 * ROUNDING
    np.testing.assert_allclose(np.cross(t, b), n, atol=8 * ROUNDING)
    assert np.abs(found[:, 6:]).max() <= 8 * ROUNDING


def test_cosine_directions(device):
    bins = HemisphereBins()
    found = run(device, "cosine", even(1), 3)
    assert np.abs(np.linalg.norm(found, axis=1) - 1).max() <= 8 * ROUNDING
    assert found[:, 2].min() >= 0
    probabilities = bins.probabilities(bins.points()[:, 2] / np.pi)
    assert probabilities[:-1].sum() == pytest.approx(1.0, abs=1e-4)  # the midpoint rule's error
    assert p_value(bins.counts(found), probabilities) > SIGNIFICANCE


def test_points_of_a_triangle_are_even(device):
    """Folded back over the diagonal of the unit square, a half of the draws at random."""
    found = run(device, "triangle", even(2), 2)
    assert found.min() >= 0 and found.sum(axis=1).max() <= 1 + ROUNDING
    turned = np.random.default_rng(3).random(len(found)) < 0.5
    found[turned] = 1 - found[turned]
    counts = np.histogram2d(*found.T, bins=16, range=[(0, 1)] * 2)[0]
    assert p_value(counts, np.full((16, 16), 1 / 256)) > SIGNIFICANCE


def visible_normal_density(h: np.ndarray, v: np.ndarray, alpha: float) -> np.ndarray:
    """D_v(h) = G1(v) max(0, v.h) D(h) / n.v (Heitz 2014, eq. 16), float64."""
    square = alpha * alpha
    masking = 2.0 * v[2] / (v[2] + sqrt(square + (1.0 - square) * v[2] ** 2))
    return masking * np.maximum(h @ v, 0.0) * brdf.ggx_distribution(h[:, 2], alpha) / v[2]


@pytest.mark.parametrize("alpha", [0.1, 0.4, 1.0])
@pytest.mark.parametrize("n_v", [1.0, 0.5, 0.1])
def test_visible_half_vectors(device, alpha, n_v):
    v = np.array([0.6, 0.8, 0.0]) * sqrt(1.0 - n_v * n_v) + [0.0, 0.0, n_v]
    given = np.column_stack([np.tile([*v, alpha], (DRAWS, 1)), even(4)])
    found = run(device, "half", given, 3)
    assert np.abs(np.linalg.norm(found, axis=1) - 1).max() <= 8 * ROUNDING
    assert (found @ v).min() >= -1e-3  # never from behind, but for rounding at the horizon
    bins = HemisphereBins()
    probabilities = bins.probabilities(visible_normal_density(bins.points(), v, alpha))
    assert abs(1.0 - probabilities[:-1].sum()) <= 1e-3
    assert p_value(bins.counts(found), probabilities) > SIGNIFICANCE
