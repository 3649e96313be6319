"""Cascades (simulator/lpv/cascades.py): where windows lie, and that through them each part of space is read once."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import cascades, gathering, injection
from octolux.simulator.lpv.cones import FADE
from octolux.simulator.lpv.emitted import Emitted
from octolux.simulator.lpv.emitted import inject as inject_emitted
from octolux.simulator.lpv.octree import level_sizes

VOLUME = Grid((-3.0, 1.0, 2.0), 0.5, 32)


def cameras(count: int):
    """Positions in and around the volume, with directions of view."""
    rng = np.random.default_rng(1)
    forward = rng.normal(size=(count, 3))
    positions = np.array(VOLUME.origin) + rng.uniform(-0.3, 1.3, (count, 3)) * 16.0
    return zip(positions, forward / np.linalg.norm(forward, axis=1)[:, None], strict=True)


@pytest.mark.parametrize("n, count", [(32, 1), (32, 3), (16, 4), (64, 2)])
def test_windows_nest(n, count):
    """On whole blocks of four cells, each within the next, and where its light is read at all, that of the next is read
    alone. Light is read in the window itself, half a cell from its rim at least, but at the volume's ends."""
    volume = Grid(VOLUME.origin, 16.0 / n, n)
    for position, forward in cameras(50):
        windows = cascades.place_windows(n, count, volume, position, forward)
        assert windows[-1].origin == (0, 0, 0) and [w.size for w in windows] == [2**i for i in range(count)]
        for inner, outer in pairwise(windows):
            corner = np.array(inner.origin) / 2 - outer.origin
            assert np.all(corner >= 0) and np.all(corner + n / 2 <= n)
            cells = n << (count - 1 - windows.index(inner))
            least, most = -np.array(inner.origin), cells - np.array(inner.origin)  # the volume's ends
            low, high = np.maximum(inner.low, least), np.minimum(inner.high, most)
            assert np.all((low >= 0.5) | (least == 0)) and np.all((high <= n - 0.5) | (most == n))
            first, last = inner.ends - np.array(inner.origin)
            assert np.all((first >= 0.0) | (least == 0)) and np.all((last <= n) | (most == n))
            # A level does not give way to the next where that itself does (cones.py, FADE).
            begin, end = outer.ends - np.array(outer.origin)
            assert np.all((corner + first / 2 - begin >= FADE) | (low == least))
            assert np.all((end - corner - last / 2 >= FADE) | (high == most))
            alone = cascades.transition(n)
            assert np.all((corner + low / 2 >= np.array(outer.low) + alone - 1e-9) | (low == least))
            assert np.all((corner + high / 2 <= np.array(outer.high) - alone + 1e-9) | (high == most))
        assert all(o % 4 == 0 for w in windows for o in w.origin)
        grids = cascades.grids_of(windows, volume)
        assert grids[-1] == volume
        for grid, window in zip(grids, windows, strict=True):
            corner = (np.array(grid.origin) - volume.origin) / grid.cell_size
            np.testing.assert_allclose(corner, window.origin, atol=1e-9)


def test_windows_follow_the_camera():
    """By whole blocks, and none where it has gone less than it takes; it is within them while it is in the volume."""
    forward = np.array([1.0, 0.0, 0.0])
    seen = []
    for x in np.linspace(0.0, 16.0, 200):
        position = VOLUME.origin + np.array([x, 8.0, 8.0])
        windows = cascades.place_windows(32, 3, VOLUME, position, forward)
        grid = cascades.grids_of(windows, VOLUME)[0]
        seen.append(windows[0].origin[0])
        if 0 < x < 16:
            assert grid.inside(position)
    steps = np.diff(seen)
    assert set(steps) == {0, cascades.SNAP} and steps.sum() == 128 - 32


