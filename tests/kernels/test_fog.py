"""Fog on the device against closed forms and the float64 march of simulator/fog.py."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from fog_tools import (
    BOX,
    EYE,
    FLOAT,
    HAZE,
    HIGH,
    LAMP,
    LOW,
    PLACES,
    SPOT,
    SUN,
    even_volume,
    expected,
    rays,
    relative,
    render,
    shaded,
    wall,
)  # fmt: skip

from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.medium import Medium
from octolux.simulator import fog


@pytest.mark.parametrize("resolution", [1, 2, 4])
@pytest.mark.parametrize("cell", [0.05, 0.5, 20.0])
def test_even_light_is_exact_whatever_the_steps(device, resolution, cell):
    """L = albedo / (4 pi) * F * (1 - T), T = e^(-x l), of each pixel's own path l."""
    picture = render(device, wall(), volume=even_volume(5.0, cell), fog_resolution=resolution)
    origins, directions, distance = rays(picture)
    first, last = fog.span(origins, directions, BOX)
    length = np.maximum(np.minimum(last, distance) - first, 0)[..., None]
    passed = np.exp(-HAZE.extinction * length)
    albedo = np.array(HAZE.scattering) / HAZE.extinction
    assert length.min() > 3.0
    assert relative(picture.layers["transmittance"], passed) < FLOAT
    assert relative(picture.layers["fog"], albedo / (4 * pi) * 5.0 * (1 - passed)) < FLOAT
    np.testing.assert_array_equal(picture.radiance, picture.layers["fog"])  # before a black wall


def test_fog_step_is_in_cells(device):
    """More cells a step, fewer steps; the light is the same."""
    coarse, fine = (render(device, wall(), volume=even_volume(5.0), fog_step=s).layers["fog"] for s in (3.0, 0.5))
    assert relative(coarse, fine) < FLOAT


@pytest.mark.parametrize("lights", [[SUN], [LAMP, SPOT]], ids=["sun", "lamps"])
def test_light_of_lamps_does_not_depend_on_the_steps(device, lights):
    """Steps of 0.1 and of 0.4 m: as above, but the fluence changes along the path."""
    volumes = (even_volume(0.0, cell) for cell in (0.1, 0.4))
    fine, coarse = (render(device, wall(), HAZE, lights, volume, size=(192, 128)) for volume in volumes)
    found, wanted = coarse.layers["fog"].astype(np.float64), fine.layers["fog"].astype(np.float64)
    assert abs(found.mean() / wanted.mean() - 1.0) < 0.02
    assert np.abs(found - wanted).mean() < 0.02 * wanted.mean()


def test_a_furnace_stays_as_it_is(device):
    """Nothing absorbs, radiance is 2 everywhere: the sky behind, and 8 pi of fluence. Seen is 2."""
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    medium = Medium(scattering=(0.05, 0.3, 2.0), low=LOW, high=HIGH)
    picture = render(device, scene, medium, volume=even_volume(8 * pi), sky_lights=0)
    sky = ~picture.mask
    assert sky.any() and picture.mask.any()
    assert np.abs(picture.radiance[sky] / 2.0 - 1.0).max() < FLOAT
    assert np.all(picture.radiance[picture.mask] <= 2.0)


def test_the_sky_lights_a_thin_medium_as_a_furnace(device):
    """All lights of the sky are asked: in air so thin that none is lost on the way, fog has the sky's own radiance."""
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    medium = Medium(scattering=(1e-5,) * 3, low=LOW, high=HIGH)
    picture = render(device, scene, medium, sky_lights=40)
    origins, directions, distance = rays(picture)
    first, last = fog.span(origins, directions, BOX)
    length = np.minimum(last, distance) - first
    # The square hides some lights behind it from some points.
    away = np.abs(origins + directions * np.where(np.isfinite(distance), distance, 0)[..., None])[..., 0] > 3
    source = picture.layers["fog"][..., 0] / (1e-5 * length)
    clear = ~picture.mask & ~away
    assert source.max() <= 2.0 * (1 + 1e-3), "more than the sky has"
    assert np.median(source[clear]) > 2.0 * (1 - 0.03)


