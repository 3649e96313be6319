"""What is measured, against closed forms."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from octolux.simulator import form_factors
from octolux.simulator import sh as harmonics
from octolux.simulator.laboratory import Area, Element, Simulation, Wall, measures
from octolux.simulator.laboratory.references import analytic_volume
from octolux.simulator.lpv import octree, propagation

X = (1.0, 0.0, 0.0)


def injected(n, shape):
    simulation = Simulation(n)
    simulation.inject(shape)
    return simulation.state.injected


def test_octree_errors_are_those_of_the_formula():
    """e_abs and e_rel with 7 / (8^l - 8) in front, cell by cell (Olovsson 2012, 6.2), for levels down to 2^3."""
    rng = np.random.default_rng(1)
    levels = [rng.normal(size=(size,) * 3 + (4,)) for size in (16, 8, 4, 2)]
    e_abs = e_rel = 0.0
    for i in range(1, 4):
        expected = octree.downsample(levels[i - 1], "average")
        for p in np.ndindex(levels[i].shape[:3]):
            error = max(abs(levels[i][p] - expected[p]))
            e_abs += error * 7 / (8**4 - 8)
            e_rel += error / max(abs(levels[i][p])) * 7 / (8**4 - 8)
    found = measures.against_downsampling(levels, "average")
    assert found["e_abs"] == pytest.approx(e_abs) and found["e_rel"] == pytest.approx(e_rel)


def test_cells_that_hold_only_rounding_are_dark():
    """Of two cells with the same error, the one just above the floor counts; the floor is its own level's."""
    found = {}
    for share in (2.0 * measures.DARK, 0.5 * measures.DARK):
        levels = [np.zeros((size,) * 3 + (4,)) for size in (8, 4, 2)]
        levels[1][0, 0, 0, 0], levels[1][3, 3, 3, 0] = 1.0, share
        levels[2][0, 0, 0, 0] = 1e-20  # its level's largest: lit
        expected = [levels[0], levels[1].copy(), levels[2].copy()]
        expected[1][3, 3, 3, 0] += 0.001
        expected[2][0, 0, 0, 0] = 3e-20
        found[share] = measures.octree_errors(levels, expected)
    lit, dark = found.values()
    assert lit["max_rel"] == pytest.approx(0.0005 / measures.DARK)
    assert lit["e_rel"] == pytest.approx((0.0005 / measures.DARK + 2.0) / 72)
    assert dark["max_rel"] == pytest.approx(2.0) and dark["e_rel"] == pytest.approx(2.0 / 72)
    assert lit["max_abs"] == dark["max_abs"] == pytest.approx(0.001)  # the absolute error hides nothing


def test_rounding_has_no_part_in_relative_errors():
    """The same light mirrored is the same light with other roundings, which the dominant lobe's leave behind it.

    A cell is off by at most DARK of the largest, and those that count hold 2^-20 of it or more: size and error are off
    by 2^-20 of the size. That changes a relative error r by 2^-20 (1 + r), twice for the two of them, and the mean
    likewise; here the means are above 1.
    """
    rows = []
    for x, direction in ((1, (-1.0, 0.0, 0.0)), (6, X)):
        simulation = Simulation(8, propagator="dominant-lobe", compare=["uniform"])
        simulation.set_injectors([Element((x, 4, 4), direction)])
        simulation.run(8)
        rows.append(simulation.state.measures[-1])
        sizes = [np.abs(level).max(axis=-1) / np.abs(level).max() for level in simulation.state.sum[1:]]
        assert not any(((size > measures.DARK) & (size < 2.0**-20)).any() for size in sizes)
        assert any(((size > 0.0) & (size < measures.DARK)).any() for size in sizes)
    for name in ("e_rel", "corrected_e_rel"):
        assert rows[0][name] > 1.0 and rows[0][name] == pytest.approx(rows[1][name], rel=2.0**-18)


def test_errors_do_not_depend_on_how_parents_are_made():
    """Sums are 8^i averages while the propagation is linear, and the errors are told in averages."""
    rows = []
    for combine in ("sum", "average"):
        simulation = Simulation(8, combine=combine, propagator="signed", compare=["uniform"])
        simulation.set_injectors([Element((2, 3, 4), X)])
        simulation.run(2)
        rows.append(simulation.state.measures[-1])
    for name in ("e_abs", "e_rel", "max_abs", "max_rel", "corrected_e_abs", "corrected_e_rel"):
        assert rows[0][name] == pytest.approx(rows[1][name], rel=1e-12)


def test_the_uniform_volume_is_the_reference_propagation():
    simulation = Simulation(8, propagator="clpv", uniform_iterations=5)
    simulation.inject(Wall("x"))
    expected = propagation.propagate(simulation.state.injected[..., None, :], 5)[..., 0, :]
    np.testing.assert_allclose(simulation.uniform(), expected, atol=1e-14)


def test_level_0_against_itself_has_no_corrected_error():
    """Where the octree has one level, and as many iterations, it is the uniform volume."""
    simulation = Simulation(4, coarsest=4, compare=["uniform"], uniform_iterations=3)
    simulation.set_injectors([Element((1, 1, 1))])
    simulation.run(3)
    row = simulation.state.measures[-1]
    assert row["corrected_e_abs"] == row["merged_abs"] == row["merged_rel"] == 0.0


