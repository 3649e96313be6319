"""Slices as geometry: what is drawn, in closed form."""

from __future__ import annotations

from math import log1p, pi, sqrt

import numpy as np
import pytest

from octolux.simulator import sh as harmonics
from octolux.simulator.laboratory import Element, Simulation, SimulationError, pictures, slices


@pytest.mark.parametrize("axis,u,v", [("x", "z", "y"), ("y", "x", "z"), ("z", "x", "y")])
def test_planes(axis, u, v):
    """A slice [v][u] has the cells whose coordinate along its axis is the index, u and v named as they are drawn."""
    z, y, x = np.indices((4, 4, 4))
    places = np.stack([x, y, z], axis=-1)
    plane = slices.cut(places, axis, 2)
    column = {name: plane[..., i] for i, name in enumerate("xyz")}
    rows, columns = np.indices((4, 4))
    assert (column[axis] == 2).all() and (column[u] == columns).all() and (column[v] == rows).all()
    assert slices.plane_names(axis) == (u, v)


@pytest.mark.parametrize("axis,direction", [("z", (1.0, 0.0, 0.0)), ("y", (0.0, 0.0, 1.0)), ("x", (0.0, 1.0, 0.0))])
def test_a_lobe_is_drawn_where_it_points(axis, direction):
    """Two bands of a cosine lobe of flux pi: 1/4 + 1/2 cos. Its largest, 3/4, reaches the edge of the cell, half a cell
    from the centre; opposite it the value -1/4 is drawn on its own side, 1/3 as long."""
    plane = np.zeros((3, 3, 4))
    plane[2, 1] = harmonics.cosine_lobe(direction)
    curves, negative = slices.polar_curves(plane, axis, samples=48)
    assert curves.shape == (1, 48, 2) and negative.shape == (1, 48)
    u, v = slices.plane_names(axis)
    along = np.array([dict(zip("xyz", direction, strict=True))[name] for name in (u, v)])
    offsets = curves[0] - [1.5, 2.5]
    angles = slices.directions(axis, 48) @ np.array(direction)
    np.testing.assert_allclose(np.linalg.norm(offsets, axis=1), 0.5 * np.abs(0.25 + 0.5 * angles) / 0.75, atol=1e-15)
    np.testing.assert_allclose(offsets[np.argmax(angles)], 0.5 * along, atol=1e-15)
    assert (negative[0] == (0.25 + 0.5 * angles < 0.0)).all()


def test_cells_of_coarser_levels_are_larger():
    plane = np.zeros((2, 2, 4))
    plane[1, 0, 0] = 3.0
    curves, _ = slices.polar_curves(plane, "z", cell=4.0)
    np.testing.assert_allclose(np.linalg.norm(curves[0] - [2.0, 6.0], axis=1), 2.0)


def test_scales():
    values = np.array([-1.0, 0.0, 1e-4, 0.5, 1.0, 2.0])
    np.testing.assert_allclose(slices.radii(values, 1.0), [-1.0, 0.0, 1e-4, 0.5, 1.0, 1.0])
    np.testing.assert_allclose(slices.radii(values, 1.0, zoom=2.0), [-1.0, 0.0, 2e-4, 1.0, 1.0, 1.0])
    log = slices.radii(values, 1.0, "log")
    np.testing.assert_allclose(log[[0, 1, 2, 4]], [-1.0, 0.0, log1p(1.0) / log1p(1e4), 1.0])
    assert not slices.radii(values, 0.0).any()
    with pytest.raises(SimulationError, match="linear, log"):
        slices.radii(values, 1.0, "cubic")


def test_borders_run_between_cells_of_different_levels():
    index = np.array([[0, 0, 1], [0, 1, 1]])
    found = {tuple(map(tuple, segment.astype(int).tolist())) for segment in slices.level_borders(index)}
    assert found == {((2, 0), (2, 1)), ((1, 1), (1, 2)), ((1, 1), (2, 1))}


def test_figures_show_what_they_are_asked_for():
    simulation = Simulation(8, propagator="signed")
    simulation.set_injectors([Element((2, 3, 4), (1.0, 0.0, 0.0))])
    simulation.run(1)
    figure = pictures.slice_figure(simulation, index=4, names=["sum"])
    (axes,) = figure.axes
    merged, borders = simulation.view("sum"), simulation.index()[4]
    lit = int(merged[4].any(axis=-1).sum())
    sizes = [len(collection.get_paths()) for collection in axes.collections]
    assert sizes[0] == 2 * 9 and lit in sizes and len(slices.level_borders(borders)) in sizes
    assert axes.get_xlabel() == "x" and axes.get_ylabel() == "y"
    assert len(pictures.slice_figure(simulation).axes) == 3
    plot = pictures.error_figure(simulation.state.measures)
    assert [len(panel.lines) for panel in plot.axes] == [1, 1, 1, 0, 2, 6]
    for bad in ({"axis": "w"}, {"index": 8}, {"level": 7}, {"scale": "cubic"}, {"names": ["som"]}):
        with pytest.raises(SimulationError):
            pictures.slice_figure(simulation, **bad)


def test_the_largest_of_a_lobe_is_three_quarters_of_its_peak():
    """So that a full cell in a picture is what `polar_curves` says: I(d) = Phi / pi * 3/4 for a lobe in the plane."""
    simulation = Simulation(4)
    simulation.inject(Element((1, 1, 1), (1.0, 0.0, 0.0), multiplier=2.0))
    cell = simulation.view("source", 0)[1, 1, 1]
    assert harmonics.evaluate(cell, [1.0, 0.0, 0.0]) == pytest.approx(0.75 * 2.0 / pi)
    assert harmonics.evaluate(cell, [sqrt(0.5), sqrt(0.5), 0.0]) == pytest.approx((0.25 + 0.5 * sqrt(0.5)) * 2.0 / pi)
