"""Propagation: step gain, conservation, symmetry, and how far light gets, all from closed forms.

A cosine lobe of unit flux along +x has I(w) = (1/4 + x/2) / pi in two bands. Centres of side faces are at
(2, 1, 0) / sqrt(5) from the source, so every flux below is a solid angle times 1/4 + cosine/2.
"""

from math import pi, sqrt

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.lpv import propagation
from octolux.simulator.lpv.transfer import DIRECTIONS, MOMENTS, SOLID_ANGLE_FAR, SOLID_ANGLE_SIDE, SOLID_ANGLES

ROUNDING = 1e-12
ALL = [(e, r) for e in propagation.EVALUATIONS for r in propagation.REPROJECTIONS]

# The signed step is linear: each step moves the centre by DRIFT times what is left of the direction, which a step
# shrinks to KEPT: the sum of solid angle * w.x * (what the lobe it becomes keeps of x), halved and over pi.
DRIFT = (SOLID_ANGLE_FAR + 4 * SOLID_ANGLE_SIDE * 2 / sqrt(5)) / pi
KEPT = {"face": (SOLID_ANGLE_FAR + 4 * SOLID_ANGLE_SIDE / sqrt(5)) / pi, "travel": 2 / 3}


def lone_lobe(n: int, direction=(1.0, 0.0, 0.0)) -> np.ndarray:
    """One cosine lobe of unit flux in the middle cell of an odd grid, one channel."""
    sh = np.zeros((n, n, n, 1, 4))
    unit = np.asarray(direction) / np.linalg.norm(direction)
    sh[n // 2, n // 2, n // 2, 0] = harmonics.cosine_lobe(unit) / pi
    return sh


def random_light(n: int, steepness: float, seed: int = 3) -> np.ndarray:
    """Random cells; the intensity of each is c00 Y0 (1 + steepness * d.w)."""
    rng = np.random.default_rng(seed)
    c00, d = rng.random((n, n, n, 3, 1)), rng.normal(size=(n, n, n, 3, 3))
    d /= np.linalg.norm(d, axis=-1, keepdims=True)
    return np.concatenate([c00, c00 * steepness * harmonics.Y0 / harmonics.Y1 * d], axis=-1)


def travelled(evaluation: str, reprojection: str, steps: int, n: int = 13) -> tuple[list[float], list[float]]:
    """Position along +x and total flux after each step of a lone lobe."""
    sh, centres, fluxes = lone_lobe(n), [], []
    for _ in range(steps):
        sh = propagation.step(sh, evaluation=evaluation, reprojection=reprojection)
        centres.append(float(propagation.centre_of_mass(sh)[0, 0]) - n // 2)
        fluxes.append(float(propagation.total_flux(sh)[0]))
    return centres, fluxes


@pytest.mark.parametrize("reprojection", propagation.REPROJECTIONS)
@pytest.mark.parametrize("evaluation", ["signed", "dominant_lobe"])
def test_step_gain_is_the_gain(evaluation, reprojection):
    sh = np.pad(random_light(3, 1.7), [(1, 1)] * 3 + [(0, 0)] * 2)
    before = propagation.total_flux(sh)
    after = propagation.total_flux(propagation.step(sh, 0.75, evaluation, reprojection))
    np.testing.assert_allclose(after, 0.75 * before, rtol=ROUNDING)


@pytest.mark.parametrize("evaluation", ["signed", "dominant_lobe"])
def test_flux_is_kept_until_light_reaches_the_border(evaluation):
    """Light moves one cell a step: of a 9^3 grid it first leaves in step 5, and then some is lost."""
    sh = lone_lobe(9, (3, 2, 1))
    for _ in range(4):
        sh = propagation.step(sh, evaluation=evaluation)
        np.testing.assert_allclose(propagation.total_flux(sh), 1.0, rtol=ROUNDING)
    sent = propagation.face_flux(sh, evaluation).sum(axis=-1)[..., 0, :]
    border = [
        sent[:, :, -1, 0],
        sent[:, :, 0, 1],
        sent[:, -1, :, 2],
        sent[:, 0, :, 3],
        sent[-1, :, :, 4],
        sent[0, :, :, 5],
    ]
    lost = sum(face.sum() for face in border)
    assert lost > 1e-6
    np.testing.assert_allclose(
        propagation.total_flux(propagation.step(sh, evaluation=evaluation)), 1.0 - lost, rtol=ROUNDING
    )


def test_clamped_step_of_a_lobe_gains_once():
    """What clamping removes of a lobe along an axis is all of the negative flux through the five faces behind it."""
    behind = SOLID_ANGLE_FAR * (1 / 4 - 1 / 2) + 4 * SOLID_ANGLE_SIDE * (1 / 4 - 1 / sqrt(5))
    _, fluxes = travelled("clamped", "face", 6)
    np.testing.assert_allclose(fluxes, 1.0 - behind / pi, rtol=ROUNDING)
    assert 1.12 < fluxes[0] < 1.14


def test_non_negative_light_gains_nothing_and_stays_non_negative():
    """The claim behind "constant afterwards": 1 + u.w with |u| <= 1 is never clamped, and what it becomes in a
    neighbour through faces f of flux F_f is non-negative everywhere iff |sum F_f n_f| <= sum F_f / 2. Both sides are
    convex and linear in u, so |u| = 1 is the worst case."""
    sh = random_light(5, 1.0)
    np.testing.assert_allclose(
        propagation.step(sh, evaluation="clamped"), propagation.step(sh, evaluation="signed"), atol=ROUNDING
    )
    after = propagation.step(sh, evaluation="clamped")
    lowest = harmonics.Y0 * after[..., 0] - harmonics.Y1 * np.linalg.norm(after[..., 1:], axis=-1)
    assert lowest.min() > 0.0


@pytest.mark.parametrize("reprojection", propagation.REPROJECTIONS)
def test_signed_centre_of_mass_is_a_geometric_series(reprojection):
    kept = KEPT[reprojection]
    expected = DRIFT * (1 - kept ** np.arange(1, 7)) / (1 - kept)
    np.testing.assert_allclose(travelled("signed", reprojection, 6)[0], expected, rtol=ROUNDING)


def test_signed_limits_are_those_published():
    assert DRIFT / (1 - KEPT["face"]) == pytest.approx(0.97, abs=0.005)
    assert DRIFT / (1 - KEPT["travel"]) == pytest.approx(1.83, abs=0.005)


def test_clamped_centre_of_mass():
    """The first step is written out; after it nothing is negative and the signed series continues."""
    ahead = SOLID_ANGLE_FAR * 3 / 4 + 4 * SOLID_ANGLE_SIDE * (1 / 4 + 1 / sqrt(5))
    sideways = 4 * (SOLID_ANGLE_FAR / 4 + 4 * SOLID_ANGLE_SIDE / 4)
    towards_x = SOLID_ANGLE_FAR * 3 / 4 + 4 * SOLID_ANGLE_SIDE / sqrt(5)
    total = ahead + sideways
    drift = DRIFT * towards_x / total
    expected = ahead / total + drift * (1 - KEPT["face"] ** np.arange(6)) / (1 - KEPT["face"])
    np.testing.assert_allclose(travelled("clamped", "face", 6)[0], expected, rtol=ROUNDING)
    np.testing.assert_allclose(expected[:3], [0.41, 0.59, 0.66], atol=0.0055)
    assert ahead / total + drift / (1 - KEPT["face"]) == pytest.approx(0.70, abs=0.005)


def test_dominant_lobe_first_step():
    """A pure lobe along +x splits by the x of the moments: five faces ahead, and of each of the four sideways
    neighbours only the side face towards +x. What goes ahead is also the distance travelled."""
    ahead = MOMENTS[0, :, 0].sum()
    sideways = 4 * MOMENTS[2, 1, 0]
    flux = propagation.face_flux(harmonics.cosine_lobe([1.0, 0.0, 0.0]) / pi, "dominant_lobe")
    np.testing.assert_allclose(flux[0], MOMENTS[0, :, 0] / (ahead + sideways), rtol=ROUNDING)
    assert flux.min() == 0.0
    assert flux[1].max() == 0.0
    centres, fluxes = travelled("dominant_lobe", "face", 1)
    np.testing.assert_allclose([centres[0], fluxes[0]], [ahead / (ahead + sideways), 1.0], rtol=ROUNDING)


@pytest.mark.parametrize("evaluation", propagation.EVALUATIONS)
def test_isotropic_light_leaves_through_solid_angles(evaluation):
    flux = propagation.face_flux(np.array([1.0, 0, 0, 0]), evaluation)
    np.testing.assert_allclose(flux / (2 * sqrt(pi)), SOLID_ANGLES / (4 * pi), rtol=ROUNDING)


@pytest.mark.parametrize(("evaluation", "reprojection"), ALL)
def test_furnace_stays_a_furnace(evaluation, reprojection):
    sh = np.zeros((5, 5, 5, 1, 4))
    sh[..., 0] = 2.0
    middle = propagation.step(sh, 1.0, evaluation, reprojection)[1:-1, 1:-1, 1:-1]
    np.testing.assert_allclose(middle[..., 0], 2.0, rtol=ROUNDING)
    np.testing.assert_allclose(middle[..., 1:], 0.0, atol=ROUNDING)


@pytest.mark.parametrize(("evaluation", "reprojection"), ALL)
def test_step_against_a_loop_over_cells(evaluation, reprojection):
    sh = random_light(3, 1.5)
    expected = np.zeros_like(sh)
    lobes = propagation.reprojection_lobes(reprojection)
    for z, y, x in np.ndindex(3, 3, 3):
        for travel, (dx, dy, dz) in enumerate(DIRECTIONS):
            source = np.array([z - dz, y - dy, x - dx])
            if (source >= 0).all() and (source < 3).all():
                flux = propagation.face_flux(sh[tuple(source)], evaluation)[:, travel]
                expected[z, y, x] += np.einsum("cf,fk->ck", flux, lobes[travel])
    np.testing.assert_allclose(propagation.step(sh, 1.0, evaluation, reprojection), expected, atol=ROUNDING)


@pytest.mark.parametrize(("evaluation", "reprojection"), ALL)
def test_step_commutes_with_turning_the_world(evaluation, reprojection):
    """Quarter turn about z: x to y, y to -x. In [z][y][x] the new cell (x', y') = (-y, x)."""
    quarter = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])

    def turn(sh: np.ndarray) -> np.ndarray:
        return harmonics.rotate(np.swapaxes(sh, 1, 2)[:, :, ::-1], quarter)

    sh = random_light(4, 1.5)
    stepped = propagation.step(sh, 1.0, evaluation, reprojection)
    np.testing.assert_allclose(propagation.step(turn(sh), 1.0, evaluation, reprojection), turn(stepped), atol=ROUNDING)


def test_propagate_accumulates_every_step():
    sh = random_light(3, 1.0)
    first = propagation.step(sh)
    np.testing.assert_allclose(propagation.propagate(sh, 2), sh + first + propagation.step(first), rtol=ROUNDING)
    np.testing.assert_array_equal(propagation.propagate(sh, 0), sh)


def test_unknown_names_are_refused():
    sh = np.zeros((2, 2, 2, 3, 4))
    with pytest.raises(ValueError, match="unknown evaluation 'clampd'"):
        propagation.step(sh, evaluation="clampd")
    with pytest.raises(ValueError, match="unknown reprojection 'back'"):
        propagation.step(sh, reprojection="back")
    with pytest.raises(ValueError, match="negative"):
        propagation.propagate(sh, -1)
