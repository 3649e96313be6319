"""Bounces of gathered light (simulator/lpv/bouncing.py): energy, symmetry, and a furnace whose sum is known."""

from __future__ import annotations

import numpy as np
import pytest
from test_simulator_cascades import vpls_in

from octolux.simulator import sh
from octolux.simulator.grid import Grid
from octolux.simulator.lpv import bouncing, cascades
from octolux.simulator.lpv.gathering import SIDE, first_moments
from octolux.simulator.lpv.propagation import total_flux
from octolux.simulator.lpv.reflectors import inject_places, inject_reflectors, merge_reflectors
from octolux.simulator.lpv.transfer import DIRECTIONS

N = 16
VOLUME = Grid((0.0, 0.0, 0.0), 1.0, N)


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


def places_of(reflectors: np.ndarray) -> np.ndarray:
    """Of surfaces that lie on the sides of their cells that they face away from: [z][y][x][3]."""
    shares = np.concatenate([reflectors[..., 0, :], reflectors[..., 1, :2]], axis=-1)
    whole = shares.sum(axis=-1, keepdims=True)
    return -0.5 * (shares @ DIRECTIONS) / np.where(whole > 0.0, whole, 1.0)


def arrived(light: np.ndarray, reflectors: np.ndarray, count: int, moments: np.ndarray | None = None) -> np.ndarray:
    moments = first_moments(light) if moments is None else moments
    return bouncing.irradiance(light, reflectors, count, moments=moments, places=places_of(reflectors))


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
    walls, flux, current, moments = room(albedo), [total_flux(light)[0]], light, first_moments(light)
    for _ in range(3):
        current = bouncing.reflected(walls, arrived(current, walls, 1, moments))
        moments = bouncing.moments_at(current, places_of(walls))
        flux.append(total_flux(current)[0])
        assert 1.0 - 4.0 / (N - 2) * SIDE < flux[-1] / (albedo * flux[-2]) < 1.0
    together = total_flux(bouncing.reflected(walls, arrived(light, walls, 3)))[0]
    assert together == pytest.approx(sum(flux[1:]), rel=1e-9)


def test_nothing_is_reflected_where_nothing_is():
    light = np.zeros((N, N, N, 3, 4))
    light[3, 3, 3] = sh.cosine_lobe([1.0, 0.0, 0.0])
    assert not arrived(light, np.zeros((N, N, N, 3, 4)), 2).any()
    black = facing(N, (slice(9, 10), slice(0, N), slice(0, N)), 1, 1.0, (0.0, 0.0, 0.0))
    assert not bouncing.reflected(black, arrived(light, black, 1)).any()


def test_even_irradiance_is_reflected_alike_in_all_windows():
    """Each window's surfaces send back share, albedo and area of what arrives, whatever their cell size, and whether a
    finer window is there or not."""
    windows = cascades.place_windows(N, 3, VOLUME, [7.0, 9.0, 8.0], [0.6, 0.0, 0.8])
    walls = [np.zeros((N, N, N, 3, 4)) for _ in windows]
    for own in walls:
        own[..., 0, 3], own[..., 2, :3] = 0.5, (0.3, 0.6, 0.9)
    found = bouncing.injected_bounces(np.full((N, N, N, 6, 3), 2.0), np.ones((N, N, N), bool), walls, windows)
    for light, window in zip(found, windows, strict=True):
        area = N**3 * (window.size / windows[-1].size) ** 2
        np.testing.assert_allclose(total_flux(light), area * 2.0 * 0.5 * np.array([0.3, 0.6, 0.9]), rtol=1e-12)


def bounced_in_the_last(position, vpls, surfels) -> tuple[np.ndarray, np.ndarray]:
    """What the last of three windows around a camera has of two bounces, and the moments of that and of all it had."""
    windows = cascades.place_windows(N, 3, VOLUME, position, [0.0, 0.0, 0.0])
    light, placed = (of_windows[2] for of_windows in vpls_in(windows, VOLUME, vpls))
    albedo = np.full((len(surfels[0]), 3), 0.5)
    walls = [merge_reflectors([inject_reflectors(*surfels, albedo, grid, 0.5)])
             for grid in cascades.grids_of(windows, VOLUME)]  # fmt: skip
    places = inject_places(*surfels, VOLUME, 0.5)
    found = bouncing.irradiance(light, walls[2], 2, moments=first_moments(light, placed=placed), places=places)
    marked = walls[2][..., :2, :].sum(axis=(-1, -2)) > 0.0
    bounced = bouncing.injected_bounces(found, marked, walls, windows)[2]
    return bounced, first_moments(light, size=4.0, placed=placed) + bouncing.moments_at(bounced, places, size=4.0)


def test_bounces_do_not_depend_on_where_finer_windows_lie():
    """The last window's cells have the same light and moments."""
    rng = np.random.default_rng(2)
    normal, place = rng.normal(size=(2, 600, 3)), N * rng.random((2, 600, 3))
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    vpls = place[0], normal[0], rng.uniform(0.1, 1.0, (600, 3))
    surfels = place[1], normal[1], rng.uniform(0.1, 0.5, 600)
    one, other = (bounced_in_the_last(p, vpls, surfels) for p in ([3.0, 4.0, 5.0], [12.0, 9.0, 11.0]))
    np.testing.assert_array_equal(one[0], other[0])
    np.testing.assert_array_equal(one[1], other[1])
    assert np.count_nonzero(one[0][..., 0, 0]) > 300
