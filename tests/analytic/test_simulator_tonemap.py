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
