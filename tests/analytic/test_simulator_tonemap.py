"""Exposure, tone curve and transfer function at their endpoints and joints."""

import numpy as np
import pytest

from octolux.simulator import tonemap


def test_exposure_halves_with_each_ev():
    np.testing.assert_allclose(tonemap.exposure_factor([0.0, 1.0, -1.0]), [1 / 1.2, 1 / 2.4, 2 / 1.2])


def test_neutral_curve_of_grey():
    """Below 0.08 grey x becomes 6.25 x^2, up to the knee x - 0.04, and 1 far above."""
    grey = np.array([0.0, 0.04, 0.08, 0.5, 0.8, 1e9])[:, None] * np.ones(3)
    expected = np.array([0.0, 6.25 * 0.04**2, 0.04, 0.46, 0.76, 1.0])[:, None] * np.ones(3)
    np.testing.assert_allclose(tonemap.pbr_neutral(grey), expected, atol=1e-9)


def test_neutral_curve_is_continuous_and_grows():
    x = np.linspace(0.0, 20.0, 200001)
    grey = tonemap.pbr_neutral(x[:, None] * np.ones(3))[:, 0]
    assert (np.diff(grey) > 0.0).all()
    assert np.diff(grey).max() <= 1.001 * (x[1] - x[0])
    assert grey[-1] < 1.0


def test_neutral_knee_is_smooth():
    """Value and slope of the compressed branch at its start are those of the straight one: 0.76 and 1."""
    step = 1e-6
    below, at, above = tonemap.pbr_neutral(np.array([0.8 - step, 0.8, 0.8 + step])[:, None] * np.ones(3))[:, 0]
    assert at == pytest.approx(0.76)
    assert (above - at) / step == pytest.approx(1.0, abs=step / 0.24 * 2)
    assert (at - below) / step == pytest.approx(1.0, abs=1e-9)


def test_highlights_turn_white():
    found = tonemap.pbr_neutral(np.array([1e7, 1e3, 0.0]))
    np.testing.assert_allclose(found, 1.0, atol=1e-5)


def test_srgb_endpoints_and_joint():
    np.testing.assert_allclose(tonemap.srgb_encode([0.0, 1.0, -1.0, 2.0]), [0.0, 1.0, 0.0, 1.0], atol=1e-15)
    np.testing.assert_allclose(tonemap.srgb_decode([0.0, 1.0, -1.0, 2.0]), [0.0, 1.0, 0.0, 1.0], atol=1e-15)
    assert tonemap.srgb_encode(0.0031308) == pytest.approx(0.04045, abs=1e-6)


def test_every_8_bit_value_survives():
    codes = np.arange(256)
    np.testing.assert_array_equal(np.round(tonemap.srgb_encode(tonemap.srgb_decode(codes / 255.0)) * 255.0), codes)


def test_display_is_exposure_curve_and_transfer():
    """Radiance 1.2 nits at EV100 0 is 1 after exposure: white without a curve, and black stays black with one."""
    np.testing.assert_array_equal(tonemap.display(np.full(3, 1.2), 0.0, "none"), [255, 255, 255])
    np.testing.assert_array_equal(tonemap.display(np.zeros(3), 0.0), [0, 0, 0])
    grey = tonemap.display(np.full(3, 0.5 * 1.2), 0.0)
    np.testing.assert_array_equal(grey, np.round(255 * (1.055 * 0.46 ** (1 / 2.4) - 0.055)).astype(np.uint8))
    with pytest.raises(ValueError, match="unknown tone map 'filmic'"):
        tonemap.display(np.zeros(3), 0.0, "filmic")


GREY = np.concatenate([np.linspace(0.0, 1.0, 4001), 10 ** np.linspace(0.0, 4.0, 2000)[1:]])


@pytest.mark.parametrize("name", tonemap.TONE_MAPS)
def test_grey_stays_grey_in_order_and_in_range(name):
    found = tonemap.TONE_MAPS[name](GREY[:, None] * np.ones(3))
    assert found.min() >= 0.0 and found.max() <= 1.0
    assert (np.diff(found[:, 1]) >= 0.0).all()
    # The rows of the published matrices of AgX and ACES have sums of 1 to 2e-4, which their curves do not magnify.
    assert np.ptp(found, axis=1).max() <= 1e-3


def test_no_curve_cuts_at_one():
    np.testing.assert_array_equal(tonemap.clipped([-1.0, 0.0, 0.3, 1.0, 7.0]), [0.0, 0.0, 0.3, 1.0, 1.0])


def test_neutral_keeps_base_colours():
    """A colour of at most 0.8 under a white surround: what a dielectric reflects of it, 0.04, is taken off again."""
    base = np.random.default_rng(5).uniform(0.04, 0.75, (100, 3))
    np.testing.assert_allclose(tonemap.pbr_neutral(base + 0.04), base, atol=1e-12)


def agx_sigmoid(x: np.ndarray) -> np.ndarray:
    """AgX's curve as it was made (Sobotka 2022): slope 2 through middle grey, at 10 of 16.5 stops and a signal of 1/2,
    from which a toe of power 3 goes to (0, 0) and a shoulder of power 3.25 to (1, 1)."""
    x_pivot, y_pivot, slope = 10 / 16.5, 0.5, 2.0

    def branch(x_room, y_room, power):
        rise = slope * x_room
        scale = rise / ((rise / y_room) ** power - 1) ** (1 / power)
        distance = slope * np.abs(x - x_pivot)
        return distance / (1 + (distance / scale) ** power) ** (1 / power)

    toe, shoulder = branch(x_pivot, y_pivot, 3.0), branch(1 - x_pivot, 1 - y_pivot, 3.25)
    return np.where(x > x_pivot, y_pivot + shoulder, y_pivot - toe)


def test_agx_follows_its_curve():
    """The polynomial fits the curve with a mean square error of 3.7e-6 (Wrensch 2023); four times the root of that
    allows for the worst place and for its rounded coefficients. Grey also passes the two matrices, see above."""
    stops = np.linspace(-12.4, 4.0, 200)
    signal = tonemap.agx(2.0 ** stops[:, None] * np.ones(3)) ** (1 / 2.2)
    expected = agx_sigmoid((stops + 12.47393) / 16.5)
    assert np.abs(signal - expected[:, None]).max() <= 4 * 3.7e-6**0.5 + 1e-3
    np.testing.assert_allclose(tonemap.agx(np.full(3, 0.18)) ** (1 / 2.2), 0.5, atol=4 * 3.7e-6**0.5 + 1e-3)


def test_aces_at_middle_grey():
    """Grey passes both matrices (rows of sum 1). By hand: 0.18 (0.18 + 0.0245786) - 0.000090537 = 0.0367336 over
    0.18 (0.983729 0.18 + 0.432951) + 0.238081 = 0.3478844. ACES itself shows 0.18 at 4.8 of 48 nits: 0.1."""
    found = tonemap.aces(np.full(3, 0.18))
    np.testing.assert_allclose(found, 0.0367336 / 0.3478844, rtol=1e-4)
    np.testing.assert_allclose(found, 0.1, rtol=0.1)


def test_strong_colours_go_to_white():
    """The film-like maps mix channels: a blue of 100 times white lights all three; without a curve it does not."""
    blue = np.array([0.0, 0.0, 100.0])
    assert tonemap.agx(blue).min() > 0.1 and tonemap.aces(blue).min() > 0.1
    assert tonemap.clipped(blue)[:2].max() == 0.0
