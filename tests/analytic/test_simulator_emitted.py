"""Low-frequency direct light as records: flux and first moments in closed form, and where injection puts them."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

import numpy as np
import pytest

from octolux.scene.environment import Environment
from octolux.scene.particles import ParticleLights
from octolux.simulator import sh
from octolux.simulator.environment import texel_directions, texel_solid_angles
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import emitted
from octolux.simulator.lpv.injection import inject as inject_vpls
from octolux.simulator.lpv.propagation import total_flux
from octolux.simulator.lpv.transfer import DIRECTIONS

GRID = Grid((-2.0, -1.0, 0.5), 0.25, 16)
SQUARE = np.array([[[0, 0, 0], [2, 0, 0], [2, 1, 0]], [[0, 0, 0], [2, 1, 0], [0, 1, 0]]], dtype=np.float64)
LIGHT = np.array([1.0, 2.0, 4.0])
FACE = (16 * 0.25) ** 2

TEXEL = 1.5 * (pi / 128) ** 2
"""Relative error of what is summed over texels of pi / 128 rad: what is summed is a cosine times a sine over half a
turn, or its square, whose second derivative is at most 4 times the function's largest value. The midpoint rule errs by
h^2 / 24 of the second derivative's integral, at most 4 * 2 h^2 / 24 = h^2 / 3 along each of the two angles; and where
the horizon cuts a texel's kink, by h^2 / 8 of the slope's change, once a side: below 1.5 h^2 in all."""


def sky(height: int = 128) -> Environment:
    """Radiance LIGHT above the horizon, none below."""
    image = np.zeros((height, 2 * height, 3), np.float32)
    image[: height // 2] = LIGHT
    return Environment(image=image)


def injected_flux(records: emitted.Emitted, grid: Grid = GRID) -> np.ndarray:
    return total_flux(emitted.inject(records, [grid])[0])


def test_particles_send_four_pi_times_their_intensity_evenly():
    rng = np.random.default_rng(1)
    group = ParticleLights(positions=rng.uniform(-0.9, 1.9, (1000, 3)) * [1, 1, 0] + [0, 0, 2],
                           intensities=rng.random((1000, 3)))  # fmt: skip
    records = emitted.particle_records([group, group])
    cells = emitted.inject(records, [GRID])[0]
    np.testing.assert_allclose(total_flux(cells), 2 * 4 * pi * group.intensities.sum(axis=0), rtol=1e-12)
    assert not cells[..., 1:].any()


def test_a_particle_stays_in_its_cell():
    group = ParticleLights(positions=[GRID.cell_centres()[3, 4, 5] + 0.49 * GRID.cell_size], intensities=LIGHT)
    cells = emitted.inject(emitted.particle_records([group]), [GRID])[0]
    np.testing.assert_allclose(sh.evaluate(cells[3, 4, 5], np.array([0.6, 0.0, -0.8])), LIGHT)
    assert np.count_nonzero(cells) == 3


@pytest.mark.parametrize("longest", [3.0, 0.5, 0.11])
def test_patches_keep_flux_and_direction_and_are_small_enough(longest):
    corners, _ = emitted.bisected(SQUARE, longest, emitted.MOST_PATCHES)
    assert np.linalg.norm(np.roll(corners, -1, axis=1) - corners, axis=2).max() <= longest
    records = emitted.patch_records(SQUARE, np.stack([LIGHT, 3 * LIGHT]), longest)
    np.testing.assert_allclose(records.flux.sum(axis=0), pi * LIGHT + 3 * pi * LIGHT, rtol=1e-12)
    np.testing.assert_allclose(records.axis, np.tile([0.0, 0.0, 1.0], (len(records.beam), 1)), atol=1e-12)
    centre = (records.position * records.flux[:, :1]).sum(axis=0) / records.flux[:, 0].sum()
    np.testing.assert_allclose(centre, (np.array([4.0, 1.0, 0]) / 3 + np.array([2.0, 2.0, 0])) / 4, rtol=1e-12)


def test_cutting_patches_ends_when_there_are_enough():
    assert len(emitted.bisected(SQUARE, 1e-6, 100)[0]) == 64  # two, doubled in each round
    assert len(emitted.bisected(np.zeros((0, 3, 3)), 1.0, 100)[0]) == 0
    with pytest.raises(ValueError, match="positive"):
        emitted.bisected(SQUARE, 0.0, 100)


def test_patches_are_injected_as_vpls_of_their_normal():
    rng = np.random.default_rng(2)
    corners = rng.uniform([-0.5, -0.5, 0.5], [1.5, 1.5, 2.5], (200, 1, 3)) + rng.uniform(-0.1, 0.1, (200, 3, 3))
    records = emitted.patch_records(corners, rng.random((200, 3)), 1.0)
    expected = inject_vpls(records.position, records.axis, records.flux, GRID)
    np.testing.assert_allclose(emitted.inject(records, [GRID])[0], expected, atol=1e-15)


def test_even_surroundings_send_pi_l_through_each_face_as_a_cosine_lobe():
    light, moment = emitted.face_light(Environment(tuple(LIGHT)))
    np.testing.assert_allclose(light, np.tile(pi * LIGHT, (6, 1)), rtol=TEXEL)
    inward = -DIRECTIONS[:, None, :] * LIGHT[:, None]
    np.testing.assert_allclose(moment, 2 * pi / 3 * inward, atol=TEXEL * 2 * pi / 3 * LIGHT.max())
    records = emitted.environment_records(Environment(tuple(LIGHT)), GRID)
    np.testing.assert_allclose(records.beam, 1.0, atol=2 * TEXEL)
    np.testing.assert_allclose(injected_flux(records), 6 * FACE * pi * LIGHT, rtol=TEXEL)


def test_a_sky_above_the_horizon_alone():
    """pi L through the top, half of that through each side, none through the bottom. A side's moment: with z along its
    normal and y up, the integral of L cos (cos, sin sin phi) over half the hemisphere is L (pi / 3, 2 / 3)."""
    light, moment = emitted.face_light(sky())
    np.testing.assert_allclose(light, np.outer([0.5, 0.5, 1.0, 0.0, 0.5, 0.5], pi * LIGHT), rtol=TEXEL, atol=1e-12)
    np.testing.assert_allclose(
        moment[0], np.outer(LIGHT, [-pi / 3, -2 / 3, 0.0]), atol=TEXEL * 2 * pi / 3 * LIGHT.max()
    )
    np.testing.assert_allclose(injected_flux(emitted.environment_records(sky(), GRID)), 3 * FACE * pi * LIGHT,
                               rtol=TEXEL)  # fmt: skip


@pytest.mark.parametrize("size", [(20, 40), (64, 128), (250, 500), (1024, 2048)])
@pytest.mark.parametrize("rotation", [0.0, 1.1])
def test_a_lone_bright_texel_counts_wholly(size, rotation):
    """What opposite faces receive differs by the integral of L d: of a texel L dw times its direction. Read bilinearly
    it reaches a width w to each side, in the map that is summed: its mean direction is at least cos(sqrt(2) w), 1 -
    w^2, long and as near to its middle, and the weights sin(polar angle) over it are their middle's within w^2."""
    height, width = size
    image = np.zeros((height, width, 3), np.float32)
    row, column = height // 3, width // 2
    image[row, column] = LIGHT
    light, _ = emitted.face_light(Environment(image=image, rotation=rotation))
    direction = texel_directions(height, width, rotation)[row, column]
    power = texel_solid_angles(height, width)[row] * LIGHT
    w = 2 * pi / min(width, 250)
    halved = {500: 1, 2048: 3}.get(width, 0)  # the texel then lies beside the middle of its larger one
    shift = pi / height * (2**halved - 1)
    away = 2 * w**2 + shift
    np.testing.assert_allclose((light[0::2] - light[1::2]).T, np.outer(power, direction), atol=away * power.max())
    np.testing.assert_allclose(np.linalg.norm(light[0::2] - light[1::2], axis=0), power, rtol=2 * w**2)


