"""Where in its cells injected light comes from (inject.wgsl, collect.wgsl) against the simulator's. Nested grids:
test_cascades.py; fading: test_small_objects.py; other light: test_emitted.py."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import read_buffer
from test_injection import GRID, N, arguments, clustered_vpls, random_vpls, run, words

from octolux.frame.structs import VPL
from octolux.frame.vpl_sources import MIN_STEPS, group_sources
from octolux.simulator.camera import pack_normals
from octolux.simulator.lpv import injection as reference
from octolux.techniques.lpv.injection import Injection, VplSource

PLACE = 1e-5  # cells, of places in float32


@pytest.fixture(scope="module")
def injection(device):
    return Injection(device, N, moments=True)


def moments_of(device, injection) -> np.ndarray:
    return read_buffer(device, injection.moments).reshape(N, N, N, 4)


def test_lights_of_very_different_flux(device, injection):
    """Each group's VPLs err by half a step at most, which is 2^-13 of a mean one's, and theirs span 1 to 10."""
    rng, totals = np.random.default_rng(1), [1e-2, 1.0, 1e6]
    groups = [random_vpls(rng, count, total) for count, total in zip((5000, 3000, 1), totals, strict=True)]
    run(device, injection, groups, totals)
    found, expected, weight = moments_of(device, injection), 0.0, 0.0
    for group in groups:
        expected = expected + reference.inject_moments(*arguments(group))
        weight = weight + reference.inject(*arguments(group))[..., 0].sum(axis=-1)
    assert np.all(np.abs(found[..., :3] - expected) <= (10.0 * 2.0**-13 + PLACE) * weight[..., None])
    assert not found[..., 3].any() and np.median(np.abs(expected)[weight > 0] / weight[weight > 0][:, None]) > 0.1


def test_a_faint_light_of_another_colour_keeps_its_own_precision(device, injection):
    """Beside a red light of 1e6 times its flux a blue one shares no channel, but all channels have one moment."""
    rng = np.random.default_rng(2)
    red, blue = random_vpls(rng, 1, 1.0), random_vpls(rng, 2000, 1.0)
    red["flux"], blue["flux"][:, :2] = (1e6, 0.0, 0.0), 0.0
    red["position"] = np.array(GRID.origin) - 3.0 * GRID.cell_size  # beyond the grid
    fluxes = np.array([[1e6, 0.0, 0.0], [0.0, 0.0, 1.0]])
    sources = [VplSource(0, 1, fluxes[0]), VplSource(1, 2000, fluxes[1])]
    assert len(group_sources(sources)) == 2
    words(device, injection, np.concatenate([red, blue]), sources)
    weight = reference.inject(*arguments(blue))[..., 0].sum(axis=-1)[..., None]
    off = np.abs(moments_of(device, injection)[..., :3] - reference.inject_moments(*arguments(blue)))
    assert np.all(off <= (10.0 / (2.0 * MIN_STEPS) + PLACE) * weight)


@pytest.mark.parametrize("width", [1, 7, 5000])
def test_light_is_the_same_to_the_bit(device, injection, width):
    """With moments and without, and moments whatever the width of the map is."""
    vpls, seen = clustered_vpls(np.random.default_rng(width), 1000), []
    for columns in (width, 64):
        sources = [VplSource(0, len(vpls), np.full(3, 1.0), width=columns)]
        light = words(device, injection, vpls, sources)
        assert np.array_equal(light, words(device, Injection(device, N), vpls, sources)) and light.any()
        seen.append(moments_of(device, injection))
    assert np.array_equal(*seen) and seen[0].any()


def test_all_in_one_cell_do_not_overflow(device, injection):
    """A hundred thousand VPLs of all channels a cell away from the middle of theirs: as many as a scale allows for."""
    vpls = VPL.array(100_000)
    vpls["normal"], vpls["flux"] = pack_normals(np.array([0.0, 1.0, 0.0])), 1e3
    vpls["position"] = np.array(GRID.origin) + GRID.cell_size * np.array([5.999, 4.501, 5.001])
    run(device, injection, [vpls], [1e8])
    found, expected = moments_of(device, injection)[5, 5, 5, :3], reference.inject_moments(*arguments(vpls))[5, 5, 5]
    np.testing.assert_allclose(found, expected, rtol=1e-4)


def test_no_moment_is_left_for_the_next(device, injection):
    """Of VPLs so faint that all light rounds to 0, but the moment, three channels in half as fine steps, to 1."""
    total, (faint, bright) = 400.0, (random_vpls(np.random.default_rng(6), 64, 1.0) for _ in range(2))
    (group,) = group_sources([VplSource(0, len(faint), np.full(3, total))])
    packed = group.pack()[0]
    faint["flux"] = 0.48 / packed["scale"][0]  # 1.02 * 0.48 < 1/2, but 3 * 0.886 * 0.48 / 2 * 0.9 > 1/2
    faint["normal"] = pack_normals(np.array([0.0, 1.0, 0.0]))
    faint["position"] = np.array(GRID.origin) + GRID.cell_size * np.array([5.5, 4.6, 5.5])
    assert packed["moment_scale"][0] * packed["to_intensity"][0, 0] == 0.5
    run(device, injection, [bright], [total])
    alone = moments_of(device, injection)
    assert not run(device, injection, [faint], [total])[0].any() and moments_of(device, injection).any()
    run(device, injection, [bright], [total])
    assert np.array_equal(alone, moments_of(device, injection)) and alone.any()
