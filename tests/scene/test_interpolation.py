"""What a track says between its keyframes."""

from __future__ import annotations

from math import cos, radians, sin, sqrt

import numpy as np
import pytest

from octolux.scene.motion.moved import rotation_matrix
from octolux.scene.motion.tracks import Track


def track(times, values, interpolation, key="translation", **more) -> Track:
    return Track(target="node", name="", index=0, property=key, times=np.array(times, np.float64),
                 values=np.array(values, np.float64), interpolation=interpolation, **more)  # fmt: skip


def about_y(degrees: float) -> tuple[float, ...]:
    return (0.0, sin(radians(degrees / 2)), 0.0, cos(radians(degrees / 2)))


@pytest.mark.covers("glTF animation")
@pytest.mark.parametrize(("time", "expected"), [(0.0, 5.0), (0.999, 5.0), (1.0, 7.0), (3.0, 7.0)])
def test_steps_hold_until_the_next_key(time, expected):
    assert track([0, 1], [[5], [7]], "step").at(time)[0] == expected


@pytest.mark.covers("glTF animation")
@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 0.9])
def test_cubic_is_the_formula_of_the_specification(share):
    values = np.random.default_rng(3).normal(size=(2, 3, 3))
    (_, v0, b0), (a1, v1, _) = values
    t, td = share, 2.5
    expected = ((2 * t**3 - 3 * t**2 + 1) * v0 + td * (t**3 - 2 * t**2 + t) * b0
                + (-2 * t**3 + 3 * t**2) * v1 + td * (t**3 - t**2) * a1)  # fmt: skip
    np.testing.assert_allclose(track([1.0, 3.5], values, "cubic").at(1.0 + td * share), expected, atol=1e-14)


@pytest.mark.covers("glTF animation")
def test_cubic_holds_the_values_and_not_the_slopes_beyond_its_ends():
    t = track([0, 1], [[[9], [1], [9]], [[9], [2], [9]]], "cubic")
    assert (t.at(-1.0)[0], t.at(5.0)[0]) == (1.0, 2.0)


@pytest.mark.covers("glTF animation")
def test_cubic_rotations_have_unit_length():
    zero, start, end = [0, 0, 0, 0], [0, 0, 0, 1], about_y(90)
    halfway = track([0, 1], [[zero, start, zero], [zero, end, zero]], "cubic", "rotation").at(0.5)
    np.testing.assert_allclose(halfway, about_y(45), atol=1e-15)


def test_smooth_goes_through_the_keys_and_has_one_slope_there():
    t = track([0, 1, 3, 3.5, 6], np.random.default_rng(1).normal(size=(5, 3)), "smooth")
    h = 1e-5
    for key, time in enumerate(t.times):
        np.testing.assert_allclose(t.at(time), t.values[key], atol=1e-14)
    for time in t.times[1:-1]:
        # One-sided differences of second order: their error is h squared times a third derivative, which the steepest
        # segment of half a second keeps below 1e3.
        left = (3 * t.at(time) - 4 * t.at(time - h) + t.at(time - 2 * h)) / (2 * h)
        right = (-3 * t.at(time) + 4 * t.at(time + h) - t.at(time + 2 * h)) / (2 * h)
        np.testing.assert_allclose(left, right, atol=1e-6)


@pytest.mark.parametrize("time", [1.2, 2.0, 2.9])
def test_smooth_repeats_a_parabola_whatever_the_distances_of_the_keys(time):
    times = np.array([0.0, 1.0, 3.0, 3.5])
    value = track(times, (2 * times**2 - 3 * times + 1)[:, None], "smooth").at(time)
    assert value[0] == pytest.approx(2 * time**2 - 3 * time + 1, abs=1e-13)


def test_smooth_with_even_times_is_the_spline_of_catmull_and_rom():
    p = np.array([[1.0], [4.0], [2.0], [7.0]])
    value = track([0, 1, 2, 3], p, "smooth").at(1.5)
    assert value[0] == pytest.approx((-p[0] + 9 * p[1] + 9 * p[2] - p[3])[0] / 16, abs=1e-14)


def test_smooth_between_two_keys_is_a_line():
    assert track([0, 2], [[1], [5]], "smooth").at(0.5)[0] == pytest.approx(2.0)


def test_smooth_rotations_turn_evenly_and_ignore_signs():
    signs = np.array([1, -1, 1, 1, -1])[:, None]
    t = track([0, 1, 2, 3, 4], signs * [about_y(30 * n) for n in range(5)], "smooth", "rotation")
    for time in (0.5, 1.5, 2.25, 3.75):
        forward = rotation_matrix(t.at(time)) @ [0, 0, 1]
        expected = (sin(radians(30 * time)), 0, cos(radians(30 * time)))
        # Keys lie h = 15 degrees apart on the sphere of quaternions. The spline's slopes h there are wrong by h**3 / 6
        # (at the ends by more, but outwards, which normalising undoes), are weighted with at most 4/27 each, and
        # vectors turn by twice the angle of quaternions: 16/27 of the tolerance.
        np.testing.assert_allclose(forward, expected, atol=radians(15) ** 3 / 6)


def test_a_period_begins_again_at_zero():
    t = track([0.5, 2.0], [[0], [3]], "linear", period=2.0)
    assert [t.at(time)[0] for time in (0.25, 1.0, 2.25, 3.0, -1.0)] == pytest.approx([0, 1, 0, 1, 1])


def test_a_closed_smooth_path_has_no_corner_where_it_begins_again():
    t = track([0, 1, 2, 3], [[0], [2], [1], [0]], "smooth", period=3.0)
    h = 1e-6
    before, after = (t.at(3 - h) - t.at(3 - 2 * h)) / h, (t.at(3 + 2 * h) - t.at(3 + h)) / h
    np.testing.assert_allclose(before, after, atol=1e-4)  # h times a second derivative below 10
    assert after[0] == pytest.approx((2 - 1) / 2, abs=1e-4)


@pytest.mark.parametrize("wrong", [{"times": [1, 0]}, {"times": [0, 1, 2]}, {"interpolation": "cubic"},
                                   {"period": 0.0}, {"times": [], "values": []}])  # fmt: skip
def test_tracks_that_make_no_sense_are_refused(wrong):
    given = {"times": [0, 1], "values": [[1], [2]], "interpolation": "linear"} | wrong
    with pytest.raises(ValueError, match="track of"):
        track(**given)


def test_constant_speed_of_half_a_rotation():
    t = track([0, 1], [[0, 0, 0, 1], about_y(90)], "linear", "rotation")
    np.testing.assert_allclose(t.at(0.5), about_y(45), atol=1e-15)
    assert sqrt(sum(t.at(0.3) ** 2)) == pytest.approx(1)
