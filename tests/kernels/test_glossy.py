"""Glossy reflections on the device (techniques/lpv/glossy) against the simulator's."""

from __future__ import annotations

from functools import cache
from math import pi
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage
from test_cascades import VOLUME, N
from test_lookup import gbuffer, picture_texture

from octolux.frame.environment import SurroundingsMap
from octolux.simulator import brdf, sh
from octolux.simulator.camera import octahedral_decode, octahedral_encode, pack_normals, unpack_normals
from octolux.simulator.environment import brdf_table
from octolux.simulator.lpv import cascades, glossy
from octolux.simulator.lpv.glossy import Surfaces
from octolux.simulator.lpv.octree import level_sizes
from octolux.simulator.lpv.strips import Planes, pack_planes
from octolux.simulator.reflection import reflected_direction
from octolux.techniques.lpv.constants import pack_grids, storage_scale
from octolux.techniques.lpv.glossy.glossy import Glossy, PaperGlossy
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.lookup import Lookup
from octolux.techniques.lpv.windows import pack_windows

COUNT = 2
WINDOWS = cascades.place_windows(N, COUNT, VOLUME, [0.1, -0.2, 0.1], [0.0, 0.0, 0.0])
GRIDS = cascades.grids_of(WINDOWS, VOLUME)
LEVELS = Levels([N] * (COUNT - 1) + level_sizes(N), COUNT)
SIZES = [size for size in LEVELS.sizes if size >= 4]  # of the levels that rays go through
CELL = GRIDS[0].cell_size
HALF_FLOAT = 2.0**-10  # relative: 2^-11 rounded, twice that where an adapter truncates
WEIGHT = 3.0 / 512  # texture units may round each of a sample's three weights to 1/256
BYTE = 1.0 / 255


@cache
def seen(device) -> SimpleNamespace:
    """test_lookup's G-buffer with materials of all kinds, shading normals near the geometric ones; as float64."""
    base, rng = gbuffer(device), np.random.default_rng(5)
    shape = base.normals.shape[:2]
    to_eye = np.array([0.3, -0.2, 2.5]) - base.points
    to_eye /= np.maximum(np.linalg.norm(to_eye, axis=-1, keepdims=True), 1e-9)  # empty pixels have no depth
    facing = np.where(np.sum(to_eye * base.geometric, axis=-1, keepdims=True) < 0.0, -1.0, 1.0) * base.geometric
    shading = facing + 0.2 * rng.normal(size=(*shape, 3))
    codes = np.rint((octahedral_encode(facing) * 0.5 + 0.5) * 4095).astype(np.uint32)
    specular, roughness, metallic = (rng.integers(low, 256, shape).astype(np.uint32) for low in (128, 0, 0))
    colors = rng.integers(0, 65536, (*shape, 3)).astype(np.uint32)
    surface = np.zeros((*shape, 4), np.uint32)
    surface[..., 0] = pack_normals(shading / np.linalg.norm(shading, axis=-1, keepdims=True))
    surface[..., 1] = codes[..., 0] | codes[..., 1] << 12 | specular << 24
    surface[..., 2] = colors[..., 0] | colors[..., 1] << 16
    surface[..., 3] = colors[..., 2] | roughness << 16 | metallic << 24
    targets = SimpleNamespace(surface=picture_texture(device, surface, "rgba32uint"), depth=base.frame.targets.depth)
    frame = SimpleNamespace(
        pixels=base.frame.pixels, buffers=base.frame.buffers, targets=targets, sample=0,
        surroundings_map=SurroundingsMap(device),
    )  # fmt: skip
    material = brdf.surface(colors / 65535.0, metallic / 255.0, roughness / 255.0, specular / 255.0)
    return SimpleNamespace(
        frame=frame, points=base.points, inside=base.inside, to_eye=to_eye, normals=unpack_normals(surface[..., 0]),
        geometric=octahedral_decode(codes / 4095 * 2 - 1), material=material,
    )  # fmt: skip


