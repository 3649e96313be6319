"""The alias table: what it chooses by is what it was given."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.scene.environment import Environment
from octolux.simulator.environment import LUMINANCE, sampled, texel_directions, texel_solid_angles
from octolux.techniques.path_tracer.emitters import alias_table, sky_table


def implied(keep: np.ndarray, alias: np.ndarray) -> np.ndarray:
    """Probability of each choice: taken itself and kept, or as the alias of those that are not."""
    return (keep + np.bincount(alias, weights=1.0 - keep, minlength=len(keep))) / len(keep)


RNG = np.random.default_rng(5)
WEIGHTS = {
    "one": np.array([3.0]),
    "two": np.array([1.0, 3.0]),
    "two, one of them 0": np.array([0.0, 2.0]),
    "equal": np.full(7, 0.3),
    "equal, many": np.full(1000, 1e-20),
    "random": RNG.random(1000),
    "many decades": 10.0 ** RNG.uniform(-12, 12, 1000),
    "zeros among them": RNG.random(1000) * (RNG.random(1000) < 0.3),
    "one huge at the end": np.r_[np.full(999, 1e-9), 1e9],
    "one huge at the start": np.r_[1e9, np.zeros(999)],
    "falling": np.linspace(1, 0, 1000),
    "whole numbers": RNG.integers(0, 3, 1000).astype(float),
}


@pytest.mark.parametrize("weights", WEIGHTS.values(), ids=WEIGHTS.keys())
def test_choices_are_as_probable_as_their_weights(weights):
    """Running sums of n numbers with a total of n err by n * 2^-53 of it at most, here 1.1e-13."""
    keep, alias = alias_table(weights)
    assert keep.min() >= 0 and keep.max() <= 1 and alias.min() >= 0 and alias.max() < len(weights)
    np.testing.assert_allclose(implied(keep, alias), weights / weights.sum(), rtol=0, atol=1e-12)


@pytest.mark.parametrize("seed", range(20))
def test_random_tables(seed):
    rng = np.random.default_rng(seed)
    weights = rng.random(rng.integers(1, 400)) ** rng.uniform(0, 20)
    np.testing.assert_allclose(implied(*alias_table(weights)), weights / weights.sum(), rtol=0, atol=1e-12)


def test_what_weighs_nothing_is_never_chosen():
    """Not even by rounding: a direction of density 0 has no weight to be divided by."""
    for name in ("zeros among them", "whole numbers", "one huge at the start"):
        weights = WEIGHTS[name]
        keep, alias = alias_table(weights)
        assert not keep[weights == 0].any(), name
        assert np.all(weights[alias[keep < 1]] > 0), name


@pytest.mark.parametrize("constant", [0.0, 0.5])
def test_the_table_of_the_surroundings(constant):
    """Texels are chosen by what bilinear filtering shows of them: the mean over a texel of (u, v) of what is seen."""
    image = np.random.default_rng(6).random((8, 16, 3)).astype(np.float32)
    environment = Environment((constant,) * 3, image)
    table, power = sky_table(environment)
    fine = 32  # the midpoint rule is exact for what is linear between texels' centres
    seen = sampled(environment, texel_directions(8 * fine, 16 * fine)) @ LUMINANCE + constant
    mean = seen.reshape(8, fine, 16, fine).mean(axis=(1, 3))
    np.testing.assert_allclose(table[..., 2], mean, rtol=1e-6)
    light = mean * texel_solid_angles(8, 16)
    assert power == pytest.approx(light.sum(), rel=1e-6)
    chosen = implied(table[..., 0].ravel().astype(np.float64), table[..., 1].ravel().astype(int))
    np.testing.assert_allclose(chosen.reshape(8, 16), light / light.sum(), atol=1e-7)  # of float32


def test_a_lone_bright_texel_is_seen_in_its_neighbours_too():
    """Wherever light comes from, the table sends rays: the density is above 0 all over the filtered texel."""
    image = np.zeros((8, 16, 3), np.float32)
    image[3, 0] = 1.0
    table, _ = sky_table(Environment(image=image))
    rows, columns = np.nonzero(table[..., 2])
    assert set(zip(rows.tolist(), columns.tolist(), strict=True)) == {(r, c) for r in (2, 3, 4) for c in (15, 0, 1)}