def test_the_corrected_error_forgives_dark_children():
    """Section 7: coarse levels run ahead of fine ones, and 6.2 counts that as error. One step from a corner reaches the
    neighbour of level 1, none of whose children are lit: 6.2 says e_rel = 1 there; the uniform volume has light."""
    simulation = Simulation(8, propagator="clpv", compare=["uniform"])
    simulation.set_injectors([Element((0, 0, 0))])
    simulation.run(1)
    level = simulation.state.sum[1]
    assert level[0, 0, 1, 0] > 0.0 and not octree.downsample(simulation.state.sum[0], "average")[0, 0, 1].any()
    assert octree.downsample(simulation.uniform(), "average")[0, 0, 1, 0] > 0.0


def test_flux_and_centre_of_a_step():
    simulation = Simulation(8, propagator="signed")
    simulation.set_injectors([Element((3, 4, 5), multiplier=2.0)])
    simulation.run(2)
    for row in simulation.state.measures:  # isotropic light stays where it is, and all of it inside for 2 steps
        found = [row[f"step_{name}"] for name in ("flux", "centre_x", "centre_y", "centre_z")]
        assert found == pytest.approx([2.0, 3.0, 4.0, 5.0])


@pytest.mark.parametrize("name,speed", [("dom6", None), ("dom18", None), ("dom26", None)])
def test_ordinates_move_the_centre_of_mass_evenly(name, speed):
    """Band 1 is kept and each step moves light by its link: by sum of w I(d) offset, every step the same."""
    simulation = Simulation(16, propagator=name)
    simulation.set_injectors([Element((7, 7, 7), X)])
    simulation.run(4)
    centres = np.array([row["step_centre_x"] for row in simulation.state.measures])
    np.testing.assert_allclose(np.diff(centres), centres[1] - centres[0], atol=1e-12)
    assert centres[1] - centres[0] > 0.6


def test_analytic_light_of_an_element_falls_with_the_square():
    """A cosine lobe of flux 1 along x: I = cos / pi; a cell at distance r holds the flux I / r^2 from one direction."""
    volume = analytic_volume(injected(16, Element((1, 8, 8), X)))
    for distance in (1, 2, 4, 8, 14):
        cell = volume[8, 8, 1 + distance]
        assert harmonics.flux(cell) == pytest.approx(1.0 / (pi * distance**2))
        np.testing.assert_allclose(cell, harmonics.basis(X) / (pi * distance**2))
    off_axis = volume[8, 8 + 3, 1 + 4]  # 5 cells away, cos = 0.8
    assert harmonics.flux(off_axis) == pytest.approx(0.8 / pi / 25.0)
    assert not volume[8, 8, 0].any() and not volume[:, :, 0].any()


@pytest.mark.parametrize("distance", [4, 6, 10])
def test_analytic_light_of_a_wall_is_that_of_a_square(distance):
    """The net flux of a cell along x is the irradiance that a Lambertian square of exitance 1 gives there.

    16 x 16 points stand for the square, the midpoint rule for E = integral of f, f = d^2 / (pi (d^2 + q^2)^2) at q
    from the foot. Its error is to leading order 1/24 of the integral of the Laplacian of f, at most
    2 pi * 2 max(q |f'|) / 24, where q |f'| = 4 d^2 q^2 / (pi (d^2 + q^2)^3) <= 0.189 / d^2: 0.099 / d^2.
    Twice that is allowed for the further orders, each smaller by 1 / d^2.
    """
    volume = analytic_volume(injected(16, Wall("x")))
    net = harmonics.vector(volume[8, 8, distance])[0] / harmonics.Y1
    expected = form_factors.irradiance_from_parallel_square(1.0 / pi, 16.0, float(distance), 0.5, 0.5)
    assert net == pytest.approx(float(expected), abs=2.0 * 0.099 / distance**2)


def test_analytic_light_of_an_isotropic_element():
    volume = analytic_volume(injected(8, Element((4, 4, 4), multiplier=3.0)))
    assert harmonics.flux(volume[4, 4, 7]) == pytest.approx(3.0 / (4.0 * pi * 9.0))
    assert harmonics.flux(volume[4, 4, 4]) == pytest.approx(3.0)


def test_there_is_no_analytic_solution_with_occluders():
    simulation = Simulation(8, compare=["analytic"])
    simulation.set_occluders([Area((4, 4, 4), (4, 5, 5))])
    simulation.set_injectors([Element((1, 1, 1))])
    simulation.run(1)
    assert simulation.analytic() is None and "analytic_rel" not in simulation.state.measures[-1]


def test_references_are_made_once_and_anew():
    simulation = Simulation(8, uniform_iterations=4)
    simulation.inject(Element((1, 1, 1)))
    first = simulation.uniform()
    simulation.propagate()
    assert simulation.uniform() is first
    simulation.set_factor(0.5)
    assert (simulation.uniform() != first).any()


def test_the_dark_has_no_errors_and_no_centre():
    simulation = Simulation(4, compare=["uniform", "analytic"])
    simulation.run(1)
    row = simulation.state.measures[-1]
    assert row["e_abs"] == row["e_rel"] == row["merged_abs"] == row["step_flux"] == 0.0
    assert np.isnan(row["step_centre_x"]) and np.isnan(row["merged_rel"])
