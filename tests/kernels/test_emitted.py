"""Injection of low-frequency direct light (emitted.wgsl) against the simulator's, and the records of scenes."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import largest_cell_error, one_stage, random_directions, read_buffer, scene_of

from octolux.frame.vpl_sources import VplSource
from octolux.gpu.records import read_records, record_texture
from octolux.scene.builtin.shapes import quad
from octolux.scene.environment import Environment
from octolux.scene.lights import AreaLight, ParticleLights, PointLight
from octolux.scene.materials import Material
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import emitted as reference
from octolux.simulator.lpv.propagation import total_flux
from octolux.techniques.lpv.constants import pack_grids
from octolux.techniques.lpv.emitted import EMITTED, EmittedInjection, EmittedLights, pack_emitted

N = 16
NESTED = [Grid((0.5, 0.25, 1.0), 0.25, N), Grid((-1.0, -1.0, 0.0), 0.5, N), Grid((-8.0, -4.0, -6.0), 1.0, N)]
EXACT = 1e-4
"""Of a cell's largest coefficient: fluxes span 1 to 10, so that with 3000 records and 31 bits the faintest coefficient
of band 0 has 3e4 steps, and rounding moves it by 2e-5 of it; float32 adds some 1e-6."""


def random_records(rng, count: int, margin: float = 0.01) -> reference.Emitted:
    """Records in and around the nested grids. After the move none lies within `margin` cells of a face of any, where
    float32 and float64 may choose different cells; their axes are as exact as packed ones."""
    axis = unpack_normals(pack_normals(random_directions(rng, 8 * count)))
    beam = rng.choice([0.0, 1.0, 0.4, 1.5], 8 * count).astype(np.float32).astype(np.float64)
    around = rng.choice(len(NESTED), 8 * count)
    low, size = np.array([g.origin for g in NESTED]), np.array([g.cell_size for g in NESTED])
    position = low[around] + size[around][:, None] * rng.uniform(-1, N + 1, (8 * count, 3))
    position = position.astype(np.float32).astype(np.float64)
    clear = np.ones(8 * count, dtype=bool)
    for grid in NESTED:
        place = grid.to_cells(position + 0.5 * grid.cell_size * beam[:, None] * axis)
        clear &= np.all(np.abs(place - np.rint(place)) > margin, axis=1)
    kept = np.flatnonzero(clear)[:count]
    assert len(kept) == count
    flux = rng.uniform(0.1, 1, (count, 3)) / count
    return reference.Emitted(position[kept], flux, axis[kept], beam[kept])


def given(device, groups) -> SimpleNamespace:
    """Records as `EmittedLights` has them, each group a light of its own."""
    rows = pack_emitted(reference.Emitted.joined(groups))
    starts = np.cumsum([0, *(len(g.beam) for g in groups)])
    sources = [VplSource(int(s), len(g.beam), g.bound) for s, g in zip(starts, groups, strict=False)]
    return SimpleNamespace(texture=record_texture(device, "emitted", EMITTED, len(rows), rows), sources=sources)


def run(device, made, lights, grids, before=None, moments=None) -> tuple[np.ndarray, float]:
    """Add records to light; the cells [grid][z][y][x][rgb][4], and the peak kept beside them. moments: a buffer."""
    n = grids[0].n
    start = np.zeros((len(grids), n, n, n, 3, 4), np.float32) if before is None else before
    injected, peak = device.buffer("injected", start), device.buffer("peak", start[..., 0].max()[None].view(np.uint32))
    with one_stage(device) as stage:
        made.run(stage, device.uniform("grids", pack_grids(grids)), lights, injected, peak, moments)
    return read_buffer(device, injected).reshape(start.shape), float(read_buffer(device, peak)[0])


@pytest.mark.parametrize("count", [1, 3], ids=["one grid", "three nested grids"])
def test_cells_are_those_of_the_simulator(device, count):
    grids, records = NESTED[-count:], random_records(np.random.default_rng(1), 3000)
    made = EmittedInjection(device, N, grids=count)
    cells, peak = run(device, made, given(device, [records]), grids)
    expected = reference.inject(records, grids)
    assert all(level.any() for level in expected)
    assert largest_cell_error(cells, expected) <= EXACT
    assert peak == cells[..., 0].max()


def test_moments_are_added_to_those_there(device):
    """Places are right to 1e-5 cells, and up to 5/4 from the middle; and light is the same bits with moments or
    without. Rounding as that of light, whose steps are no more than four times as fine."""
    records = random_records(np.random.default_rng(7), 3000)
    before = np.random.default_rng(8).uniform(0.0, 1e-3, (3, N, N, N, 4)).astype(np.float32)
    moments, lights = device.buffer("moments", before), given(device, [records])
    made, plain = (EmittedInjection(device, N, grids=3, moments=m) for m in (True, False))
    cells, _ = run(device, made, lights, NESTED, None, moments)
    assert cells.tobytes() == run(device, plain, lights, NESTED)[0].tobytes()
    found = read_buffer(device, moments).reshape(before.shape) - before.astype(np.float64)
    expected, weight = reference.inject_moments(records, NESTED), cells[..., 0].sum(axis=-1)[..., None]
    assert np.all(np.abs(found[..., :3] - expected) <= (4.0 * EXACT + 1e-5) * weight + 1e-3 * 2.0**-23)
    beside = np.abs(expected)[weight[..., 0] > 0.0] / weight[weight[..., 0] > 0.0]
    assert not found[..., 3].any() and np.median(beside) > 0.1


@pytest.fixture(scope="module")
def injection(device):
    return EmittedInjection(device, N, grids=3)


def test_lights_of_very_different_flux_are_added_to_what_is_there(device, injection):
    """Each in its own fixed point: a sun's sky beside fireflies of a billionth of its flux."""
    rng = np.random.default_rng(2)
    groups = [random_records(rng, 2000) for _ in range(3)]
    groups = [replace(g, flux=g.flux * f) for g, f in zip(groups, (1e-3, 1.0, 1e6), strict=True)]
    before = rng.uniform(0, 1e-3, (3, N, N, N, 3, 4)).astype(np.float32)
    cells, peak = run(device, injection, given(device, groups), NESTED, before)
    expected = before + sum(reference.inject(g, NESTED) for g in groups)
    assert largest_cell_error(cells, expected) <= EXACT
    assert peak == cells[..., 0].max()