def lobe_albedo(s: SimpleNamespace) -> np.ndarray:
    """From the table, between its nodes (shaders/tables.wgsl)."""
    table = brdf_table().astype(np.float64)
    n_v = np.maximum(0.0, np.sum(s.normals * s.to_eye, axis=-1))
    rough = np.maximum(s.material.roughness, brdf.MIN_ROUGHNESS)
    at = np.clip(np.stack([rough, n_v], axis=-1) * len(table) - 0.5, 0.0, len(table) - 1)
    low = np.minimum(at.astype(int), len(table) - 2)
    part, even = at - low, np.zeros((*n_v.shape, 3))
    for i, j in np.ndindex(2, 2):
        weight = np.where(i, part[..., 0], 1 - part[..., 0]) * np.where(j, part[..., 1], 1 - part[..., 1])
        even += weight[..., None] * table[low[..., 0] + i, low[..., 1] + j]
    _, f0, f90 = brdf.reflectances(s.material)
    return f0 * even[..., :1] + f90 * even[..., 1:2]


def smooth(rng: np.random.Generator, n: int, values: int, size: float) -> np.ndarray:
    """[z][y][x][values] from 0 to 1 that vary slowly, in cells of `size` of the finest."""
    z, y, x = size * np.indices((n, n, n))
    places = np.stack([x, y, z], axis=-1)
    return 0.5 + 0.5 * np.sin(places @ rng.uniform(0.02, 0.06, (3, values)) + rng.uniform(0, 6, values))


@cache
def scene() -> SimpleNamespace:
    """Light and surfaces in all cells, which vary slowly: areas such that rays end after some steps, and covers that
    bytes hold; every twentieth cell has planes. As the device holds them, and as the simulator does."""
    rng, levels, light, words, squares = np.random.default_rng(7), [], [], [], []
    for i, n in enumerate(LEVELS.sizes):
        size, whole = 2.0**i, i >= COUNT - 1
        if i < COUNT:
            # The same towards both ends of an axis; the last window's are the same everywhere, so that bytes also hold
            # what coarser cells have.
            cover = np.rint(8.0 + 8.0 * smooth(rng, n, 3, 0.0 if whole else size)).repeat(2, axis=-1) * BYTE
            squares.append(cover**2 / np.linalg.norm(cover, axis=-1, keepdims=True))
        else:
            squares.append(glossy.coarser_squares(squares[COUNT - 1], i - COUNT + 1))
        flux = (1.0 + smooth(rng, n, 3, size)) * squares[-1].sum(axis=-1, keepdims=True) * pi * (CELL * size) ** 2
        light.append(np.zeros((n, n, n, 3, 4), np.float32))
        light[-1][..., 0] = flux * sh.Y0
        share, plane = rng.integers(0, 33, (n, n, n, 3)), rng.integers(0, 32, (n, n, n, 3))
        share *= rng.random((n, n, n, 1)) < 0.05
        planes = Planes.sheets(share / 32.0, (plane + 0.5) / 32.0)
        words.append(pack_planes(planes).reshape(-1, 4))
        window = WINDOWS[min(i, COUNT - 1)]
        if n in SIZES:
            levels.append(Surfaces(
                *glossy.surface_light(light[-1], squares[-1], CELL * size), planes.shares, planes.offsets,
                (0, 0, 0) if whole else window.origin, np.zeros(3) if whole else np.array(window.low),
                np.full(3, float(n)) if whole else np.array(window.high),
            ))  # fmt: skip
    reflectors = np.zeros((LEVELS.cells, 3, 4), np.float32)
    flat = np.concatenate([each.reshape(-1, 6) for each in squares[:COUNT]])
    reflectors[: len(flat), 0], reflectors[: len(flat), 1, :2] = flat[:, :4], flat[:, 4:]
    injected = np.concatenate([each.reshape(-1, 3, 4) for each in light])
    return SimpleNamespace(levels=levels, injected=injected, reflectors=reflectors, words=np.concatenate(words))


def run(device, made: Glossy, what: SimpleNamespace) -> np.ndarray:
    """What the device writes for the G-buffer's pixels: float64 (height, width, 3)."""
    frame, (grids, windows) = seen(device).frame, places(device)
    injected = device.buffer("injected", what.injected)
    peak = device.buffer("peak", np.array([what.injected[..., 0].max()], np.float32))
    reflectors, words = device.buffer("reflectors", what.reflectors), device.buffer("packed", what.words)
    made.prepare(frame)
    with one_stage(device) as stage:
        made.update(stage, injected, peak, reflectors, windows)
        made.run(stage, frame, grids, peak, words, windows)
    return read(device, made)


