"""Cones through voxels (simulator/voxels/cones.py) against closed forms."""

from __future__ import annotations

from functools import cache
from math import pi

import numpy as np
import pytest

from octolux.scene.cameras import Camera
from octolux.simulator.form_factors import point_to_parallel_square
from octolux.simulator.gtao import Seen
from octolux.simulator.voxels.cones import COVERS, Traced, diffuse_samples, gather, specular_light
from octolux.simulator.voxels.directions import PHASES, directions
from octolux.simulator.voxels.facing import FacingVoxels
from octolux.simulator.voxels.filtering import filtered
from octolux.simulator.voxels.starts import cone_start

DEPTH, N = 6, 64
UP = np.array([[0.0, 1.0, 0.0]])
LOW, HIGH = 1, N - 2  # the layers of voxels that walls lie in, as simulator/voxels/surfaces.py, `around`, places them
FLOOR = LOW + 0.5
RADIANCE = np.array([3.0, 1.0, 0.25])
PHASE_CHOICE = (0, 5, 10, 15)  # where all 16 would only be slower
FLOOR_WAY, CEILING_WAY, WALL_WAY = 2, 3, 0  # of surfaces.DIRECTIONS: what looks up, down, along x


def walls(*ways: int, low: int = LOW, high: int = HIGH, radiance=RADIANCE) -> FacingVoxels:
    """A cube's walls in layers `low` and `high`, those that look along `ways` into it."""
    facing = np.zeros((N, N, N, 6))
    for way in ways:
        place = [slice(low, high + 1)] * 3
        place[2 - way // 2] = slice(low, low + 1) if way % 2 == 0 else slice(high, high + 1)
        facing[(*place, way)] = 1.0
    return FacingVoxels(facing, facing[..., None] * radiance)


@cache
def room() -> FacingVoxels:
    return walls(*range(6))


def on_floor(count: int, low: float = LOW + 1.5, high: float = HIGH - 0.5, floor: float = FLOOR) -> np.ndarray:
    points = np.random.default_rng(0).uniform(low, high, (count, 3))
    points[:, 1] = floor
    return points


def light(voxels: FacingVoxels, points, normals=UP, **options):
    return gather(voxels, DEPTH, points, np.broadcast_to(normals, np.shape(points)), **options)


@pytest.mark.parametrize("count", [4, 5, 8, 12, 16])
def test_directions_are_spread_by_the_cosine(count):
    """Their mean is that of the cosine lobe, 2/3 along its axis, and so are the squares: 1/4, 1/4, 1/2. Each direction
    stands for 1 / (16 count) of the disc, 1/8 across for 4 cones: a tenth of that is off."""
    every = np.concatenate([directions(count, phase) for phase in range(PHASES)])
    assert np.allclose(np.linalg.norm(every, axis=1), 1.0)
    assert np.abs(every.mean(axis=0) - [0.0, 0.0, 2 / 3]).max() <= 0.0125
    assert np.abs(every.T @ every / len(every) - np.diag([0.25, 0.25, 0.5])).max() <= 0.02
    assert every[:, 2].min() > 0.0


@pytest.mark.parametrize("layer", [20, 27, 31])
@pytest.mark.parametrize("place", [0.0, 0.5, 1.0])
def test_a_thin_floor_does_not_hide_the_sky_from_itself(layer, place):
    """It looks up and down; wherever it lies in its voxels, and these in those of coarser levels."""
    facing = np.zeros((N, N, N, 6))
    facing[:, layer, :, [FLOOR_WAY, CEILING_WAY]] = 1.0
    points = on_floor(20, floor=layer + place)
    received, visible = light(FacingVoxels(facing, facing[..., None] * RADIANCE), points)
    np.testing.assert_allclose(visible, 1.0, atol=1e-9)
    assert not received.any()


@pytest.mark.parametrize("count", [3, 17])
def test_counts_of_cones(count):
    with pytest.raises(ValueError, match="4 to 16"):
        directions_and_samples(count)


def directions_and_samples(count: int):
    return directions(count, 0), diffuse_samples(count, DEPTH)


@pytest.mark.parametrize("per_level", [1, 2])
def test_samples_stand_for_the_whole_way(per_level):
    """Each begins where the former ends, in voxels of level 0, and its voxels are as large as the cone or up to
    2^(1 / per_level) times too small; but for the first, where there are none so small, and the coarsest level."""
    found = diffuse_samples(8, DEPTH, per_level)
    ends = np.cumsum([s.step * 2.0**s.level for s in found])
    near = [s for s in found if s.distance < found[0].distance * 4 and s.level == 0 and s.step < 1.2]
    assert np.allclose([s.distance for s in found[len(near) :]], ends[len(near) - 1 : -1])
    assert ends[-1] > np.sqrt(3.0) * N
    levels = [s.level for s in found]
    assert levels == sorted(levels) and set(levels) == set(range(DEPTH))


@pytest.mark.parametrize("cover", COVERS)
@pytest.mark.parametrize("opacity", [0.05, 0.15])
def test_a_slab_does_not_depend_on_the_step(cover, opacity):
    """Five voxels thick, across the way of a tight cone: 1 - 5 o, or (1 - o)^5."""
    facing = np.zeros((N, N, N, 6))
    facing[30:35, :, :, 5] = opacity  # looks down along z
    voxels = FacingVoxels(facing, facing[..., None] * RADIANCE)
    start, up = np.array([[20.3, 30.1, 5.2]]), np.array([[0.0, 0.0, 1.0]])
    left = [
        specular_light(voxels, DEPTH, start, up, up, up, 0.0, step=step, cover=cover)[1].left[0]
        for step in (0.125, 0.25, 0.5, 1.0)
    ]
    expected = 1.0 - 5.0 * opacity if cover == "surfaces" else (1.0 - opacity) ** 5
    assert np.abs(np.array(left) - expected).max() <= 0.02


@pytest.mark.parametrize("count", [4, 8, 16])
def test_an_open_floor_sees_all_of_the_sky(count):
    """Though its own voxels reach into every cone: they look up, and hide nothing from below."""
    floor = walls(FLOOR_WAY)
    irradiance, visible = light(floor, on_floor(20), count=count, sky=lambda d: np.tile(RADIANCE, (len(d), 1)))
    assert visible.min() >= 0.95
    assert np.abs(irradiance / (pi * RADIANCE) - 1.0).max() <= 0.03


@pytest.mark.parametrize("count", [8, 16])
def test_no_sky_in_a_closed_box(count):
    _, visible = light(room(), on_floor(40), count=count)
    assert visible.max() <= 0.05


@pytest.mark.parametrize("away", [0.01, 0.3, 0.7, 1.5])
def test_cones_start_outside_of_other_walls(away):
    """In a corner they start a voxel away from the wall beside, if the eye shows on which side it is, and no sky comes
    through that; half of it is behind them else. In the open they start where they did."""
    points, eye = on_floor(12, high=HIGH - 1.5), np.full((12, 3), 1.0 / np.sqrt(3.0))
    points[:, 0] = LOW + 0.5 + away
    moved = cone_start(room(), DEPTH, points, np.broadcast_to(UP, (12, 3)), eye, 1.0)
    open_floor = np.add(points, [max(1.0 - away, 0.0), 1.0, 0.0])
    np.testing.assert_allclose(moved, open_floor, atol=1e-9)
    assert light(room(), points, to_eye=eye)[1].max() <= 0.05
    if away < 0.1:
        assert light(room(), points)[1].min() >= 0.15


def test_few_wide_cones_see_past_the_edges_of_a_box():
    """Whose coarse voxels are half empty: four cones are as wide as they are far, and lose more there."""
    _, visible = light(room(), on_floor(40), count=4)
    assert visible.mean() <= 0.05
    assert visible.max() <= 0.15


@pytest.mark.parametrize(("count", "per_level"), [(8, 1), (8, 2), (16, 2)])
def test_white_furnace(count, per_level):
    """Between walls of radiance L: pi L, at all places of all walls. No more than that arrives in any case, as cones'
    shares add up to 1 at most."""
    lost = []
    for axis, sign in ((0, 1), (0, -1), (1, 1), (1, -1), (2, 1), (2, -1)):
        points = np.random.default_rng(axis).uniform(LOW + 1.5, HIGH - 0.5, (6, 3))
        points[:, axis] = FLOOR if sign > 0 else HIGH + 0.5
        found, _ = light(room(), points, sign * np.eye(3)[axis], count=count, per_level=per_level, phases=PHASE_CHOICE)
        lost.append(1.0 - found / (pi * RADIANCE))
    assert np.min(lost) >= -1e-9
    assert np.max(lost) <= 0.05


@pytest.mark.parametrize(("distance", "most"), [(8, 0.15), (16, 0.1), (32, 0.2)])
def test_irradiance_from_a_parallel_square(distance, most):
    """In front of its middle, and some way off: closed form. Samples of low cones are lifted towards it: by a voxel,
    which at 8 voxels makes the closed form 4 to 6 % larger. Where voxels are as large as half the square,
    at 32, its light is a matter of where their faces are."""
    ceiling = np.zeros((N, N, N, 6))
    side, first = 32, 16
    layer = LOW + distance
    ceiling[first : first + side, layer, first : first + side, CEILING_WAY] = 1.0
    voxels = FacingVoxels(ceiling, ceiling[..., None] * RADIANCE)
    middle = first + 0.5 * side
    offsets = np.array([0.0, 6.0, 12.0])
    points = np.stack([middle + offsets, np.full(3, FLOOR), np.full(3, middle)], axis=-1)
    found, _ = light(voxels, points)
    expected = pi * point_to_parallel_square(side, distance, offsets)
    assert np.abs(found[:, 0] / RADIANCE[0] / expected - 1.0).max() <= most


def test_a_wall_hides_its_share_of_the_sky():
    """Beside an endless wall half of the sky is hidden; as far away as it is high, about a seventh."""
    _, visible = light(walls(FLOOR_WAY, WALL_WAY), np.array([[LOW + 1.5, FLOOR, 0.5 * N], [0.5 * N, FLOOR, 0.5 * N]]))
    assert visible[0] == pytest.approx(0.5, abs=0.1)
    assert visible[0] < visible[1] < 0.95


def test_cones_end_at_the_first_surface():
    """What is behind a wall one voxel thick does not shine through it, wherever samples fall."""
    facing = np.zeros((N, N, N, 6))
    facing[:, 20, :, CEILING_WAY] = facing[:, 40, :, CEILING_WAY] = 1.0
    colors = np.where(np.arange(N)[:, None, None, None] < 30, [1.0, 0.0], [0.0, 1.0])  # of rows along y
    voxels = FacingVoxels(facing, facing[..., None] * colors)
    start = np.array([[30.2, y, 30.7] for y in (3.0, 3.3, 3.5, 3.8)])
    _, cone = specular_light(voxels, DEPTH, start, *[np.broadcast_to(UP, (4, 3))] * 3, 0.0)
    assert np.abs(cone.radiance - [1.0, 0.0]).max() <= 1e-6


def test_traced_light_is_what_was_met():
    """A mirror that looks at a wall sees its radiance."""
    towards, cone = specular_light(room(), DEPTH, on_floor(5), *[np.broadcast_to(UP, (5, 3))] * 3, 0.0)
    assert isinstance(cone, Traced)
    assert np.allclose(towards, UP)
    assert np.abs(cone.radiance / RADIANCE - 1.0).max() <= 1e-6


@pytest.mark.parametrize("resolution", [1, 2, 4])
def test_phases_weigh_the_same_around_every_pixel(resolution):
    """Pixels of each phase bring light of their own, which grows across the picture by as much of their own: away from
    the border the result is the mean of all, at the pixel."""
    camera, height, width = Camera(transform=np.eye(4)), 24 * resolution, 28 * resolution
    towards_eye = np.broadcast_to([0.0, 0.0, 1.0], (height, width, 3))
    seen = Seen(camera, np.full((height, width), 2.0), towards_eye, towards_eye)
    y, x = np.indices((24, 28))
    phase, at = x % 4 + 4 * (y % 4), resolution * np.stack([x, y]) + resolution // 2
    own, right, down = np.random.default_rng(5).uniform(size=(3, 16))
    raw = own[phase] + right[phase] * at[0] + down[phase] * at[1]
    place = np.broadcast_to([0.0, 0.0, 1.0, 2.0], (24, 28, 4))
    found = filtered(seen, raw[..., None], place, resolution)[..., 0]
    rows, columns = np.indices(found.shape)
    inner = np.s_[4 * resolution : -4 * resolution, 4 * resolution : -4 * resolution]
    expected = own.mean() + right.mean() * columns + down.mean() * rows
    np.testing.assert_allclose(found[inner], expected[inner], rtol=1e-12)
