"""Injection (inject.wgsl, collect.wgsl) against the simulator's, which has its own tests."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import largest_cell_error, one_stage, random_directions, read_buffer

from octolux.frame.structs import VPL
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import injection as reference
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.injection import Injection, VplSource

N = 16
GRID = Grid((-1.0, -0.5, 2.0), 0.25, N)


@pytest.fixture(scope="module")
def injection(device):
    return Injection(device, N)


def random_vpls(rng, count: int, total: float, margin: float = 0.01) -> np.ndarray:
    """VPLs in and around the grid whose flux adds to less than `total`; every seventh has none.

    After the move by half a cell none lies within `margin` cells of a face, where float32 and float64 may choose
    different cells. Fluxes span 1 to 10: with 5000 VPLs and 31 bits the faintest still have 4e4 steps of fixed point.
    """
    vpls = VPL.array(count)
    vpls["normal"] = pack_normals(random_directions(rng, count))
    cells = rng.integers(-2, N + 2, (count, 3)) + rng.uniform(margin, 1 - margin, (count, 3))
    moved = GRID.origin + GRID.cell_size * cells
    vpls["position"] = moved - 0.5 * GRID.cell_size * unpack_normals(vpls["normal"])
    vpls["flux"] = rng.uniform(0.1, 1, (count, 3)) * total / count
    vpls["flux"][3::7] = 0.0
    return vpls


def run(device, injection, groups, totals, grid=GRID) -> tuple[np.ndarray, float]:
    """Inject groups of VPLs, one light each; the cells, and the peak kept beside them."""
    starts = np.cumsum([0, *(len(g) for g in groups)])
    sources = [VplSource(int(s), len(g), np.full(3, t)) for s, g, t in zip(starts, groups, totals, strict=False)]
    vpls = VPL.array(int(starts[-1]))
    for start, group in zip(starts, groups, strict=False):
        vpls[start : start + len(group)] = group
    with one_stage(device) as stage:
        buffers = device.uniform("grid", pack_grid(grid)), device.buffer("vpls", vpls)
        injection.run(stage, *buffers, sources)
    cells = read_buffer(device, injection.injected).reshape(N, N, N, 3, 4)
    return cells, float(read_buffer(device, injection.peak)[0])


def arguments(vpls: np.ndarray, grid=GRID):
    return vpls["position"].astype(np.float64), unpack_normals(vpls["normal"]), vpls["flux"].astype(np.float64), grid


def test_lights_of_very_different_flux(device, injection):
    rng = np.random.default_rng(1)
    totals = [1e-2, 1.0, 1e6]
    groups = [random_vpls(rng, count, total) for count, total in zip((5000, 3000, 1), totals, strict=True)]
    cells, peak = run(device, injection, groups, totals)
    expected = sum(reference.inject(*arguments(g)) for g in groups)
    assert largest_cell_error(cells, expected) <= 1e-4
    assert peak == cells[..., 0].max()


def test_a_faint_light_keeps_its_own_precision(device, injection):
    """Beside a light of 1e9 times its flux, the faint one's cells are as exact as if it were alone."""
    rng = np.random.default_rng(2)
    sun = random_vpls(rng, 1, 1e6)
    sun["flux"] = 1e6
    sun["position"] = np.array(GRID.origin) + 0.3 * GRID.cell_size
    sun["normal"] = pack_normals(np.array([0.0, 0.0, 1.0]))
    faint = random_vpls(rng, 2000, 1e-3)
    cells, _ = run(device, injection, [sun, faint], [1e6, 1e-3])
    expected = reference.inject(*arguments(faint)) + reference.inject(*arguments(sun))
    assert largest_cell_error(cells, expected) <= 1e-4


