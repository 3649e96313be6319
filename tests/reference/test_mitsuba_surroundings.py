"""The surroundings as the exporter writes them, and cameras, against octolux's own pictures of them."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from gpu_tools import scene_of
from mitsuba_tools import Witness

from octolux.export.mitsuba_lights import envmap_pixels
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.simulator import environment
from octolux.simulator.camera import pixel_rays

# A quad far below the camera: octolux wants a scene with triangles for its bounds, no picture shows it.
FAR_AWAY = quad([(-1, -50, 1), (1, -50, 1), (1, -50, -1), (-1, -50, -1)])
SIZE = (64, 48)


def map_of(height: int, width: int) -> np.ndarray:
    return np.random.default_rng(4).uniform(0.1, 2.0, (height, width, 3)).astype(np.float32)


def camera(degrees: float, pitch: float, **rest) -> Camera:
    turn, tilt = np.radians(degrees), np.radians(pitch)
    target = (np.sin(turn) * np.cos(tilt), np.sin(tilt), -np.cos(turn) * np.cos(tilt))
    return Camera.look_at((0.0, 0.0, 0.0), target, vertical_fov=1.2, **rest)


@pytest.mark.parametrize(
    ("degrees", "pitch", "rotation"), [(0, 0, 0.0), (100, 20, 0.0), (-60, -35, 0.7), (180, 60, -2.0)]
)
def test_background(degrees, pitch, rotation, device):
    """An image, a constant and a rotation: the same radiance through every pixel's centre. float32 places a direction
    to some 2^-22 of a turn; neighbouring texels differ by 1.9 at most and 32 lie in a turn: 32 * 1.9 * 2^-22 = 1.5e-5;
    Mitsuba's own arc functions take a few ulps more. Those of graphics cards may be 4096 ulps off (Vulkan, "Precision
    and Operation of SPIR-V Instructions"): 4096 * 2^-24 * pi * 16 / pi * 1.9 = 0.0074 along each axis."""
    surroundings = Environment((0.05, 0.1, 0.2), map_of(16, 32), rotation)
    scene = scene_of([FAR_AWAY], environment=surroundings)
    view = camera(degrees, pitch)
    seen = Witness(scene, view, SIZE).at_centres()
    exact = environment.radiance(surroundings, pixel_rays(view, *SIZE)[1])
    assert np.abs(seen - exact).max() < 1e-4
    picture = Renderer(scene, "none", size=SIZE, device=device).render(view)
    assert np.abs(seen - picture.radiance).max() < 2 * 0.0074


def test_constant():
    scene = scene_of([FAR_AWAY], environment=Environment((0.5, 1.0, 2.0)))
    assert np.allclose(Witness(scene, camera(0, 0), SIZE).at_centres(), (0.5, 1.0, 2.0), rtol=1e-6)


def test_written_map_is_the_same_map():
    """Between its rows, from pole to pole, Mitsuba's map is linear as ours is."""
    source = Environment(image=map_of(4, 8))
    pixels = envmap_pixels(source)
    assert pixels.shape == (9, 8, 3)
    height = np.linspace(0.0, 1.0, 50)
    place = height * 8
    row, part = np.minimum(place.astype(int), 7), place - np.minimum(place.astype(int), 7)
    column = 3
    found = pixels[row, column] * (1 - part[:, None]) + pixels[row + 1, column] * part[:, None]
    azimuth = (column + 0.5) / 8 * 2 * pi - pi
    across = np.sin(height * pi) + 1e-9
    directions = np.stack([across * np.sin(azimuth), np.cos(height * pi), -across * np.cos(azimuth)], axis=-1)
    assert np.allclose(found, environment.sampled(source, directions), atol=1e-6)


def test_irradiance(device):
    """The map lights a plane with the irradiance of the simulator: what it shows and what it sends are one."""
    surroundings = Environment(image=map_of(8, 16), rotation=0.4)
    floor = quad([(-1, 0, 1), (1, 0, 1), (1, 0, -1), (-1, 0, -1)])
    view = Camera.look_at((0.0, 1.0, 0.0), (0.0, 0.0, 0.0), up=(0, 0, -1), vertical_fov=0.2)
    batches = Witness(scene_of([floor], environment=surroundings), view, (8, 8)).batches(4096, paths="direct")
    # Of a finer map, so that the sum over texels is the integral: 256 rows leave some 1e-4.
    fine = environment.sampled(surroundings, environment.texel_directions(256, 512))
    up = environment.texel_directions(256, 512)[..., 1].clip(min=0.0) * environment.texel_solid_angles(256, 512)
    expected = (fine * up[..., None]).sum(axis=(0, 1)) / pi
    means = batches.mean(axis=(1, 2))
    error = means.std(axis=0, ddof=1) / np.sqrt(len(means))
    assert np.all(np.abs(means.mean(axis=0) - expected) < 5.0 * error + 2e-4 * expected)
    assert np.all(error < 5e-3 * expected)
