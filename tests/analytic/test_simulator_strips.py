"""Strips of planes in a cell (simulator/lpv/strips.py): where they lie, what they cover, how they are kept, and what of
a way they stop (simulator/lpv/cones.py)."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator.lpv.cones import cone_transmittance
from octolux.simulator.lpv.strips import STEPS, Planes, pack_planes, unpack_planes

N = 16


def of_one(share: float, middle_next: float, middle_last: float) -> tuple[float, float, float, bool]:
    """Density and ends of the strip across x of one cell, and whether they are along z."""
    one = np.ones((1, 1, 1, 3))
    found = Planes.sheets(share * one, 0.5 * one, middle_next * one, middle_last * one).strips
    density, low, high, last = (float(each[0, 0, 0, 0]) for each in (found.density, *found[2:]))
    return density, low, high, bool(last)


def test_strips():
    """Half a wall in its half; sheets all through a cell in all of it; a whole wall in all of it, wherever its surfels'
    mean may lie; and of what does not fit around its middle, as much as its share, to the cell's side."""
    assert of_one(0.5, 0.25, 0.5) == (1.0, 0.0, 0.5, False)
    assert of_one(0.5, 0.5, 0.75) == (1.0, 0.5, 1.0, True)
    assert of_one(0.3, 0.5, 0.5)[:3] == (0.3, 0.0, 1.0)
    assert of_one(1.0, 0.4, 0.6)[:3] == (1.0, 0.0, 1.0)
    np.testing.assert_allclose(of_one(0.25, 0.9, 0.5), (1.0, 0.75, 1.0, False), atol=1e-12)


def test_strips_block_what_surfaces_do():
    """Their shares are the surfaces', and their middles too, where they need not be wider than they would be. Soft
    ends, of strips as they are kept, cover as much as hard ones: by 1024 places, whose mean errs where a slope begins
    or ends, at four places, by less than half of one place's, which changes by 32 / 1024 at most."""
    rng = np.random.default_rng(4)
    planes = Planes.sheets(*rng.random((4, 6, 6, 6, 3)))
    found = planes.strips
    np.testing.assert_allclose(found.shares, planes.shares, rtol=1e-12)
    middle = np.where(found.last, planes.lasts, planes.nexts)
    roomy = 2.0 * np.minimum(middle, 1.0 - middle) > np.maximum(planes.shares, 1 / STEPS)
    np.testing.assert_allclose((0.5 * (found.low + found.high))[roomy], middle[roomy], atol=1e-12)
    assert 0.1 < roomy.mean() < 0.9
    other = np.where(found.last, planes.nexts, planes.lasts)
    assert np.all(np.abs(middle - 0.5) >= np.abs(other - 0.5) - 0.5 / STEPS)
    found = unpack_planes(pack_planes(planes))
    covered = np.mean([found.cover(np.full(planes.shares.shape, (k + 0.5) / 1024)) for k in range(1024)], axis=0)
    np.testing.assert_allclose(covered, found.high - found.low, atol=4 * 0.5 * STEPS / 1024**2)


def test_packing():
    """The density and the ends rounded, the place to its middle, and whether the ends are along the last axis. What
    rounding takes from a strip that is as wide as its share its density cannot bring back: a step at most."""
    rng = np.random.default_rng(0)
    planes = Planes.sheets(*rng.random((4, 8, 8, 8, 3)))
    planes.fronts[0, 0, 0], planes.fronts[0, 0, 1], planes.offsets[0, 0, 1] = 1.0, 0.0, 1.0
    words, exact, filled = pack_planes(planes), planes.strips, planes.shares > 0.0
    found = unpack_planes(words)
    for kept, end in ((found.low, exact.low), (found.high, exact.high)):
        assert np.abs(kept - end)[filled].max() <= 0.5 / STEPS + 1e-12
    assert (planes.shares - found.shares).max() <= 1 / STEPS and (found.shares - planes.shares).max() <= 0.5 / STEPS
    assert np.abs(found.offsets - planes.offsets)[filled].max() <= 0.5 / STEPS
    assert np.array_equal(found.last[filled], exact.last[filled])
    assert (found.shares[0, 0, 0] == 1.0).all() and not words[0, 0, 1].any()
    assert words.dtype == np.uint32 and words.max() < 1 << 24 and not words[..., 3].any()
    one = Planes.sheets(np.array([[[[1.0, 0.0, 0.5]]]]), np.array([[[[0.5, 0.0, 1.0]]]]), nexts=0.4, lasts=0.25)
    assert pack_planes(one)[0, 0, 0].tolist() == [
        32 | 16 << 6 | 0 << 11 | 32 << 17 | 1 << 23, 0, 32 | 31 << 6 | 0 << 11 | 16 << 17 | 1 << 23, 0
    ]  # fmt: skip


