"""Gathering through the octree (simulator/lpv/gathering.py): each pair of cells once, inverse square, lobes, furnace.

How far a node may be off. A patch of side s in the plane of a wall sends the mean of K over itself, where K is what the
same light sends from its middle: K + s^2/24 laplace(K) + O(s^4). With r the length of the way and t its angle to the
wall's normal, the second order over K is (s/r)^2 / 3 times

    2 - 3 cos^2 t  on a receiver that faces the wall,    1 - 3 cos^2 t  on one across it,

and that of the node, 1 / (r^2 + s^2/3), is -(s/r)^2 / 3. They differ by (s/r)^2 sin^2 t, and by (s/r)^2 times at most
2/3. `test_a_node_is_a_lit_square` shows that the first, with (s/r)^4 / 100 more, also covers the higher orders.
"""

from __future__ import annotations

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.form_factors import (
    irradiance_from_parallel_square,
    point_to_parallel_square,
    squares_with_a_common_edge,
)
from octolux.simulator.lpv import gathering, geometry, strips
from octolux.simulator.lpv.transfer import DIRECTIONS

N, H, RADIANCE = 16, 0.25, 3.0
EXITANCE = pi * RADIANCE  # W/m^2
FACE = {tuple(d): i for i, d in enumerate(DIRECTIONS.tolist())}
DOWN = FACE[0, 0, -1]  # the face that a light below lights


def every_cell(n: int) -> np.ndarray:
    return np.stack(np.meshgrid(*[np.arange(n)] * 3, indexing="ij"), axis=-1).reshape(-1, 3)


def wall(normal, cells: slice = slice(0, N)) -> np.ndarray:
    """Light of a wall of radiance RADIANCE in the outermost cells that `normal` leads away from: at the volume's side
    (gathering.first_moments)."""
    injected = np.zeros((N, N, N, 3, 4))
    axis = int(np.argmax(np.abs(normal)))
    layer = np.moveaxis(injected, 2 - axis, 0)[0 if normal[axis] > 0 else N - 1]
    layer[cells, cells] = EXITANCE * H**2 / pi * sh.cosine_lobe(np.asarray(normal, dtype=float))
    return injected


def bound(cell: np.ndarray, nodes: list[gathering.Nodes], facing: bool) -> np.ndarray:
    """What `nodes` of a wall may be off in all at `cell`, (6, 3), by the top of this file.

    Its bounds are shares of the exact value: d of that is d / (1 - d) of the node's. On a receiver across the wall a
    patch may also be ahead in part. With its middle in the receiver's plane the mean distance ahead is s / 8 where the
    node's is 0, which is the worst.
    """
    sure, ahead, last = [], np.zeros((6, 3)), gathering.coarsest_read(len(nodes))
    for level in nodes:
        way = cell + 0.5 - level.place
        square, size = np.maximum(np.sum(way * way, axis=-1), 1e-12), 2.0**level.level
        x, cosine = size**2 / square, np.sum(way * level.direction[:, 0], axis=-1) / np.sqrt(square)
        share = np.minimum(x * (1.0 - cosine**2) + x * x / 100.0 if facing else x, 0.99)
        sure.append(replace(level, flux=level.flux * (share / (1.0 - share))[:, None]))
        read = (cosine > 0) & (level.level <= last)
        read &= gathering.takes(cell, level.cell, level.level, level.level == last)
        sent = level.flux * (cosine * size / 8.0 / pi / square**1.5)[:, None] / H**2
        for face in range(6):
            split = read & (np.abs(way @ DIRECTIONS[face]) < 0.5 * size)
            ahead[face] += sent[split].sum(axis=0)
    return gathering.gather(cell[None], sure, H)[0] + (0.0 if facing else ahead)


@pytest.mark.parametrize(("n", "coarsest"), [(8, 4), (16, 8), (16, 1)])
def test_each_pair_of_cells_meets_on_one_level(n, coarsest):
    """Exhaustive but for the order of the axes, which the rule does not know: whichever cell of level 0 the light is
    in, exactly one of its ancestors is read, down to whichever level; none by the cell itself."""
    cells, levels = every_cell(n).astype(np.int8), n.bit_length() - coarsest.bit_length() + 1
    assert coarsest == 1 or levels == gathering.coarsest_read(n.bit_length()) + 1
    sorted_cells = cells[np.all(np.diff(cells) >= 0, axis=1)]
    for some in np.array_split(sorted_cells, 16):
        times = sum(
            gathering.takes(some[:, None], cells[None] >> i, i, i == levels - 1).astype(np.int8) for i in range(levels)
        )
        itself = (some[:, None] == cells[None]).all(axis=-1)
        np.testing.assert_array_equal(times, 1 - itself.astype(np.int8))


