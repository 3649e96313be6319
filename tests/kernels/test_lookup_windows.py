"""Lookup of nested windows (lookup.wgsl, volumes.wgsl, volume_light.wgsl) against the simulator's: each window with
its own cells, blended by the simulator's weights. The G-buffer, and how far one window may be off, are those of
test_lookup.py."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import TESTS, one_stage, read_buffer
from test_lookup import GRID as BOX
from test_lookup import SIZE, WEIGHT_ERROR, gbuffer, scale_of, sensitivity, smooth_light, spread

from octolux.gpu.bindings import storage, storage_rw
from octolux.gpu.passes import ComputePass
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import cascades
from octolux.simulator.lpv import lookup as reference
from octolux.techniques.lpv.constants import pack_grids
from octolux.techniques.lpv.lookup import CHANNELS, Lookup
from octolux.techniques.lpv.windows import pack_windows

N, COUNT = 16, 3
VOLUME = Grid(BOX.origin, 2.0 / N, N)  # the box of test_lookup's G-buffer
SHARE_ERROR = 1e-4
"""Of a window's share: places are right to 1e-4 cells, and a transition is two cells wide; twice that, as the share of
the next window errs by as much the other way."""


def placed(device) -> SimpleNamespace:
    """Windows around one of the G-buffer's points, on host and device."""
    g = gbuffer(device)
    windows = cascades.place_windows(N, COUNT, VOLUME, g.points[g.inside][44], [0.0, 0.0, 0.0])
    grids = cascades.grids_of(windows, VOLUME)
    return SimpleNamespace(
        windows=windows, grids=grids, grids_buffer=device.uniform("grids", pack_grids(grids)),
        windows_buffer=device.uniform("windows", pack_windows(windows)),
    )  # fmt: skip


def filled(device, made: Lookup, grids: list[Grid], seed: int):
    """Light of all windows, four times as much in each as in the finer one, as a cell of twice the size holds: in the
    volumes; and what they hold, W/sr, with the buffer of the peak."""
    light = np.stack([smooth_light(seed + i, grid=grid) * np.float32(4.0**i) for i, grid in enumerate(grids)])
    scale = scale_of(light)
    with one_stage(device) as stage:
        made.write_volumes(stage, device.buffer("light", (light * scale).astype(np.float32)))
    layout = {"bytes_per_row": N * 8, "rows_per_image": N * COUNT}
    size = (N, N * COUNT, N)
    halves = [device.queue.read_texture({"texture": made.volumes[c]}, layout, size) for c in CHANNELS]
    cells = [np.frombuffer(h, np.float16).reshape(N, COUNT, N, N, 4).swapaxes(0, 1) for h in halves]
    stored = np.stack(cells, axis=4).astype(np.float64) / scale
    np.testing.assert_allclose(stored, light, rtol=2**-10, atol=1e-7 * light.max())  # half floats
    return stored, device.buffer("peak", np.array([light[..., 0].max()], np.float32))


def lookup(device, reading: str, damping: bool, offset: float) -> Lookup:
    return Lookup(device, N, reading=reading, damping=damping, lookup_offset=offset, windows=COUNT)


def shares_of(points: np.ndarray, shift: np.ndarray, at: SimpleNamespace) -> np.ndarray:
    """Share of each window (COUNT, M) at `points` (M, 3), moved by `shift` of its cells."""
    shares = cascades.weights(np.array([grid.to_cells(points) + shift for grid in at.grids]), at.windows, N)
    assert all(np.any((s > 0) & (s < 1)) and np.any(s == 1) for s in shares[:-1]), "no window gives way to another"
    return shares


@pytest.mark.parametrize(("reading", "damping", "offset"), [("dominant_lobe", False, 0.5), ("paper", True, 0.0)])
def test_windows_are_read_with_their_own_cells_and_blended(device, reading, damping, offset):
    made, g, at = lookup(device, reading, damping, offset), gbuffer(device), placed(device)
    made.prepare(SIZE)
    stored, peak = filled(device, made, at.grids, 3)
    with one_stage(device) as stage:
        made.read(stage, g.frame, at.grids_buffer, peak, at.windows_buffer)
    found = device.read_texture(made.irradiance, np.float32, 4)[..., :3].astype(np.float64)
    assert not found[~g.inside].any()
    points, normals, geometric = g.points[g.inside], g.normals[g.inside], g.geometric[g.inside]
    expected, bound = np.zeros((2, len(points), 3))
    shares = shares_of(points, offset * geometric, at)
    for share, volume, grid in zip(shares, stored, at.grids, strict=True):
        read, error = expected_in(volume, grid, points, normals, geometric, reading, damping, offset)
        expected += share[:, None] * read
        blended = np.where((share > 0) & (share < 1), SHARE_ERROR, 0.0)
        bound += share[:, None] * error + blended[:, None] * read
    assert np.all(np.abs(found[g.inside] - expected) <= bound)
    assert np.median(bound) < 0.05 * np.median(expected), "the bound says nothing"


