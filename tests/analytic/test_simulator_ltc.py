"""Linearly transformed cosines (simulator/ltc.py): closed forms, what the fit promises, and the BRDF by quadrature."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from octolux.scene.geometry.quadrilaterals import PLANARITY, flaw
from octolux.scene.lights import AreaLight
from octolux.simulator import brdf, direct, ltc

UP = np.array([0.0, 0.0, 1.0])
CEILING = ((-1.0, -1.0, 2.0), (-1.0, 1.0, 2.0), (1.0, 1.0, 2.0), (1.0, -1.0, 2.0))
"""A square at z = 2 whose corners run counter-clockwise seen from below."""
LOBES = [(r, c) for r in (0.1, 0.3, 0.5, 0.7, 1.0) for c in (1.0, 0.7, 0.4, 0.1)]


def lobe(roughness: float, n_dot_v: float) -> np.ndarray:
    return ltc.matrix(ltc.parameters(roughness, n_dot_v), float(brdf.alpha_of(roughness)), n_dot_v)


def eye(n_dot_v: float) -> np.ndarray:
    return np.array([np.sqrt(1.0 - n_dot_v**2), 0.0, n_dot_v])


def hemisphere(steps: int) -> tuple[np.ndarray, float]:
    """Unit directions above the horizon, all of one solid angle (midpoints in height and azimuth), and that."""
    z, turn = np.meshgrid((np.arange(steps) + 0.5) / steps, (np.arange(2 * steps) + 0.5) / steps * pi, indexing="ij")
    sine = np.sqrt(1.0 - z * z)
    points = np.stack([sine * np.cos(turn), sine * np.sin(turn), z], axis=-1).reshape(-1, 3)
    return points, 2.0 * pi / len(points)


def test_the_identity_gives_the_cosine():
    """Irradiance over pi L, also of a light that the horizon cuts."""
    light = AreaLight(corners=CEILING, radiance=(1.0, 1.0, 1.0))
    for normal in (UP, [0.0, 0.6, 0.8], [0.9, 0.3, -0.2]):
        n = np.asarray(normal) / np.linalg.norm(normal)
        vertices = np.asarray(CEILING) @ ltc.lobe_axes(n, np.array([0.1, -0.3, 0.9])).T
        expected = direct.area_light_irradiance(light, np.zeros(3), n)[0] / pi
        assert ltc.polygon_moment_of_lobe(np.eye(3), vertices)[2] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize(("roughness", "n_dot_v"), LOBES)
def test_light_all_around_gives_all_of_the_lobe(roughness, n_dot_v):
    """Five faces of a box around the point, open below, are the hemisphere: closed forms, to rounding."""
    m = lobe(roughness, n_dot_v)
    low, high = np.array([-2.0, -1.0, -0.5]), np.array([1.0, 3.0, 1.5])
    total = 0.0
    for axis in range(3):
        for bound in (low, high):
            if axis == 2 and bound is low:
                continue
            u, v = (axis + 1) % 3, (axis + 2) % 3
            face = np.zeros((4, 3))
            face[:, axis] = bound[axis]
            face[:, u], face[:, v] = [low[u], high[u], high[u], low[u]], [low[v], low[v], high[v], high[v]]
            total += ltc.polygon_moment_of_lobe(m, face if bound is low else face[::-1])[2]
    assert total == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(("roughness", "n_dot_v"), [x for x in LOBES if x[0] >= 0.5])
def test_the_density_is_what_the_polygons_integrate(roughness, n_dot_v):
    """The midpoint rule with 2 * 600^2 directions: of a density whose slope is at most some 10 / alpha a part of
    1 / 600 across errs by a share of 1e-3, at the polygon's rim by as much again."""
    m, (directions, part) = lobe(roughness, n_dot_v), hemisphere(600)
    values = ltc.density(m, directions) * part
    assert values.sum() == pytest.approx(1.0, abs=2e-3)
    vertices = np.array([[-3.0, -1.0, -0.5], [-3.0, 1.0, -0.5], [-1.0, 1.0, 1.5], [-1.0, -1.0, 1.5]])
    plane = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[1])
    at = directions * ((vertices[0] @ plane) / (directions @ plane))[:, None]
    inside = (directions @ plane < 0) & (np.abs(at[:, 1]) < 1) & (at[:, 0] > -3) & (at[:, 0] < -1)
    share = ltc.polygon_moment_of_lobe(m, vertices)[2]
    assert share == pytest.approx(values[inside].sum(), abs=2e-3)


