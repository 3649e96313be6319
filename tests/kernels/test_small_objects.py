"""Light of objects smaller than a cell (small_objects.wgsl) against the simulator's injection of weighted flux."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, read_buffer
from test_cascades import COUNT, GRIDS, N, random_vpls, safe, uniforms

from octolux.frame import traits
from octolux.frame.structs import VPL
from octolux.gpu.records import record_texture, word_texture
from octolux.simulator.camera import unpack_normals
from octolux.simulator.lpv.injection import inject, inject_moments, small_object_share
from octolux.techniques.lpv.injection import Injection, VplSource

SHARE_ERROR = 3 * 41 * 2.0**-23
"""A share changes by at most 3 times the relative change of size or cell: 1.5 is the fade's steepest, of a place that
goes by 2 size / h. exp2 is right to 3 + 2 * 16 units in the last place, inverseSqrt to 2 (Vulkan), four roundings
besides: 41 * 2^-23."""


def surfaces(count: int) -> np.ndarray:
    """Traits of objects from a quarter of the finest cell to twice the coarsest, half of which move."""
    rng = np.random.default_rng(21)
    low, high = np.log2(0.25 * GRIDS[0].cell_size), np.log2(2.0 * GRIDS[-1].cell_size)
    return traits.pack_traits(rng.random((count, 3)), np.exp2(rng.uniform(low, high, count)), rng.random(count) < 0.5)


@pytest.mark.parametrize("small_objects", ["fade moving", "fade"])
def test_flux_of_small_objects_fades(device, small_objects):
    """In each grid by its own cells; VPLs of the source begin behind others."""
    vpls = safe(random_vpls(4000), 0.5)
    words, first = surfaces(len(vpls)), 300
    made = Injection(device, N, grids=COUNT, small_objects=small_objects, moments=True)
    total = vpls["flux"].sum(axis=0, dtype=np.float64)
    source = VplSource(first, len(vpls) - first, total, width=40)
    with one_stage(device) as stage:
        textures = record_texture(device, "vpls", VPL, len(vpls), vpls), word_texture(device, "s", len(words), words)
        made.run(stage, uniforms(device)[0], textures[0], [source], textures[1])
    found = read_buffer(device, made.injected).reshape(COUNT, N, N, N, 3, 4)
    normals, positions = unpack_normals(vpls["normal"]), vpls["position"].astype(np.float64)
    placed = read_buffer(device, made.moments).reshape(COUNT, N, N, N, 4)[..., :3]
    _, size, moving = traits.unpack_traits(words)
    step, sums = 2.0**-30 * len(vpls) * total.max(), []  # half a step of fixed point each, as in test_cascades.py
    for i, grid in enumerate(GRIDS):
        share = small_object_share(size, grid.cell_size)
        if small_objects == "fade moving":
            share = np.where(moving, share, 1.0)
        given, flux = (positions[first:], normals[first:]), vpls["flux"].astype(np.float64)
        faded, whole = (inject(*given, (flux * w[:, None])[first:], grid) for w in (share, np.ones(len(vpls))))
        # No coefficient of a VPL is more than 2 / sqrt(3) of its band 0.
        bound = step + (1e-5 + SHARE_ERROR) * 2.0 / np.sqrt(3.0) * whole[..., :1]
        assert np.all(np.abs(found[i] - faded) <= bound)
        moments = inject_moments(*given, (flux * share[:, None])[first:], grid)
        of_all = 3.75 * step + (1e-5 + SHARE_ERROR) * whole[..., 0].sum(axis=-1)  # at most a cell from the middle
        assert np.all(np.abs(placed[i] - moments) <= of_all[..., None])
        assert np.any((share[first:] > 0) & (share[first:] < 1))
        sums.append((faded[..., 0].sum(), whole[..., 0].sum()))
    kept, there = np.sum(sums, axis=0)
    assert kept < 0.95 * there


def test_all_light_is_kept_of_what_is_larger_than_a_cell(device):
    """To the bit what "keep" injects."""
    vpls = safe(random_vpls(500), 0.5)
    words = traits.pack_traits(np.ones((len(vpls), 3)), np.full(len(vpls), 1.2 * GRIDS[-1].cell_size),
                               np.ones(len(vpls), bool))  # fmt: skip
    source, results = VplSource(0, len(vpls), vpls["flux"].sum(axis=0, dtype=np.float64)), []
    for small_objects in ("keep", "fade"):
        made = Injection(device, N, grids=COUNT, small_objects=small_objects)
        with one_stage(device) as stage:
            texture = record_texture(device, "vpls", VPL, len(vpls), vpls)
            made.run(stage, uniforms(device)[0], texture, [source], word_texture(device, "s", len(vpls), words))
        results.append(read_buffer(device, made.injected, np.uint32))
    assert results[0].any() and np.array_equal(*results)