def test_weights_add_up_and_are_continuous():
    """To one everywhere in the volume; along any line they change by no more than the transition's slope, and a window
    has none where filters would reach beyond it."""
    windows = cascades.place_windows(32, 3, VOLUME, [5.0, 9.0, 10.0], [0.6, 0.0, 0.8])
    grids = cascades.grids_of(windows, VOLUME)
    rng = np.random.default_rng(2)
    middle = np.array(grids[0].origin) + 16 * grids[0].cell_size
    a, b = (VOLUME.origin + 16.0 * rng.random((20, 1, 3)), middle + rng.uniform(-0.5, 0.5, (20, 1, 3)))
    points = a + (b - a) * np.linspace(0, 1, 2000)[None, :, None]
    places = np.array([g.to_cells(points.reshape(-1, 3)) for g in grids])
    shares = cascades.weights(places, windows, 32).reshape(3, 20, 2000)
    np.testing.assert_allclose(shares.sum(axis=0), 1.0, rtol=1e-12)
    step = np.linalg.norm(b - a, axis=-1) / 1999 / grids[0].cell_size / cascades.transition(32)
    assert np.all(np.abs(np.diff(shares, axis=-1)) <= 2 * step[None] + 1e-12)
    at_rim = np.any((places[0] < 0.5) | (places[0] > 31.5), axis=-1)
    assert np.all(shares[0].ravel()[at_rim] == 0.0) and np.count_nonzero(at_rim) and shares[0].max() == 1.0


def test_weights_do_not_jump_when_windows_do():
    """Of fixed places, while the camera goes a tenth of a cell at a time: by no more than that over the transition. As
    little do the ends of ways."""
    points = np.array(VOLUME.origin) + 16.0 * np.random.default_rng(5).random((300, 3))
    before, ends, jumps, moved = None, np.zeros((2, 3)), 0.0, set()
    for step in range(400):
        position = VOLUME.origin + np.array([2.0 + 0.0125 * step, 8.0, 7.0])
        windows = cascades.place_windows(32, 3, VOLUME, position, [0.0, 0.6, 0.8])
        places = np.array([g.to_cells(points) for g in cascades.grids_of(windows, VOLUME)])
        shares = cascades.weights(places, windows, 32)
        moved.add(windows[0].origin)
        if before is not None:
            jumps = max(jumps, float(np.abs(shares - before).max()))
            assert np.abs(windows[0].ends - ends).max() <= 0.1 + 1e-9
        before, ends = shares, windows[0].ends
    assert len(moved) > 5 and jumps <= 0.0125 / 0.125 / cascades.transition(32) + 1e-9


def points_of_light(windows, volume: Grid, count: int) -> list[np.ndarray]:
    """Light [z][y][x][rgb][4] that each window has of points anywhere in the volume, 1 lm each in every channel."""
    edge = volume.n * volume.cell_size
    position = volume.origin + edge * np.random.default_rng(3).random((count, 3))
    points = Emitted(position, np.ones((count, 3)), np.tile([0.0, 0.0, 1.0], (count, 1)), np.zeros(count))
    return list(inject_emitted(points, cascades.grids_of(windows, volume)))


def test_light_is_kept_and_each_part_of_space_is_read_once():
    """Windows have the light within them, the coarsest all: a cell reads every light once, wherever it lies, but for
    its own cell's."""
    n, count, lights = 16, 3, 2000
    volume = Grid((0, 0, 0), 1.0, n)
    windows = cascades.place_windows(n, count, volume, [5.0, 9.0, 6.0], [0.0, 0.6, 0.8])
    own = points_of_light(windows, volume, lights)
    levels = cascades.window_levels(own)
    assert [len(level) for level in levels] == [n] * (count - 1) + level_sizes(n)
    for level in levels[count - 1 :]:
        np.testing.assert_allclose(level[..., 0].sum(axis=(0, 1, 2)) / sh.Y0, lights, rtol=1e-12)
    nodes = cascades.window_nodes(own, windows)
    rng = np.random.default_rng(4)
    origins = [w.origin for w in windows]
    for base in range(count):
        cells = rng.integers(0, n, (40, 3)) + windows[base].origin
        read = np.zeros(len(cells))
        coarsest = gathering.coarsest_read(len(nodes), base)
        for level in nodes[base : coarsest + 1]:
            whole: np.ndarray | bool = True
            if 0 < level.level < count:
                child = 2 * level.cell - origins[level.level - 1]
                whole = np.all((child >= 0) & (child < n), axis=-1)[None]
            steps, last = level.level - base, level.level == coarsest
            chosen = gathering.takes(cells[:, None], level.cell[None], steps, last, whole)
            read += chosen @ level.flux.sum(axis=-1)
        x, y, z = (cells - windows[base].origin).T
        here = levels[base][z, y, x, :, 0].sum(axis=-1) / sh.Y0  # band 0 is Y0 times the flux
        np.testing.assert_allclose(read + here, 3.0 * lights, rtol=1e-9)


