"""The path tracer and Mitsuba estimate the same pictures: their means agree within 1 %, and the differences of blocks
are distributed as those of two unbiased estimators (see estimators.py for the tolerances)."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from estimators import assert_ratio_of_means, assert_same_expectation
from mitsuba_tools import BATCHES, LLVM, Witness
from witness_scenes import VIEWS, View

from octolux.gpu.device import Device
from octolux.renderer import Renderer

CASES = [
    ("cornell-point", "all"), ("cornell-point", "direct"), ("cornell-point", "first-bounce"), ("cornell-area", "all"),
    ("cornell-glow", "all"), ("cornell-glossy", "all"), ("sponza-sun", "all"), ("bunny-environment", "all"),
]  # fmt: skip
SAMPLES = {
    ("cornell-glossy", "all"): (512, 4096), ("cornell-point", "first-bounce"): (1024, 4096),
    ("sponza-sun", "all"): (128, 512),
}  # fmt: skip
"""Samples a pixel of the path tracer and of Mitsuba: so many that the ratio of means is uncertain by less than a third
of a percent. Mitsuba finds the bright paths of the glossy box more rarely."""
COMMON = (256, 1024)


def path_traced(view: View, samples: int, paths: str, device: Device) -> np.ndarray:
    """(BATCHES, height, width, 3): independent pictures, together of `samples` samples a pixel."""
    settings = {"samples": samples // BATCHES, "paths": paths}
    renderer = Renderer(view.scene, "path-tracer", settings=settings, size=view.size, anti_aliasing="off",
                        device=device, default_light=False, exposure=0.0)  # fmt: skip
    pictures = []
    for seed in range(BATCHES):
        renderer.technique.settings = replace(renderer.technique.settings, seed=seed)
        pictures.append(renderer.render(view.camera).radiance.astype(np.float64))
    return np.stack(pictures)


@pytest.mark.parametrize(("name", "paths"), CASES)
def test_same_pictures(name, paths, device):
    view = VIEWS[name]()
    if view.glossy and not LLVM:
        pytest.skip("needs an LLVM for Mitsuba: DRJIT_LIBLLVM_PATH, version 16 or later")
    ours, theirs = SAMPLES.get((name, paths), COMMON)
    expected = Witness(view.scene, view.camera, view.size).batches(theirs, seed=1, paths=paths)
    found = path_traced(view, ours, paths, device)
    assert_ratio_of_means(found, expected)
    assert_same_expectation(found, expected)


def test_mitsuba_agrees_with_itself():
    """The comparison lets two estimators of the same picture pass."""
    view = VIEWS["cornell-point"]()
    witness = Witness(view.scene, view.camera, view.size)
    first, second = witness.batches(1024, seed=2), witness.batches(512, seed=3)
    assert_ratio_of_means(first, second)
    assert_same_expectation(first, second)
