"""Gathering on the device (moments, nodes, gather, mark, cube_lookup .wgsl) against the simulator's."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions
from test_lookup import GRID as LOOKUP_GRID
from test_lookup import WEIGHT_ERROR, gbuffer

from octolux.gpu.records import read_records
from octolux.simulator import sh
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import gathering as reference
from octolux.simulator.lpv import geometry, strips
from octolux.simulator.lpv.octree import build_levels, level_sizes
from octolux.techniques.lpv.constants import pack_grid, storage_scale
from octolux.techniques.lpv.gathering.gathering import NODE, Gathering
from octolux.techniques.lpv.levels import Levels

N = 16
GRID = Grid(LOOKUP_GRID.origin, 0.125, N)  # the same box as that of the G-buffer made in test_lookup.py
LEVELS = Levels(level_sizes(N))
HALF_FLOAT = 2.0**-10  # relative: 2^-11 rounded, twice that where an adapter truncates
# Of what a cell's brightest face receives from some hundred nodes in float32: places, lobes and ways of some ten
# roundings each, of up to 16 cells; and a sum of as many terms. Half floats stop at 6e-8 of numbers of about 10.
ARITHMETIC = 1e-4
# Lobes are half floats of the node's weight, of which each channel here has a twentieth at least; no node errs by more.
STORED = ARITHMETIC + HALF_FLOAT


@cache
def kernel(device, occlusion: bool, everywhere: bool, offset: float = 0.5) -> Gathering:
    return Gathering(device, LEVELS, occlusion=occlusion, lookup_offset=offset, everywhere=everywhere)


def scattered_light(seed: int, lit: float = 0.1) -> np.ndarray:
    """Float32 [z][y][x][rgb][4]: mixes of lobes in a share `lit` of the cells, of many strengths."""
    rng = np.random.default_rng(seed)
    light = np.zeros((N, N, N, 3, 4))
    light[..., 0] = rng.uniform(0.1, 2, (N, N, N, 3))
    directions = random_directions(rng, N**3 * 3).reshape(N, N, N, 3, 3)
    light[..., 1:] = directions * (light[..., :1] * rng.uniform(0, 2 / np.sqrt(3), (N, N, N, 3, 1)))
    return (light * (rng.random((N, N, N, 1, 1)) < lit)).astype(np.float32)


def packed(levels: list[strips.Planes]) -> tuple[np.ndarray, list[strips.Strips]]:
    """The words that the device holds, and what these say."""
    words = [strips.pack_planes(level) for level in levels]
    return np.concatenate([w.reshape(-1, 4) for w in words]), [strips.unpack_planes(w) for w in words]


def random_planes(rng: np.random.Generator, density: float, most: float = 1.0) -> strips.Planes:
    """Shares up to `most`, in a share `density` of the cells, anywhere in them."""
    shares = rng.uniform(0.0, most, (N, N, N, 3)) * (rng.random((N, N, N, 1)) < density)
    return strips.Planes.sheets(shares, *rng.random((3, N, N, N, 3)))


def run(device, made: Gathering, light: np.ndarray, words=None) -> tuple[np.ndarray, np.ndarray]:
    """The cube's irradiance (W/m^2) and weight [z][y][x][face][rgb, weight], and what test_lookup's G-buffer reads."""
    injected = np.concatenate([level.reshape(-1, 3, 4) for level in build_levels(light)]).astype(np.float32)
    peak = light[..., 0].max()
    buffers = device.buffer("injected", injected), device.buffer("peak", np.array([peak], np.float32))
    blockers = device.buffer("shares", words) if words is not None else None
    frame, grid = gbuffer(device).frame, device.uniform("grid", pack_grid(GRID))
    width, height = frame.pixels
    irradiance = device.texture("irradiance", (width, height), "rgba32float", usage=made.cube.usage)
    with one_stage(device) as stage:
        made.forget(stage)
        made.update(stage, buffers[0])
        made.mark(stage, frame, grid)
        made.gather(stage, buffers[1], blockers)
        made.read(stage, frame, grid, buffers[1], irradiance)
    layout = {"bytes_per_row": N * 8, "rows_per_image": N}
    data = device.queue.read_texture({"texture": made.cube}, layout, (N, N, 6 * N))
    cube = np.frombuffer(data, np.float16).reshape(6, N, N, N, 4).astype(np.float64)
    read = device.read_texture(irradiance, np.float32, 4)[..., :3].astype(np.float64)
    cells = np.moveaxis(cube, 0, 3)
    return np.concatenate([cells[..., :3] / storage_scale(peak) / GRID.cell_size**2, cells[..., 3:]], axis=-1), read


def some_cells(count: int) -> np.ndarray:
    rng = np.random.default_rng(9)
    corners = np.array([(0, 0, 0), (N - 1, N - 1, N - 1), (0, N - 1, 7)])
    return np.concatenate([corners, rng.integers(0, N, (count, 3))])


def at(cube: np.ndarray, cells: np.ndarray) -> np.ndarray:
    return cube[cells[..., 2], cells[..., 1], cells[..., 0]]


def test_nodes(device):
    """Places and dominant lobes of all levels; those of float32 sums of some hundred cells."""
    light, made = scattered_light(1), kernel(device, False, True)
    run(device, made, light)
    words = read_records(device, made.nodes, NODE, LEVELS.cells).view(np.uint32).reshape(-1, 12)
    about = words[:, :4].copy().view(np.float32)
    lobes = words[:, 4:10].copy().view(np.float16).reshape(-1, 3, 4) * about[:, 3, None, None].astype(np.float64)
    count = 0
    for nodes in reference.light_nodes(light):
        n = N >> nodes.level
        number = LEVELS.first(nodes.level) + nodes.cell @ [1, n, n * n]
        np.testing.assert_allclose(about[number, :3], nodes.place, rtol=ARITHMETIC)
        directed = (nodes.flux * nodes.fraction)[..., None] / np.pi * nodes.direction
        rest = nodes.flux * (1 - nodes.fraction) / (4 * np.pi)
        assert np.all(np.abs(lobes[number, :, :3] - directed) <= STORED * nodes.flux[..., None])
        assert np.all(np.abs(lobes[number, :, 3] - rest) <= STORED * nodes.flux)
        count += len(number)
    assert np.count_nonzero(about[:, 3]) == count


@pytest.mark.parametrize("lit", [0.003, 0.1, 1.0])
def test_every_cell_gathers(device, lit):
    light = scattered_light(2, lit)
    cube, _ = run(device, kernel(device, False, True), light)
    cells = some_cells(20)
    expected = reference.gather(cells, reference.light_nodes(light), GRID.cell_size)
    off = np.abs(at(cube, cells)[..., :3] - expected)
    assert np.all(off <= HALF_FLOAT * expected + STORED * expected.max(axis=1, keepdims=True))
    assert (cube[..., 3] == 1.0).all() and expected.max() > 0


@pytest.mark.parametrize("density", [0.02, 0.3, 1.0])
def test_surfaces_between_block(device, density):
    """Both read the same words, so that only arithmetic is left, and a way that is opaque is stopped at 2^-12. Random
    volumes tell at once where a way passes through another cell, or crosses another plane, than the simulator's."""
    words, blockers = packed(geometry.plane_levels(random_planes(np.random.default_rng(3), density)))
    light, cells = scattered_light(4), some_cells(20)
    cube, _ = run(device, kernel(device, True, True), light, words)
    nodes = reference.light_nodes(light)
    expected = reference.gather(cells, nodes, GRID.cell_size, blockers)
    free = reference.gather(cells, nodes, GRID.cell_size)
    difference, brightest = np.abs(at(cube, cells)[..., :3] - expected), free.max(axis=1, keepdims=True)
    assert np.all(difference <= HALF_FLOAT * expected + (STORED + 2.0**-12) * brightest)
    assert np.median(expected[free > 0] / free[free > 0]) < 0.97


