"""The actions of a simulation, singly and together."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.laboratory import Area, Element, FromArray, Simulation, SimulationError, Wall
from octolux.simulator.lpv import octree

X = (1.0, 0.0, 0.0)


def flux(cells):
    return harmonics.flux(cells).sum()


def stepped(simulation, iterations):
    """The algorithm by single actions."""
    simulation.inject()
    simulation.downsample()
    simulation.accumulate()
    for _ in range(iterations):
        simulation.propagate()
        simulation.accumulate()
    simulation.merge()


def test_injected_flux_is_the_multiplier_of_each_cell():
    simulation = Simulation(8)
    simulation.inject(Wall("y", 2, multiplier=3.0))
    assert flux(simulation.state.source[0]) == pytest.approx(64 * 3.0)
    assert not simulation.state.source[0][:, [0, 1, 3, 4, 5, 6, 7]].any()
    # The lobe along +y, since 2 is nearer to the low end: Phi / pi times the cosine lobe.
    np.testing.assert_allclose(simulation.state.source[0][0, 2, 0], 3.0 / pi * harmonics.cosine_lobe([0.0, 1.0, 0.0]))
    simulation.inject(Element((1, 2, 3)))
    assert simulation.state.source[0][3, 2, 1] == pytest.approx([3.0 / pi * np.sqrt(pi) / 2 + 0.5 / np.sqrt(pi),
                                                                 3.0 / pi * np.sqrt(pi / 3), 0.0, 0.0])  # fmt: skip


@pytest.mark.parametrize("combine,share", [("sum", 1.0), ("average", 0.125)])
def test_downsampling_sums_or_averages_flux(combine, share):
    simulation = Simulation(8, combine=combine)
    simulation.inject(Area((1, 2, 3), (6, 4, 7), X))
    simulation.downsample()
    fluxes = [flux(level) for level in simulation.state.source]
    assert fluxes == pytest.approx([fluxes[0] * share**i for i in range(4)])


def test_errors_are_zero_right_after_downsampling():
    """By definition: the levels are then what they are compared with (Olovsson 2012, 6.2)."""
    simulation = Simulation(16, combine="average")
    simulation.inject(Element((3, 4, 5), (1.0, 2.0, 3.0)))
    simulation.downsample()
    simulation.accumulate()
    row = simulation.state.measures[-1]
    assert row["e_abs"] == row["e_rel"] == row["max_abs"] == row["max_rel"] == 0.0


def test_run_is_its_actions():
    by_hand, at_once = (Simulation(8, propagator="clpv") for _ in range(2))
    for simulation in (by_hand, at_once):
        simulation.set_injectors([Wall("x"), Element((5, 5, 5))])
    stepped(by_hand, 3)
    at_once.run(3)
    for ours, theirs in zip(by_hand.state.arrays(), at_once.state.arrays(), strict=True):
        assert (ours == theirs).all()
    assert len(by_hand.state.measures) == len(at_once.state.measures) == 4
    assert by_hand.state.measures[3] == at_once.state.measures[3]


def test_source_and_target_alternate():
    simulation = Simulation(8)
    simulation.inject(Element((4, 4, 4)))
    first = simulation.state.source[0]
    simulation.propagate()
    assert simulation.state.source[0] is first
    second = simulation.state.target[0]
    simulation.propagate()
    assert simulation.state.source[0] is second


def test_undo_and_redo_restore_every_bit():
    simulation = Simulation(8)
    simulation.add_injector(Wall("z"))
    simulation.add_occluder(Area((2, 2, 2), (4, 4, 4)))
    stepped(simulation, 2)
    names = list(simulation.undoable)
    states = [[array.copy() for array in simulation.state.arrays()]]
    while simulation.undo():
        states.append([array.copy() for array in simulation.state.arrays()])
    assert len(states) == len(names) + 1 and not simulation.state.injectors and not simulation.state.occluded
    for expected in reversed(states[:-1]):
        assert simulation.redo()
        found = simulation.state.arrays()
        assert len(found) == len(expected)
        assert all((a == b).all() for a, b in zip(found, expected, strict=True))
    assert simulation.redo() is None and simulation.undoable == names


def test_an_action_after_undo_forgets_what_was_undone():
    simulation = Simulation(4)
    simulation.inject(Element((1, 1, 1)))
    simulation.undo()
    simulation.inject(Element((2, 2, 2)))
    assert simulation.redo() is None and simulation.state.source[0][2, 2, 2, 0] > 0.0


def test_history_stays_within_its_bytes():
    limit = 300_000  # some three times what a state of 8^3 cells holds
    simulation = Simulation(8, history_bytes=limit)
    simulation.inject(Element((4, 4, 4)))
    for _ in range(20):
        simulation.propagate()
        simulation.accumulate()
    assert simulation.kept_bytes <= limit
    assert 0 < len(simulation.undoable) < 41


def test_states_cannot_be_changed():
    simulation = Simulation(4)
    simulation.inject(Element((1, 1, 1)))
    with pytest.raises(ValueError, match="read-only"):
        simulation.state.source[0][0] = 1.0


def test_two_facing_walls_are_symmetric():
    """Figure 9's set-up: mirrored in x the light is the same, x components negated, on every level."""
    simulation = Simulation(8, propagator="best")
    simulation.set_injectors([Wall("x", 0), Wall("x", -1)])
    simulation.run(3)
    for level in [*simulation.state.sum, simulation.state.merged]:
        mirrored = level[:, :, ::-1] * [1.0, 1.0, 1.0, -1.0]
        # Additions come in another order; sums of some hundred terms of at most the largest.
        np.testing.assert_allclose(level, mirrored, atol=2.0**-44 * np.abs(level).max())


