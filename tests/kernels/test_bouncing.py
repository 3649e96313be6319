"""Bounces of gathered light on the device (techniques/lpv/bouncing) against the simulator's."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions, read_buffer

from octolux.simulator.grid import Grid
from octolux.simulator.lpv import bouncing, cascades
from octolux.simulator.lpv.octree import level_sizes
from octolux.techniques.lpv.bouncing.bounces import Bounces
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.reflectors import Reflectors
from octolux.techniques.lpv.windows import pack_windows

N = 16
VOLUME = Grid((0.0, 0.0, 0.0), 1.0, N)
HALF_FLOAT = 2.0**-10  # of irradiance, in which each bounce is kept: 2^-11 rounded, twice that where truncated
ARITHMETIC = 2e-3  # of float32 sums of hundreds of nodes, and of half floats of their lobes (test_octree_gathering.py)


def windows_of(count: int):
    return cascades.place_windows(N, count, VOLUME, [5.0, 9.0, 8.0], [0.6, 0.0, 0.8])


def outside_finer(values: np.ndarray, windows, number: int) -> np.ndarray:
    """`values` [z][y][x]... of a window, 0 where a finer one is."""
    if number:
        x, y, z = np.array(windows[number - 1].origin) // 2 - windows[number].origin
        values[z : z + N // 2, y : y + N // 2, x : x + N // 2] = 0.0
    return values


def scattered(windows, seed: int) -> tuple[list[np.ndarray], list[np.ndarray]]:
    """Light [z][y][x][rgb][4] and reflectors [z][y][x][3][4] of each window's own cells, in a share of them."""
    rng, lights, reflectors = np.random.default_rng(seed), [], []
    for number in range(len(windows)):
        light = np.zeros((N, N, N, 3, 4))
        light[..., 0] = rng.uniform(0.1, 2.0, (N, N, N, 3))
        light[..., 1:] = random_directions(rng, 3 * N**3).reshape(N, N, N, 3, 3) * light[..., :1]
        light *= rng.random((N, N, N, 1, 1)) < 0.03
        faces = rng.uniform(0.0, 1.0, (N, N, N, 3, 4)) * (rng.random((N, N, N, 1, 1)) < 0.08)
        faces[..., 1, 2:], faces[..., 2, 3] = 0.0, 0.0
        lights.append(outside_finer(light, windows, number).astype(np.float32))
        reflectors.append(outside_finer(faces, windows, number).astype(np.float32))
    return lights, reflectors


@pytest.mark.parametrize("count, bounces", [(1, 1), (1, 3), (3, 2)])
def test_bounces_are_the_simulators(device, count, bounces):
    """All windows' light after some bounces: of each cell, to a share of the brightest that any has. A bounce
    hands on the errors of the one before, which are smaller than it by the albedo."""
    windows = windows_of(count)
    lights, reflectors = scattered(windows, 1)
    levels = Levels([N] * (count - 1) + level_sizes(N), count)
    made = Bounces(device, levels, bounces, occlusion=False)
    injected = np.zeros((levels.cells, 3, 4), np.float32)
    injected[: count * N**3] = np.concatenate([light.reshape(-1, 3, 4) for light in lights])
    mirrors = np.zeros((levels.cells, 3, 4), np.float32)
    whole = bouncing.with_children(reflectors, windows)
    mirrors[: count * N**3] = np.concatenate([r.reshape(-1, 3, 4) for r in whole])
    peak = device.buffer("peak", np.array([injected[:, :, 0].max()], np.float32))
    buffer, given = device.buffer("injected", injected), device.buffer("reflectors", mirrors)
    with one_stage(device) as stage:
        made.run(stage, buffer, peak, given, None, device.uniform("windows", pack_windows(windows)))
    cells = read_buffer(device, buffer).reshape(-1, 3, 4)[: count * N**3]
    found = cells.reshape(count, N, N, N, 3, 4) - np.array(lights)

    nested = cascades.nested_levels([np.asarray(light, np.float64) for light in lights], windows)[count - 1]
    arrived = bouncing.irradiance(nested, whole[-1], bounces)
    marked = whole[-1][..., :2, :].sum(axis=(-1, -2)) > 0.0
    expected = np.array(bouncing.injected_bounces(arrived, marked, whole, windows))
    brightest = np.abs(expected).max()
    assert brightest > 0.1 and np.count_nonzero(expected[..., 0, 0]) > 50
    np.testing.assert_allclose(found, expected, atol=bounces * (HALF_FLOAT + ARITHMETIC) * brightest, rtol=HALF_FLOAT)


def test_the_same_bits_again(device):
    windows = windows_of(2)
    lights, reflectors = scattered(windows, 2)
    levels = Levels([N, *level_sizes(N)], 2)
    made, uniform = Bounces(device, levels, 2, occlusion=False), device.uniform("windows", pack_windows(windows))
    results = []
    for _ in range(2):
        injected, mirrors = (np.zeros((levels.cells, 3, 4), np.float32) for _ in range(2))
        injected[: 2 * N**3] = np.concatenate([light.reshape(-1, 3, 4) for light in lights])
        mirrors[: 2 * N**3] = np.concatenate([r.reshape(-1, 3, 4) for r in reflectors])
        buffer = device.buffer("injected", injected)
        with one_stage(device) as stage:
            peak = device.buffer("peak", np.array([2.0], np.float32))
            made.run(stage, buffer, peak, device.buffer("reflectors", mirrors), None, uniform)
        results.append(read_buffer(device, buffer))
    assert np.array_equal(*results)


def test_coarser_windows_have_what_finer_ones_have(device):
    windows = windows_of(3)
    _, own = scattered(windows, 3)
    made = Reflectors(device, Levels([N, N, *level_sizes(N)], 3), 0.5)
    cells = np.zeros((made.reflectors.size // 48, 3, 4), np.float32)
    cells[: 3 * N**3] = np.concatenate([r.reshape(-1, 3, 4) for r in own])
    device.write(made.reflectors, cells)
    with one_stage(device) as stage:
        made.complete(stage, device.uniform("windows", pack_windows(windows)))
    found = read_buffer(device, made.reflectors)[: 36 * N**3].reshape(3, N, N, N, 3, 4)
    expected = np.array(bouncing.with_children(own, windows))
    np.testing.assert_allclose(found[..., :3], expected[..., :3], rtol=1e-5, atol=1e-6)
    assert np.count_nonzero(expected[2] != own[2]) > 100
