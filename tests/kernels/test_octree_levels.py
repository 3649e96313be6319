"""All levels of an octree in the same dispatches: downsampling, steps and the index volume, against the simulator's."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import largest_cell_error, one_stage, random_directions, read_buffer
from test_propagation import BOUNDS, random_light

from octolux.simulator import sh
from octolux.simulator.lpv import geometry, octree
from octolux.simulator.lpv import propagation as reference
from octolux.techniques.lpv.downsampling import Downsampling
from octolux.techniques.lpv.levels import Levels
from octolux.techniques.lpv.propagation import Propagation

SCHEME = {"evaluation": "dominant_lobe", "reprojection": "travel", "gain": 1.0}


def split(flat: np.ndarray, sizes: list[int]) -> list[np.ndarray]:
    """[level][cell]... as it lies in a buffer to a list of [z][y][x]..."""
    levels = Levels(sizes)
    firsts = [levels.first(i) for i in range(len(sizes))]
    return [flat[f : f + n**3].reshape(n, n, n, *flat.shape[1:]) for f, n in zip(firsts, sizes, strict=True)]


def downsampled(device, finest: np.ndarray, sizes: list[int], **rest) -> list[np.ndarray]:
    """What Downsampling makes of `finest` [z][y][x][per_cell][4]."""
    levels, per_cell = Levels(sizes), finest.shape[3]
    cells = device.buffer("cells", np.full((levels.cells, per_cell, 4), np.nan, np.float32))
    device.write(cells, np.ascontiguousarray(finest, np.float32))
    with one_stage(device) as stage:
        Downsampling(device, levels, per_cell=per_cell, **rest).run(stage, cells)
    return split(read_buffer(device, cells).reshape(-1, per_cell, 4), sizes)


@pytest.mark.parametrize("coarsest", [1, 2])
@pytest.mark.parametrize("n", [16, 32])
@pytest.mark.parametrize("combine", octree.COMBINATIONS)
def test_light_of_children(device, combine, n, coarsest):
    """4, 5 and 6 levels, of which three come from one dispatch. Eight numbers are added on each level: 8 roundings."""
    finest, sizes = random_light(n, seed=n), octree.level_sizes(n, coarsest)
    found = downsampled(device, finest, sizes, factor=1.0 if combine == "sum" else 0.125)
    expected = octree.build_levels(finest, combine, coarsest)
    assert np.array_equal(found[0], finest)
    for i, (f, e) in enumerate(zip(found, expected, strict=True)):
        # Directions cancel in sums: errors are those of the sum of sizes, here of band 0, which no direction exceeds by
        # more than 2 / sqrt(3).
        assert np.all(np.abs(f - e) <= 8 * max(i, 1) * 2.0**-24 * 2 / np.sqrt(3) * e[..., :1])


@pytest.mark.parametrize("n", [16, 32])
def test_shares_of_children(device, n):
    """A quarter of the sum, at most 1: many cells here reach the limit, and many do not."""
    finest = np.zeros((n, n, n, 1, 4), np.float32)
    finest[..., 0, :3] = np.random.default_rng(n).uniform(0.0, 1.0, (n, n, n, 3)) ** 2
    found = downsampled(device, finest, octree.level_sizes(n), factor=0.25, limit=1.0)
    for i, (f, e) in enumerate(zip(found, geometry.geometry_levels(finest[..., 0, :3]), strict=True)):
        np.testing.assert_allclose(f[..., 0, :3], e, rtol=8 * max(i, 1) * 2.0**-24)
    assert 0.02 < (found[1] == 1.0).mean() < 0.98


def steps(device, levels: list[np.ndarray], iterations: int, threshold: float | None, cell_format: str = "f32"):
    """`Propagation` of all levels at once: the accumulated light of each, W/sr, and what is marked as touched."""
    sizes = [level.shape[0] for level in levels]
    made = Propagation(device, sizes, cell_format=cell_format, threshold=threshold, **SCHEME)
    flat = np.concatenate([level.reshape(-1, 3, 4) for level in levels]).astype(np.float32)
    peak = levels[0][..., 0].max(keepdims=True).astype(np.float32).ravel()
    with one_stage(device) as stage:
        made.run(stage, device.buffer("injected", flat), device.buffer("peak", peak), iterations)
    light = read_buffer(device, made.light).reshape(-1, 3, 4) / 2.0 ** (3 - np.floor(np.log2(peak[0])))
    touched = split(read_buffer(device, made.touched, np.uint32), sizes) if threshold is not None else []
    return split(light, sizes), touched


@pytest.mark.parametrize("cell_format", ["f32", "f16"])
@pytest.mark.parametrize("iterations", [1, 4])
@pytest.mark.parametrize(("n", "coarsest"), [(16, 1), (32, 2)])
def test_each_level_goes_its_own_steps(device, n, coarsest, iterations, cell_format):
    """Random light on each level, not of the same octree: nothing of one level comes to another."""
    levels = [random_light(size, seed=size) for size in octree.level_sizes(n, coarsest)]
    found, _ = steps(device, levels, iterations, None, cell_format)
    for level, light in zip(levels, found, strict=True):
        if level.shape[0] > 1:  # of a single cell all light leaves in the first step
            expected = reference.propagate(level, iterations, 1.0, "dominant_lobe", "travel")
            assert largest_cell_error(light, expected) <= BOUNDS[cell_format]
        else:
            np.testing.assert_allclose(light, level, rtol=BOUNDS[cell_format])


def faint_corner(n: int) -> np.ndarray:
    """Lobes in a few cells, the faintest a thousandth of the brightest."""
    rng, light = np.random.default_rng(4), np.zeros((n, n, n, 3, 4))
    lobes = sh.cosine_lobe(random_directions(rng, 24).reshape(8, 3, 3)) * 10.0 ** rng.uniform(-3, 0, (8, 1, 1))
    light[tuple(rng.integers(0, n // 2, (3, 8)))] = lobes
    return light


@pytest.mark.parametrize("iterations", [0, 1, 2, 5])
@pytest.mark.parametrize("threshold", [0.0, 2.0**-10])
def test_the_index_volume_is_the_simulators(device, iterations, threshold):
    """Marked is what any term of the sum brought more than the threshold, a share of the power of two below the peak.
    Terms within 1e-4 of it may fall on either side."""
    levels = octree.build_levels(faint_corner(16))
    limit = threshold * 2.0 ** np.floor(np.log2(levels[0][..., 0].max()))
    index, unsure, terms = octree.index_levels(16), [np.zeros(level.shape[:3], bool) for level in levels], levels
    for _ in range(iterations + 1):
        index = octree.mark(index, terms, limit)
        for i, term in enumerate(terms):
            unsure[i] |= np.any(np.abs(term[..., 0] - limit) < 1e-4 * limit, axis=-1)
        terms = [reference.step(t, 1.0, "dominant_lobe", "travel") if len(t) > 1 else 0.0 * t for t in terms]
    _, touched = steps(device, levels, iterations, threshold)
    for i, (found, expected) in enumerate(zip(touched[:-1], index, strict=False)):
        assert np.array_equal((found == 1)[~unsure[i]], (expected == i)[~unsure[i]])
    assert 0 < touched[0].sum() < 16**3 and not any(u.mean() > 0.01 for u in unsure)