@pytest.mark.parametrize("middles", [(0.75, 0.5), (0.5, 0.25), (0.25, 0.25), (0.75, 0.25)])
def test_rounding_decides_nothing_where_walls_end_at_halves(middles):
    """Neither where a strip ends nor along which axis, of half a wall and of a quarter in its corner."""
    one, share = np.ones((2, 2, 2, 3)), 0.5 if 0.5 in middles else 0.25
    exact = pack_planes(Planes.sheets(share * one, 0.3 * one, *(m * one for m in middles)))
    rng = np.random.default_rng(2)
    for _ in range(20):
        share_about, *about = (m + rng.uniform(-1e-6, 1e-6, one.shape) for m in (share, *middles))
        assert np.array_equal(exact, pack_planes(Planes.sheets(share_about, 0.3 * one, *about)))


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_half_a_wall_stops_what_goes_through_that_half(axis):
    """Across `axis`, as far as 1/2 along the next: all below 1/4, nothing above 3/4, evenly less between
    (Strips.cover). Of ways from one cell's middle up to the wall's place, 6 cells away, to the next side."""
    next_axis, place = (axis + 1) % 3, 8.5
    shares, middles = np.zeros((N, N, N, 3)), np.full((N, N, N, 3), 0.25)
    np.moveaxis(shares, 2 - axis, 0)[8, ..., axis] = 0.5
    levels = [Planes.sheets(shares, np.full(shares.shape, 0.5), nexts=middles)]
    start, aims = np.full((50, 3), 4.5), np.linspace(0.01, 0.99, 50)
    start[:, axis] = 2.5
    end = start.copy()
    end[:, axis], end[:, next_axis] = 14.5, 4.5 + 2.0 * (aims - 0.5)  # half-way at the wall
    assert np.all(place - start[:, axis] == 0.5 * (end - start)[:, axis])
    found = cone_transmittance(levels, start, end, 1.0)
    np.testing.assert_allclose(found, np.clip(2.0 * aims - 0.5, 0.0, 1.0), atol=4e-4)  # SHORT, 2 / w of it


def test_folds_do_not_dim_what_runs_along_before_them():
    """A curtain across z at 0.9 of its cells, whose folds' sides, 0.2 of the cross section, face along x and lie around
    there, from 0.8 on: ways along x at 0.5 pass, those through the curtain do not. Folds all through the cells dim."""
    shares, offsets = np.zeros((N, N, N, 3)), np.full((N, N, N, 3), 0.9)
    shares[8, ..., 2], shares[8, ..., 0] = 1.0, 0.2
    start, end = np.array([[2.5, 7.5, 8.5]]), np.array([[13.5, 7.5, 8.5]])
    folds = Planes.sheets(shares, offsets, lasts=offsets)  # z is the last axis of x
    assert cone_transmittance([folds], start, end, 1.0) == 1.0
    assert cone_transmittance([folds], start, end + np.array([0.0, 0.0, 5.0]), 1.0) == 0.0
    anywhere = Planes.sheets(shares, offsets)
    np.testing.assert_allclose(cone_transmittance([anywhere], start, end, 1.0), 0.8**10)
