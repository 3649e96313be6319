"""Bounces of gathered light on the device (techniques/lpv/bouncing) against the simulator's."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions, read_buffer

from octolux.simulator.grid import Grid
from octolux.simulator.lpv import bouncing, cascades
from octolux.simulator.lpv.gathering import first_moments
from octolux.simulator.lpv.octree import level_sizes
from octolux.techniques.lpv.bouncing.bounces import Bounces
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.windows import pack_windows

N = 16
VOLUME = Grid((0.0, 0.0, 0.0), 1.0, N)
HALF_FLOAT = 2.0**-10  # of irradiance, in which each bounce is kept: 2^-11 rounded, twice that where truncated
ARITHMETIC = 2e-3  # of float32 sums of hundreds of nodes, and of half floats of their lobes (test_octree_gathering.py)


def windows_of(count: int, position=(5.0, 9.0, 8.0)):
    return cascades.place_windows(N, count, VOLUME, position, [0.6, 0.0, 0.8])


def levels_of(count: int) -> Levels:
    return Levels([N] * (count - 1) + level_sizes(N), count)


def scattered(windows, seed: int) -> SimpleNamespace:
    """`light` [z][y][x][rgb][4] in a share of each window's cells, and its `moments`; and `reflectors` [z][y][x][3][4]
    in other cells, with their `places` [z][y][x][4]."""
    rng, own, moments, reflectors, places = np.random.default_rng(seed), [], [], [], []
    for window in windows:
        light = np.zeros((N, N, N, 3, 4))
        light[..., 0] = rng.uniform(0.1, 2.0, (N, N, N, 3))
        light[..., 1:] = random_directions(rng, 3 * N**3).reshape(N, N, N, 3, 3) * light[..., :1]
        light *= rng.random((N, N, N, 1, 1)) < 0.03
        placed = light[..., 0].sum(axis=-1)[..., None] * rng.uniform(-0.8, 0.8, (N, N, N, 3))
        own.append(light)
        moments.append(first_moments(light, window.origin, window.size, placed))
        faces = rng.uniform(0.0, 1.0, (N, N, N, 3, 4)) * (rng.random((N, N, N, 1, 1)) < 0.08)
        faces[..., 1, 2:], faces[..., 2, 3] = 0.0, 0.0
        reflectors.append(faces)
        places.append(rng.uniform(-1.0, 1.0, (N, N, N, 4)) * [1, 1, 1, 0])
    return SimpleNamespace(light=own, moments=moments, reflectors=reflectors, places=places)


def run(device, made: Bounces, windows, what: SimpleNamespace) -> tuple[np.ndarray, np.ndarray]:
    """Light [window][z][y][x][rgb][4] and moments [window][z][y][x][4] after the bounces."""
    count, room = len(windows), levels_of(len(windows)).cells

    def buffer(values):
        rows = np.stack(values).astype(np.float32).reshape(count * N**3, -1)
        return device.buffer("given", np.pad(rows, ((0, room - len(rows)), (0, 0))))

    light, moments = buffer(what.light), buffer(what.moments)
    mirrors = SimpleNamespace(reflectors=buffer(what.reflectors), places=buffer(what.places))
    peak = device.buffer("peak", np.array([what.light[-1][..., 0].max()], np.float32))
    with one_stage(device) as stage:
        made.run(stage, light, moments, peak, mirrors, None, device.uniform("windows", pack_windows(windows)))
    found = (read_buffer(device, each).reshape(room, -1)[: count * N**3] for each in (light, moments))
    return next(found).reshape(count, N, N, N, 3, 4), next(found).reshape(count, N, N, N, 4)


@pytest.mark.parametrize("count, bounces", [(1, 1), (1, 3), (3, 2)])
def test_bounces_are_the_simulators(device, count, bounces):
    """Added to all windows' cells, whether finer ones are there or not: of each cell, to a share of the brightest that
    any has. A bounce hands on the errors of the one before, which are smaller than it by the albedo. Moments are of
    what has been added, but for rounding of all that there is then: 2^-23 times some roundings."""
    windows = windows_of(count)
    what, size = scattered(windows, 1), windows[-1].size
    light, moments = run(device, Bounces(device, levels_of(count), bounces, occlusion=False), windows, what)
    places = [each[..., :3] for each in what.places]
    arrived = bouncing.irradiance(
        what.light[-1], what.reflectors[-1], bounces, moments=what.moments[-1] / [size, size, size, 1.0],
        places=places[-1],
    )  # fmt: skip
    marked = what.reflectors[-1][..., :2, :].sum(axis=(-1, -2)) > 0.0
    expected = np.array(bouncing.injected_bounces(arrived, marked, what.reflectors, windows))
    brightest = np.abs(expected).max()
    allowed = bounces * (HALF_FLOAT + ARITHMETIC) * brightest
    np.testing.assert_allclose(light - what.light, expected, atol=allowed, rtol=HALF_FLOAT)
    assert brightest > 0.1 and all(np.count_nonzero(cells[..., 0, 0]) > 50 for cells in expected)
    for number, window in enumerate(windows):
        added = light[number].astype(np.float64) - what.light[number]
        bounced = bouncing.moments_at(added, places[number], window.origin, window.size)
        there = light[number][..., 0].sum(axis=-1)[..., None] * [N * size, N * size, N * size, 1.0]
        assert np.all(np.abs(moments[number] - what.moments[number] - bounced) <= 1e-6 * there)


def test_the_same_bits_again(device):
    windows = windows_of(2)
    made, what = Bounces(device, levels_of(2), 2, occlusion=False), scattered(windows, 2)
    for first, again in zip(*(run(device, made, windows, what) for _ in range(2)), strict=True):
        assert first.tobytes() == again.tobytes()
