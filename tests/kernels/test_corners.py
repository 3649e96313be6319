"""Lookup in the cells around a place as far as planes let through (corners.wgsl), in nested windows, against the
simulator's. The G-buffer is test_lookup's; the windows are test_cascades'."""

from __future__ import annotations

from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer
from test_cascades import COUNT, LEVELS, VOLUME, N
from test_lookup import gbuffer

from octolux.simulator.blending import moved_share
from octolux.simulator.lpv import cascades, corners, gathering, strips
from octolux.techniques.lpv.constants import pack_grids
from octolux.techniques.lpv.gathering.gathering import Gathering
from octolux.techniques.lpv.windows import pack_windows

PLACE = 1e-4  # cells by which a place may be off
WEIGHT = 3.0 * PLACE  # a corner's weight then is: that of each axis, times two that are at most 1
PASSED = WEIGHT * 0.5 / corners.UNSURE  # and what passes its planes is, if they lie next to the place


@cache
def made(device, occlusion: bool) -> Gathering:
    return Gathering(device, LEVELS, occlusion=occlusion, lookup_offset=0.5, corners=True)


@cache
def seen(device) -> SimpleNamespace:
    """Pixels of the G-buffer that are inside, and windows around one of them: places in each, and shares of each."""
    g = gbuffer(device)
    points, shift = g.points[g.inside], 0.5 * g.geometric[g.inside]
    windows = cascades.place_windows(N, COUNT, VOLUME, points[44], [0.0, 0.0, 0.0])
    grids = cascades.grids_of(windows, VOLUME)
    places = np.array([grid.to_cells(points) + shift for grid in grids])
    return SimpleNamespace(
        g=g, places=places, shares=cascades.weights(places, windows, N), normals=g.normals[g.inside],
        sizes=[grid.cell_size for grid in grids], grids=device.uniform("grids", pack_grids(grids)),
        windows=device.uniform("windows", pack_windows(windows)),
    )  # fmt: skip


@cache
def walled() -> SimpleNamespace:
    """Planes of all windows, of which a third are closed and a third are not there; and the words that say so."""
    rng = np.random.default_rng(1)
    shares = np.clip(rng.uniform(-1.0, 2.0, (COUNT, N, N, N, 3)), 0.0, 1.0)
    words = [strips.pack_planes(strips.Planes.sheets(s, *rng.random((3, N, N, N, 3)))) for s in shares]
    packed = np.zeros((LEVELS.cells, 4), np.uint32)
    packed[: COUNT * N**3] = np.concatenate([w.reshape(-1, 4) for w in words])
    return SimpleNamespace(planes=[strips.unpack_planes(w) for w in words], packed=packed)


