"""Light of a place from the eight cells around it (simulator/lpv/corners.py): closed forms of what walls leave."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.lpv.corners import CORNERS, LEAST, UNSURE, corner_cells, corner_weights, read_corners
from octolux.simulator.lpv.strips import Planes

N = 8
MIDDLES = np.stack(np.meshgrid(*[np.arange(N) + 0.5] * 3, indexing="ij")[::-1], axis=-1)  # [z][y][x][3]


def walls(*across: tuple[int, float, float]) -> Planes:
    """Planes of walls, each across an axis, at a place in cells, with a share: one in a layer of cells."""
    shares, offsets = np.zeros((2, N, N, N, 3))
    for axis, place, share in across:
        np.moveaxis(shares, 2 - axis, 0)[int(place), ..., axis] = share
        np.moveaxis(offsets, 2 - axis, 0)[int(place), ..., axis] = place % 1.0
    return Planes.sheets(shares, offsets)


def along(axis: int, at: float, planes: Planes | None) -> tuple[float, float]:
    """Weights of the two layers of cells across an axis, of a place at `at` along it and anywhere across."""
    place = np.insert(np.array([2.7, 4.1]), axis, at)
    _, weights = corner_weights(place[None], planes)
    upper = CORNERS[:, axis] == 1
    assert weights.sum() == pytest.approx(1.0, rel=1e-12)
    return weights[0, ~upper].sum(), weights[0, upper].sum()


def test_nothing_between_is_trilinear():
    """Which has what is linear right, but in the outermost half cell."""
    places = np.random.default_rng(1).uniform(0.5, N - 0.5, (200, 3))
    for planes in (None, walls()):
        np.testing.assert_allclose(read_corners(MIDDLES, places, planes), places, rtol=1e-12)


def test_the_rim_holds_beyond_it():
    places = np.array([[0.1, 4.0, 7.9], [0.0, 8.0, 0.3]])
    np.testing.assert_allclose(read_corners(MIDDLES, places), np.clip(places, 0.5, N - 0.5), rtol=1e-12)
    first, _ = corner_weights(places)
    assert first.min() == -1 and corner_cells(first, N).min() == 0 and corner_cells(first, N).max() == N - 1


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_wall_between_two_corners(axis):
    """It takes what lies beyond it, by its share, wherever it lies between their middles, be it in either's cell, and
    nothing when it lies beyond a middle, or between neither."""
    for wall, at, nearer in ((4.6, 4.9, 1), (5.2, 5.4, 1), (5.2, 4.9, 0), (4.6, 4.55, 0)):
        part = at - 4.5
        kept = [1.0 - part, part]
        for share in (1.0, 0.5):
            expected = list(kept)
            expected[1 - nearer] *= 1.0 - share
            np.testing.assert_allclose(along(axis, at, walls((axis, wall, share))), np.array(expected) / sum(expected))
    for wall in (4.3, 4.5, 4.9, 5.7, 6.1):
        np.testing.assert_allclose(along(axis, 4.9, walls((axis, wall, 1.0))), [0.6, 0.4])


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_places_beside_a_wall_are_on_either_side(axis):
    """At the wall both sides count alike, by their trilinear weights, and from UNSURE on its own alone. Between, what
    passes to either changes by 1 over twice UNSURE, and the larger weight moves the mean by 3 times as much at most."""
    planes = walls((axis, 4.75, 1.0))
    np.testing.assert_allclose(along(axis, 4.75, planes), [0.75, 0.25])
    np.testing.assert_allclose(along(axis, 4.75 - 1.01 * UNSURE, planes), [1.0, 0.0])
    np.testing.assert_allclose(along(axis, 4.75 + 1.01 * UNSURE, planes), [0.0, 1.0])
    places = np.linspace(4.75 - 2.0 * UNSURE, 4.75 + 2.0 * UNSURE, 401)
    upper = np.array([along(axis, at, planes)[1] for at in places])
    assert np.all(np.diff(upper) >= -1e-12)
    assert np.diff(upper).max() < 3.0 * (1.0 + 1e-9) * 0.5 / UNSURE * (places[1] - places[0])


def test_a_wall_cut_by_a_face_blocks_once():
    """Half of it in either cell: the larger of the shares that lie between, not both together."""
    planes = walls((0, 4.9, 0.5), (0, 5.1, 0.25))
    np.testing.assert_allclose(along(0, 4.7, planes), np.array([0.8, 0.2 * 0.5]) / 0.9)
    np.testing.assert_allclose(along(0, 5.0, planes), np.array([0.5 * 0.5, 0.5 * 0.75]) / 0.625)


def test_walls_across_several_axes():
    """An edge where two walls meet: of four columns of cells one is left, and of a half wall's the product."""
    planes = walls((0, 4.7, 1.0), (1, 3.6, 0.5))
    place = np.array([[4.9, 3.8, 2.0]])
    _, weights = corner_weights(place, planes)
    expected = np.where(CORNERS[:, 0] == 1, 0.4, 0.0) * np.where(CORNERS[:, 1] == 1, 0.3, 0.7 * 0.5) * 0.5
    np.testing.assert_allclose(weights[0], expected / expected.sum(), rtol=1e-12)


def test_between_walls_on_all_sides_all_corners_count():
    """Between 4.6 and 5.4 along an axis, or in a box; as little as LEAST is as good as nothing."""
    np.testing.assert_allclose(along(0, 5.0, walls((0, 4.6, 1.0), (0, 5.4, 1.0))), [0.5, 0.5])
    box = walls(*((axis, place, 1.0) for axis in range(3) for place in (4.6, 5.4)))
    place = np.full((1, 3), 4.9)
    np.testing.assert_array_equal(corner_weights(place, box)[1], corner_weights(place)[1])
    for left, expected in ((0.5 * LEAST, [0.5, 0.5]), (2.0 * LEAST, [1.0, 0.0])):
        np.testing.assert_allclose(along(0, 5.0, walls((0, 4.6, 1.0 - 2.0 * left), (0, 5.4, 1.0))), expected)


def test_mirrored_volumes_are_mirrored():
    rng = np.random.default_rng(3)
    shares, offsets = rng.random((2, N, N, N, 3))
    places = rng.uniform(0.0, N, (300, 3))
    cells = rng.random((N, N, N, 2))
    straight = read_corners(cells, places, Planes.sheets(shares, offsets))
    turned = Planes.sheets(shares[::-1, ::-1, ::-1], 1.0 - offsets[::-1, ::-1, ::-1])
    mirrored = read_corners(cells[::-1, ::-1, ::-1], N - places, turned)
    np.testing.assert_allclose(mirrored, straight, rtol=1e-9)
    assert np.median(np.abs(straight - read_corners(cells, places))) > 0.02
