"""Direct light against closed forms and quadrature, and the form factors it is compared with."""

from math import cos, pi, radians

import numpy as np
import pytest

from octolux.scene.lights import AreaLight, DirectionalLight, PointLight, SpotLight
from octolux.simulator import brdf, direct, form_factors

UP = np.array([0.0, 0.0, 1.0])
WHITE = (1.0, 1.0, 1.0)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(64)
CEILING = ((-1.0, -1.0, 2.0), (-1.0, 1.0, 2.0), (1.0, 1.0, 2.0), (1.0, -1.0, 2.0))
"""A square at z = 2 whose corners run counter-clockwise seen from below."""


def square_quadrature(low_u, high_u, low_v, high_v, point, normal, plane=2.0) -> float:
    """Integral of cos cos' / r^2 over a rectangle at z = plane that faces -z. Smooth over a square no wider than its
    distance, so 64 nodes are exact to rounding; the rectangle must lie above the point's horizon."""
    u = 0.5 * (high_u - low_u) * NODES + 0.5 * (high_u + low_u)
    v = 0.5 * (high_v - low_v) * NODES + 0.5 * (high_v + low_v)
    points = np.stack([*np.meshgrid(u, v, indexing="ij"), np.full((64, 64), plane)], axis=-1) - point
    distance = np.linalg.norm(points, axis=-1)
    integrand = (points @ normal) * points[..., 2] / distance**4
    return float(np.einsum("u,v,uv->", WEIGHTS, WEIGHTS, integrand) * 0.25 * (high_u - low_u) * (high_v - low_v))


def test_point_light_inverse_square_and_cosine():
    light = PointLight(position=(0.0, 3.0, 4.0), intensity=(25.0, 50.0, 100.0))
    np.testing.assert_allclose(direct.irradiance(light, np.zeros(3), UP), np.array([1.0, 2.0, 4.0]) * 0.8)
    np.testing.assert_array_equal(direct.irradiance(light, np.zeros(3), -UP), 0.0)


def test_directional_light_is_lux_across_its_direction():
    light = DirectionalLight(direction=(0.0, 0.0, -5.0), illuminance=(10.0, 20.0, 30.0))
    slanted = np.array([0.0, np.sin(1.0), cos(1.0)])
    np.testing.assert_allclose(
        direct.irradiance(light, np.zeros((2, 3)), slanted), np.tile([10, 20, 30], (2, 1)) * cos(1)
    )


def test_spot_falloff():
    """Full inside the inner cone, nothing outside the outer, a quarter where the cosine is half-way between."""
    inner, outer = radians(20), radians(40)
    light = SpotLight(position=(0, 0, 1), direction=(0, 0, -2), intensity=WHITE, inner_angle=inner, outer_angle=outer)
    middle = np.arccos(0.5 * (cos(inner) + cos(outer)))
    angles = np.array([0.0, inner, middle, outer, radians(60), pi])
    to_light = np.stack([np.sin(angles), np.zeros(6), np.cos(angles)], axis=-1)
    np.testing.assert_allclose(direct.spot_attenuation(light, to_light), [1, 1, 0.25, 0, 0, 0], atol=1e-15)
    np.testing.assert_allclose(direct.irradiance(light, np.zeros(3), UP), WHITE)


def test_radiance_of_a_pure_lambert_material_is_lamberts():
    light = PointLight(position=(1.0, 2.0, 3.0), intensity=(5.0, 6.0, 7.0))
    points = np.random.default_rng(6).uniform(-1, 1, (20, 3)) * [1, 1, 0]
    albedo = np.array([0.2, 0.5, 0.8])
    full = direct.radiance(light, points, UP, (0.0, 0.0, 5.0), brdf.surface(albedo, specular=0.0))
    np.testing.assert_allclose(full, direct.lambert_radiance(light, points, UP, albedo), rtol=1e-12)


def test_area_light_above_a_point_is_the_form_factor():
    light = AreaLight(corners=CEILING, radiance=(1.0, 2.0, 3.0))
    points = np.array([[0.0, 0, 0], [0.3, -0.7, 0], [2.5, 1.0, 0], [0.0, 0.0, 1.9]])
    found = direct.irradiance(light, points, UP)
    for point, value in zip(points, found, strict=True):
        expected = form_factors.irradiance_from_parallel_square(
            np.array([1.0, 2.0, 3.0]), 2.0, 2.0 - point[2], point[0], point[1]
        )
        np.testing.assert_allclose(value, expected, rtol=1e-12)