def test_light_enters_in_the_outer_cells_with_the_first_moment_of_what_passed_the_faces():
    """Each channel's light comes from elsewhere. Corner cells have three faces, those of edges two, others one."""
    image = np.random.default_rng(4).random((32, 64, 3)).astype(np.float32) ** 6
    environment = Environment((0.1, 0.0, 0.0), image, 0.3)
    light, moment = emitted.face_light(environment)
    cells = emitted.inject(emitted.environment_records(environment, GRID), [GRID])[0]
    assert not cells[1:-1, 1:-1, 1:-1].any()
    area = GRID.cell_size**2
    for (z, y, x), faces in {(8, 8, 0): [1], (15, 8, 8): [4], (0, 0, 7): [3, 5], (15, 15, 15): [0, 2, 4]}.items():
        np.testing.assert_allclose(sh.flux(cells[z, y, x]), area * light[faces].sum(axis=0), rtol=1e-12)
        np.testing.assert_allclose(sh.vector(cells[z, y, x]), sh.Y1 * area * moment[faces].sum(axis=0), atol=1e-12)


def test_channels_of_one_lobe_share_a_record_and_dark_ones_have_none():
    assert len(emitted.environment_records(Environment((1.0, 2.0, 3.0)), GRID).beam) == 6 * 16**2
    assert len(emitted.environment_records(Environment((0.0, 2.0, 0.0)), GRID).beam) == 6 * 16**2
    assert len(emitted.environment_records(sky(), GRID).beam) == 5 * 16**2
    assert len(emitted.environment_records(Environment(), GRID).beam) == 0
    image = np.zeros((32, 64, 3), np.float32)
    image[4, 10, 0], image[9, 40, 1:] = 1e3, 1e3
    seen = (DIRECTIONS @ texel_directions(32, 64)[[4, 9], [10, 40]].T > 0).any(axis=1)
    lobes = emitted.environment_records(Environment((1.0, 1.0, 1.0), image), GRID)
    assert len(lobes.beam) == np.where(seen, 3, 1).sum() * 16**2


