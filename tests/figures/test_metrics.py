"""The error metrics of figures in cases worked out by hand, and where shadow edges are found."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from benchmarks.edges import away_from_edges, lit_by
from benchmarks.metrics import pixel_errors, relative_errors
from octolux.scene.lights import DirectionalLight

SIZE = (20, 50)
MASK = np.ones(SIZE, bool)
MASK[:, 40:] = False


def test_a_factor_and_an_offset():
    truth = np.full((*SIZE, 3), 2.0)
    errors = relative_errors(truth * 1.25, truth, truth, MASK, truth)
    assert errors == pytest.approx({"ratio": 1.25, "rmse": 0.25, "trimmed": 0.25})


def test_pixels_outside_the_mask_do_not_count():
    truth = np.full((*SIZE, 3), 2.0)
    picture = np.where(MASK[..., None], truth, 100.0)
    assert relative_errors(picture, truth, truth, MASK, truth) == pytest.approx({"ratio": 1, "rmse": 0, "trimmed": 0})


def test_trimming_leaves_out_the_worst_three_percent():
    """800 masked pixels, 24 of them wrong by 10 in each channel: rmse is 10 sqrt(0.03) / 2; one more remains."""
    truth = np.full((*SIZE, 3), 2.0)
    picture = truth.copy()
    picture[0, :24] += 10.0
    errors = relative_errors(picture, truth, truth, MASK, truth)
    assert errors["rmse"] == pytest.approx(10 * np.sqrt(0.03) / 2)
    assert errors["trimmed"] == 0.0
    picture[1, 0] += 10.0
    assert relative_errors(picture, truth, truth, MASK, truth)["trimmed"] == pytest.approx(5 / np.sqrt(776))


def test_noise_of_the_halves_has_no_bias():
    """Noise of 0.5 in each half leaves an error of 0.1 visible; squaring the difference to their mean would give 0.37.

    (x - A)(x - B) with noises of 0.5 has a standard deviation of 0.26; over 120000 values 7.5e-4 of the 0.01."""
    rng = np.random.default_rng(1)
    truth = np.ones((200, 200, 3))
    a, b = (truth + rng.normal(0, 0.5, truth.shape) for _ in range(2))
    errors = relative_errors(truth + 0.1, a, b, np.ones((200, 200), bool), truth)
    assert errors["rmse"] == pytest.approx(0.1, abs=4 * 7.5e-4 / (2 * 0.1))


def test_errors_of_pixels():
    reference = np.array([[[1.0, 2.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]])
    picture = reference + np.array([0.1, 0.0, 0.0])
    picture[0, 3] = 0.0
    unshadowed = np.zeros((1, 4, 3))
    unshadowed[0, 1] = 5.0
    np.testing.assert_allclose(pixel_errors(picture, reference, unshadowed), [[0.05, 0.02, np.inf, 0.0]])


SUN = DirectionalLight(direction=(0.0, 0.0, -1.0), illuminance=(1.0, 1.0, 1.0))
LOW = DirectionalLight(direction=(-1.0, 0.0, -1.0), illuminance=(1.0, 1.0, 1.0))


def wall() -> dict[str, np.ndarray]:
    """A wall at z = 0 seen head on from 10 m, a pixel a centimetre, lit by SUN."""
    height, width = SIZE
    position = np.zeros((*SIZE, 3))
    position[..., 0], position[..., 1] = np.meshgrid(np.arange(width) * 0.01, np.arange(height) * 0.01)
    normal = np.broadcast_to([0.0, 0.0, 1.0], position.shape).copy()
    full = np.full((*SIZE, 3), 0.5)
    return {
        "position": position, "normal": normal, "albedo": full, "direct": full / pi, "mask": np.ones(SIZE, bool),
        "depth": np.full(SIZE, 10.0),
    }  # fmt: skip


def test_a_lit_wall_has_no_edges():
    assert away_from_edges([SUN], wall()).all()


def columns(clear: np.ndarray) -> list[int]:
    assert (clear == clear[0]).all()
    return np.flatnonzero(~clear[0]).tolist()


def test_two_pixels_on_each_side_of_a_shadow():
    truth = wall()
    truth["direct"][:, 30:] = 0.0
    assert columns(away_from_edges([SUN], truth)) == [28, 29, 30, 31]


def test_creases_steps_and_the_mask_are_edges():
    for change in ("normal", "position", "mask"):
        truth = wall()
        if change == "normal":
            truth["normal"][:, 30:] = [np.sin(0.2), 0.0, np.cos(0.2)]
            truth["direct"][:, 30:] *= np.cos(0.2)
        elif change == "position":
            truth["position"][:, 30:, 2] = -0.2
        else:
            truth["mask"][:, 30:] = False
        wrong = columns(away_from_edges([SUN], truth))
        assert wrong == (list(range(28, 50)) if change == "mask" else [28, 29, 30, 31]), change


def test_which_of_two_lights_reaches_a_pixel():
    truth = wall()
    one, other = 0.5 / pi, 0.5 / pi / np.sqrt(2)
    truth["direct"][:] = one + other
    truth["direct"][:, 10:20] = one
    truth["direct"][:, 20:30] = other
    truth["direct"][:, 30:40] = 0.0
    found = lit_by([SUN, LOW], truth)
    assert [int(found[0, i]) for i in (5, 15, 25, 35, 45)] == [3, 1, 2, 0, 3]
    assert columns(away_from_edges([SUN, LOW], truth)) == [i + j for i in (10, 20, 30, 40) for j in (-2, -1, 0, 1)]


def test_grazing_light_is_left_out():
    """A light at a cosine of 0.05 is grazing; one behind the wall brings nothing and is not."""
    graze = DirectionalLight(direction=(-1.0, 0.0, -0.05), illuminance=(1e-6,) * 3)
    behind = DirectionalLight(direction=(-1.0, 0.0, 0.05), illuminance=(1.0,) * 3)
    assert not away_from_edges([SUN, graze], wall()).any()
    assert away_from_edges([SUN, behind], wall()).all()
