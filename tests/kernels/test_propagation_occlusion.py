"""Steps with the geometry volume (faces.wgsl, propagation.wgsl) against the simulator's, and what a wall does."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from gpu_tools import largest_cell_error, read_buffer
from test_propagation import BOUNDS, random_light, run

from octolux.simulator.lpv import formats, geometry
from octolux.simulator.lpv import propagation as reference
from octolux.simulator.lpv.octree import build_levels
from octolux.techniques.lpv.propagation import Propagation

N = 16


@cache
def kernel(device, sizes: tuple[int, ...]) -> Propagation:
    return Propagation(
        device, sizes, evaluation="dominant_lobe", reprojection="travel", gain=1.0, cell_format="f32", occlusion=True
    )


def packed(levels: list[np.ndarray]) -> np.ndarray:
    """Shares of all levels as the device holds them."""
    flat = np.concatenate([level.reshape(-1, 3) for level in levels])
    return np.concatenate([flat, np.zeros((len(flat), 1))], axis=1).astype(np.float32)


def stored_faces(device, made: Propagation, level: int = 0) -> np.ndarray:
    """What the device's faces let through, as `geometry.face_transmittance` has it: the lower faces of all cells, and
    of one more along each axis, without the dark border before them."""
    sizes = made.levels.sizes
    words = read_buffer(device, made.blockers["faces"], np.uint32)
    n, first = sizes[level], 3 * sum((m + 2) ** 3 for m in sizes[:level])
    words = words[first : first + 3 * (n + 2) ** 3].reshape((n + 2,) * 3 + (3,))
    return formats.unpack_thousandths(words[1:, 1:, 1:])


@pytest.mark.parametrize("n", [1, 4, N])
def test_faces_are_rounded_to_thousandths(device, n):
    """To the nearest of 1023 steps, but where float32 rounds to the other side of the middle between two; and where
    less would be blocked than 1/sqrt(5) of the rounded share across the face, up to it: by 0.5 / sqrt(5) and a step."""
    shares = np.random.default_rng(n).uniform(0.0, 1.2, (n, n, n, 3)).clip(max=1.0).astype(np.float32)
    made = kernel(device, (N, n))
    light = np.concatenate([random_light(k).reshape(-1, 3, 4) for k in (N, n)])
    run(device, made, light, 2, device.buffer("shares", packed([np.zeros((N, N, N, 3)), shares])))
    steps = (stored_faces(device, made, 1) - geometry.face_transmittance(shares)) * formats.STEPS
    rounding = formats.STEPS * 2.0**-21  # some eight in float32, of 1 at most
    assert steps.max() <= 0.5 + rounding and steps.min() >= -0.5 / np.sqrt(5.0) - 1.0 - rounding
    assert np.mean(np.abs(steps) > 0.5 + rounding) < 0.05
    blocked = 1.0 - stored_faces(device, made, 1)
    straight = np.einsum("zyxaa->zyxa", blocked)[..., None] / np.sqrt(5.0)
    assert np.all(blocked >= straight - 1e-12)
    np.testing.assert_array_equal(stored_faces(device, made, 0), 1.0)


@pytest.mark.parametrize("iterations", [1, 2, 5])
def test_random_blockers(device, iterations):
    light, shares = random_light(N, seed=7), np.random.default_rng(8).uniform(0.0, 1.2, (N, N, N, 3)).clip(max=1.0)
    blockers, made = device.buffer("shares", packed([shares])), kernel(device, (N,))
    found = run(device, made, light, iterations, blockers)
    expected = reference.propagate(light, iterations, 1.0, "dominant_lobe", "travel", stored_faces(device, made))
    assert largest_cell_error(found, expected) <= BOUNDS["f32"]


def test_every_level_has_its_own_blockers(device):
    levels = build_levels(random_light(N, seed=9))[:3]
    shares = geometry.geometry_levels(np.random.default_rng(10).uniform(0.0, 1.0, (N, N, N, 3)))[:3]
    blockers, made = device.buffer("shares", packed(shares)), kernel(device, (N, N // 2, N // 4))
    light = np.concatenate([level.reshape(-1, 3, 4) for level in levels]).astype(np.float32)
    found = run(device, made, light, 3, blockers)
    for number, (level, cells) in enumerate(zip(levels, made.levels.split(found), strict=True)):
        faces = stored_faces(device, made, number)
        expected = reference.propagate(level.astype(np.float32), 3, 1.0, "dominant_lobe", "travel", faces)
        assert largest_cell_error(cells, expected) <= BOUNDS["f32"]


def test_what_the_faces_at_a_wall_let_through():
    """A wall at x = 8, which is layer 7 of the geometry volume, half a cell aside. By hand, from its shares (1, 0,
    0): no
    light straight on; of light along the wall the part whose way is (0, 2, 1) / sqrt(5) to the wall's own faces; and
    faces across y beside it have two of their four corners in it."""
    shares = np.zeros((N, N, N, 3))
    shares[:, :, 7, 0] = 1.0
    faces = geometry.face_transmittance(shares)[1:-1, 1:-1]
    x, y, z = range(3)
    np.testing.assert_array_equal(faces[:, :, 8, x, x], 0.0)
    np.testing.assert_allclose(faces[:, :, 8, x, y], 1.0 - 1.0 / np.sqrt(5.0), rtol=1e-15)
    np.testing.assert_allclose(faces[:, :, 8, y, x], 1.0 - 2.0 * 0.5 / np.sqrt(5.0), rtol=1e-15)
    np.testing.assert_array_equal(faces[:, :, 8, y, z], 1.0)
    np.testing.assert_array_equal(faces[:, :, 10:], 1.0)


def test_blockers_only_take_light_away():
    shares = np.random.default_rng(12).uniform(0.0, 1.0, (N, N, N, 3))
    light, faces = random_light(N, seed=13), geometry.face_transmittance(shares)
    free, blocked = (reference.propagate(light, 6, 1.0, "dominant_lobe", "travel", f) for f in (None, faces))
    assert (blocked[..., 0] <= free[..., 0]).all()
    first = [reference.propagate(light, 1, 1.0, "dominant_lobe", "travel", f) for f in (None, faces)]
    np.testing.assert_array_equal(*first)  # the first step goes without (CLPV 3.3)


def test_no_blockers_change_nothing(device):
    light, blockers = random_light(N, seed=11), device.buffer("shares", packed([np.zeros((N, N, N, 3))]))
    plain = Propagation(device, (N,), evaluation="dominant_lobe", reprojection="travel", gain=1.0, cell_format="f32")
    with_none = run(device, kernel(device, (N,)), light, 4, blockers)
    assert largest_cell_error(with_none, run(device, plain, light, 4)) <= BOUNDS["f32"]
