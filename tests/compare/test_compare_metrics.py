"""Metrics in closed form: offsets, factors, noise of known variance, leaks counted by hand; SSIM and FLIP."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.compare import perception
from octolux.compare.metrics import (
    LEAK_SHARE,
    brightness_map,
    error_map,
    leak,
    lit_level,
    relative_errors,
    relative_noise,
)
from octolux.compare.perception import flip, ssim

SIZE = (40, 50)
MASK = np.ones(SIZE, bool)
MASK[:, 40:] = False


def flat(value: float) -> np.ndarray:
    return np.full((*SIZE, 3), value)


def test_a_factor_and_an_offset():
    """A picture k times the reference r has the ratio k and the error |k - 1|; r + d has 1 + d / r and d / r."""
    for picture, ratio, rmse in ((flat(2.0) * 0.7, 0.7, 0.3), (flat(2.0) + 0.5, 1.25, 0.25)):
        errors = relative_errors(picture, flat(2.0), flat(2.0), MASK, flat(2.0))
        assert errors == pytest.approx({"ratio": ratio, "rmse": rmse, "trimmed": rmse})


def test_a_black_reference_has_no_ratios():
    for mask in (MASK, np.zeros(SIZE, bool)):
        errors = relative_errors(flat(1.0), flat(0.0), flat(0.0), mask, flat(0.0))
        assert errors == {"ratio": None, "rmse": None, "trimmed": None}
        assert relative_noise(flat(0.0), flat(0.0), mask) is None


def test_the_noise_of_a_reference_is_no_error():
    """A right picture beside halves of noise s = 0.5: (x - A)(x - B) has the mean 0 and the standard deviation s^2, so
    over n values the squared error is within 4 s^2 / sqrt(n). The plain error would be s / sqrt(2) = 0.35."""
    rng = np.random.default_rng(4)
    truth = np.ones((200, 200, 3))
    a, b = (truth + rng.normal(0.0, 0.5, truth.shape) for _ in range(2))
    mask = np.ones((200, 200), bool)
    errors = relative_errors(truth, a, b, mask, 0.5 * (a + b))
    assert errors["rmse"] < np.sqrt(4 * 0.25 / np.sqrt(truth.size)) < 0.06
    plain = relative_errors(truth, 0.5 * (a + b), 0.5 * (a + b), mask, 0.5 * (a + b))
    assert plain["rmse"] == pytest.approx(0.5 / np.sqrt(2), rel=0.02)


def test_the_noise_itself():
    """Two halves of standard deviation 0.5 around 2: their mean's is 0.5 / sqrt(2), relative to 2. The estimate of a
    standard deviation from n values is within 4 / sqrt(2 n) of it, relatively."""
    rng = np.random.default_rng(5)
    a, b = (2.0 + rng.normal(0.0, 0.5, (100, 100, 3)) for _ in range(2))
    assert relative_noise(a, b, np.ones((100, 100), bool)) == pytest.approx(
        0.5 / np.sqrt(2) / 2.0, rel=4 / np.sqrt(2 * 30000)
    )


def test_the_error_map_adds_up_to_the_relative_rmse():
    rng = np.random.default_rng(6)
    picture, reference = rng.random((*SIZE, 3)), rng.random((*SIZE, 3))
    shown = error_map(picture, reference, MASK)
    wanted = relative_errors(picture, reference, reference, MASK, reference)["rmse"]
    assert np.sqrt(np.mean(np.square(shown[MASK]))) == pytest.approx(wanted)
    assert not shown[~MASK].any()


def test_the_brightness_map_has_a_sign():
    """Half of the reference is 50 % too dark, twice is 100 % too bright; grey has the luminance of its value."""
    np.testing.assert_allclose(brightness_map(flat(1.0), flat(2.0), MASK)[MASK], -0.5)
    np.testing.assert_allclose(brightness_map(flat(4.0), flat(2.0), MASK)[MASK], 1.0)
    np.testing.assert_allclose(brightness_map(flat(0.3), flat(0.0), MASK)[MASK], 0.3)


def test_the_lit_level_is_the_mean_of_what_is_lit_in_any_view():
    half = flat(0.0)
    half[:20] = 3.0
    dark, other = flat(0.0), flat(9.0)
    assert lit_level([(half, MASK)]) == pytest.approx(3.0)
    assert lit_level([(dark, MASK), (other, MASK), (half, MASK)]) == pytest.approx((9.0 * 2 + 3.0) / 3)
    assert lit_level([(dark, MASK)]) is None
    assert lit_level([]) is None


def test_leaks_are_counted():
    """Of 1600 masked pixels the reference is dark in the upper half; a quarter of these is lit."""
    reference = flat(1.0)
    reference[:20] = 0.0
    light = reference.copy()
    light[:5] = 2.0 * LEAK_SHARE
    light[5:20] = 0.5 * LEAK_SHARE
    found = leak(light, reference, reference, MASK, 1.0)
    assert found.score == 0.25
    assert found.dark_share == 0.5
    assert found.mean == pytest.approx((0.25 * 2.0 + 0.75 * 0.5) * LEAK_SHARE)
    assert leak(light, flat(1.0), flat(1.0), MASK, 1.0) == (None, None, 0.0)


def test_few_dark_pixels_tell_nothing():
    """Of 1600 masked pixels 16 are 1 %; with 15 no share is told, but how few there are."""
    reference = flat(1.0)
    reference[0, :16] = 0.0
    assert leak(flat(1.0), reference, reference, MASK, 1.0) == (1.0, 1.0, 0.01)
    reference[0, 15] = 1.0
    assert leak(flat(1.0), reference, reference, MASK, 1.0) == (None, None, 15 / 1600)


def test_dark_is_what_both_halves_find_dark():
    a, b = flat(0.0), flat(0.0)
    a[:20], b[10:30] = 1.0, 1.0
    assert leak(flat(1.0), a, b, MASK, 1.0) == (1.0, 1.0, 0.25)


def test_ssim_of_the_same_and_of_an_offset():
    """Without contrast only the luminance term is left: (2 a b + C1) / (a^2 + b^2 + C1)."""
    rng = np.random.default_rng(7)
    picture = rng.random((*SIZE, 3))
    assert ssim(picture, picture) == pytest.approx(1.0)
    c1 = perception.SSIM_K1**2
    assert ssim(flat(0.25), flat(0.5)) == pytest.approx((2 * 0.125 + c1) / (0.0625 + 0.25 + c1))


def test_ssim_of_a_scaled_contrast():
    """Both around 0.5, one with k times the contrast: (2 k v + C2) / ((1 + k^2) v + C2) in every window of variance v.
    With v much larger than C2 = 9e-4 that is 2 k / (1 + k^2) but for C2 / v and what the windows' means differ."""
    board = np.where(np.indices((64, 64)).sum(axis=0) % 2, 0.9, 0.1)[..., None].repeat(3, axis=-1)
    k, v = 0.5, 0.16
    c2 = perception.SSIM_K2**2
    wanted = (2 * k * v + c2) / ((1 + k * k) * v + c2)
    # The Gaussian of 1.5 pixels passes exp(-2 (pi 1.5 / sqrt(2))^2) < 1e-9 of a checkerboard to the means.
    assert ssim(0.5 + k * (board - 0.5), board) == pytest.approx(wanted, abs=1e-3)