def test_the_same_records_in_any_order_give_the_same_bits(device, injection):
    rng = np.random.default_rng(3)
    records = random_records(rng, 3000)
    turn = rng.permutation(3000)
    mixed = reference.Emitted(*(getattr(records, k)[turn] for k in ("position", "flux", "axis", "beam")))
    once, again, other = (run(device, injection, given(device, [r]), NESTED)[0] for r in (records, records, mixed))
    assert once.tobytes() == again.tobytes() == other.tobytes()


def test_all_records_in_one_cell_do_not_overflow(device, injection):
    """100,000 parallel beams along one axis, from nearly 5/4 cells before the middle: the largest sums that the scales
    allow for."""
    count = 100_000
    place = NESTED[0].cell_centres()[5, 6, 7] - [0.0, 0.49 * NESTED[0].cell_size, 0.0]
    axis = np.tile([0.0, 1.0, 0.0], (count, 1))
    records = reference.Emitted(np.tile(place, (count, 1)), np.full((count, 3), 1e3), axis, np.full(count, 1.5))
    records = replace(records, position=records.position - 0.5 * NESTED[0].cell_size * 1.5 * axis)
    moments, made = device.buffer("moments", size=3 * N**3 * 16), EmittedInjection(device, N, grids=3, moments=True)
    for each, given_moments in ((injection, None), (made, moments)):
        cells, _ = run(device, each, given(device, [records]), NESTED, None, given_moments)
        assert largest_cell_error(cells, reference.inject(records, NESTED)) <= EXACT
    found = read_buffer(device, moments).reshape(3, N, N, N, 4)[0, 5, 6, 7]
    weight = cells[0, 5, 6, 7, :, 0].sum()
    np.testing.assert_allclose(found / weight, [0.0, -1.24, 0.0, 0.0], atol=1e-4)


