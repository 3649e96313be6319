"""Planes of the geometry volume on the device (surfel, surfels_merge, coarser_planes, pack_shares .wgsl)."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer
from test_octree_geometry import GRID, LEVELS, N, cell_numbers, inject, random_surfels, run, too_many

from octolux.frame.structs import VPL
from octolux.simulator.camera import pack_normals, unpack_normals
from octolux.simulator.lpv import geometry as reference
from octolux.simulator.lpv import strips
from octolux.simulator.lpv.octree import level_sizes
from octolux.techniques.lpv.geometry import GeometryVolume, fixed_point_wall
from octolux.techniques.lpv.levels import Levels


def planes_of(device, made: GeometryVolume) -> list[strips.Planes]:
    """What the last run has left, where it lies too."""
    volumes = (
        LEVELS.split(read_buffer(device, made.volume[name]).reshape(-1, 4)[:, :3].astype(np.float64))
        for name in strips.Planes._fields
    )  # fmt: skip
    return [strips.Planes(*level) for level in zip(*volumes, strict=True)]


@pytest.fixture(scope="module")
def with_planes(device):
    return GeometryVolume(device, LEVELS, camera=False)


@pytest.mark.parametrize("lights", [1, 2, 6])
def test_planes_lie_where_the_surfels_do(device, with_planes, lights):
    """In those of the light that has the most, also where more lights are than have sums of their own. A mean errs by a
    step of fixed point for each surfel, over its shares; by what small components of normals err in float32, 1e-6 of a
    wall; and by 1e-5 for places. Which light has the most is decided by rounding where two have nearly as much."""
    rng = np.random.default_rng(7)
    groups = [random_surfels(rng, 9000, 0.05) for _ in range(lights)]
    run(device, with_planes, groups)
    found, volumes = planes_of(device, with_planes), [inject(g) for g in groups]
    merged = reference.merge_planes(volumes)
    one, most = fixed_point_wall(9000, True), max(np.bincount(cell_numbers(g)).max() for g in groups)
    for side, expected in zip(found[0][:2], merged[:2], strict=True):
        np.testing.assert_allclose(side, expected, rtol=1e-5, atol=most * (0.5 / one + 1e-6))
    bounds = []
    for g, v in zip(groups, volumes, strict=True):
        count = np.bincount(cell_numbers(g), minlength=N**3).reshape(N, N, N).T[..., None]
        bounds.append(count * (1.0 / one + 1e-6) / np.maximum(v.shares, 1e-9) + 1e-5)
    filled = merged.shares > 1e-3
    for place in ("offsets", "nexts", "lasts"):
        here, right = (getattr(planes, place) for planes in (found[0], merged))
        near = [
            (v.shares > merged.shares - 1e-4) & (np.abs(here - getattr(v, place)) <= b)
            for v, b in zip(volumes, bounds, strict=True)
        ]  # fmt: skip
        assert np.any(near, axis=0)[filled].all() and filled.mean() > 0.3
        assert np.mean(np.abs(here - right)[filled] < 1e-3) > 0.999


def test_coarser_planes(device, with_planes):
    """From the finest as the device has it. Sums of eight in float32."""
    run(device, with_planes, [random_surfels(np.random.default_rng(8), 3000, 0.1)])
    found = planes_of(device, with_planes)
    for f, e in zip(found, reference.plane_levels(found[0]), strict=True):
        np.testing.assert_allclose(f.fronts, e.fronts, rtol=1e-5)
        np.testing.assert_allclose(f.backs, e.backs, rtol=1e-5)
        for place, right in zip(f[2:], e[2:], strict=True):
            np.testing.assert_allclose(place[e.shares > 0.0], right[e.shares > 0.0], rtol=1e-5)


def test_planes_have_the_same_bits_in_any_order(device, with_planes):
    """Of the surfels in their buffer, and of frames before."""
    rng = np.random.default_rng(9)
    surfels, seen = random_surfels(rng, 20001, 0.1), []
    for order in (np.arange(20001), rng.permutation(20001), np.argsort(cell_numbers(surfels), kind="stable")):
        run(device, with_planes, [surfels[order]], width=int(rng.integers(1, 900)))
        found = planes_of(device, with_planes)
        seen.append([(*p[:2], *(np.where(p.shares > 0.0, place, 0.0) for place in p[2:])) for p in found])
        run(device, with_planes, [random_surfels(rng, 9000, 0.3) for _ in range(3)])
    for first, *others in zip(*seen, strict=True):
        assert all(np.array_equal(a, b) for other in others for a, b in zip(first, other, strict=True))
    assert len(np.unique(seen[0][0][2])) > 1000


def closed_box(twofold: bool) -> np.ndarray:
    """In the cell (5, 5, 5), as wide as a half of it and 64 surfels on each side; `twofold`: with those of the inside,
    whose areas are negative."""
    steps = 0.25 + (np.arange(8) + 0.5) / 16
    a, b = (v.ravel() for v in np.meshgrid(steps, steps))
    vpls = VPL.array(6 * 64)
    for i, (axis, side) in enumerate((axis, side) for axis in range(3) for side in (-1, 1)):
        face = vpls[64 * i : 64 * (i + 1)]
        within = np.insert(np.stack([a, b], axis=-1), axis, 0.5 + 0.25 * side, axis=-1)
        face["position"] = GRID.origin + GRID.cell_size * (5.0 + within)
        face["normal"] = pack_normals(side * np.eye(3)[axis])
    vpls["area"] = (GRID.cell_size / 16) ** 2
    inside = vpls.copy()
    inside["normal"], inside["area"] = pack_normals(-unpack_normals(vpls["normal"])), -vpls["area"]
    return np.concatenate([vpls, inside]) if twofold else vpls


@pytest.mark.parametrize("twofold", [False, True])
def test_a_closed_box_blocks_once(device, with_planes, twofold):
    """A quarter of its cell along each axis, and of that a quarter on each level above. Packed normals are turned by
    up to 6.5e-5 (`pack_normals`), so that each of four sides beside an axis may bring as much of itself: 2.6e-4."""
    run(device, with_planes, [closed_box(twofold)])
    for i, level in enumerate(planes_of(device, with_planes)):
        at = (5 >> i,) * 3
        np.testing.assert_allclose(level.shares[at], 0.25 / 4**i, rtol=3e-4)
        np.testing.assert_allclose(level.shares.sum(axis=(0, 1, 2)), 0.25 / 4**i, rtol=3e-4)
        np.testing.assert_allclose(level.offsets[at], 5.5 / 2**i % 1.0, atol=3e-4)


@pytest.mark.parametrize("facing", [1, -1])
@pytest.mark.parametrize("area", [1e3, 1e-6])
def test_the_plane_of_very_many(device, with_planes, area, facing):
    """It is their mean, of large ones, whose sums go beyond 32 bits, and of a wall of small ones alike. A share of the
    small ones is 16 steps of fixed point for 10^-6 m^2 in a cell of 1/16, so that it and the place err by 1/32 a step:
    by 1/32 of each at most."""
    vpls = too_many(area, facing)
    run(device, with_planes, [vpls])
    found, expected = planes_of(device, with_planes)[0], inject(vpls)
    assert not (found.backs if facing > 0 else found.fronts)[5, 5, 5, 2]
    steps = min(1.0, area / GRID.cell_size**2) * fixed_point_wall(len(vpls), True)
    np.testing.assert_allclose(found.shares[5, 5, 5, 2], expected.shares[5, 5, 5, 2], rtol=0.5 / steps + 1e-5)
    np.testing.assert_allclose(found.offsets[5, 5, 5, 2], 0.6 - facing * reference.BEHIND, atol=1.0 / steps + 1e-5)


def test_packed_planes(device, with_planes):
    """Densities and ends to the nearest of 32 steps, planes in the one that they lie in; float32 may choose the next:
    of sums and quotients right to 1e-6 one in ten thousand lies so near to half a step."""
    run(device, with_planes, [random_surfels(np.random.default_rng(5), 5000, 0.1)])
    with one_stage(device) as stage:
        with_planes.pack(stage)
    words = read_buffer(device, with_planes.packed, np.uint32).reshape(-1, 4)[: LEVELS.cells]
    for found, planes in zip(LEVELS.split(words), planes_of(device, with_planes), strict=True):
        filled, packed = planes.shares > 0.0, strips.pack_planes(planes)
        assert np.mean((found == packed)[..., :3][filled]) > 0.999 and not found[..., :3][~filled].any()
        step = 1.0 / strips.STEPS + 1e-6
        for each, expected in zip(strips.unpack_planes(found)[:4], strips.unpack_planes(packed), strict=False):
            assert np.abs(each - expected).max() <= step


def test_as_many_cells_as_settings_allow(device):
    """Five cascades of 64^3, and an octree of 128^3: buffers and their bindings fit."""
    for levels in (Levels([64] * 4 + level_sizes(64), 5), Levels(level_sizes(128))):
        made = GeometryVolume(device, levels)
        with one_stage(device) as stage:
            made.pack(stage)
        assert not read_buffer(device, made.packed, np.uint32).any()