def expected_in(volume, grid, points, normals, geometric, reading, damping, offset):
    """Irradiance of one window, and how far the device may be from it; as in test_lookup.py."""
    places = points + offset * grid.cell_size * geometric
    sampled = reference.sample_trilinear(volume, grid, places)
    error = WEIGHT_ERROR * spread(volume, places, grid) + 1e-4 * np.abs(sampled)
    full = reference.irradiance(sampled, normals, grid.cell_size, reading)
    if not damping:
        return full, sensitivity(reading, error, grid)
    for side in (0.5, -0.5):
        beside = places + side * grid.cell_size * geometric
        error = np.maximum(error, WEIGHT_ERROR * spread(volume, beside, grid) + 1e-4 * np.abs(sampled))
    relative = np.linalg.norm(error, axis=-1) / np.linalg.norm(sampled, axis=-1)
    kept = reference.damping(volume, grid, places, geometric)
    return kept * full, sensitivity(reading, error, grid) + 4 * relative * full


def test_fog_reads_the_finest_window_at_a_place(device):
    """Fluence, blended, and steps as long as the cells of the finest window that holds the place."""
    made, at = lookup(device, "dominant_lobe", False, 0.5), placed(device)
    stored, peak = filled(device, made, at.grids, 7)
    points = np.random.default_rng(8).uniform(-1.05, 1.05, (4000, 3)).astype(np.float32)
    light = made.volume_light(at.grids_buffer, peak, at.windows_buffer)
    kernel = ComputePass(
        device, "volume light", str(TESTS / "kernels" / "volume_light.wgsl"),
        [storage("given", "f32"), storage_rw("result", "f32", "write"), *light.bindings], structs=light.structs,
        workgroup=(64, 1, 1), threads=len(points), **light.values,
    )  # fmt: skip
    result = device.buffer("result", size=len(points) * 16)
    with one_stage(device) as stage:
        kernel.run(stage, (len(points),), given=device.buffer("given", points), result=result, **light.resources)
    found = read_buffer(device, result).reshape(-1, 4).astype(np.float64)
    points = points.astype(np.float64)
    inside = np.all(np.abs(points) <= 1.0, axis=1)
    assert not found[~inside, :3].any() and (~inside).sum() > 100
    shares = shares_of(points, np.zeros(3), at)
    expected, bound = np.zeros((2, len(points), 3))
    for share, volume, grid in zip(shares, stored, at.grids, strict=True):
        sampled = reference.sample_trilinear(volume, grid, points)
        error = WEIGHT_ERROR * spread(volume, points, grid) + 1e-4 * np.abs(sampled)
        fluence = reference.fluence(sampled, grid.cell_size)
        # Phi / h^2 (2/3 + a / 3), with a Phi = sqrt(3 pi) |c1| or all of Phi.
        most = 2 * np.sqrt(np.pi) * error[..., 0] + np.sqrt(3 * np.pi) / 3 * np.linalg.norm(error[..., 1:], axis=-1)
        expected += share[:, None] * fluence
        blended = np.where((share > 0) & (share < 1), SHARE_ERROR, 0.0)
        bound += share[:, None] * most / grid.cell_size**2 + blended[:, None] * fluence
    assert np.all(np.abs(found[:, :3] - expected)[inside] <= bound[inside])
    assert np.median(bound[inside]) < 0.05 * np.median(expected[inside])
    finest = np.argmax(shares > 0, axis=0)
    sizes = np.array([grid.cell_size for grid in at.grids])
    sure = np.all((shares == 0) | (shares > SHARE_ERROR), axis=0)
    np.testing.assert_allclose(found[sure, 3], sizes[finest[sure]], rtol=1e-6)
