"""Steps whose blockers reflect (faces.wgsl, propagation.wgsl) against the simulator's, and the flux they keep."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from gpu_tools import largest_cell_error, one_stage, read_buffer
from test_propagation import BOUNDS, random_light
from test_propagation_occlusion import N, packed, stored_faces

from octolux.simulator.lpv import bounces, formats
from octolux.simulator.lpv import propagation as reference
from octolux.techniques.lpv.constants import storage_scale
from octolux.techniques.lpv.propagation import Propagation

KINDS = ("mono", "spectral")
# A stored reflectance is off by at most half a step, but where float32 rounds to the other side of the middle.
HALF_STEP = (0.5 + 1023 * 2.0**-20) / formats.STEPS


@cache
def kernel(device, sizes: tuple[int, ...], kind: str, evaluation: str = "dominant_lobe") -> Propagation:
    return Propagation(
        device, sizes, evaluation=evaluation, reprojection="travel", gain=1.0, cell_format="f32", occlusion=True,
        bounces=kind,
    )  # fmt: skip


def blockers(n: int, seed: int, albedo: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Float32 shares and reflectors of n^3 cells, half of them empty. In some, less is blocked than the sides cover."""
    rng = np.random.default_rng(seed)
    facing = rng.uniform(0.0, 1.0, (n, n, n, 6)) * (rng.random((n, n, n, 1)) < 0.5)
    colour = rng.random((n, n, n, 3)) if albedo is None else np.full((n, n, n, 3), albedo)
    shares = np.minimum(facing[..., ::2] + facing[..., 1::2], 1.0).astype(np.float32)
    return shares, bounces.reflectors(facing, colour).astype(np.float32)


def run(device, made: Propagation, light: np.ndarray, iterations: int, volumes: list) -> np.ndarray:
    """The accumulated light, W/sr. volumes: shares and reflectors of each level."""
    injected = device.buffer("injected", light.astype(np.float32))
    peak = np.float32(light[..., 0].max())
    shares = device.buffer("shares", packed([s for s, _ in volumes]))
    reflectors = device.buffer("reflectors", np.concatenate([r.reshape(-1, 4) for _, r in volumes]))
    with one_stage(device) as stage:
        made.run(stage, injected, device.buffer("peak", np.array([peak])), iterations, shares, reflectors)
    return read_buffer(device, made.light).reshape(light.shape) / np.float32(storage_scale(peak))


def stored_reflectance(device, made: Propagation, level: int = 0) -> np.ndarray:
    """The device's, as `bounces.cell_reflectance` has it."""
    words = read_buffer(device, made.blockers["reflectances"], np.uint32)
    cells = made.levels.split(words.reshape(made.levels.cells, -1, 2))[level]
    return np.moveaxis(formats.unpack_thousandths(cells), (-1, -2), (3, 4)).reshape(*cells.shape[:3], 6, -1)


@pytest.mark.parametrize("kind", KINDS)
def test_reflectances_are_the_simulators(device, kind):
    shares, reflectors = blockers(N, seed=3)
    made = kernel(device, (N,), kind)
    run(device, made, random_light(N), 2, [(shares, reflectors)])
    expected = bounces.cell_reflectance(reflectors, shares, kind == "spectral")
    assert np.abs(stored_reflectance(device, made) - expected).max() <= HALF_STEP


@pytest.mark.parametrize("evaluation", ["clamped", "dominant_lobe"])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("iterations", [1, 2, 5])
def test_random_blockers(device, kind, iterations, evaluation):
    light, made = random_light(N, seed=7), kernel(device, (N,), kind, evaluation)
    found = run(device, made, light, iterations, [blockers(N, seed=8)])
    faces, reflectance = stored_faces(device, made), stored_reflectance(device, made)
    expected = reference.propagate(light, iterations, 1.0, evaluation, "travel", faces, reflectance)
    assert largest_cell_error(found, expected) <= BOUNDS["f32"]


@pytest.mark.parametrize("kind", KINDS)
def test_cascades_have_blockers_of_their_own(device, kind):
    sizes = (8, 8, 8)
    levels = [random_light(8, seed=k) for k in range(3)]
    made = kernel(device, sizes, kind)
    found = run(
        device, made, np.concatenate([x.reshape(-1, 3, 4) for x in levels]), 3, [blockers(8, k) for k in range(3)]
    )
    for number, (light, cells) in enumerate(zip(levels, made.levels.split(found), strict=True)):
        faces, reflectance = stored_faces(device, made, number), stored_reflectance(device, made, number)
        expected = reference.propagate(light, 3, 1.0, "dominant_lobe", "travel", faces, reflectance)
        assert largest_cell_error(cells, expected) <= BOUNDS["f32"]


def test_black_blockers_are_occlusion_alone(device):
    light, volumes = random_light(N, seed=11), blockers(N, 12, albedo=0.0)
    plain = Propagation(
        device, (N,), evaluation="dominant_lobe", reprojection="travel", gain=1.0, cell_format="f32", occlusion=True
    )
    with_black = run(device, kernel(device, (N,), "spectral"), light, 4, [volumes])
    injected, peak = device.buffer("injected", light), device.buffer("peak", np.array([light[..., 0].max()]))
    with one_stage(device) as stage:
        plain.run(stage, injected, peak, 4, device.buffer("shares", packed([volumes[0]])))
    without = read_buffer(device, plain.light).reshape(light.shape) / np.float32(storage_scale(light[..., 0].max()))
    # Compilers may fuse differently: a few roundings in float32 a step.
    assert largest_cell_error(with_black, without) <= 4 * 2.0**-20


def test_white_blockers_keep_all_light(device):
    """A hollow among full blockers that reflect everything, nothing near the border. Zero, one and what they leave are
    exact in thousandths or add to one, so that only float32 rounds: 2^-24 in each of some hundred sums a step."""
    shares, reflectors = np.ones((N, N, N, 3), np.float32), np.ones((N, N, N, 3, 4), np.float32)
    shares[6:9, 6:9, 6:9] = 0.0
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[7:9, 7:9, 7:9] = random_light(2, seed=5)
    made = kernel(device, (N,), "mono")
    now, before = (run(device, made, light, k, [(shares, reflectors)]).astype(np.float64) for k in (5, 4))
    np.testing.assert_allclose(reference.total_flux(now - before), reference.total_flux(light), rtol=500 * 2.0**-24)


@pytest.mark.parametrize(("kind", "occlusion"), [("mono", False), ("red", True)])
def test_bounces_need_occlusion_and_a_name(device, kind, occlusion):
    scheme = {"evaluation": "clamped", "reprojection": "face", "gain": 1.0, "cell_format": "f32"}
    with pytest.raises(ValueError, match="need occlusion"):
        Propagation(device, (N,), bounces=kind, occlusion=occlusion, **scheme)