@pytest.mark.parametrize(("roughness", "n_dot_v"), [x for x in LOBES if x[0] >= 0.3])
def test_specular_light_errs_by_no_more_than_the_fit(roughness, n_dot_v):
    """Under any light the lobe's share differs from the BRDF's by at most half the integral of |difference|, both
    having the integral 1. White metal: Fresnel is 1. Quadratures err by 2e-3 (above), the albedo's table by 64^-1.5."""
    rng = np.random.default_rng(5)
    directions, part = hemisphere(600)
    half = directions + eye(n_dot_v)
    half /= np.linalg.norm(half, axis=1, keepdims=True)
    alpha = brdf.alpha_of(roughness)
    true = brdf.ggx_distribution(half[:, 2], alpha) * brdf.smith_visibility(directions[:, 2], n_dot_v, alpha)
    true *= directions[:, 2]
    albedo = true.sum() * part
    fitted = ltc.density(lobe(roughness, n_dot_v), directions)
    worst = 0.5 * np.abs(fitted - true / albedo).sum() * part
    assert worst < 0.35
    metal = brdf.surface((1.0, 1.0, 1.0), 1.0, roughness)
    for _ in range(4):
        corners = rng.uniform(-2, 2, 3) * [1, 1, 0] + [[0, 0, 1], [0, 1.5, 1], [1.5, 1.5, 1], [1.5, 0, 1]]
        light = AreaLight(corners=tuple(map(tuple, corners)), radiance=(1.0, 1.0, 1.0))
        found = ltc.radiance(light, np.zeros(3), UP, eye(n_dot_v), metal)[0]
        expected = ltc.quadrature(light, np.zeros(3), UP, eye(n_dot_v), metal)[0]
        assert abs(found - expected) <= albedo * worst + 4e-3


def test_a_mirror_shows_the_light():
    """The smoothest metal, whose lobe (alpha 0.002) lies within the light: its radiance, to the tail outside, of which
    D leaves alpha^2 / tan^2 (t) beyond the angle t of half vectors; and black where it mirrors something else."""
    light = AreaLight(corners=CEILING, radiance=(3.0, 2.0, 1.0))
    metal = brdf.surface((1.0, 1.0, 1.0), 1.0, 0.0)
    to_eye = np.array([0.3, -0.2, 1.0]) / np.linalg.norm([0.3, -0.2, 1.0])
    shown = ltc.radiance(light, np.zeros(3), UP, to_eye, metal)
    np.testing.assert_allclose(shown, light.radiance, rtol=64**-1.5)
    away = np.array([3.0, 0.0, 1.0]) / np.sqrt(10.0)
    assert ltc.radiance(light, np.zeros(3), UP, away, metal).max() < 1e-3


def test_diffuse_light_of_a_small_lamp_is_that_of_the_brdf():
    """With one direction of light there is one Fresnel: what is left is the lamp's size, (0.1 / 2)^2."""
    lamp = AreaLight(corners=tuple((0.05 * x, 0.05 * y, z) for x, y, z in CEILING), radiance=(1.0, 1.0, 1.0))
    for material in (brdf.surface((0.8, 0.5, 0.2), 0.0, 1.0), brdf.surface((0.8, 0.5, 0.2), 0.0, 1.0, 0.0)):
        arguments = (lamp, np.zeros(3), UP, eye(0.8), material)
        diffuse = direct.area_light_irradiance(*arguments[:3])
        found = ltc.radiance(*arguments) - ltc.radiance(*arguments[:4], material._replace(base_color=np.zeros(3)))
        half = (UP + eye(0.8)) / np.linalg.norm(UP + eye(0.8))
        albedo, f0, f90 = brdf.reflectances(material)
        expected = (1.0 - brdf.schlick_fresnel(f0, f90, half @ eye(0.8))) * albedo / pi * diffuse
        np.testing.assert_allclose(found, expected, rtol=0.05**2)


def test_quadrature_wants_a_parallelogram():
    bent = AreaLight(corners=((0, 0, 1), (0, 1, 1), (2, 2, 1), (1, 0, 1)), radiance=(1.0, 1.0, 1.0))
    with pytest.raises(ValueError, match="parallelogram"):
        ltc.quadrature(bent, np.zeros(3), UP, UP, brdf.surface((1.0, 1.0, 1.0)))


def test_flaws_of_quadrilaterals():
    a, b, c, d = (np.array(corner) for corner in CEILING)
    for fine in (CEILING, CEILING[::-1], (a, b, c, c), (a, a, a, a), (a, b, c, 0.5 * (a + c)), (a, b, a, b),
                 (a, b, c, d + 0.9 * PLANARITY * UP)):  # fmt: skip
        assert flaw(fine) is None
    assert "plane" in flaw((a, b, c, d + 0.1 * UP))[0]
    assert "convex" in flaw((a, c, b, d))[0]
    assert "convex" in flaw((a, b, c, 0.2 * a + 0.2 * c + 0.6 * b))[0]