def test_packing_hardly_matters():
    """A share errs by 1/62 at most, either way: of m planes crossed that is a standard deviation of sqrt(m / 3) / 62 of
    what passes; a place errs by 1/64 of a cell, so that of m steps through cells of shares of s = 0.15 on average some
    m / 32 meet a plane or not, which is sqrt(m / 32) s more. Ways meet up to three planes a cell, in a dozen cells:
    0.056 and 0.16 of a way's light, and less of the mean of the hundreds of ways that a face's light comes by."""
    levels = geometry.plane_levels(random_planes(np.random.default_rng(5), 1.0, 0.3))
    nodes, cells = reference.light_nodes(scattered_light(6)), some_cells(5)
    exact, rounded = (reference.gather(cells, nodes, GRID.cell_size, g) for g in (levels, packed(levels)[1]))
    free = reference.gather(cells, nodes, GRID.cell_size)
    assert np.all(np.abs(exact - rounded) <= (0.056 + 0.16) * free) and not np.array_equal(exact, rounded)


@pytest.mark.parametrize("offset", [0.0, 0.5])
def test_cells_that_are_looked_up_are_filled(device, offset):
    """Those in which a seen surface's place lies, no others; places within 1e-4 cells of a face may be in either."""
    made, g = kernel(device, False, False, offset), gbuffer(device)
    cube, _ = run(device, made, scattered_light(7))
    place = GRID.to_cells(g.points)[g.inside] + offset * g.geometric[g.inside]
    filled = set(map(tuple, np.argwhere(cube[..., 0, 3] == 1.0)[:, ::-1].tolist()))
    surely = {tuple(np.clip(np.floor(p), 0, N - 1).astype(int).tolist())
              for p in place if np.abs(p - np.rint(p)).min() > 1e-4}  # fmt: skip
    perhaps = {tuple(np.clip(np.floor(p + e), 0, N - 1).astype(int).tolist()) for p in place for e in (-1e-4, 1e-4)}
    assert surely <= filled <= perhaps | surely
    assert 50 < len(filled) < N**3 / 2
    assert not cube[cube[..., 3] == 0.0].any()
    whole, _ = run(device, kernel(device, False, True, offset), scattered_light(7))
    assert np.array_equal(whole[cube[..., 0, 3] == 1.0], cube[cube[..., 0, 3] == 1.0])


