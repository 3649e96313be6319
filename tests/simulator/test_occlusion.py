"""Fuzzy occlusion, in closed form (Kaplanyan & Dachsbacher 2010, 3.2 and 3.3)."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.laboratory import PROPAGATORS, Area, Element, Simulation, Wall, occlusion
from octolux.simulator.laboratory.injectors import ROLES, blocking

X = (1.0, 0.0, 0.0)


def links_along(propagator, offset):
    return np.flatnonzero((propagator.offsets == offset).all(axis=1))


def test_a_wall_blocks_light_through_its_faces():
    """B = <x|w> in two bands is 1/4 + 1/2 w.x: through a face of the wall, both on the far face and on the sides."""
    corners = blocking(Wall("x", 4, X), 8)
    propagator = PROPAGATORS["clpv"]
    passed = occlusion.transmittance(corners, propagator)
    for link in links_along(propagator, [1, 0, 0]):
        expected = 1.0 - (0.25 + 0.5 * propagator.directions[link, 0])
        np.testing.assert_allclose(passed[:, :, 3, link], expected)
        np.testing.assert_array_equal(passed[:, :, [0, 1, 2, 4, 5, 6, 7], link], 1.0)


def test_light_along_a_wall_meets_half_of_its_corners():
    """A face across y beside the wall has two corners on it: half of B, and B(y) = 1/4."""
    passed = occlusion.transmittance(blocking(Wall("x", 4, X), 8), PROPAGATORS["dom6"])
    link = links_along(PROPAGATORS["dom6"], [0, 1, 0])[0]
    np.testing.assert_allclose(passed[:, :, [3, 4], link], 1.0 - 0.5 * 0.25)


@pytest.mark.parametrize("offset,corner", [((1, 1, 0), (4, 4, None)), ((-1, -1, -1), (3, 3, 3))])
def test_diagonal_links_are_blocked_where_they_cross(offset, corner):
    """From cell (3, 3, 3): along an edge's diagonal at the middle of that edge, along a body's diagonal at a corner."""
    corners = np.zeros((9, 9, 9, 4))
    x, y, z = corner
    corners[slice(3, 5) if z is None else z, y, x, 0] = 1.0
    assert occlusion.halfway(corners, np.array(offset))[3, 3, 3, 0] == 1.0


def test_opaque_in_all_directions_lets_nothing_through():
    """2 sqrt(pi) Y0 is 1 but for rounding, so that 2^-52 may pass."""
    simulation = Simulation(8, propagator="signed")
    simulation.set_occluders([Wall("x", 4, "all")])
    simulation.set_injectors([Element((1, 4, 4))])
    simulation.run(6)
    behind = np.abs(simulation.state.sum[0][:, :, 4:]).max()
    assert behind <= 2.0**-52 * np.abs(simulation.state.sum[0]).max()


def test_nothing_blocks_in_the_first_step():
    simulation = Simulation(8, propagator="clpv")
    simulation.set_occluders([Wall("x", 4, "all")])
    simulation.inject(Element((3, 4, 4)))
    simulation.propagate()
    assert simulation.state.target[0][4, 4, 4, 0] > 0.0
    second = simulation.state.target[0]
    simulation.propagate()
    crossed = np.where(np.arange(8)[:, None] >= 4, second, 0.0)  # what had crossed goes on, and nothing joins it
    np.testing.assert_allclose(
        simulation.state.target[0][4, 4, 5], PROPAGATORS["clpv"].step(crossed)[4, 4, 5], atol=1e-15
    )
    assert np.abs(simulation.state.target[0][4, 4, 4]).max() < 1e-15


def test_what_is_blocked_is_lost():
    """Flux after a step is the flux that is let through: T times the flux of each link, signed gain 1."""
    propagator = PROPAGATORS["signed"]
    corners = blocking(Area((3, 3, 3), (5, 5, 5), multiplier=0.3), 8)
    cells = np.zeros((8, 8, 8, 4))
    cells[4, 4, 4] = harmonics.cosine_lobe([0.0, 0.6, 0.8])
    passed = occlusion.transmittance(corners, propagator)
    after = propagator.step(cells, corners=corners)
    assert harmonics.flux(after).sum() == pytest.approx((propagator.flux(cells) * passed)[4, 4, 4].sum())
    assert harmonics.flux(after).sum() == pytest.approx(0.7 * harmonics.flux(cells).sum())


@pytest.mark.parametrize("index,planes", [(8, {4: 1.0}), (5, {2: 0.5, 3: 0.5})])
def test_a_wall_blocks_alike_on_coarser_levels(index, planes):
    """A plane of corners keeps its blocking in total: on one coarse plane, or half on each beside it."""
    corners = Wall("x", index, X).fill(17, ROLES["blocking"])
    coarse = occlusion.coarser(corners)
    inner = coarse[1:-1, 1:-1]  # at the rim of the volume corners have no neighbours
    for plane in range(9):
        expected = planes.get(plane, 0.0) * harmonics.cosine_lobe(X)
        np.testing.assert_allclose(inner[:, :, plane], np.broadcast_to(expected, (*inner.shape[:2], 4)), atol=1e-15)


def test_occluders_add_up_and_have_every_level():
    simulation = Simulation(8)
    simulation.set_occluders([Element((2, 2, 2)), Element((2, 2, 2), multiplier=0.5)])
    assert [level.shape[0] for level in simulation.state.geometry] == [9, 5, 3, 2]
    assert harmonics.evaluate(simulation.state.geometry[0][2, 2, 2], [0.0, 1.0, 0.0]) == pytest.approx(1.5)


def test_slabs_do_not_show():
    """64 cells along each side are worked on in slabs of two, a smaller volume within it in one."""
    rng = np.random.default_rng(7)
    inner, corners = rng.random((16, 16, 16, 4)), 0.1 * rng.random((17, 17, 17, 4))
    large, large_corners = np.zeros((64, 64, 64, 4)), np.zeros((65, 65, 65, 4))
    large[7:23, 9:25, 11:27], large_corners[7:24, 9:26, 11:28] = inner, corners
    for name in ("clpv", "dom26"):
        found = PROPAGATORS[name].step(large, corners=large_corners)[7:23, 9:25, 11:27]
        np.testing.assert_allclose(found, PROPAGATORS[name].step(inner, corners=corners), atol=1e-14)