def test_nodes_are_read_from_where_they_look_small():
    """From 1.5 to 3.5 of their own sizes, middle to middle along the longest axis."""
    cells = every_cell(32)[::61]
    for level in range(1, 4):
        nodes = every_cell(32 >> level)
        read = gathering.takes(cells[:, None], nodes[None], level, level == 5)
        away = np.abs((cells[:, None] + 0.5) / 2**level - (nodes[None] + 0.5)).max(axis=-1)
        assert away[read].min() > 1.5 and away[read].max() < 3.5


def test_a_node_is_a_lit_square():
    """One node's expression against the closed form, facing receivers, from r = s on, in all directions."""
    for distance in np.linspace(0.25, 4.0, 31):
        offset, turned = np.meshgrid(np.linspace(0.0, 4.0, 41), np.linspace(0.0, pi / 4, 4))
        exact = pi * point_to_parallel_square(1.0, distance, offset * np.cos(turned), offset * np.sin(turned))
        square = distance**2 + offset**2
        node = distance**2 / square / (square + gathering.SPREAD)
        off = offset**2 / square**2 + 0.01 / square**2
        assert np.all((np.abs(node - exact) <= off * exact)[square >= 1.0])


@pytest.mark.parametrize("distance", [2, 3, 5, 8, 12, 15])
def test_a_lit_square_facing_receivers(distance):
    """A square of 8 x 8 cells on the floor, half a cell below the cells' middles, on its axis and beside it, against
    the closed form."""
    nodes = gathering.light_nodes(wall((0, 0, 1), slice(4, 12)))
    for x, y in ((7, 7), (4, 9), (1, 13)):
        cell = np.array([x, y, distance])
        found = gathering.gather(cell[None], nodes, H)[0]
        offset = (np.array([x, y]) + 0.5 - 8.0) * H
        exact = irradiance_from_parallel_square(RADIANCE, 8 * H, (distance + 0.5) * H, *offset)
        off = bound(cell, nodes, facing=True)[DOWN]
        assert np.all(np.abs(found[DOWN] - exact) <= off)
        assert np.all(off < 0.5 * exact), "the bound says nothing"
        assert not found[FACE[0, 0, 1]].any()


def test_inside_a_box_of_one_radiance():
    """The furnace: E = pi L on every small surface inside. Each wall is gathered alone, as a cell of two walls is no
    dominant lobe."""
    walls = [gathering.light_nodes(wall(normal)) for normal in DIRECTIONS]
    for cell in np.array([[8, 8, 8], [4, 8, 11]]):
        found = sum(gathering.gather(cell[None], nodes, H)[0] for nodes in walls)
        off = sum(bound(cell, nodes, facing=False) for nodes in walls)
        assert np.all(np.abs(found - EXITANCE) <= off)
        assert np.all(off < 0.5 * EXITANCE), "the bound says nothing"


def one_light(coefficients) -> np.ndarray:
    injected = np.zeros((N, N, N, 3, 4))
    injected[8, 8, 8] = coefficients
    return injected


def test_no_light_behind_a_lobe_but_its_isotropic_rest():
    """A cosine lobe sends nothing backwards; mixed with F isotropic, what F sends, on whichever level it is read."""
    cells = np.array([[8, 8, z] for z in range(8)])
    lobe = sh.cosine_lobe([0.0, 0.0, 1.0]) / pi
    alone = gathering.gather(cells, gathering.light_nodes(one_light(lobe)), H)
    ahead = gathering.gather(np.array([[8, 8, 10]]), gathering.light_nodes(one_light(lobe)), H)
    assert alone.max() < 1e-12 * ahead.max()  # the fraction in the lobe is 1 but for rounding
    isotropic = np.array([1.0 / (2.0 * sqrt(pi)), 0.0, 0.0, 0.0])  # flux 1
    nodes = gathering.light_nodes(one_light(lobe + isotropic))
    mixed = gathering.gather(cells, nodes, H)
    rest = zip(gathering.light_nodes(one_light(isotropic)), nodes, strict=True)
    only = gathering.gather(cells, [replace(level, place=whole.place) for level, whole in rest], H)
    np.testing.assert_allclose(mixed, only, rtol=1e-12)
    assert only[:, FACE[0, 0, 1]].min() > 0


def test_the_inverse_square():
    """Of a single cell's lobe, read on whichever level: F / pi / (r^2 + s^2 / 3), the light being half a cell behind
    its cell's middle."""
    distances = np.arange(1, 8)
    cells = np.array([[8, 8, 8 + z] for z in distances])
    levels = gathering.light_nodes(one_light(sh.cosine_lobe([0.0, 0.0, 1.0]) / pi))
    last = gathering.coarsest_read(len(levels))
    size = np.array([2.0 ** next(
        level.level for level in levels if gathering.takes(cell, level.cell[0], level.level, level.level == last)
    ) for cell in cells])  # fmt: skip
    found = gathering.gather(cells, levels, H)[:, DOWN, 0]
    np.testing.assert_allclose(found, 1.0 / pi / ((distances + 0.5) ** 2 + size**2 / 3.0) / H**2, rtol=1e-12)
    assert len(set(size)) > 1


