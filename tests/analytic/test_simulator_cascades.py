"""Cascades (simulator/lpv/cascades.py): where windows lie, and that through them each part of space is read once."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import cascades, gathering
from octolux.simulator.lpv.geometry import Planes, plane_levels
from octolux.simulator.lpv.octree import build_levels

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
    """Of fixed places, while the camera goes a tenth of a cell at a time: by no more than that over the transition."""
    points = np.array(VOLUME.origin) + 16.0 * np.random.default_rng(5).random((300, 3))
    before, jumps, moved = None, 0.0, set()
    for step in range(400):
        position = VOLUME.origin + np.array([2.0 + 0.0125 * step, 8.0, 7.0])
        windows = cascades.place_windows(32, 3, VOLUME, position, [0.0, 0.6, 0.8])
        places = np.array([g.to_cells(points) for g in cascades.grids_of(windows, VOLUME)])
        shares = cascades.weights(places, windows, 32)
        moved.add(windows[0].origin)
        if before is not None:
            jumps = max(jumps, float(np.abs(shares - before).max()))
        before = shares
    assert len(moved) > 5 and jumps <= 0.0125 / 0.125 / cascades.transition(32) + 1e-9


def own_light(windows, n: int, seed: int = 3, lit: float = 0.02) -> list[np.ndarray]:
    """Light [z][y][x][rgb][4] of each window in cells that no finer one holds."""
    rng, result = np.random.default_rng(seed), []
    for number in range(len(windows)):
        light = np.zeros((n, n, n, 3, 4))
        light[..., 0] = rng.uniform(0.1, 2.0, (n, n, n, 3)) * (rng.random((n, n, n, 1)) < lit)
        if number:
            x, y, z = np.array(windows[number - 1].origin) // 2 - windows[number].origin
            light[z : z + n // 2, y : y + n // 2, x : x + n // 2] = 0.0
        result.append(light)
    return result


def test_light_is_kept_and_each_part_of_space_is_read_once():
    """Every level holds the light within its reach, the coarsest all. Isotropic lights of 1 lm each, of which a cell
    reads every one once, wherever it lies, but for its own cell's."""
    n, count = 16, 3
    windows = cascades.place_windows(n, count, Grid((0, 0, 0), 1.0, n), [5.0, 9.0, 6.0], [0.0, 0.6, 0.8])
    own = own_light(windows, n)
    levels = cascades.nested_levels(own, windows)
    np.testing.assert_allclose(levels[-1].sum(axis=(0, 1, 2)), sum(o.sum(axis=(0, 1, 2)) for o in own), rtol=1e-12)
    nodes = cascades.window_nodes(own, windows)
    rng = np.random.default_rng(4)
    origins = [w.origin for w in windows]
    for base in range(count):
        cells = rng.integers(0, n, (40, 3)) + windows[base].origin
        read = np.zeros(len(cells))
        for level in nodes[base:]:
            whole: np.ndarray | bool = True
            if 0 < level.level < count:
                child = 2 * level.cell - origins[level.level - 1]
                whole = np.all((child >= 0) & (child < n), axis=-1)[None]
            steps, last = level.level - base, level.level == len(nodes) - 1
            chosen = gathering.takes(cells[:, None], level.cell[None], steps, last, whole)
            read += chosen @ level.flux.sum(axis=-1)
        x, y, z = (cells - windows[base].origin).T
        here = levels[base][z, y, x, :, 0].sum(axis=-1) / sh.Y0  # band 0 is Y0 times the flux
        np.testing.assert_allclose(read + here, levels[-1][0, 0, 0, :, 0].sum() / sh.Y0, rtol=1e-9)


def test_a_wall_through_nested_windows_stays_whole_and_where_it_is():
    """Each window has of its own what no finer one holds: with its children's it has all of the wall within its reach,
    at the same place, and in no other layer."""
    n, place = 16, 30.3  # in cells of level 0
    windows = cascades.place_windows(n, 3, Grid((0, 0, 0), 1.0, n), [5.0, 9.0, 6.0], [0.0, 0.6, 0.8])
    own = []
    for number, window in enumerate(windows):
        shares, offsets = np.zeros((n, n, n, 3)), np.full((n, n, n, 3), place / window.size % 1.0)
        shares[int(place / window.size) - window.origin[2], ..., 2] = 1.0
        if number:
            x, y, z = np.array(windows[number - 1].origin) // 2 - window.origin
            shares[z : z + n // 2, y : y + n // 2, x : x + n // 2] = 0.0
        own.append(Planes.sheets(shares, offsets))
    for level, window in zip(cascades.nested_planes(own, windows), windows, strict=False):
        layer = int(place / window.size) - window.origin[2]
        assert 0 <= layer < n and np.count_nonzero(level.shares) == n * n
        np.testing.assert_allclose(level.shares[layer, ..., 2], 1.0, rtol=1e-12)
        np.testing.assert_allclose(level.offsets[layer, ..., 2], place / window.size % 1.0, rtol=1e-12)
    alone = cascades.nested_planes(own[-1:], windows[-1:])
    for ours, plain in zip(alone, plane_levels(own[-1]), strict=True):
        assert np.array_equal(ours.shares, plain.shares) and np.array_equal(ours.offsets, plain.offsets)


def test_one_window_is_the_octree():
    light = own_light([cascades.Window((0, 0, 0), 1, (-np.inf,) * 3, (np.inf,) * 3)], 16)[0]
    windows = cascades.place_windows(16, 1, Grid((0, 0, 0), 1.0, 16), [0, 0, 0], [1, 0, 0])
    for ours, plain in zip(cascades.window_nodes([light], windows), gathering.light_nodes(light), strict=True):
        for name in ("cell", "place", "flux", "fraction"):
            np.testing.assert_array_equal(getattr(ours, name), getattr(plain, name))
    for ours, plain in zip(cascades.nested_levels([light], windows), build_levels(light), strict=True):
        np.testing.assert_array_equal(ours, plain)


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