def test_parallel_light_has_the_longest_beam():
    image = np.zeros((512, 1024, 3), np.float32)
    image[40, 100] = 1.0
    beams = emitted.environment_records(Environment(image=image), GRID).beam
    assert 1.499 < beams.min() <= beams.max() <= emitted.MOST_BEAM


def test_each_of_nested_grids_takes_what_it_holds():
    """Moved by half a cell of its own."""
    fine, coarse = Grid((0.0, 0.0, 0.0), 0.5, 4), Grid((-1.0, -1.0, -1.0), 1.0, 4)
    turn = radians(30)
    records = emitted.Emitted(
        position=np.array([[0.25, 0.25, 0.25], [1.9, 1.0, 1.0], [2.6, 1.0, 1.0], [2.9, 1.0, 1.0], [-0.2, 0.3, 0.3]]),
        flux=np.ones((5, 3)), axis=np.tile([cos(turn), sin(turn), 0.0], (5, 1)),
        beam=np.array([0.0, 1.0, 0.0, 1.0, 1.0]),
    )  # fmt: skip
    light = emitted.inject(records, [fine, coarse])
    # The second is moved out of the fine grid by 0.25 cos 30, the last one into it; the fourth leaves both.
    np.testing.assert_allclose([sh.flux(level[..., 0, :]).sum() for level in light], [2.0, 4.0])
    assert light[0, 0, 0, 0, 0, 0] == pytest.approx(2 * sh.COSINE_LOBE_0 / pi)
    # From where they are, not from where they have been moved to: in cells from the middle.
    moments = emitted.inject_moments(records, [fine, coarse]) / (3 * sh.COSINE_LOBE_0 / pi)
    np.testing.assert_allclose(moments[0, 0, 0, 0], [0.0 - 0.9, 0.0 + 0.1, 0.0 + 0.1], atol=1e-12)
    np.testing.assert_allclose(moments[1, 1, 1, 1], [-0.25 - 0.7, -0.25 - 0.2, -0.25 - 0.2], atol=1e-12)
    np.testing.assert_allclose(moments[1, 2, 2, 3], [0.1 - 0.6, -0.5 - 0.5, -0.5 - 0.5], atol=1e-12)


@pytest.mark.parametrize("slope", [0.0, 0.3, -0.3])
def test_a_narrow_sky_enters_grids_within(slope):
    """At the side that they share with the outer one, whatever their cells' size: all that its cells there have."""
    image = np.zeros((512, 1024, 3), np.float32)
    towards = np.array([-1.0, 0.0, slope]) / np.hypot(1.0, slope)
    image[np.unravel_index((texel_directions(512, 1024) @ towards).argmax(), image.shape[:2])] = LIGHT
    records = emitted.environment_records(Environment(image=image), GRID)
    low, h = np.array(GRID.origin), GRID.cell_size
    assert records.beam.max() > 1.49
    for size in (0.5, 0.25, 0.125):
        within = Grid(tuple(low + h * np.array([0.0, 8.0 - 8.0 * size, 8.0 - 8.0 * size])), size * h, 16)
        edge = slice(int(8 - 8 * size), int(8 + 8 * size))
        outer = emitted.inject(records, [GRID])[0][edge, edge, :1]
        np.testing.assert_allclose(injected_flux(records, within), total_flux(outer), rtol=1e-9)


def test_no_sum_of_coefficients_exceeds_that_of_the_bound():
    records = emitted.Emitted(np.zeros((2, 3)), np.array([[1.0, 2.0, 0.0], [3.0, 0.0, 0.0]]),
                              np.array([[0.0, 0.0, 1.0], [0.0, 0.0, 1.0]]), np.array([0.2, 1.5]))  # fmt: skip
    np.testing.assert_allclose(records.bound, [5.5, 2.0, 0.0])
    largest = np.abs(emitted.coefficients(records)).max(axis=-1).sum(axis=0)
    assert (largest <= records.bound * sqrt(pi / 3) / pi).all()