def sure(place: np.ndarray, planes: strips.Blockers | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Of places (M, 3): where rounding them decides nothing (M,), neither which cells are around nor whether any corner
    is left; what the weights' sum is (M,), before it is made 1; and how far each of them may be off (M,)."""
    first, weights = corners.corner_weights(place)
    steady = np.abs(place - 0.5 - np.rint(place - 0.5)).min(axis=-1) > PLACE
    if planes is None:
        return steady, np.ones(len(place)), np.full(len(place), WEIGHT)
    x, y, z = np.moveaxis(corners.corner_cells(first, N), -1, 0)
    at, shares, offsets = place - first, planes.shares[z, y, x], planes.offsets[z, y, x]
    near = np.abs(at[:, None] - corners.CORNERS - offsets) < corners.UNSURE + 2.0 * PLACE
    off = WEIGHT + PASSED * np.any(near & (shares > 0.0), axis=(1, 2))
    whole = (weights * corners._passed(at, shares, offsets)).sum(axis=-1)
    return steady & ((whole == 0.0) | (whole > corners.LEAST + 8.0 * off)), whole, off


def written(device, gathering: Gathering, cube: np.ndarray) -> None:
    """cube: float16 [window][z][y][x][face][rgb, weight]."""
    texture = device.texture("cube", gathering.cube.size, "rgba16float", usage=gathering.cube.usage | 2, dimension="3d")
    layout = {"bytes_per_row": N * 8, "rows_per_image": N * COUNT}
    texels = np.ascontiguousarray(np.transpose(cube, (4, 1, 0, 2, 3, 5)))  # [face][z][window][y][x]
    device.queue.write_texture({"texture": texture}, texels, layout, texture.size)
    gathering.cube = texture


def read_in(s: SimpleNamespace, number: int, cells, planes) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What a window has at the pixels (M, 3), how far the device may be off, and where (M,) rounding decides nothing.
    A corner differs from the mean of all by 1.5 at most, and counts with that as its weight is off."""
    place = s.places[number]
    read = gathering.read_cube(corners.read_corners(cells, place, planes), s.normals) / s.sizes[number] ** 2
    steady, whole, off = sure(place, planes)
    of_all = np.where(whole > corners.LEAST, whole, 1.0)[:, None]
    bound = 8.0 * off[:, None] * 1.5 / of_all / s.sizes[number] ** 2 + 1e-5 * read
    return read, bound, steady | (s.shares[number] == 0.0)


def blended(s: SimpleNamespace, found) -> tuple[np.ndarray, np.ndarray]:
    """All windows together, and how far the device may be off: as each of the two that are read is, by their parts, and
    as the parts are, which grow with the share, and shrink as the finer one has more."""
    values, bounds = (np.array([each[k] for each in found]) for k in range(2))
    each, first = np.arange(values.shape[1]), (s.shares > 0.0).argmax(axis=0)
    pair = first, np.minimum(first + 1, COUNT - 1)
    (fine, coarse), (off, next_off) = ([a[i, each] for i in pair] for a in (values, bounds))
    share, error = s.shares[first, each], 2.0 * PLACE / cascades.transition(N)

    def part(sign: int) -> np.ndarray:
        moved = np.where(share == 1.0, share, np.clip(share + sign * error, 0.0, 1.0))
        sums = (np.maximum(a, 0.0).sum(axis=-1) for a in (fine - sign * off, coarse + sign * next_off))
        return moved_share(*sums, moved)[:, None]

    low, high = part(-1), part(1)
    bound = high * off + (1.0 - low) * next_off + np.abs(fine - coarse) * (high - low)
    return cascades.blended(values, s.shares), bound


@pytest.mark.parametrize("occlusion", [False, True])
def test_lookup(device, occlusion):
    """What the corners hold, by their weights, and by those of the windows."""
    s, w, here = seen(device), walled(), made(device, occlusion)
    cube = np.ones((COUNT, N, N, N, 6, 4), np.float16)
    cube[..., :3] = np.random.default_rng(2).uniform(0.5, 2.0, (COUNT, N, N, N, 6, 3))
    written(device, here, cube)
    irradiance = device.texture("irradiance", s.g.frame.pixels, "rgba32float", usage=here.cube.usage)
    one, packed = device.buffer("peak", np.array([8.0], np.float32)), device.buffer("packed", w.packed)
    with one_stage(device) as stage:
        here.read(stage, s.g.frame, s.grids, one, irradiance, s.windows, packed_strips=packed if occlusion else None)
    picture = device.read_texture(irradiance, np.float32, 4)[..., :3].astype(np.float64)
    cells = cube[..., :3].astype(np.float64)
    found = [read_in(s, i, cells[i], w.planes[i] if occlusion else None) for i in range(COUNT)]
    expected, bound = blended(s, found)
    steady = np.all([each[2] for each in found], axis=0)
    assert np.all(np.abs(picture[s.g.inside] - expected)[steady] <= bound[steady]) and not picture[~s.g.inside].any()
    assert steady.mean() > 0.8 and np.median(bound[steady] / expected[steady]) < 0.02
    free = blended(s, [read_in(s, i, cells[i], None) for i in range(COUNT)])[0]
    assert occlusion == (np.median(np.abs(expected - free) / free) > 0.02)


@pytest.mark.parametrize("occlusion", [False, True])
def test_what_is_asked_for(device, occlusion):
    """The corners that count, in the finest window that is read and, where it gives way, in the next; no others. A
    pixel for which rounding decides may ask for any of its corners."""
    s, w, here = seen(device), walled(), made(device, occlusion)
    packed = device.buffer("packed", w.packed) if occlusion else None
    with one_stage(device) as stage:
        here.forget(stage)
        here.mark(stage, s.g.frame, s.grids, s.windows, packed)
    marks = read_buffer(device, here.marks, np.uint32).reshape(COUNT, N, N, N) == 1
    surely, perhaps = np.zeros((2, COUNT, N, N, N), bool)
    for number, (place, share, planes) in enumerate(zip(s.places, s.shares, w.planes, strict=True)):
        planes = planes if occlusion else None
        first, weights = corners.corner_weights(place, planes)
        x, y, z = np.moveaxis(corners.corner_cells(first, N), -1, 0)
        steady = sure(place, planes)[0] & ((share > PLACE) | (share == 0.0))
        counts = (weights > 0.0) & (share > 0.0)[:, None]
        for at, which in ((surely, counts & steady[:, None]), (perhaps, counts | ~steady[:, None])):
            at[number, z[which], y[which], x[which]] = True
    assert np.all(marks[surely]) and not marks[~perhaps].any()
    assert all(level.sum() > 10 for level in surely) and perhaps.sum() < 1.1 * surely.sum()