def test_factor_by_level():
    simulation = Simulation(4, propagator="signed", factor=[1.0, 0.5, 0.25], combine="sum")
    simulation.inject(Area((1, 1, 1), (2, 2, 2)))
    simulation.downsample()
    whole = Simulation(4, propagator="signed", combine="sum")
    whole.inject(Area((1, 1, 1), (2, 2, 2)))
    whole.downsample()
    for one in (simulation, whole):
        one.propagate()
    for part, all_of_it, factor in zip(simulation.state.target, whole.state.target, [1.0, 0.5, 0.25], strict=True):
        np.testing.assert_allclose(part, factor * all_of_it, atol=1e-15)


def test_the_index_volume_follows_light():
    """Injection marks 0, and a level that light has crossed wholly hides the coarser ones (4.2). From a corner that
    takes 3 (m - 1) steps for m cells a side, since a step leads to one of six neighbours."""
    simulation = Simulation(16, propagator="clpv")
    simulation.set_injectors([Element((0, 0, 0))])
    simulation.run(0)
    assert simulation.index()[0, 0, 0] == 0 and simulation.index()[15, 15, 15] == 4
    simulation.run(3)
    assert simulation.index().max() == 3
    simulation.run(9)
    assert simulation.index().max() == 2


def test_threshold_stops_the_index_volume():
    for threshold, reached in ((0.0, True), (0.5, False)):
        simulation = Simulation(8, threshold=threshold)
        simulation.set_injectors([Element((4, 4, 4))])
        simulation.run(1)
        assert (simulation.index()[4, 4, 5] == 0) == reached


def test_merge_reads_the_level_the_index_names():
    simulation = Simulation(8, combine="average")
    simulation.set_injectors([Element((1, 2, 3), X)])
    simulation.run(2)
    index = simulation.index()
    expected = np.empty((8, 8, 8, 4))
    for z, y, x in np.ndindex(8, 8, 8):
        i = index[z, y, x]
        expected[z, y, x] = simulation.state.sum[i][z >> i, y >> i, x >> i]
    np.testing.assert_array_equal(simulation.state.merged, expected)
    np.testing.assert_array_equal(simulation.view("sum"), expected)


