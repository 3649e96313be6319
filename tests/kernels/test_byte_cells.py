"""Cells of a word a channel (byte_cells.wgsl) against the simulator's, and what steps with them do to light."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import run_kernel
from test_propagation import kernel, random_light, run

from octolux.simulator.lpv import formats
from octolux.simulator.lpv import propagation as reference
from octolux.techniques.lpv.constants import propagation_values
from octolux.techniques.lpv.levels import ROW, Levels
from octolux.techniques.lpv.octree.settings import OctreeLpvSettings
from octolux.techniques.lpv.propagation import CELL_BYTES
from octolux.techniques.lpv.uniform.settings import UniformLpvSettings
from octolux.techniques.settings import SettingsError

EVALUATIONS = ("clamped", "dominant_lobe")
COUNT = 20_000


@pytest.mark.parametrize("dither", [0.0, 0.5])
@pytest.mark.parametrize("evaluation", EVALUATIONS)
def test_packing(device, evaluation, dither):
    """The device rounds a size or a threshold by 2^-22 or so before it compares them, and a gap is 2^-5 of a size: of
    20,000 words some may differ by a code, and so may shares, by one of 127, that lie in the middle."""
    rng = np.random.default_rng(1)
    d = rng.normal(size=(COUNT, 3))
    d *= rng.uniform(0.0, 1.0, (COUNT, 1)) / np.linalg.norm(d, axis=-1, keepdims=True)
    e = (2.0 ** rng.uniform(-16.0, 5.5, (COUNT, 1)) * np.concatenate([rng.random((COUNT, 1)), d], axis=-1)).astype("f4")
    e[:50] = 0.0
    e[50:100, 1:] = 0.0
    if evaluation == "clamped":
        e[:, 1:] *= e[:, :1] / np.maximum(np.abs(e[:, 1:]).max(axis=-1, keepdims=True), 1e-30)
    found = run_kernel(
        device, "byte_cells.wgsl", e, 6, levels=Levels([4]).described(), row=ROW, access=[], format="snorm8",
        dither=dither, **propagation_values(evaluation, "travel", 1.0),
    )  # fmt: skip
    words = found[:, 0].astype(np.uint32) | found[:, 1].astype(np.uint32) << 16
    expected = formats.pack_cells(e, np.arange(COUNT), dither, evaluation)
    assert np.mean(words != expected) <= 1e-3
    for field in range(4):
        difference = (words >> 8 * field & 255).astype(np.uint8) - (expected >> 8 * field & 255).astype(np.uint8)
        assert np.isin(difference, [0, 1, 255]).all()
    np.testing.assert_allclose(found[:, 2:], formats.unpack_cells(words, evaluation), rtol=1e-6, atol=1e-8)


@pytest.mark.parametrize("evaluation", EVALUATIONS)
@pytest.mark.parametrize("steps", [2, 8])
def test_error_of_the_sum(device, evaluation, steps):
    """A store is off by at most half a gap, 1/18 of a size above a power of two, as a standard deviation, and by 3
    shares of at most 1/254. Stores of one cell reach others by gain 1, those of k steps add in quadrature: S_i is off
    by sqrt(i) of that at most, and so is their sum."""
    light = random_light(16, seed=steps)
    found = run(device, kernel(device, 16, evaluation, "travel", 1.0, "snorm8"), light, steps)
    expected = reference.propagate(light, steps, 1.0, evaluation, "travel")
    error = np.sqrt(np.mean((found - expected) ** 2) / np.mean(expected**2))
    assert 1e-4 < error <= np.hypot(0.5 * formats.GAP, 3.0 / 254.0) * np.sqrt(steps)


@pytest.mark.parametrize("steps", [4, 7])
def test_flux_is_kept(device, steps):
    """Of light that does not meet the border. What step j stores is off by half a gap over the root of the cells that
    share the flux, and is in the sum k - j + 1 times: of itself, if the sum reads it back, and of all later steps.
    Four standard deviations, for three channels."""
    light = np.zeros((16, 16, 16, 3, 4), np.float32)
    light[8, 8, 8] = random_light(2, seed=steps)[0, 0, 0]
    found = run(device, kernel(device, 16, "dominant_lobe", "travel", 1.0, "snorm8"), light, steps)
    deviations, current = [], light.astype(np.float64)
    for step in range(1, steps):
        current = reference.step(current, 1.0, "dominant_lobe", "travel")
        shares = current[..., 0] / current[..., 0].sum(axis=(0, 1, 2))
        deviations.append((steps - step + 1) * 0.5 * formats.GAP * np.sqrt((shares**2).sum(axis=(0, 1, 2))))
    kept = reference.total_flux(found.astype(np.float64)) / reference.total_flux(light)
    assert np.all(np.abs(kept - (steps + 1)) <= 4.0 * np.linalg.norm(deviations, axis=0))


def test_dark_in_dark_out(device):
    made = kernel(device, 16, "dominant_lobe", "travel", 1.0, "snorm8")
    run(device, made, random_light(16), 2)
    assert not run(device, made, np.zeros((16, 16, 16, 3, 4), np.float32), 3).any()


def test_half_the_memory_of_half_floats():
    assert 2 * CELL_BYTES["snorm8"] <= CELL_BYTES["f16"]


def test_negative_flux_is_refused():
    with pytest.raises(SettingsError, match="snorm8 hold no negative flux"):
        UniformLpvSettings.from_strings("default", {"cell_format": "snorm8", "evaluation": "signed"})


def test_sums_of_children_are_refused():
    """Those of a lit wall are four times as bright on each level: beyond the largest size from the third on."""
    with pytest.raises(SettingsError, match="outgrow cells in snorm8"):
        OctreeLpvSettings.from_strings("steps", {"cell_format": "snorm8"})
    assert OctreeLpvSettings.from_strings("thesis", {"cell_format": "snorm8"}).cell_format == "snorm8"