def test_ssim_agrees_with_scipys_gaussian():
    from scipy.ndimage import gaussian_filter

    rng = np.random.default_rng(8)
    x, y = (rng.random(SIZE) for _ in range(2))

    def mean(values):
        return gaussian_filter(values, 1.5, truncate=5 / 1.5)[5:-5, 5:-5]

    mx, my = mean(x), mean(y)
    c1, c2 = 1e-4, 9e-4
    top = (2 * mx * my + c1) * (2 * (mean(x * y) - mx * my) + c2)
    wanted = np.mean(top / ((mx**2 + my**2 + c1) * (mean(x * x) - mx**2 + mean(y * y) - my**2 + c2)))
    grey = [np.repeat(v[..., None], 3, axis=-1) for v in (x, y)]
    assert ssim(*grey) == pytest.approx(wanted, rel=1e-9)


def test_ssim_needs_a_window():
    with pytest.raises(ValueError, match="11 x 11"):
        ssim(np.zeros((10, 40, 3)), np.zeros((10, 40, 3)))


@pytest.mark.skipif(bool(perception.flip_missing()), reason=perception.flip_missing())
def test_flip_of_the_same_and_of_black_on_white():
    """FLIP's range is [0, 1]; black and white are as far apart as colours are (Andersson et al. 2020, section 4.1)."""
    same, far = flip(flat(0.5), flat(0.5)), flip(flat(0.0), flat(1.0))
    assert same and same[0] == 0.0 and same[1].shape == SIZE
    assert far and 0.9 < far[0] <= 1.0


def test_without_flip(monkeypatch):
    monkeypatch.setattr(perception, "flip_missing", lambda: "not here")
    assert flip(flat(0.5), flat(0.5)) is None