def test_sums_are_those_of_the_fixed_point_reference(device, injection):
    """A coefficient becomes an integer of at most 2^23 here, exact in float32, so that a sum differs by at most one
    unit for each VPL (its coefficient may round the other way), and most do not differ."""
    rng = np.random.default_rng(3)
    vpls, total = random_vpls(rng, 4000, 1.0), 400.0
    cells, _ = run(device, injection, [vpls], [total])
    scale = reference.fixed_point_scale(np.full(3, total), len(vpls))
    expected = reference.inject_fixed_point(*arguments(vpls), scale)
    difference = np.abs(np.rint(cells.astype(np.float64) * scale[:, None]) - expected)
    per_cell = reference._scatter(np.ones((len(vpls), 3, 4)), reference.vpl_cells(*arguments(vpls)[:2], GRID), N)
    assert np.all(difference <= per_cell)
    assert (difference > 0).mean() < 0.01


def test_axis_aligned_vpls_agree_to_the_bit(device, injection):
    """Normals along the axes and fluxes of few bits: nothing rounds but the lobe's own constants."""
    rng = np.random.default_rng(4)
    vpls = random_vpls(rng, 1000, 1.0)
    axes = np.concatenate([np.eye(3), -np.eye(3)])
    vpls["normal"] = pack_normals(axes[rng.integers(0, 6, len(vpls))])
    cells = rng.integers(1, N - 1, (len(vpls), 3)) + 0.5
    vpls["position"] = GRID.origin + GRID.cell_size * cells - 0.125 * unpack_normals(vpls["normal"])
    vpls["flux"] = 2.0 ** rng.integers(-12, -10, (len(vpls), 1))
    # Fixed point in 2^-20 steps: lobes of 2^-12 become integers near 200, far from where they could round both ways.
    total = 0.9 * 2**31 / 2**20 / 0.33
    scale = reference.fixed_point_scale(np.full(3, total), len(vpls))
    found, _ = run(device, injection, [vpls], [total])
    expected = reference.inject_fixed_point(*arguments(vpls), scale)
    assert np.array_equal(found.astype(np.float64) * scale[:, None], expected)
    assert expected[..., 0].max() > 100


def test_a_vpl_on_a_face_belongs_to_the_upper_cell(device, injection):
    """Positions and cell size have few bits, so that moved VPLs lie exactly on faces; the upper border is outside."""
    vpls = VPL.array(N + 2)
    vpls["normal"] = pack_normals(np.array([0.0, 0.0, 1.0]))
    vpls["flux"] = 1.0 + np.arange(N + 2)[:, None]
    face = np.stack([np.arange(N + 2) - 1.0, np.full(N + 2, 3.0), np.full(N + 2, 4.0)], axis=1)
    vpls["position"] = GRID.origin + GRID.cell_size * (face - [0.0, 0.0, 0.5])
    cells, _ = run(device, injection, [vpls], [1000.0])
    flux = cells[4, 3, :, 0, 0] * 2.0 * np.sqrt(np.pi)
    np.testing.assert_allclose(flux, 2.0 + np.arange(N), rtol=1e-6)
    assert np.count_nonzero(cells[..., 0]) == 3 * N


def test_no_flux_gives_dark_cells_and_no_peak(device, injection):
    vpls = random_vpls(np.random.default_rng(5), 100, 1.0)
    vpls["flux"] = 0.0
    cells, peak = run(device, injection, [vpls], [1.0])
    assert not cells.any() and peak == 0.0


def test_nothing_of_a_frame_is_left_for_the_next(device, injection):
    """VPLs so faint that band 0 rounds to 0 while band 1 rounds to 1 must not stay in the sums."""
    faint, bright = (random_vpls(np.random.default_rng(6), 64, 1.0) for _ in range(2))
    total = 1000.0
    unit = 1 / (reference.fixed_point_scale(total, len(faint)) / np.pi)  # flux of one step of fixed point
    faint["flux"] = 0.53 * unit  # band 0: 0.886 * 0.53 < 1/2; band 1 along an axis: 1.023 * 0.53 > 1/2
    faint["normal"] = pack_normals(np.array([0.0, 1.0, 0.0]))
    alone, _ = run(device, injection, [bright], [total])
    run(device, injection, [faint], [total])
    after, _ = run(device, injection, [bright], [total])
    assert np.array_equal(alone, after)
