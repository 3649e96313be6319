"""Merging an octree's levels (merge.wgsl, merge_level.wgsl): by the index and by arrival, against the simulator's
and in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import one_stage, random_directions

from octolux.gpu.profiler import Profiler
from octolux.simulator import sh
from octolux.simulator.lpv import octree, propagation
from octolux.techniques.lpv.downsampling import Downsampling
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.octree.settings import OctreeLpvSettings
from octolux.techniques.lpv.octree.stepping import Stepping

N = 16
HALF_FLOAT = 2.0**-10  # of the volumes, relative: 2^-11 rounded, twice that where an adapter truncates


def merged(device, settings: OctreeLpvSettings, light: np.ndarray) -> np.ndarray:
    """What the lookup filters, in W/sr: [z][y][x][rgb][4]."""
    levels = Levels(octree.level_sizes(settings.n, settings.coarsest))
    made, injected = Stepping(device, levels, settings), device.buffer("injected", size=levels.cells * 48)
    peak = light[..., 0].max(keepdims=True).astype(np.float32).ravel()
    device.write(injected, light.astype(np.float32))
    factor = 1.0 if settings.combine == "sum" else 0.125
    with one_stage(device) as stage:
        Downsampling(device, levels, per_cell=3, factor=factor).run(stage, injected)
    profiler = Profiler(device, "off")
    with profiler.frame():
        made.run(profiler, injected, device.buffer("peak", peak))
    channels = [read_volume(device, texture) for texture in made.lookup.volumes.values()]
    return np.stack(channels, axis=3) / 2.0 ** (3 - np.floor(np.log2(peak[0])))


def read_volume(device, texture) -> np.ndarray:
    """An rgba16float volume of N^3 texels."""
    layout = {"bytes_per_row": N * 8, "rows_per_image": N}
    data = device.queue.read_texture({"texture": texture}, layout, (N, N, N))
    return np.frombuffer(data, np.float16).reshape(N, N, N, 4).astype(np.float64)


def lit_corner() -> np.ndarray:
    """Lobes in a few cells of one corner, so that far cells are reached by coarse levels alone."""
    light, rng = np.zeros((N, N, N, 3, 4)), np.random.default_rng(5)
    lobes = sh.cosine_lobe(random_directions(rng, 24).reshape(2, 2, 2, 3, 3))
    light[1:3, 2:4, 1:3] = lobes * rng.uniform(0.5, 2.0, (2, 2, 2, 3, 1))
    return light


@pytest.mark.parametrize("combine", ["average", "sum"])
@pytest.mark.parametrize("iterations", [1, 2, 5])
def test_by_the_index(device, combine, iterations):
    """Eq. 10 on levels that went their steps each for itself; what is marked is every term of more than the threshold.

    Volumes hold down to 6e-8 absolute (a half float's smallest number) of a peak of 8 to 16.
    """
    s = OctreeLpvSettings.make("thesis", n=N, iterations=iterations, combine=combine)
    light = lit_corner()
    index, sums = octree.index_levels(N, 2), []
    threshold = s.threshold * 2.0 ** np.floor(np.log2(light[..., 0].max()))
    levels = octree.build_levels(light, combine, 2)
    for k in range(iterations + 1):
        before, sums = sums, [propagation.propagate(level, k, s.gain, s.evaluation, s.reprojection) for level in levels]
        index = octree.mark(index, [a - b for a, b in zip(sums, before or [0.0] * len(sums), strict=True)], threshold)
    expected, found = octree.merge(sums, index, combine), merged(device, s, light)
    largest = np.abs(expected).max(axis=-1, keepdims=True)
    assert (np.abs(found - expected) <= HALF_FLOAT * largest + 2.0**-23).all()
    assert len(np.unique(octree.flat_index(index))) > 1


def test_nothing_has_arrived_before_the_first_step(device):
    """Without steps all of the sum is its last term, so that all cells read the coarsest level: for the same light in
    each, its sum over 8^4 children, read with 4^-4."""
    light = np.broadcast_to(sh.cosine_lobe([0.0, 0.6, 0.8]), (N, N, N, 3, 4))
    s = OctreeLpvSettings.make("steps", n=N, iterations=0)
    np.testing.assert_allclose(merged(device, s, light), 2.0**4 * light, rtol=HALF_FLOAT)


@pytest.mark.parametrize("combine", ["average", "sum"])
@pytest.mark.parametrize("iterations", [2, 5])
def test_by_arrival(device, combine, iterations):
    """Against the simulator's blending; a cell's own rounding in float32 is far below a half float's."""
    s = OctreeLpvSettings.make("steps", n=N, iterations=iterations, combine=combine)
    light, sums = lit_corner(), []
    for k in (iterations - 1, iterations):
        levels = octree.build_levels(light, combine)
        sums.append([propagation.propagate(level, k, s.gain, s.evaluation, s.reprojection) for level in levels])
        sums[-1][-1] = levels[-1]  # of a level of one cell all light leaves in the first step
    last = [after - before for before, after in zip(*sums, strict=True)]
    expected, found = octree.merge_by_arrival(sums[1], last, combine), merged(device, s, light)
    largest = np.abs(expected).max(axis=-1, keepdims=True)
    assert (np.abs(found - expected) <= HALF_FLOAT * largest + 2.0**-23).all()
