"""Bounces of gathered light (simulator/lpv/bouncing.py): energy, symmetry, and a furnace whose sum is known."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.simulator import sh
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import bouncing, cascades
from octolux.simulator.lpv.gathering import SIDE
from octolux.simulator.lpv.propagation import total_flux
from octolux.simulator.lpv.transfer import DIRECTIONS

N = 16


def facing(n: int, cells, face: int, share: float, albedo) -> np.ndarray:
    """Reflectors of a volume in which `cells` (slices x, y, z) have surfaces that face one way."""
    result = np.zeros((n, n, n, 3, 4))
    x, y, z = cells
    result[z, y, x, face // 4, face % 4] = share
    result[z, y, x, 2, :3] = albedo
    return result


def room(albedo: float) -> np.ndarray:
    """The inside of a cubic room whose six walls lie on the cells' faces 1 and N - 1."""
    result = np.zeros((N, N, N, 3, 4))
    inner = slice(1, N - 1)
    for face, outward in enumerate(DIRECTIONS):
        axis, at = face // 2, 1 if outward.sum() > 0 else N - 2
        place = [inner] * 3
        place[2 - axis] = slice(at, at + 1)  # [z][y][x]
        result[(*place, face // 4, face % 4)] = 1.0
    lit = result[..., :2, :].sum(axis=(-1, -2)) > 0
    result[lit, 2, :3] = albedo
    return result


def test_a_face_sends_back_its_share():
    """Of irradiance E on a face of area h^2 the flux E h^2 share albedo, as a cosine lobe along the face's normal."""
    rng = np.random.default_rng(1)
    for face, outward in enumerate(DIRECTIONS):
        one = facing(2, (slice(0, 1),) * 3, face, 0.7, (0.9, 0.5, 0.1))
        cube = np.zeros((2, 2, 2, 6, 3))
        cube[0, 0, 0] = rng.uniform(1.0, 2.0, (6, 3))
        light = bouncing.reflected(one, cube)
        flux = 0.7 * np.array([0.9, 0.5, 0.1]) * cube[0, 0, 0, face]
        np.testing.assert_allclose(light[0, 0, 0], flux[:, None] * sh.cosine_lobe(outward) / np.pi, rtol=1e-12)
        np.testing.assert_allclose(total_flux(light), flux, rtol=1e-12)


@pytest.mark.parametrize("albedo", [0.5, 0.9])
def test_a_closed_room_keeps_its_light(albedo):
    """Light of one wall in an empty room reaches the walls whole: each bounce has the flux of the one before times the
    albedo, and all of them together the geometric series'.

    No light is made. What may be lost is what cells beside an edge of the room, a share of 4 / 14 of a wall's, exchange
    with those across it: there the inverse square of middles stands for squares side by side. That is at most what two
    squares with a common edge exchange.
    """
    light = np.zeros((N, N, N, 3, 4))
    light[1:-1, 1, 1:-1] = sh.cosine_lobe([0.0, 1.0, 0.0]) / np.pi
    walls, before, current = room(albedo), total_flux(light)[0], light
    for _ in range(3):
        current = bouncing.reflected(walls, bouncing.irradiance(current, walls, 1))
        kept = total_flux(current)[0] / (albedo * before)
        assert 1.0 - 4.0 / (N - 2) * SIDE < kept < 1.0
        before = total_flux(current)[0]
    together = total_flux(bouncing.reflected(walls, bouncing.irradiance(light, walls, 3)))[0]
    assert together == pytest.approx(sum(self_flux(light, walls, k) for k in (1, 2, 3)), rel=1e-9)


def self_flux(light: np.ndarray, walls: np.ndarray, count: int) -> float:
    """Flux after the bounce number `count` alone."""
    for _ in range(count):
        light = bouncing.reflected(walls, bouncing.irradiance(light, walls, 1))
    return total_flux(light)[0]


def test_nothing_is_reflected_where_nothing_is():
    light = np.zeros((N, N, N, 3, 4))
    light[3, 3, 3] = sh.cosine_lobe([1.0, 0.0, 0.0])
    assert not bouncing.irradiance(light, np.zeros((N, N, N, 3, 4)), 2).any()
    black = facing(N, (slice(9, 10), slice(0, N), slice(0, N)), 1, 1.0, (0.0, 0.0, 0.0))
    assert not bouncing.reflected(black, bouncing.irradiance(light, black, 1)).any()


def test_coarser_reflectors_keep_area_and_albedo():
    """A wall in fine cells is the same wall in coarse ones: share 1, its albedo the mean of its parts."""
    windows = cascades.place_windows(N, 2, Grid((0, 0, 0), 1.0, N), [8.0, 8.0, 8.0], [1.0, 0.0, 0.0])
    x, y, z = np.array(windows[0].origin)
    fine = facing(N, (slice(4, 5), slice(0, N), slice(0, N)), 0, 1.0, (0.2, 0.4, 0.6))
    fine[: N // 2, :, 4, 2, :3] = (0.4, 0.4, 0.2)
    whole = bouncing.with_children([fine, np.zeros((N, N, N, 3, 4))], windows)[1]
    at = (slice(z // 2, z // 2 + N // 2), slice(y // 2, y // 2 + N // 2), x // 2 + 2)
    np.testing.assert_allclose(whole[at][..., 0, 0], 1.0)
    np.testing.assert_allclose(whole[at][0, 0, 2, :3], (0.4, 0.4, 0.2), rtol=1e-12)
    np.testing.assert_allclose(whole[at][-1, 0, 2, :3], (0.2, 0.4, 0.6), rtol=1e-12)
    assert whole[..., :2, :].sum() == pytest.approx((N // 2) ** 2)


def test_even_irradiance_is_reflected_alike_in_all_windows():
    """Each window's surfaces send back share, albedo and area of what arrives, whatever their cell size; where a finer
    window is, a coarser one sends nothing."""
    windows = cascades.place_windows(N, 3, Grid((0, 0, 0), 1.0, N), [7.0, 9.0, 8.0], [0.6, 0.0, 0.8])
    walls = [np.zeros((N, N, N, 3, 4)) for _ in windows]
    for own in walls:
        own[..., 0, 3], own[..., 2, :3] = 0.5, (0.3, 0.6, 0.9)
    found = bouncing.injected_bounces(np.full((N, N, N, 6, 3), 2.0), np.ones((N, N, N), bool), walls, windows)
    for number, (light, window) in enumerate(zip(found, windows, strict=True)):
        sent = total_flux(light)
        ratio = window.size / windows[-1].size
        cells = N**3 - (N // 2) ** 3 * (number > 0)
        np.testing.assert_allclose(sent, cells * ratio**2 * 2.0 * 0.5 * np.array([0.3, 0.6, 0.9]), rtol=1e-12)
