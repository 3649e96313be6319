"""Injection (inject.wgsl, collect.wgsl) against the simulator's, which has its own tests."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from gpu_tools import largest_cell_error, one_stage, random_directions, read_buffer

from octolux.frame.structs import VPL
from octolux.frame.vpl_sources import MIN_STEPS, group_sources
from octolux.gpu.records import record_texture
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import injection as reference
from octolux.simulator.sh import COSINE_LOBE_1
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.injection import RUN, Injection, VplSource

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # benchmarks is not installed

from benchmarks.injection import OneAddEach

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
        buffers = device.uniform("grid", pack_grid(grid)), record_texture(device, "vpls", VPL, len(vpls), vpls)
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


def clustered_vpls(rng, count: int) -> np.ndarray:
    """Neighbours mostly in one cell, with steps to other cells and back, some of them outside the grid."""
    vpls = random_vpls(rng, count, 1.0)
    cells = np.repeat(rng.integers(-1, N + 1, (count, 3)), rng.integers(1, 12, count), axis=0)[:count]
    cells[1::5] = cells[::5][: len(cells[1::5])] + 1
    vpls["position"] = GRID.origin + GRID.cell_size * (cells + rng.uniform(0.01, 0.99, (count, 3)))
    vpls["position"] -= 0.5 * GRID.cell_size * unpack_normals(vpls["normal"])
    return vpls


def words(device, injection, vpls, sources) -> np.ndarray:
    """All bits of the injected light, and the peak's."""
    with one_stage(device) as stage:
        texture = record_texture(device, "vpls", VPL, len(vpls), vpls)
        injection.run(stage, device.uniform("grid", pack_grid(GRID)), texture, sources)
    return np.concatenate([read_buffer(device, b, np.uint32) for b in (injection.injected, injection.peak)])


@pytest.fixture(scope="module")
def baseline(device):
    return OneAddEach(device, N)


@pytest.mark.parametrize("width", [1, 7, 64, 5000])
@pytest.mark.parametrize("count", [1, RUN, 1000, 4096])
def test_bits_are_those_of_one_atomic_add_for_each_coefficient(device, injection, baseline, count, width):
    """Integers add in any order. Also rows that do not fill blocks, a width that is not the map's, and fewer VPLs than
    a thread's run; the VPLs behind those of the source are not its own."""
    rng = np.random.default_rng(count + width)
    for vpls in (clustered_vpls(rng, count + 9), random_vpls(rng, count + 9, 1.0)):
        sources = [VplSource(5, count, np.full(3, 1.0), width=width)]
        expected = words(device, baseline, vpls, sources)
        assert count == 1 or expected.any()
        assert np.array_equal(words(device, injection, vpls, sources), expected)


def test_lights_that_share_a_scale(device, injection):
    """Six lights of like flux, one of them apart in the buffer and one with a factor of its own: one scale, in which
    every coefficient of every VPL is wrong by at most half a step, but for the rounding of float32."""
    rng = np.random.default_rng(10)
    totals, counts = [1.0, 2.0, 0.5, 3.0, 1.0, 2.0], [900, 1000, 700, 800, 640, 500]
    factors = [1 / np.pi] * 5 + [1.0]
    starts = np.cumsum([0, *counts])
    vpls = np.concatenate([random_vpls(rng, c, t) for c, t in zip(counts, totals, strict=True)])
    sources = [
        VplSource(int(s), c, np.full(3, t), f, width=20)
        for s, c, t, f in zip(starts, counts, totals, factors, strict=False)
    ]
    sources.append(sources.pop(1))
    (group,) = group_sources(sources)
    assert len(group.pack()) == 2  # five lights that follow one another, and the one with another factor
    words(device, injection, vpls, sources)
    found = read_buffer(device, injection.injected).reshape(N, N, N, 3, 4)
    lights = [vpls[s : s + c] for s, c in zip(starts, counts, strict=False)]
    expected = sum(reference.inject(*arguments(v), f) for v, f in zip(lights, factors, strict=True))
    step = 1 / reference.fixed_point_scale(np.dot(totals, factors), len(vpls), 1.0)
    per_cell = reference._scatter(np.ones((len(vpls), 3, 4)), reference.vpl_cells(*arguments(vpls)[:2], GRID), N)
    # Each float32 product has four roundings of 2^-24 and the normal's six (simulator/lpv/injection.py), as has the sum
    # of a cell one; the terms of a coefficient are no larger than those of band 0 times 2 / sqrt(3).
    slack = reference.ARITHMETIC_SLACK * expected[..., :1] * 2 / np.sqrt(3)
    assert np.all(np.abs(found - expected) <= 0.5 * step * per_cell + slack)


def grouped(fluxes, counts):
    starts = np.cumsum([0, *counts])
    sources = [VplSource(int(s), c, np.array(f)) for s, c, f in zip(starts, counts, fluxes, strict=False)]
    return sources, group_sources(sources)


def test_a_scale_is_shared_only_where_every_light_keeps_its_steps():
    """For any lights: each with VPLs in one group, no sum overflows, and a mean VPL of who shares has MIN_STEPS."""
    rng = np.random.default_rng(11)
    for _ in range(50):
        lights = rng.integers(1, 40)
        colors = rng.uniform(0, 1, (lights, 3)) * rng.integers(0, 2, (lights, 3))
        fluxes = 10 ** rng.uniform(-3, 3, (lights, 1)) * colors
        sources, groups = grouped(fluxes, rng.integers(0, 70000, lights).tolist())
        assert sorted(s.first for g in groups for s in g.sources) == [s.first for s in sources if s.count]
        for group in groups:
            flux = sum(s.total_flux * s.intensity_per_flux for s in group.sources)
            scale = 1.0 / group.pack()[0]["to_intensity"][0].astype(np.float64)
            count = sum(s.count for s in group.sources)
            assert np.all(scale * flux * COSINE_LOBE_1 + count / 2 <= 2**31)
            for s in group.sources if len(group.sources) > 1 else []:
                mean = s.total_flux * s.intensity_per_flux / s.count
                # Of the room half is lost to the power of two at most, and by `count` 70000 * 40 / 2 of 2^31.
                assert np.all((mean == 0) | (scale * COSINE_LOBE_1 * mean >= 0.998 * MIN_STEPS))


def test_a_sun_and_a_sky_are_two_groups():
    """32 lights of 4096 VPLs share; a sun a hundred times as bright as one of them would take their steps."""
    _, groups = grouped([[2e7] * 3, *[[3e5] * 3] * 32], [65536] + [4096] * 32)
    assert [len(g.sources) for g in groups] == [32, 1]
    assert [len(g.pack()) for g in groups] == [1, 1]