def test_from_array_is_injected_as_it_is():
    light = np.random.default_rng(6).normal(size=(4, 4, 4, 4))
    simulation = Simulation(4)
    simulation.inject(FromArray(light, 2.0))
    np.testing.assert_array_equal(simulation.state.source[0], 2.0 * light)


def test_levels_down_to_2_as_in_the_thesis():
    simulation = Simulation(32, coarsest=2)
    assert [level.shape[0] for level in simulation.state.sum] == [32, 16, 8, 4, 2]
    assert simulation.state.index[0].max() == 4 == len(octree.level_sizes(32, 2)) - 1


@pytest.mark.parametrize("arguments,part", [
    ({"n": 12}, "power of two"), ({"n": 0}, "power of two"), ({"n": 256}, "at most 128"), ({"n": 8.0}, "n"),
    ({"n": 4, "coarsest": 8}, "coarsest"), ({"combine": "mean"}, "sum, average"), ({"threshold": -1}, "threshold"),
    ({"propagator": "clvp"}, "Perhaps 'clpv' is meant"), ({"factor": float("nan")}, "factor"),
    ({"n": 4, "factor": [1.0, 2.0]}, "3 levels"), ({"factor": -1.0}, "factor"), ({"factor": "p"}, "factor"),
    ({"compare": ["unifrom"]}, "Perhaps 'uniform' is meant"), ({"uniform_iterations": -2}, "-2"),
])  # fmt: skip
def test_bad_settings(arguments, part):
    with pytest.raises(SimulationError, match=part):
        Simulation(**arguments)


@pytest.mark.parametrize("make,part", [
    (lambda: Wall("w"), "x, y, z"), (lambda: Wall("x", 1.5), "whole"), (lambda: Wall("x", 0, (0, 0, 0)), "not all 0"),
    (lambda: Wall("x", 0, "up"), "'all'"), (lambda: Element((1, 2)), "three whole"),
    (lambda: Element((-1, 0, 0)), "none"),
    (lambda: Element((0, 0, 0), X, float("nan")), "multiplier"), (lambda: Area((3, 0, 0), (2, 9, 9)), "Exchange"),
    (lambda: FromArray(np.zeros((4, 4, 4))), "shape"), (lambda: FromArray(np.full((4, 4, 4, 4), np.nan)), "finite"),
    (lambda: Simulation(4).inject(Element((4, 0, 0))), "outside"),
    (lambda: Simulation(4).inject(Wall("x", 4)), "outside"),
    (lambda: Simulation(4).inject(FromArray(np.zeros((8, 8, 8, 4)))), "8 wide"),
    (lambda: Simulation(4).run(-1), "-1"), (lambda: Simulation(4).run(2.5), "2.5"),
    (lambda: Simulation(4).view("som"), "Perhaps 'sum'"), (lambda: Simulation(4).view("sum", 3), "0 to 2"),
])  # fmt: skip
def test_bad_actions(make, part):
    with pytest.raises(SimulationError, match=part):
        make()


def test_a_bad_action_leaves_the_state_alone():
    simulation = Simulation(4)
    before = simulation.state
    with pytest.raises(SimulationError):
        simulation.inject(Wall("x", 9))
    assert simulation.state is before and not simulation.undoable


def test_light_that_grows_for_ever_is_an_error():
    """Of a factor of 100 not all leaves the volume in a step; nothing of the action is done then."""
    simulation = Simulation(4, propagator="clpv", factor=100.0)
    simulation.set_injectors([Element((1, 1, 1))])
    with pytest.raises(SimulationError, match="without bound"):
        simulation.run(200)
    assert not simulation.state.sum[0].any()


@pytest.mark.parametrize("length", [5e-324, 1e-200, 1e300])
def test_directions_of_any_length(length):
    simulation = Simulation(4)
    simulation.inject(Element((1, 1, 1), (0.0, length, 0.0)))
    np.testing.assert_allclose(simulation.state.source[0][1, 1, 1], harmonics.cosine_lobe([0.0, 1.0, 0.0]) / pi)