def vpls_in(windows, volume: Grid, vpls) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Light and moments of VPLs (position, normal, flux) in each window."""
    grids = cascades.grids_of(windows, volume)
    return [injection.inject(*vpls, g) for g in grids], [injection.inject_moments(*vpls, g) for g in grids]


def test_distant_light_does_not_depend_on_where_windows_lie():
    """What nodes of the last window and of the levels above hold, and where."""
    rng, seen = np.random.default_rng(6), []
    normal = rng.normal(size=(4000, 3))
    vpls = (VOLUME.origin + 16.0 * rng.random((4000, 3)), normal / np.linalg.norm(normal, axis=1)[:, None],
            rng.uniform(0.1, 1.0, (4000, 3)))  # fmt: skip
    for position in ([1.0, 6.0, 5.0], [5.0, 13.0, 15.0]):
        windows = cascades.place_windows(32, 3, VOLUME, position, [0.0, 0.6, 0.8])
        light, moments = vpls_in(windows, VOLUME, vpls)
        seen.append(cascades.window_nodes(light, windows, moments))
    assert len(seen[0][0].cell) != len(seen[1][0].cell)
    for one, other in zip(seen[0][2:], seen[1][2:], strict=True):
        for name in ("cell", "place", "flux", "fraction", "direction"):
            np.testing.assert_array_equal(getattr(one, name), getattr(other, name))


def test_one_window_is_the_octree():
    volume = Grid((0, 0, 0), 1.0, 16)
    windows = cascades.place_windows(16, 1, volume, [0, 0, 0], [1, 0, 0])
    (light,) = points_of_light(windows, volume, 100)
    for ours, plain in zip(cascades.window_nodes([light], windows), gathering.light_nodes(light), strict=True):
        for name in ("cell", "place", "flux", "fraction"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(plain, name))


@pytest.mark.parametrize("arguments", [(32, 0), (24, 2), (0, 1)])
def test_sizes_that_cannot_be(arguments):
    with pytest.raises(ValueError):
        cascades.place_windows(*arguments, VOLUME, [0, 0, 0], [1, 0, 0])


def test_a_volume_that_moves_with_the_camera():
    """As long as asked for, the camera in it and most of it ahead; it moves by a quarter of its edge, whole cells of
    the level of four along each side, and not at all in between."""
    forward, seen = np.array([0.0, 0.0, -1.0]), set()
    for z in np.linspace(0.0, -30.0, 300):
        grid = cascades.moving_volume(20.0, 32, [3.0, 1.0, z], forward)
        assert grid.n * grid.cell_size == pytest.approx(20.0) and grid.inside([3.0, 1.0, z])
        assert z - grid.origin[2] > 8.0
        np.testing.assert_allclose(np.array(grid.origin) / 5.0, np.rint(np.array(grid.origin) / 5.0), atol=1e-9)
        seen.add(grid.origin)
    assert len(seen) == 7
    with pytest.raises(ValueError, match="more than 0 m"):
        cascades.moving_volume(0.0, 32, [0, 0, 0], [1, 0, 0])
