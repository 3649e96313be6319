"""Further bounces in closed form: no light is created, none is lost in a white box, and a wall sends light back."""

from math import pi, sqrt

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.environment import LUMINANCE
from octolux.simulator.lpv import bounces, geometry, propagation
from octolux.simulator.lpv.transfer import SOLID_ANGLE_FAR, SOLID_ANGLE_SIDE

N = 12
ROUNDING = 1e-12


def everywhere(facing=1.0, albedo=1.0) -> np.ndarray:
    return bounces.reflectors(np.full((N, N, N, 6), facing), np.full((N, N, N, 3), albedo))


def random_light(lit: slice, seed: int = 0) -> np.ndarray:
    """Cells of cosine lobes of random colours; dark outside of `lit` along each axis."""
    rng = np.random.default_rng(seed)
    d = rng.normal(size=(N, N, N, 3, 3))
    light = np.zeros((N, N, N, 3, 4))
    lobes = harmonics.cosine_lobe(d / np.linalg.norm(d, axis=-1, keepdims=True)) * rng.random((N, N, N, 3, 1))
    light[lit, lit, lit] = lobes[lit, lit, lit]
    return light


def random_blockers(seed: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Shares, and what the two sides of them face: together at least what is blocked, in some cells more."""
    rng = np.random.default_rng(seed)
    facing = rng.uniform(0.0, 1.0, (N, N, N, 6)) * (rng.random((N, N, N, 1)) < 0.5)
    shares = np.minimum(facing[..., ::2] + facing[..., 1::2], 1.0)
    return shares, bounces.reflectors(facing, rng.random((N, N, N, 3)))


@pytest.mark.parametrize("evaluation", ["clamped", "dominant_lobe"])
@pytest.mark.parametrize("reprojection", propagation.REPROJECTIONS)
@pytest.mark.parametrize("spectral", [False, True])
def test_no_light_is_created(evaluation, reprojection, spectral):
    """Received and reflected are together at most what cells send in the open, in every cell and channel."""
    shares, reflectors = random_blockers()
    faces, light = geometry.face_transmittance(shares), random_light(slice(None))
    reflectance = bounces.cell_reflectance(reflectors, shares, spectral)
    free, dark, bright = (
        harmonics.flux(propagation.step(light, 1.0, evaluation, reprojection, *what))
        for what in ((), (faces,), (faces, reflectance))
    )
    assert (bright <= free * (1.0 + ROUNDING)).all()
    assert (bright >= dark).all() and bright.sum() > 1.05 * dark.sum()


@pytest.mark.parametrize("evaluation", ["signed", "dominant_lobe"])
def test_a_white_box_keeps_all_light(evaluation):
    """Full blockers, which reflect all that they block, several cells thick around a hollow. Nothing leaves the
    volume in as many steps as the lit cells are from its border."""
    shares = np.zeros((N, N, N, 3))
    shares[:] = 1.0
    shares[4:7, 4:7, 4:7] = 0.0
    light = random_light(slice(5, 7))
    faces, reflectance = geometry.face_transmittance(shares), bounces.cell_reflectance(everywhere(), shares, False)
    current = propagation.step(light, 1.0, evaluation, "travel")
    for _ in range(3):
        current = propagation.step(current, 1.0, evaluation, "travel", faces, reflectance)
    np.testing.assert_allclose(propagation.total_flux(current), propagation.total_flux(light), rtol=ROUNDING)


def test_black_blockers_change_nothing():
    shares, _ = random_blockers()
    faces, light = geometry.face_transmittance(shares), random_light(slice(None))
    black = bounces.cell_reflectance(everywhere(albedo=0.0), shares, True)
    with_black, without = (propagation.step(light, faces=faces, reflectance=r) for r in (black, None))
    np.testing.assert_array_equal(with_black, without)


def wall_at_8(facing: int) -> tuple[np.ndarray, np.ndarray]:
    """A wall across x between cells 7 and 8, which is layer 7 of the geometry volume; its surfaces face one way."""
    shares, sides = np.zeros((N, N, N, 3)), np.zeros((N, N, N, 6))
    shares[:, :, 7, 0], sides[:, :, 7, facing] = 1.0, 1.0
    return shares, bounces.reflectors(sides, np.broadcast_to((0.8, 0.4, 0.0), (N, N, N, 3)))


def test_a_wall_sends_light_back():
    """By hand: of a lobe of unit flux along +x in cell 6, cell 7 before the wall receives at its far
    face SOLID_ANGLE_FAR / pi times (1/4 + 1/2), all of which is blocked, and at its four sides SOLID_ANGLE_SIDE / pi
    times (1/4 + 1/sqrt(5)), of which each has two of its four corners in the wall: half of 2 / sqrt(5) is blocked. The
    albedo's share of that goes back along -x."""
    light = np.zeros((N, N, N, 3, 4))
    light[6, 6, 6] = harmonics.cosine_lobe([1.0, 0.0, 0.0]) / pi
    shares, reflectors = wall_at_8(facing=1)
    faces = geometry.face_transmittance(shares)
    far = SOLID_ANGLE_FAR / pi * 0.75
    sides = 4.0 * SOLID_ANGLE_SIDE / pi * (0.25 + 1.0 / sqrt(5.0))
    blocked = far + sides * 0.5 * 2.0 / sqrt(5.0)
    for spectral, albedo in ((True, np.array([0.8, 0.4, 0.0])), (False, np.array([0.8, 0.4, 0.0]) @ LUMINANCE)):
        reflectance = bounces.cell_reflectance(reflectors, shares, spectral)
        with_wall, without = (propagation.step(light, 1.0, "signed", "face", faces, r) for r in (reflectance, None))
        back = (with_wall - without)[6, 6, 7]
        expected = np.broadcast_to(albedo, (3,))[:, None] * blocked * harmonics.cosine_lobe([-1.0, 0.0, 0.0]) / pi
        np.testing.assert_allclose(back, expected, rtol=ROUNDING, atol=ROUNDING)


def test_the_back_of_a_wall_absorbs():
    light = np.zeros((N, N, N, 3, 4))
    light[6, 6, 6] = harmonics.cosine_lobe([1.0, 0.0, 0.0]) / pi
    shares, reflectors = wall_at_8(facing=0)
    faces, reflectance = geometry.face_transmittance(shares), bounces.cell_reflectance(reflectors, shares, True)
    with_wall, without = (propagation.step(light, faces=faces, reflectance=r) for r in (reflectance, None))
    np.testing.assert_array_equal(with_wall[6, 6, 7], without[6, 6, 7])


def test_a_floor_sends_up_what_passes_above_it():
    """Light along the floor: of what goes down to its face it blocks 1 / sqrt(5), and that goes up, not back."""
    light = np.zeros((N, N, N, 3, 4))
    light[6, 6, 6] = harmonics.cosine_lobe([1.0, 0.0, 0.0]) / pi
    shares, sides = np.zeros((N, N, N, 3)), np.zeros((N, N, N, 6))
    shares[:, 5, :, 1], sides[:, 5, :, 2] = 1.0, 1.0  # layer 5 is at y = 6, below cell 6
    reflectors = bounces.reflectors(sides, np.ones((N, N, N, 3)))
    faces, reflectance = geometry.face_transmittance(shares), bounces.cell_reflectance(reflectors, shares, False)
    with_floor, without = (propagation.step(light, 1.0, "signed", "face", faces, r) for r in (reflectance, None))
    blocked = SOLID_ANGLE_SIDE / pi * (0.25 + 1.0 / sqrt(5.0)) / sqrt(5.0)
    expected = blocked * harmonics.cosine_lobe([0.0, 1.0, 0.0]) / pi
    np.testing.assert_allclose((with_floor - without)[6, 6, 7, 0], expected, rtol=ROUNDING, atol=ROUNDING)


def test_the_first_step_neither_blocks_nor_reflects():
    shares, reflectors = random_blockers()
    faces, light = geometry.face_transmittance(shares), random_light(slice(None))
    reflectance = bounces.cell_reflectance(reflectors, shares, False)
    once = [propagation.propagate(light, 1, faces=f, reflectance=r) for f, r in ((faces, reflectance), (None, None))]
    np.testing.assert_array_equal(*once)


def test_corners_of_a_cell_are_the_geometry_volumes_cells():
    """Cell c has the corners c and c + 1; the geometry volume's cell g lies at corner g + 1, and none at corner 0."""
    cells = np.random.default_rng(3).random((5, 5, 5))
    found = bounces.corner_sum(cells)
    np.testing.assert_allclose(found[2, 3, 4], cells[1:3, 2:4, 3:5].sum(), rtol=ROUNDING)
    np.testing.assert_allclose(found[0, 0, 0], cells[0, 0, 0], rtol=ROUNDING)