@pytest.mark.parametrize("scattering", [0.1, 1.0, 30.0])
def test_no_light_is_made(device, scattering):
    """Of an even sky through a medium that only scatters: never more than the sky, and less the denser it is, as what
    is scattered twice is lost."""
    scene = replace(wall(half=0.5), environment=Environment((2.0, 2.0, 2.0)))
    picture = render(device, scene, Medium(scattering=(scattering,) * 3, low=LOW, high=HIGH), sky_lights=40)
    assert picture.radiance.max() <= 2.0 * (1 + FLOAT)
    assert np.all(picture.layers["fog"] + 2.0 * picture.layers["transmittance"] <= 2.0 * (1 + FLOAT))


@pytest.mark.parametrize("resolution", [1, 2])
def test_a_sun_that_the_medium_dims(device, resolution):
    """L = s E / (4 pi) e^(-x (top - y)) (1 - e^(-r l)) / r, with r = x (1 - dy) and y where the path begins."""
    picture = render(device, wall(), lights=[SUN], fog_resolution=resolution, size=(192, 128))
    origins, directions, distance = rays(picture)
    first, last = fog.span(origins, directions, BOX)
    length = np.maximum(np.minimum(last, distance) - first, 0)[..., None]
    start = origins + first[..., None] * directions
    x, e = HAZE.extinction, np.array(SUN.illuminance)
    rate = x * (1 - directions[..., 1:2])
    top = np.exp(-x * (HIGH[1] - start[..., 1:2]))
    wanted = np.array(HAZE.scattering) / (4 * pi) * e * top * (1 - np.exp(-rate * length)) / rate
    assert relative(picture.layers["fog"], wanted) < 0.02


@pytest.mark.parametrize("resolution", [1, 2])
@pytest.mark.parametrize("lights", [[SUN], [LAMP], [SPOT], [SUN, LAMP, SPOT]], ids=["sun", "lamp", "spot", "all"])
def test_lights_against_float64(device, lights, resolution):
    picture = render(device, wall(), lights=lights, fog_resolution=resolution, size=(384, 256))
    wanted, passed = expected(picture, HAZE, fog.of_lights(lights, HAZE, BOX))
    assert relative(picture.layers["transmittance"][PLACES], passed) < FLOAT
    found = picture.layers["fog"].astype(np.float64)[PLACES]
    assert abs(found.mean() / wanted.mean() - 1.0) < 0.02
    # Near a lamp light is as 1 / angle, whose second derivative is 2 / angle^2 of it; the filter, which spreads texels
    # with a variance of 1.5 along either axis, errs there by 1.5 (texel / angle)^2: by 2 % at 9 texels. A cone's rim,
    # which has no second derivative, is left to the means.
    if SPOT not in lights:
        texel = resolution * 2 * np.tan(0.5 * EYE.vertical_fov) / 256
        to_lamp = np.array(LAMP.position) - EYE.position
        cosine = rays(picture)[1][PLACES] @ (to_lamp / np.linalg.norm(to_lamp))
        far = np.arccos(np.clip(cosine, -1, 1)) > 9 * texel
        assert far.sum() > 0.9 * far.size
        assert relative(found[far], wanted[far]) < 0.02


@pytest.mark.parametrize("resolution", [1, 2])
def test_shafts_of_light(device, resolution):
    """Half of the medium is in shadow, and lines of sight cross the edge."""
    eye = Camera.look_at((1.5, 0.0, 2.0), (1.5, 0.0, 0.0))
    scene, sizes = replace(shaded(), cameras=[eye]), {"size": (384, 256), "shadow_resolution": 2048}
    picture = render(device, scene, lights=[SUN], fog_resolution=resolution, **sizes)
    lit = fog.of_lights([SUN], HAZE, BOX)
    wanted, _ = expected(picture, HAZE, lambda p: lit(p) * (p[..., :1] > 0), eye, steps=4096)
    whole, _ = expected(picture, HAZE, lit, eye)
    found = picture.layers["fog"][PLACES]
    assert np.abs(found - wanted).max() < 0.02 * whole.max()