def test_light_adds_up_by_flux():
    """Four times the flux is four times the light, to the bit."""
    rng = np.random.default_rng(0)
    injected = one_light(0.0)
    injected[rng.integers(0, N, 9), rng.integers(0, N, 9), 3] = sh.cosine_lobe(rng.normal(size=(9, 3, 3)))
    cells = rng.integers(0, N, (20, 3))
    once, four = (gathering.gather(cells, gathering.light_nodes(f * injected), H) for f in (1.0, 4.0))
    assert np.array_equal(4.0 * once, four) and once.any()


def test_a_wall_between_stops_light():
    """A closed wall in the middle of the volume: nothing of the light beyond it, all of the light on this side."""
    blocked = np.zeros((N, N, N, 3))
    blocked[:, :, 8, 0] = 1.0
    levels = geometry.plane_levels(strips.Planes.sheets(blocked, np.full(blocked.shape, 0.3)))
    cells = np.array([[2, 8, 8], [4, 8, 8], [10, 8, 8], [11, 8, 8], [12, 8, 8], [15, 8, 8]])
    nodes = gathering.light_nodes(wall((1, 0, 0), slice(7, 10)))
    free, found = (gathering.gather(cells, nodes, H, g) for g in (None, levels))
    assert np.array_equal(found[:2], free[:2])
    assert found[2:].max() < 1e-12 and free[2:].any()


@pytest.mark.parametrize("beyond", [True, False])
def test_a_wall_beside_a_node_stops_its_light(beyond):
    """A node of 4 x 4 x 4 cells, lit one of them before its side, sends through what is in it, but not through a wall
    in the next cells, though that is within two of its light."""
    blocked = np.zeros((32, 32, 32, 3))
    blocked[..., 8 if beyond else 7, 0] = 1.0
    levels = geometry.plane_levels(strips.Planes.sheets(blocked, np.full(blocked.shape, 0.5)))
    light = np.zeros((32, 32, 32, 3, 4))
    light[18, 18, 7] = sh.cosine_lobe([1.0, 0.0, 0.0])
    placed = gathering.first_moments(light, placed=np.array([-0.5, 0.0, 0.0]) * light[..., :1].sum(axis=-2))
    found = gathering.gather(np.array([[25, 18, 18]]), gathering.light_nodes(light, placed), H, levels)
    assert found.any() != beyond


def test_cubes_are_exact_along_the_axes():
    cube = np.random.default_rng(1).uniform(0.0, 2.0, (6, 3))
    np.testing.assert_array_equal(gathering.read_cube(np.tile(cube, (6, 1, 1)), DIRECTIONS), cube)


def test_an_even_cube_is_even_in_all_directions():
    normals = np.random.default_rng(2).normal(size=(50, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    read = gathering.read_cube(np.full((50, 6, 3), 1.5), normals)
    np.testing.assert_allclose(read, 1.5, rtol=1e-12)  # squares of a unit vector's components add up to 1


def test_what_a_cell_receives_of_its_own_surfaces():
    """Of a floor that fills a cell's lower side, the faces of walls beside it receive the form factor of two squares
    with a common edge; the floor itself nothing, nor what looks away from it."""
    levels = gathering.light_nodes(one_light(sh.cosine_lobe([0.0, 0.0, 1.0]) / pi))
    cell = levels[0].cell
    found = gathering.gather(cell, levels, 1.0)[0, :, 0]
    np.testing.assert_allclose(found, [squares_with_a_common_edge()] * 4 + [0.0, 0.0], rtol=1e-12)


def test_the_form_factor_of_squares_with_a_common_edge():
    """Against the double integral over both squares, by midpoints. Squares beside the edge are as many as there are
    along it and their integrand is as the inverse square: the error falls with the step, and halves with it."""
    errors = []
    for steps in (20, 40):
        u = (np.arange(steps) + 0.5) / steps
        x, y, a, b = np.meshgrid(u, u, u, u, indexing="ij", sparse=True)  # (x, y, 0) and (a, 0, b)
        square = (x - a) ** 2 + y**2 + b**2
        errors.append(np.mean(y * b / (pi * square**2)) - squares_with_a_common_edge())
    assert 0.4 < errors[1] / errors[0] < 0.6 and abs(2.0 * errors[1] - errors[0]) < 0.002
