"""Gathering through nested windows on the device against the simulator's: injection, surfels, nodes, cells, lookup."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions, read_buffer
from test_lookup import GRID as BOX
from test_lookup import gbuffer
from test_octree_gathering import HALF_FLOAT, STORED, packed, random_planes

from octolux.frame.structs import VPL
from octolux.gpu.records import record_texture
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import cascades, gathering, geometry, strips
from octolux.simulator.lpv import injection as injection_reference
from octolux.simulator.lpv.octree import level_sizes
from octolux.techniques.lpv.constants import pack_grids, storage_scale
from octolux.techniques.lpv.gathering.gathering import Gathering
from octolux.techniques.lpv.geometry import GeometryVolume
from octolux.techniques.lpv.injection import Injection, VplSource
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.windows import pack_windows

N, COUNT = 16, 3
VOLUME = Grid(BOX.origin, 2.0 / N, N)  # the box of test_lookup's G-buffer
WINDOWS = cascades.place_windows(N, COUNT, VOLUME, [c + 0.9 for c in BOX.origin], [0.6, 0.0, 0.8])
GRIDS = cascades.grids_of(WINDOWS, VOLUME)
LEVELS = Levels([N] * (COUNT - 1) + level_sizes(N), COUNT)


def uniforms(device):
    """Of grids and windows."""
    return device.uniform("grids", pack_grids(GRIDS)), device.uniform("windows", pack_windows(WINDOWS))


def random_vpls(count: int) -> np.ndarray:
    """VPLs in and a little beyond the volume, none within float32's rounding of a cell's face."""
    rng, vpls = np.random.default_rng(1), VPL.array(count)
    vpls["normal"] = pack_normals(random_directions(rng, count))
    fine = rng.integers(-8, 4 * N + 8, (count, 3)) + rng.uniform(0.01, 0.99, (count, 3))
    vpls["position"] = VOLUME.origin + VOLUME.cell_size / 4 * fine
    vpls["flux"], vpls["area"] = rng.uniform(0.1, 1, (count, 3)), 0.02 * VOLUME.cell_size**2
    return vpls


def safe(vpls: np.ndarray, shift: float) -> np.ndarray:
    """Those whose cells no rounding decides."""
    normals, kept = unpack_normals(vpls["normal"]), np.ones(len(vpls), bool)
    for grid in GRIDS:
        off = grid.to_cells(vpls["position"]) + shift * normals
        kept &= np.all(np.abs(off - np.rint(off)) > 1e-3, axis=-1)
    return vpls[kept]


@pytest.mark.parametrize("moments", [False, True])
def test_injection_into_every_grid(device, moments):
    """As the simulator's in each. Rounding: half a step each (test_injection.py); of moments too, whose places are
    right to 1e-5 cells."""
    vpls = safe(random_vpls(4000), 0.5)
    made = Injection(device, N, grids=COUNT, moments=moments)
    source = VplSource(0, len(vpls), vpls["flux"].sum(axis=0, dtype=np.float64))
    with one_stage(device) as stage:
        texture = record_texture(device, "vpls", VPL, len(vpls), vpls)
        made.run(stage, uniforms(device)[0], texture, [source])
    found = read_buffer(device, made.injected).reshape(COUNT, N, N, N, 3, 4)
    placed = read_buffer(device, made.moments).reshape(COUNT, N, N, N, 4) if moments else None
    step = 2.0**-30 * len(vpls) * vpls["flux"].sum(axis=0).max()
    position, flux = (vpls[name].astype(np.float64) for name in ("position", "flux"))
    for i, grid in enumerate(GRIDS):
        given = position, unpack_normals(vpls["normal"]), flux, grid
        expected = injection_reference.inject(*given)
        np.testing.assert_allclose(found[i], expected, rtol=1e-5, atol=step)
        assert np.count_nonzero(expected[..., 0, 0]) > 20
        if placed is not None:
            weight = expected[..., 0].sum(axis=-1)[..., None]
            difference = np.abs(placed[i][..., :3] - injection_reference.inject_moments(*given))
            # Three channels together, at up to 5/4 cells from the middle, in as many bits as one has.
            assert np.all(difference <= 1e-5 * weight + 3.75 * step) and not placed[i][..., 3].any()


def test_surfels_are_in_every_window_that_holds_them(device):
    """And the levels above are made of the last; as in test_octree_geometry.py. Planes are the means of shares of
    1/1000 at least, of which normals in float32 take 1e-6 of a wall, and rounding less."""
    vpls = safe(random_vpls(20000), -geometry.BEHIND)
    made = GeometryVolume(device, LEVELS, camera=False)
    frame = SimpleNamespace(
        vpls=record_texture(device, "vpls", VPL, len(vpls), vpls), vpl_surfaces=None, lights=SimpleNamespace(lamps=1),
        vpl_ranges=[(0, len(vpls))], vpl_widths=[64], lamp_layers=(),
    )  # fmt: skip
    with one_stage(device) as stage:
        made.run(stage, frame, uniforms(device)[0])
    buffers = (read_buffer(device, made.volume[name]) for name in strips.Planes._fields)
    made_levels = zip(*(LEVELS.split(b.reshape(-1, 4)[:, :3]) for b in buffers), strict=True)
    normals, positions = unpack_normals(vpls["normal"]), vpls["position"].astype(np.float64)
    own = [geometry.inject_planes(positions, normals, vpls["area"].astype(np.float64), grid) for grid in GRIDS]
    most = len(vpls) / N**3 * 50  # far more than any cell has
    levels = [*own[:-1], *geometry.plane_levels(own[-1])]
    for found_level, expected in zip(made_levels, levels, strict=True):
        for found, side in zip(found_level[:2], expected[:2], strict=True):
            np.testing.assert_allclose(found, side, rtol=1e-5, atol=most * 0.5 / 65536)
        filled = expected.shares > 1e-3
        for found, place in zip(found_level[2:], expected[2:], strict=True):
            np.testing.assert_allclose(found[filled], place[filled], atol=2e-3)
        assert filled.any()


def scattered_light(seed: int, count: int = COUNT) -> list[np.ndarray]:
    """Float32 [z][y][x][rgb][4] of each window: mixes of lobes in a twentieth of the cells."""
    rng, result = np.random.default_rng(seed), []
    for i in range(count):
        light = np.zeros((N, N, N, 3, 4))
        light[..., 0] = rng.uniform(0.1, 2, (N, N, N, 3)) * 4.0**i
        directions = random_directions(rng, N**3 * 3).reshape(N, N, N, 3, 3)
        light[..., 1:] = directions * (light[..., :1] * rng.uniform(0, 2 / np.sqrt(3), (N, N, N, 3, 1)))
        light *= rng.random((N, N, N, 1, 1)) < 0.05
        result.append(light.astype(np.float32))
    return result


def gathered(device, own: list[np.ndarray], windows, words=None) -> np.ndarray:
    """Irradiance on the faces of all cells, times the square of their size: [window][z][y][x][face][rgb]."""
    count = len(own)
    levels = Levels([N] * (count - 1) + level_sizes(N), count)
    made = Gathering(device, levels, occlusion=words is not None, lookup_offset=0.5, everywhere=True)
    injected = np.zeros((levels.cells, 3, 4), np.float32)
    injected[: count * N**3] = np.concatenate([light.reshape(-1, 3, 4) for light in own])
    peak, buffer = injected[:, :, 0].max(), device.uniform("windows", pack_windows(windows))
    with one_stage(device) as stage:
        made.forget(stage)
        made.update(stage, device.buffer("injected", injected), buffer)
        packed_strips = device.buffer("shares", words) if words is not None else None
        made.gather(stage, device.buffer("peak", np.array([peak], np.float32)), packed_strips, buffer)
    layout = {"bytes_per_row": N * 8, "rows_per_image": N * count}
    data = device.queue.read_texture({"texture": made.cube}, layout, (N, count * N, 6 * N))
    cube = np.frombuffer(data, np.float16).reshape(6, N, count, N, N, 4).astype(np.float64)[..., :3]
    return np.transpose(cube, (2, 1, 3, 4, 0, 5)) / storage_scale(peak)


@pytest.mark.parametrize("density", [None, 0.05, 0.5])
def test_every_window_gathers(device, density):
    """Cells of all windows, in their middle and at their rims, without and with surfaces between."""
    own, rng = scattered_light(2), np.random.default_rng(3)
    words, blockers = None, None
    if density is not None:
        planes = [random_planes(rng, density) for _ in range(COUNT)]
        words, blockers = packed([*planes, *geometry.plane_levels(planes[-1])[1:]])
    cube = gathered(device, own, WINDOWS, words)
    nodes, origins = cascades.window_nodes(own, WINDOWS), [w.origin for w in WINDOWS]
    for base, window in enumerate(WINDOWS):
        local = np.concatenate([[(0, 0, 0), (N - 1, 3, N - 1)], rng.integers(0, N, (15, 3))])
        options = {"base": base, "origins": origins, "ends": [w.ends for w in WINDOWS], "n": N}
        expected, free = (
            gathering.gather(local + window.origin, nodes, 1.0, b, **options) for b in (blockers, None)
        )  # fmt: skip
        found = cube[base, local[:, 2], local[:, 1], local[:, 0]]
        brightest = free.max(axis=1, keepdims=True)
        assert np.all(np.abs(found - expected) <= HALF_FLOAT * expected + (STORED + 2.0**-12) * brightest)
        assert expected.max() > 0 and (density is None or np.median(expected[free > 0] / free[free > 0]) < 0.99)


def test_many_windows_gather(device):
    """So many that a workgroup's threads list more than 32 nodes each."""
    count, rng = 8, np.random.default_rng(4)
    windows, own = cascades.place_windows(N, count, VOLUME, VOLUME.origin, [0.6, 0.0, 0.8]), scattered_light(5, count)
    nodes, origins = cascades.window_nodes(own, windows), [w.origin for w in windows]
    cube = gathered(device, own, windows)
    for base in (0, count - 1):
        local = rng.integers(0, N, (10, 3))
        expected = gathering.gather(local + origins[base], nodes, 1.0, base=base, origins=origins, n=N)
        found = cube[base, local[:, 2], local[:, 1], local[:, 0]]
        assert np.all(np.abs(found - expected) <= HALF_FLOAT * expected + STORED * expected.max(axis=1, keepdims=True))