def test_area_light_is_cut_at_the_horizon():
    """A point that faces +x sees the half of the ceiling with x > 0 only."""
    light = AreaLight(corners=CEILING, radiance=WHITE)
    sideways = np.array([1.0, 0.0, 0.0])
    expected = square_quadrature(0.0, 1.0, -1.0, 1.0, np.zeros(3), sideways)
    np.testing.assert_allclose(direct.irradiance(light, np.zeros(3), sideways), expected, rtol=1e-12)


def test_area_light_of_any_tilt_above_the_horizon():
    light = AreaLight(corners=CEILING, radiance=WHITE)
    normal = np.array([0.3, -0.2, 1.0]) / np.linalg.norm([0.3, -0.2, 1.0])
    point = np.array([0.4, 0.1, 0.2])
    expected = square_quadrature(-1.0, 1.0, -1.0, 1.0, point, normal)
    np.testing.assert_allclose(direct.irradiance(light, point, normal), expected, rtol=1e-12)


def test_area_light_has_one_side():
    light = AreaLight(corners=CEILING, radiance=WHITE)
    points = np.array([[0.0, 0, 3], [0.0, 0, 2], [5.0, 0, 2], [0.0, 0, 0]])
    normals = np.array([[0.0, 0, -1], [0.0, 0, -1], [-1.0, 0, 0], [0.0, 0, -1]])
    np.testing.assert_array_equal(direct.irradiance(light, points, normals), 0.0)


def test_area_light_has_no_single_direction():
    with pytest.raises(ValueError, match="area_light_irradiance"):
        direct.incident(AreaLight(corners=CEILING, radiance=WHITE), np.zeros(3))


@pytest.mark.parametrize(("u", "v"), [(0.0, 0.0), (0.4, -0.2), (1.0, 1.0), (2.0, -0.5)])
def test_point_to_square_against_quadrature(u, v):
    found = form_factors.point_to_parallel_square(2.0, 2.0, u, v)
    expected = square_quadrature(-1.0, 1.0, -1.0, 1.0, np.array([u, v, 0.0]), UP) / pi
    assert found == pytest.approx(expected, rel=1e-12)


def test_square_near_and_far():
    """Touching, the plate fills the half sphere: what is missing lies beyond side / 2 and is at most (2 d / side)^2.
    Far away it is a small area: side^2 / (pi d^2), less a relative (side / d)^2 at most."""
    assert 0.0 < 1.0 - form_factors.point_to_parallel_square(1.0, 1e-3) < 4e-6
    small = 1.0 / (pi * 100.0**2)
    assert 0.0 < 1.0 - form_factors.point_to_parallel_square(1.0, 100.0) / small < 1e-4


@pytest.mark.parametrize("distance", [0.5, 1.0, 3.0])
def test_parallel_squares_are_the_mean_over_a_plate(distance):
    u = 0.5 * NODES
    values = form_factors.point_to_parallel_square(1.0, distance, u[:, None], u[None, :])
    mean = 0.25 * np.einsum("u,v,uv->", WEIGHTS, WEIGHTS, values)
    assert form_factors.parallel_squares(1.0, distance) == pytest.approx(mean, rel=1e-10)


def test_parallel_plates_sum_the_series_of_bounces():
    passive, emitting = form_factors.parallel_plates_irradiance(3.0, 0.5, 0.8)
    series = sum(0.8 * 3.0 * (0.5 * 0.8) ** (2 * k) for k in range(40))
    assert passive == pytest.approx(series, rel=1e-12)
    assert emitting == pytest.approx(0.4 * series, rel=1e-12)


def test_bad_geometry_is_refused():
    with pytest.raises(ValueError, match="side must be positive"):
        form_factors.point_to_parallel_square(0.0, 1.0)
    with pytest.raises(ValueError, match="distance must be positive"):
        form_factors.parallel_squares(1.0, -1.0)
    with pytest.raises(ValueError, match="albedo times form factor"):
        form_factors.parallel_plates_irradiance(1.0, 1.0, 1.0)