def test_no_light_leaves_everything_as_it_is(device, injection):
    before = np.random.default_rng(4).random((3, N, N, N, 3, 4)).astype(np.float32)
    cells, peak = run(device, injection, SimpleNamespace(texture=None, sources=[]), NESTED, before)
    assert cells.tobytes() == before.tobytes() and peak == before[..., 0].max()
    dark = replace(random_records(np.random.default_rng(5), 50), flux=np.zeros((50, 3)))
    assert run(device, injection, given(device, [dark]), NESTED, before)[0].tobytes() == before.tobytes()


SQUARE = AreaLight(corners=((3, 3, 3), (5, 3, 3), (5, 5, 3), (3, 5, 3)), radiance=(1.0, 2.0, 3.0))
GROUP = ParticleLights(positions=np.random.default_rng(6).uniform(1, 4, (500, 3)), intensities=(3.0, 2.0, 1.0))
PANE = quad([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], material=1)
MATERIALS = [Material(), Material(emissive=(0.0, 5.0, 0.0), double_sided=True)]


def frame_of(scene, moves: int = 0) -> SimpleNamespace:
    return SimpleNamespace(scene=scene, surroundings=scene.environment, gpu_scene=SimpleNamespace(moves=moves))


def glowing_scene(**changes):
    return scene_of([PANE], MATERIALS, lights=[SQUARE, GROUP, PointLight(position=(0, 0, 0), intensity=(1, 1, 1))],
                    environment=Environment((0.5, 0.5, 0.0)), **changes)  # fmt: skip


def test_a_scenes_lights_arrive_with_all_their_flux(device, injection):
    """In the last grid all, in the one inside it what lies there: not the sky, nor the pane's back. Point lights have
    shadow maps and are none of it. The sky's flux is summed over texels, to 1e-3."""
    lights = EmittedLights(device)
    lights.sync(frame_of(glowing_scene()), NESTED)
    cells, _ = run(device, injection, lights, NESTED)
    particles = 500 * 4 * pi * np.array([3.0, 2.0, 1.0])
    square, pane = 4 * pi * np.array([1.0, 2.0, 3.0]), pi * np.array([0.0, 5.0, 0.0])
    sky = 6 * N**2 * pi * np.array([0.5, 0.5, 0.0])
    found = [total_flux(level.astype(np.float64)) for level in cells]
    np.testing.assert_allclose(found[2], particles + square + 2 * pane + sky, rtol=1e-3)
    np.testing.assert_allclose(found[1], particles + square + pane, rtol=1e-3)
    assert [s.count for s in lights.sources] == [500, lights.sources[1].count, 6 * N**2]
    assert lights.sources[1].count >= (4 + 2) / (0.5 * 0.125**2)  # one is less than half its longest edge's square


def test_only_the_kinds_asked_for(device):
    for kind, count in (("particles", 500), ("surroundings", 6 * N**2)):
        lights = EmittedLights(device, [kind])
        lights.sync(frame_of(glowing_scene()), NESTED)
        assert [s.count for s in lights.sources] == [count]


def test_records_are_made_anew_when_their_scene_changes_and_only_then(device):
    lights, scene = EmittedLights(device), glowing_scene()
    lights.sync(frame_of(scene), NESTED)
    first = lights.sources
    lights.sync(frame_of(scene), NESTED)
    assert lights.sources is first
    moved = ParticleLights(positions=GROUP.positions[:100] + 1.0, intensities=(1.0, 1.0, 1.0))
    scene.lights[1] = moved
    lights.sync(frame_of(scene), NESTED)
    assert [s.count for s in lights.sources] == [100, first[1].count, first[2].count]
    rows = read_records(device, lights.texture, EMITTED, 100)
    np.testing.assert_array_equal(rows["position"], moved.positions.astype(np.float32))
    scene.environment = Environment()
    lights.sync(frame_of(scene), NESTED)
    assert [s.count for s in lights.sources] == [100, first[1].count]
    lights.sync(frame_of(scene_of([], lights=[SQUARE, SQUARE]), moves=1), NESTED)
    found = read_records(device, lights.texture, EMITTED, lights.sources[0].count)
    flux = found["flux"].sum(axis=0, dtype=np.float64)
    np.testing.assert_allclose(flux, 8 * pi * np.array([1.0, 2.0, 3.0]), rtol=1e-5)
    lights.sync(frame_of(scene_of([])), NESTED)
    assert lights.sources == []
