"""Spherical harmonics against quadrature that is exact for what is integrated; tolerances are rounding only."""

from math import pi, sqrt

import numpy as np
import pytest

from octolux.simulator import sh

ROUNDING = 1e-12
RNG = np.random.default_rng(1)


def random_directions(count: int) -> np.ndarray:
    directions = RNG.normal(size=(count, 3))
    return directions / np.linalg.norm(directions, axis=-1, keepdims=True)


def rotation_to(direction: np.ndarray) -> np.ndarray:
    """A rotation that turns +z into `direction`."""
    other = np.eye(3)[np.argmin(np.abs(direction))]
    x = np.cross(other, direction)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(direction, x), direction], axis=1)


def integrate_over_sphere(function, pole: np.ndarray) -> np.ndarray:
    """Quadrature with the equator across `pole`, so that max(0, pole.w) is a polynomial on each half."""
    directions, weights = sh.sphere_quadrature(16)
    return np.einsum("m,m...->...", weights, function(directions @ rotation_to(pole).T))


def test_basis_is_orthonormal():
    for index in range(4):
        projected = sh.project(lambda w, index=index: sh.basis(w)[:, index], samples=8)
        np.testing.assert_allclose(projected, np.eye(4)[index], atol=ROUNDING)


def test_order_is_1_y_z_x_all_positive():
    np.testing.assert_allclose(sh.basis([1.0, 0, 0]), [sh.Y0, 0, 0, sh.Y1])
    np.testing.assert_allclose(sh.basis([0, 1.0, 0]), [sh.Y0, sh.Y1, 0, 0])
    np.testing.assert_allclose(sh.basis([0, 0, 1.0]), [sh.Y0, 0, sh.Y1, 0])


def test_cosine_lobe_is_the_projection_of_the_clamped_cosine():
    for d in random_directions(8):
        exact = integrate_over_sphere(lambda w, d=d: np.maximum(0.0, w @ d)[:, None] * sh.basis(w), d)
        np.testing.assert_allclose(sh.cosine_lobe(d), exact, atol=ROUNDING)
        np.testing.assert_allclose(sh.flux(sh.cosine_lobe(d)), pi, rtol=ROUNDING)


def test_project_then_evaluate_reproduces_linear_functions():
    slope, directions = np.array([0.3, -2.0, 0.7]), random_directions(10)
    coefficients = sh.project(lambda w: 1.5 + w @ slope)
    np.testing.assert_allclose(sh.evaluate(coefficients, directions), 1.5 + directions @ slope, atol=ROUNDING)


def test_rotation_turns_the_function():
    """exp(a.w) turned by M is exp((M a).w); both are entire functions, whose quadrature converges exponentially."""
    a = np.array([0.5, -1.0, 0.8])
    for d in random_directions(4):
        matrix = rotation_to(d)
        turned = sh.project(lambda w, m=matrix: np.exp(w @ (m @ a)))
        np.testing.assert_allclose(sh.rotate(sh.project(lambda w: np.exp(w @ a)), matrix), turned, atol=ROUNDING)


def test_dominant_lobe_takes_a_mix_apart():
    for d, a, total in zip(random_directions(6), [0.0, 0.2, 0.5, 0.7, 0.99, 1.0], [1, 2, 0.1, 5, 7, 3], strict=True):
        mixed = total * (a / pi * sh.cosine_lobe(d) + (1 - a) / (4 * pi) * np.array([2 * sqrt(pi), 0, 0, 0]))
        flux, fraction, direction = sh.dominant_lobe(mixed)
        np.testing.assert_allclose([flux, fraction], [total, a], atol=ROUNDING * total)
        np.testing.assert_allclose(direction, d if a else 0.0, atol=ROUNDING / max(a, 0.1))


def test_dominant_lobe_keeps_flux_and_first_moment():
    for d, steepness in zip(random_directions(6), np.linspace(0.1, 1.1, 6), strict=True):
        coefficients = np.concatenate([[1.0], steepness * d[list(sh.VECTOR_TO_BAND1)]])
        intensity = integrate_over_sphere(
            lambda w, c=coefficients: sh.evaluate_dominant_lobe(c, w)[:, None] * np.c_[np.ones(len(w)), w], d
        )
        first_moment = sqrt(4 * pi / 3) * sh.vector(coefficients)
        np.testing.assert_allclose(intensity[0], sh.flux(coefficients), atol=ROUNDING)
        np.testing.assert_allclose(intensity[1:], first_moment, atol=ROUNDING)


def test_dominant_lobe_of_darkness_and_of_too_steep_light():
    flux, fraction, direction = sh.dominant_lobe(np.array([[0.0, 0, 0, 0], [1.0, 0, 0, 0], [1.0, 9.0, 0, 0]]))
    np.testing.assert_array_equal(fraction, [0.0, 0.0, 1.0])
    np.testing.assert_array_equal(direction, [[0, 0, 0], [0, 0, 0], [0, 1, 0]])
    np.testing.assert_allclose(flux, [0.0, 2 * sqrt(pi), 2 * sqrt(pi)])


def test_quadrature_rejects_too_few_samples():
    with pytest.raises(ValueError, match="at least 2"):
        sh.sphere_quadrature(1)
