"""Stored numbers: what rounding does to them, from the distance between neighbours."""

from math import pi

import numpy as np
import pytest

from octolux.simulator.lpv import formats

EVALUATIONS = ("clamped", "dominant_lobe")


def emissions(count: int, evaluation: str, seed: int = 0) -> np.ndarray:
    """Of mixes of cosine lobes, of sizes from a tenth of the evenly spaced ones to the largest: float64 (count, 4)."""
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(count, 3))
    d *= rng.uniform(0.0, 1.0, (count, 1)) / np.linalg.norm(d, axis=-1, keepdims=True)
    size = 2.0 ** rng.uniform(-13.0, 5.0, (count, 1))
    if evaluation == "clamped":
        return size * np.concatenate([np.ones((count, 1)), 2.0 / np.sqrt(3.0) * d], axis=-1)
    return size * np.concatenate([rng.uniform(0.0, 0.25, (count, 1)), d], axis=-1)


def flux_of(e: np.ndarray, evaluation: str) -> np.ndarray:
    """Up to a factor."""
    return e[..., 0] if evaluation == "clamped" else 4.0 * pi * e[..., 0] + formats.lobe_flux(e[..., 1:])


def gaps(size: np.ndarray) -> np.ndarray:
    """Largest distance of the two neighbours of a size."""
    return formats.GAP * 2.0 ** np.floor(np.log2(size + formats.LEAST)) * 2.0


def test_thousandths():
    x = np.linspace(0.0, 1.0, 5000).reshape(-1, 1) * [1.0, 0.5, 0.25]
    found = formats.unpack_thousandths(formats.pack_thousandths(x))
    assert np.abs(found - x).max() <= 0.5 / formats.STEPS + 1e-15
    np.testing.assert_array_equal(formats.unpack_thousandths(formats.pack_thousandths([0.0, 1.0, 0.0])), [0, 1, 0])


def test_sizes_begin_at_none_and_hold_the_largest_light():
    table = formats.sizes(np.arange(256))
    assert table[0] == 0.0 and np.all(np.diff(table) > 0.0)
    assert 62.0 <= table[-1] <= 64.0  # storage_scale.wgsl: light stays below 6 * 0.58 * 16 = 55.7
    faint = formats.sizes(np.arange(15))  # below the first power of two above LEAST
    np.testing.assert_allclose(np.diff(faint), formats.LEAST * formats.GAP, rtol=0.01)
    relative = np.diff(table)[64:] / table[64:-1]
    assert relative.max() <= formats.GAP * 1.07 and relative.min() >= 0.5 * formats.GAP / 1.07


def test_thresholds_are_even():
    """Multiples of a golden ratio fill [0, 1) with gaps of at most (1 + golden) / count; those of two steps are
    opposite."""
    for dither in (0.0, 0.5):
        found = np.sort(formats.thresholds(np.arange(5000), dither))
        assert found[0] >= 0.0 and found[-1] < 1.0 and np.diff(found).max() <= 2.7 / 5000
    apart = formats.thresholds(np.arange(100), 0.5) - formats.thresholds(np.arange(100), 0.0)
    np.testing.assert_allclose(np.abs(apart), 0.5, atol=1e-12)


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_cells_are_off_by_a_gap_and_half_a_share(evaluation):
    e = emissions(20_000, evaluation)
    found = formats.unpack_cells(formats.pack_cells(e, np.arange(len(e)), 0.0, evaluation), evaluation)
    size = e[:, 0] if evaluation == "clamped" else 4.0 * e[:, 0] + np.abs(e[:, 1:]).max(axis=-1)
    # Shares are off by 1/254 of the size, times 2/sqrt(3) for the coefficients; what keeps the flux of the dominant
    # lobe moves the size by that of three shares, whose flux is at most as much as the size's, pi, times 3.
    size = size * (1.0 + (3.0 / 254.0 if evaluation == "dominant_lobe" else 0.0))
    bound = gaps(size) * 1.16 + size * (1.16 + 3.0) / 254.0
    assert np.all(np.abs(found - e) <= bound[:, None])
    assert found[:, 0].min() >= 0.0


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_the_mean_flux_is_kept(evaluation):
    """Stored at many places, one emission keeps its flux: rounding up is as frequent as the share of the gap, but for
    the discrepancy of multiples of the golden ratio, (3 + (1 / ln golden + 1 / ln 2) ln count) / count (Kuipers and
    Niederreiter, Uniform distribution of sequences, theorem 2.3.4 for partial quotients of 1)."""
    count = 4000
    uneven = (3.0 + (1.0 / np.log((1.0 + np.sqrt(5.0)) / 2.0) + 1.0 / np.log(2.0)) * np.log(count)) / count
    for e in emissions(40, evaluation, seed=2):
        stored = formats.pack_cells(np.tile(e, (count, 1)), np.arange(count), 0.5, evaluation)
        codes = stored >> 24
        assert codes.max() == codes.min() + 1
        gap = formats.sizes(codes.max()) / formats.sizes(codes.min()) - 1.0 if codes.min() else 1.0
        mean = flux_of(formats.unpack_cells(stored, evaluation), evaluation).mean()
        np.testing.assert_allclose(mean, flux_of(e, evaluation), rtol=uneven * gap)


@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_no_light_stays_none(evaluation):
    stored = formats.pack_cells(np.zeros((50, 4)), np.arange(50), 0.5, evaluation)
    np.testing.assert_array_equal(stored, 0)
    np.testing.assert_array_equal(formats.unpack_cells(stored, evaluation), 0.0)


def test_light_that_fades_slowly_fades():
    """0.5 % a step is a tenth of a gap and less: rounded to the nearest it would never fade. After k steps N cells are
    off by sqrt(k / N) times half a gap; four times that is not to be met."""
    e, steps, cells = np.tile([1.0, 0.0, 0.0, 0.0], (20_000, 1)), 16, 20_000
    for step in range(steps):
        stored = formats.pack_cells(e, np.arange(cells), 0.5 * (step % 2), "clamped")
        e = 0.995 * formats.unpack_cells(stored, "clamped")
        e[:, 0] = np.random.default_rng(step).permutation(e[:, 0])  # a cell's light comes from others
    assert abs(e[:, 0].mean() / 0.995**steps - 1.0) <= 4.0 * np.sqrt(steps / cells) * 0.5 * formats.GAP
