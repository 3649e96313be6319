"""The BRDF: reciprocity, normalisation and energy, by quadrature over the hemisphere."""

from math import pi

import numpy as np
import pytest

from octolux.simulator import brdf, sh

UP = np.array([0.0, 0.0, 1.0])


def hemisphere(samples: int) -> tuple[np.ndarray, np.ndarray]:
    directions, weights = sh.sphere_quadrature(samples)
    above = directions[:, 2] > 0.0
    return directions[above], weights[above]


def view(degrees: float) -> np.ndarray:
    return np.array([np.sin(np.radians(degrees)), 0.0, np.cos(np.radians(degrees))])


def directional_albedo(material: brdf.Surface, to_eye: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Share of a white furnace that the diffuse and the specular part send to the eye, each (3,)."""
    to_light, weights = hemisphere(96)
    parts = brdf.diffuse_and_specular(material, UP, to_light, to_eye)
    diffuse, specular = (np.einsum("m,m,mc->c", weights, to_light[:, 2], part) for part in parts)
    return diffuse, specular


def test_reciprocity():
    rng = np.random.default_rng(8)
    a, b = rng.normal(size=(2, 200, 3))
    a[:, 2], b[:, 2] = np.abs(a[:, 2]), np.abs(b[:, 2])
    a, b = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (a, b))
    material = brdf.surface(rng.random((200, 3)), rng.random(200), rng.random(200), rng.random(200))
    np.testing.assert_allclose(brdf.evaluate(material, UP, a, b), brdf.evaluate(material, UP, b, a), rtol=1e-10)


def test_no_specular_is_exactly_lambert():
    directions, _ = hemisphere(8)
    base = np.array([0.9, 0.3, 0.1])
    found = brdf.evaluate(brdf.surface(base, specular=0.0, roughness=0.2), UP, directions, directions[::-1])
    np.testing.assert_array_equal(found, np.broadcast_to(base / pi, found.shape))


@pytest.mark.parametrize("roughness", [0.4, 0.7, 1.0])
def test_distribution_is_normalised(roughness):
    """The projected area of the microfacets is the area of the surface: integral of D n.h is 1. D is rational in z^2
    with poles sqrt(1 / (1 - alpha^2)) from the origin, 0.013 or more beyond the interval; 96 nodes of half length
    0.5 leave less than (1 + sqrt(2 * 0.026))^-192 = 1e-17."""
    directions, weights = hemisphere(96)
    distribution = brdf.ggx_distribution(directions[:, 2], brdf.alpha_of(roughness))
    assert np.sum(weights * directions[:, 2] * distribution) == pytest.approx(1.0, abs=1e-12)


def test_visibility_is_height_correlated_smith():
    """4 n.l n.v V = 1 / (1 + Lambda(l) + Lambda(v)), Lambda = (sqrt(1 + alpha^2 tan^2) - 1) / 2 (Heitz 2014)."""
    cosines = np.linspace(0.05, 1.0, 12)
    n_dot_l, n_dot_v = np.meshgrid(cosines, cosines)
    for alpha in (0.05, 0.4, 1.0):
        smith_l, smith_v = (0.5 * (np.sqrt(1 + alpha**2 * (1 / c**2 - 1)) - 1) for c in (n_dot_l, n_dot_v))
        masking = 4 * n_dot_l * n_dot_v * brdf.smith_visibility(n_dot_l, n_dot_v, alpha)
        np.testing.assert_allclose(masking, 1 / (1 + smith_l + smith_v), rtol=1e-12)


@pytest.mark.parametrize("degrees", [0.0, 40.0, 70.0])
@pytest.mark.parametrize("roughness", [0.5, 0.75, 1.0])
def test_white_furnace_gains_nothing(degrees, roughness):
    """A white metal loses what a second bounce between facets would return; a dielectric's parts stay in their shares:
    the diffuse part below its albedo, the specular below that of a metal, since F <= 1."""
    _, metal = directional_albedo(brdf.surface(np.ones(3), 1.0, roughness), view(degrees))
    diffuse, specular = directional_albedo(brdf.surface(np.full(3, 0.8), 0.0, roughness), view(degrees))
    assert 0.3 < metal.max() <= 1.0
    assert 0.0 < diffuse.max() <= 0.8
    assert 0.0 < specular.max() <= metal.max()


@pytest.mark.parametrize("roughness", [0.5, 1.0])
def test_white_dielectric_gains_nothing_head_on(roughness):
    """Seen from straight above, v.h >= cos 45 deg, so F <= 0.04 + 0.96 (1 - cos 45 deg)^5 = 0.042: the whole is at most
    (1 - 0.04) + 0.042 = 1.002, the size of the flaw of one Fresnel term for both parts."""
    diffuse, specular = directional_albedo(brdf.surface(np.ones(3), 0.0, roughness), UP)
    assert (diffuse + specular).max() <= (1 - 0.04) + 0.04 + 0.96 * (1 - np.cos(pi / 4)) ** 5


def test_mirror_peak_of_a_metal_has_its_colour():
    base = np.array([1.0, 0.6, 0.2])
    found = brdf.evaluate(brdf.surface(base, 1.0, 0.3), UP, UP, UP)
    np.testing.assert_allclose(found, base / (4 * pi * 0.3**4))


def test_grazing_reflectance_of_metal_and_dielectric_is_one():
    _, f0, f90 = brdf.reflectances(brdf.surface(np.array([0.5, 0.5, 0.5]), np.array(0.0)))
    np.testing.assert_allclose(f0, 0.04)
    np.testing.assert_allclose(brdf.schlick_fresnel(f0, f90, 0.0), 1.0)
    np.testing.assert_allclose(brdf.schlick_fresnel(f0, f90, 1.0), 0.04)


def test_nothing_from_below():
    material = brdf.surface(np.ones(3), 0.5, 0.5)
    np.testing.assert_array_equal(brdf.evaluate(material, UP, view(100.0), UP), 0.0)


def test_lambert_from_wherever_it_is_seen():
    """A shading normal may lean away from the eye; the light on it is reflected all the same."""
    base = np.array([0.9, 0.3, 0.1])
    directions, _ = hemisphere(8)
    found = brdf.evaluate(brdf.surface(base, specular=0.0), UP, directions, -directions[::-1])
    np.testing.assert_array_equal(found, np.broadcast_to(base / pi, found.shape))


@pytest.mark.parametrize("roughness", [0.5, 0.7, 1.0])
def test_an_eye_below_the_horizon_gains_nothing(roughness):
    """Nor is there a step at the horizon: 1e-9 to each side of it V changes by 1e-9 / (n.l alpha) of itself, n.l being
    above 1e-4 at the hemisphere's nodes. Further down a white metal reflects less, but at roughness 1, where D and V
    are the same for all, 1 / pi and 1 / (2 n.l): all light, to the rounding of 10^4 terms."""
    metal = brdf.surface(np.ones(3), 1.0, roughness)
    across, below = (np.array([[np.cos(a), 0.0, np.sin(a)] for a in angles]) for angles in ((1e-9, -1e-9), (-0.2, -1)))
    over, under = (directional_albedo(metal, eye)[1].max() for eye in across)
    assert over == pytest.approx(under, rel=1e-9 / (1e-4 * roughness**2) * 2)
    shallow, steep = (directional_albedo(metal, eye)[1].max() for eye in below)
    assert 0.0 < steep <= shallow * (1 + 1e-10) and shallow <= 1.0 + 1e-10


def test_smooth_surfaces_stay_finite():
    found = brdf.evaluate(brdf.surface(np.ones(3), 1.0, 0.0), UP, UP, UP)
    np.testing.assert_allclose(found, 1.0 / (4 * pi * brdf.MIN_ROUGHNESS**4))