def test_lookup_blends_windows(device):
    """Each window's cells hold a number of their own on all faces: what is read lies between them by the windows'
    weights."""
    made, g = Gathering(device, LEVELS, occlusion=False, lookup_offset=0.5, everywhere=True), gbuffer(device)
    placed = cascades.place_windows(N, COUNT, VOLUME, g.points[g.inside][44], [0.0, 0.0, 0.0])
    places_of = cascades.grids_of(placed, VOLUME)
    grids = device.uniform("grids", pack_grids(places_of))
    windows = device.uniform("windows", pack_windows(placed))
    usage = made.cube.usage
    values = np.ones((6 * N, COUNT, N, N, 4), np.float16)
    values[..., :3] = (np.array([1.0, 3.0, 7.0]) * [grid.cell_size**2 for grid in places_of])[None, :, None, None, None]
    made.cube = device.texture("cube", made.cube.size, "rgba16float", usage=usage | 2, dimension="3d")
    layout = {"bytes_per_row": N * 8, "rows_per_image": N * COUNT}
    device.queue.write_texture({"texture": made.cube}, values, layout, made.cube.size)
    irradiance = device.texture("irradiance", g.frame.pixels, "rgba32float", usage=usage)
    one = device.buffer("peak", np.array([8.0], np.float32))  # a scale of 1
    with one_stage(device) as stage:
        made.read(stage, g.frame, grids, one, irradiance, windows)
    read = device.read_texture(irradiance, np.float32, 4)[..., 0][g.inside]
    places = np.array([grid.to_cells(g.points[g.inside]) + 0.5 * g.geometric[g.inside] for grid in places_of])
    shares = cascades.weights(places, placed, N)
    # Cell sizes' squares are rounded to half floats, places to 1e-4 cells, over a transition of two cells, and what is
    # read changes by no more than the logarithm of 3 times itself.
    expected = cascades.blended(np.broadcast_to([[[1.0]], [[3.0]], [[7.0]]], (3, len(read), 3)), shares)[:, 0]
    np.testing.assert_allclose(np.log(expected), shares.T @ np.log([1.0, 3.0, 7.0]), atol=1e-12)
    bound = 7.0 * np.log(3.0) * 1e-4 / cascades.transition(N)
    np.testing.assert_allclose(read, expected, rtol=HALF_FLOAT + 1e-5, atol=bound)
    assert all(np.any((s > 0) & (s < 1)) for s in shares[:2])