def places(device) -> tuple:
    """Uniform buffers of grids and windows."""
    return device.uniform("grids", pack_grids(GRIDS)), device.uniform("windows", pack_windows(WINDOWS))


def read(device, made) -> np.ndarray:
    return device.read_texture(made.specular, np.float32, 4)[..., :3].astype(np.float64)


def starts(s: SimpleNamespace) -> tuple[np.ndarray, np.ndarray]:
    """Of the pixels inside: windows that rays begin in (M,), and where (M, 3), in cells of level 0."""
    places = np.array([g.to_cells(s.points[s.inside]) + 0.5 * s.geometric[s.inside] for g in GRIDS])
    base = (cascades.weights(places, WINDOWS, N) > 0.0).argmax(axis=0)
    at = GRIDS[0].to_cells(s.points[s.inside]) + np.array(WINDOWS[0].origin)
    return base, at + 0.5 * 2.0 ** base[:, None] * s.geometric[s.inside]


MOST = 2.0  # the largest radiance of `scene`


@pytest.mark.parametrize("step", [1.0, 0.5])
def test_reflections(device, step):
    """Of pixels whose rays no rounding decides. A ray brings shares of radiances that add up to 1 at most: these are
    means by areas, of half floats, read by weights that texture units round; and each step's cover errs by such weights
    times the difference of neighbours, up to 8 of 255 along three axes, which moves as much of the ray to another
    radiance. Neighbours' radiances differ by a quarter at most, their areas by as much as twice."""
    s, what = seen(device), scene()
    found, at = run(device, Glossy(device, LEVELS, step=step), what)[s.inside], s.inside
    (base, start), roughness = starts(s), s.material.roughness[at]
    towards = reflected_direction(s.to_eye[at], s.normals[at], s.geometric[at], roughness)
    shifts = np.concatenate([np.zeros((1, 3)), 1e-4 * np.random.default_rng(1).normal(size=(3, 3))])
    results = [glossy.march(what.levels, start + shift, towards, roughness, base, step=step) for shift in shifts]
    expected, albedo = results[0], lobe_albedo(s)[at]
    apart = np.max([np.abs(r.radiance - expected.radiance).max(axis=-1) for r in results[1:]], axis=0)
    of_radiance = 2.0 * (HALF_FLOAT + 0.25 * WEIGHT) * MOST
    allowed = of_radiance + expected.steps * step * 3.0 * WEIGHT * 8.0 * BYTE * MOST
    error = np.abs(found - albedo * expected.radiance).max(axis=-1) / albedo.max(axis=-1)
    steady = apart < 0.2 * allowed
    assert steady.mean() > 0.8
    assert np.all(error[steady] <= allowed[steady]), (error / allowed)[steady].max()
    assert expected.steps.max() > 8 and expected.radiance.max() > 1.0


def filled(radiance: float) -> SimpleNamespace:
    """Every cell full of surfaces of that radiance, six walls each: a step covers all of a ray. Nothing blocks."""
    per_cell = radiance * pi * sh.Y0 * 6.0 * (CELL * 2.0 ** np.arange(len(LEVELS.sizes))) ** 2
    injected = np.zeros((LEVELS.cells, 3, 4), np.float32)
    injected[..., 0] = np.repeat(per_cell, [n**3 for n in LEVELS.sizes])[:, None]
    reflectors = np.ones((LEVELS.cells, 3, 4), np.float32)
    return SimpleNamespace(injected=injected, reflectors=reflectors, words=np.zeros((LEVELS.cells, 4), np.uint32))


@pytest.mark.parametrize("resolution", [1, 2, 4])
def test_even_light_at_every_resolution(device, resolution):
    """A surface among surfaces of radiance L reflects L times its lobe's albedo, and upsampled light is a mean of such.
    Only rays that begin at the volume's end leave it before their first step is over. Where nothing is seen, and
    beyond the volume, it is black."""
    s = seen(device)
    found = run(device, Glossy(device, LEVELS, resolution=resolution), filled(3.0))
    share = (found / lobe_albedo(s))[s.inside]
    assert share.max() <= 3.0 * (1.0 + 2.0 * HALF_FLOAT)
    whole = np.all(np.abs(s.points) < 1.0 - 2.0 * VOLUME.cell_size, axis=-1)[s.inside] if resolution == 1 else ...
    assert np.median(share[whole]) >= 3.0 * (1.0 - 2.0 * HALF_FLOAT)
    if resolution == 1:
        assert share[whole].min() >= 3.0 * (1.0 - 2.0 * HALF_FLOAT) and not found[~s.inside].any()