@pytest.mark.parametrize("everywhere", [True, False])
def test_lookup(device, everywhere):
    """From the cells as they are stored: faces by the squares of the normal, filtered among the cells that are filled.

    A texture unit's weights are off by WEIGHT_ERROR at most, in the sum of light and in that of weights by which it is
    divided alike, so that a cell counts with its difference from the mean.
    """
    g, offset = gbuffer(device), 0.5
    cube, found = run(device, kernel(device, False, everywhere, offset), scattered_light(8, 1.0))
    place = np.clip(GRID.to_cells(g.points) + offset * g.geometric - 0.5, 0.0, N - 1.0)
    low = np.clip(np.floor(place).astype(int), 0, N - 2)
    corners = list(np.ndindex(2, 2, 2))
    weights = [np.prod(np.where(np.array(c, bool), place - low, 1 - (place - low)), axis=-1) for c in corners]
    cells = np.stack([at(cube, low + c) for c in corners])
    share = np.stack(weights)[..., None] * cells[..., 0, 3:]
    total = share.sum(axis=0)
    filtered = (share[..., None, :] * cells[..., :3]).sum(axis=0) / np.maximum(total, 1e-9)[..., None, :]
    expected = reference.read_cube(filtered, g.normals)
    sure = g.inside & (total[..., 0] > 0.1)
    apart = (cells[..., 3:] * np.abs(cells[..., :3] - filtered)).sum(axis=0).max(axis=-2)
    bound = WEIGHT_ERROR * apart / np.maximum(total, 1e-9) + 1e-4 * expected
    assert np.all(np.abs(found - expected)[sure] <= bound[sure])
    assert sure.sum() > 0.9 * g.inside.sum() and not found[~g.inside].any()
    assert np.median(bound[sure] / expected[sure]) < 0.1, "the bound says nothing"


def test_dark_in_dark_out(device):
    made = kernel(device, False, True)
    run(device, made, scattered_light(1))
    cube, read = run(device, made, np.zeros((N, N, N, 3, 4), np.float32))
    assert not cube[..., :3].any() and not read.any()


def test_one_beam(device):
    """A cosine lobe of flux F straight ahead at r cells: F / pi / (r^2 + s^2 / 3), in closed form; s is 2 at most, as
    nodes of the coarsest level that is read are."""
    light = np.zeros((N, N, N, 3, 4), np.float32)
    light[4, 8, 8] = sh.cosine_lobe([0.0, 0.0, 1.0]) / np.pi
    cube, _ = run(device, kernel(device, False, True), light)
    for z, size in ((5, 1), (6, 1), (7, 1), (8, 2), (11, 2), (12, 2), (15, 2)):
        expected = 1.0 / np.pi / ((z - 3.5) ** 2 + size**2 / 3) / GRID.cell_size**2
        np.testing.assert_allclose(cube[z, 8, 8, 5, :3], expected, rtol=HALF_FLOAT + STORED)
        assert cube[z, 8, 8, :5, :3].max() <= 1e-6 * expected