def test_light_without_areas(device):
    """Counts as a wall's that faces along it."""
    rng = np.random.default_rng(11)
    light = np.zeros((LEVELS.cells, 3, 4), np.float32)
    directions = rng.normal(size=(LEVELS.cells, 1, 3))
    light[..., :] = rng.uniform(0.5, 1.0, (LEVELS.cells, 3, 1)) * sh.cosine_lobe(
        directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    )
    what = SimpleNamespace(injected=light, reflectors=np.zeros_like(scene().reflectors), words=scene().words)
    made = Glossy(device, LEVELS)
    run(device, made, what)
    cells = volume(device, made, "radiance", np.float16)
    facing = volume(device, made, "facing", np.uint8) / 255.0
    scale = storage_scale(light[..., 0].max())
    for i, own in enumerate(LEVELS.split(light)[: len(SIZES)]):
        n = own.shape[0]
        radiance, areas, covers = glossy.surface_light(own, np.zeros((n, n, n, 6)), 2.0**i)
        for octant in range(8):
            seen_ends = [2 * axis + (octant >> axis & 1) for axis in range(3)]
            area = areas[..., seen_ends].sum(axis=-1)
            slot, aside = min(i, COUNT), N - 2 * n if i >= COUNT else 0
            found = cells[octant, :n, slot, :n, aside : aside + n]
            np.testing.assert_allclose(found[..., 3], area, rtol=HALF_FLOAT, atol=1e-5)
            np.testing.assert_allclose(found[..., :3], scale * area[..., None] * radiance, rtol=HALF_FLOAT, atol=1e-4)
            found = facing[octant, :n, slot, :n, aside : aside + n, :3]
            np.testing.assert_allclose(found, covers[..., seen_ends], atol=0.5 * BYTE + 1e-5)


def volume(device, made: Glossy, name: str, kind: type) -> np.ndarray:
    """float64 [octant][z][slot][y][x][4]: windows, and behind them the coarser levels beside one another."""
    texture = made.volumes[name]
    layout = {"bytes_per_row": N * 4 * np.dtype(kind).itemsize, "rows_per_image": N * (COUNT + 1)}
    data = device.queue.read_texture({"texture": texture}, layout, texture.size)
    return np.frombuffer(data, kind).reshape(8, N, COUNT + 1, N, N, 4).astype(np.float64)


@pytest.mark.parametrize("cells", [1, 4])
def test_the_papers_mean(device, cells):
    """Light that varies slowly, from all sides and none more than another: trilinear weights of texture units."""
    s, what = seen(device), scene()
    own = what.injected[: COUNT * N**3]
    scaled = own * storage_scale(own[..., 0].max())
    lookup = Lookup(device, N, reading="paper", damping=False, lookup_offset=0.5, windows=COUNT)
    made = PaperGlossy(device, LEVELS, lookup_offset=0.5, cells=cells)
    made.prepare(s.frame)
    with one_stage(device) as stage:
        lookup.write_volumes(stage, device.buffer("light", scaled.astype(np.float32)))
        peak = device.buffer("peak", np.array([own[..., 0].max()], np.float32))
        grids, windows = places(device)
        made.run(stage, s.frame, grids, peak, lookup.volumes, windows)
    found = read(device, made)[s.inside] / lobe_albedo(s)[s.inside]
    base, start = starts(s)
    at = s.inside
    towards = reflected_direction(s.to_eye[at], s.normals[at], s.geometric[at], s.material.roughness[at])
    light = LEVELS.split(what.injected)
    for i, window in enumerate(WINDOWS):
        r = base == i
        size = CELL * window.size
        expected = glossy.paper_light(light[i], start[r] / window.size - window.origin, towards[r], cells, size)
        np.testing.assert_allclose(found[r], expected, rtol=HALF_FLOAT + WEIGHT + 1e-4)
        assert r.sum() > 10
