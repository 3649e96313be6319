"""Blended materials by stochastic transparency: the mean over samples is the blend of all layers in their order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import run_kernel, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import merge, quad
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import DirectionalLight
from octolux.scene.materials import Material

STRAIGHT = Camera.look_at((0.0, 0.0, 3.0), (0.0, 0.0, 0.0), orthographic_height=2.0)
BLUE = Environment((0.0, 0.0, 1.0))
EDGE = 32
# How far the mean of EDGE^2 independent pixels may lie from what is expected: 5 of its standard deviations, of which
# each is at most 1/2 / EDGE.
MEAN = 5 * 0.5 / EDGE
# Pixels that show one triangle: but for the wall's diagonal, and its rim, where samples may pass it by.
OF_ONE = np.pad(~np.eye(EDGE - 2, dtype=bool)[::-1], 1)


def wall(z: float, material: int = 0, tilt: float = 0.0):
    """Fills the view; with a tilt it comes forward by as much on the right as it goes back on the left."""
    return quad([(-1, -1, z - tilt), (1, -1, z + tilt), (1, 1, z + tilt), (-1, 1, z - tilt)], material=material)


def glowing(color, alpha: float, **rest) -> Material:
    rest = {"alpha_mode": "blend", "double_sided": True, **rest}
    return Material(emissive=color, base_color=(0, 0, 0), specular=0.0, alpha=alpha, **rest)


def render(device, scene, samples=1, camera=STRAIGHT, **settings):
    settings = small_settings(**{"sky_lights": 0, "emitter_lights": 0, **settings})
    renderer = Renderer(scene, "none", size=(EDGE, EDGE), device=device, anti_aliasing=samples, default_light=False,
                        frame_settings=settings)  # fmt: skip
    return renderer.render(camera)


@pytest.mark.parametrize("samples", [2, 7, 16, 64, 1000])
def test_thresholds_are_even_over_the_samples(device, samples):
    """Each surface of each pixel has one threshold in each of `samples` equal parts, in an order of its own."""
    pixels, surfaces = np.arange(40), np.array([1, 2, 500])
    given = np.stack(np.meshgrid(pixels, surfaces, np.arange(samples), indexing="ij"), axis=-1)
    found = run_kernel(device, "hashed_alpha.wgsl", given.reshape(-1, 3), 1, samples=samples)
    found = found.reshape(len(pixels), len(surfaces), samples).astype(np.float64)
    assert found.min() >= 0 and found.max() < 1
    parts = np.sort(found, axis=-1) * samples - np.arange(samples)
    # A part's end may be rounded: of 1000, half a rounding of 2^-24.
    assert parts.min() >= -1e-3 and parts.max() <= 1 + 1e-3
    if samples >= 16:  # layers are independent: 120 pairs of 16 samples or more, 5 standard deviations
        a, b = (found[:, i].ravel() - 0.5 for i in (0, 1))
        assert abs(np.corrcoef(a, b)[0, 1]) < 5 / np.sqrt(len(a))


@pytest.mark.parametrize("samples", [16, 64])
def test_one_layer(device, samples):
    """With a threshold in each of N parts the share of the samples that is kept is alpha, to 1 / N, in every pixel of
    one triangle."""
    picture = render(device, scene_of([wall(0.0)], [glowing((1.0, 0.0, 0.0), 0.3)], environment=BLUE), samples)
    assert np.abs(picture.alpha - 0.3)[OF_ONE].max() <= 1 / samples + 1e-6
    np.testing.assert_allclose(picture.radiance[..., 0], picture.alpha, atol=1e-6)
    np.testing.assert_allclose(picture.radiance[..., 2], 1 - picture.alpha, atol=1e-6)
    assert abs(picture.alpha.mean() - 0.3) <= MEAN / np.sqrt(samples)


def over(*layers) -> np.ndarray:
    """Layers (color, alpha) from front to back, over BLUE (Porter and Duff 1984)."""
    color, left = np.zeros(3), 1.0
    for layer, alpha in layers:
        color, left = color + left * alpha * np.array(layer), left * (1 - alpha)
    return color + left * np.array(BLUE.radiance)


RED, GREEN = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0)


def test_two_layers_in_every_pixel(device):
    """The samples that the front lets through meet the back independently: 256 samples, 6 standard deviations of what
    sampling without replacement leaves, sqrt(a (1 - a) b (1 - b) / (N - 1)), and 1 / N of each layer's own."""
    scene = scene_of([wall(0.0, 1), wall(0.5, 0)], [glowing(RED, 0.5), glowing(GREEN, 0.5)], environment=BLUE)
    picture = render(device, scene, 256)
    error = np.abs(picture.radiance - over((RED, 0.5), (GREEN, 0.5))).max()
    assert error <= 6 * np.sqrt(0.25 * 0.25 / 255) + 2 / 256


def test_crossing_layers(device):
    """Red is in front on the right, green on the left, though green is drawn later: blended in the right order."""
    scene = scene_of([wall(0.0, 0, 0.5), wall(0.0, 1, -0.5)], [glowing(RED, 0.6), glowing(GREEN, 0.3)],
                     environment=BLUE)  # fmt: skip
    left, right = np.split(render(device, scene, 64).radiance, 2, axis=1)
    # Means of half as many pixels, of 64 samples each.
    error = MEAN * np.sqrt(2) / np.sqrt(64)
    np.testing.assert_allclose(right.mean(axis=(0, 1)), over((RED, 0.6), (GREEN, 0.3)), atol=error)
    np.testing.assert_allclose(left.mean(axis=(0, 1)), over((GREEN, 0.3), (RED, 0.6)), atol=error)


def test_layers_of_one_mesh(device):
    """Two walls in one mesh, and so in one cluster, let through what two panes do: (1 - alpha)^2."""
    scene = scene_of([merge([wall(0.5), wall(-0.5)])], [glowing(RED, 0.5)], environment=BLUE)
    picture = render(device, scene, 64)
    np.testing.assert_allclose(picture.radiance.mean(axis=(0, 1)), over((RED, 0.5), (RED, 0.5)), atol=MEAN / 8)


@pytest.mark.parametrize("samples", [1, 16])
@pytest.mark.parametrize("alpha", [0.0, 1.0])
def test_none_and_all_are_exact(device, alpha, samples):
    picture = render(device, scene_of([wall(0.0)], [glowing(RED, alpha)], environment=BLUE), samples)
    assert (picture.alpha == alpha).all()
    assert (picture.radiance == (RED if alpha else BLUE.radiance)).all()


@pytest.mark.parametrize("alpha", [0.2, 0.5, 0.9])
def test_one_sample_keeps_alpha_of_the_pixels(device, alpha):
    """Hashed by the place in space, in cells of one to two pixels, so that a quarter of the pixels are independent."""
    camera = Camera.look_at((0.3, 0.2, 3.0), (0.0, 0.1, 0.0), orthographic_height=1.0)
    scene = scene_of([wall(0.0)], [glowing(RED, alpha)], environment=BLUE)
    first, again = render(device, scene, camera=camera), render(device, scene, camera=camera)
    assert set(np.unique(first.alpha)) == {0.0, 1.0}
    assert abs(first.alpha.mean() - alpha) <= 5 * np.sqrt(alpha * (1 - alpha) / (EDGE**2 / 4))
    assert np.array_equal(first.radiance, again.radiance)  # and stable


def test_many_samples_are_repeatable(device):
    scene = scene_of([wall(0.0)], [glowing(RED, 0.3)], environment=BLUE)
    assert np.array_equal(render(device, scene, 8).radiance, render(device, scene, 8).radiance)


@pytest.mark.parametrize("alpha", [0.3, 0.8])
def test_shadows_let_the_rest_through(device, alpha):
    """A pane before a wall, lit along the view: on average 1 - alpha of the light arrives.

    Of the 64 x 64 texels of the shadow map half across are seen, in cells of one to two: a quarter is independent."""
    light = DirectionalLight(direction=(0.0, 0.0, -1.0), illuminance=(np.pi,) * 3)
    white = Material(specular=0.0)
    pane = glowing((0.0, 0.0, 0.0), alpha)
    behind = Camera.look_at((0.0, 0.0, 0.4), (0.0, 0.0, 0.0), orthographic_height=1.0)  # between pane and wall
    scene = scene_of([wall(0.0, 0), wall(0.5, 1)], [white, pane], lights=[light])
    lit = render(device, scene, camera=behind).radiance[..., 0]
    independent = (64 / 2) ** 2 / 4
    assert abs(lit.mean() - (1 - alpha)) <= 5 * np.sqrt(alpha * (1 - alpha) / independent)
    assert lit.min() == 0.0 and lit.max() == pytest.approx(1.0, abs=1e-4)


def test_alpha_of_vertices(device):
    """Alpha of the vertices takes part: from 0 on the left to 1 on the right."""
    mesh = wall(0.0)
    ramp = np.ones((4, 4), np.float32)
    ramp[:, 3] = (mesh.positions[:, 0] + 1) / 2
    picture = render(device, scene_of([replace(mesh, colors=ramp)], [glowing(RED, 1.0)], environment=BLUE), 64)
    expected = (np.arange(EDGE) + 0.5) / EDGE
    # In each pixel 1 / 64 of the thresholds, and alpha's change across the samples of a pixel, half of 1 / 32 each way.
    assert np.abs(picture.alpha - expected)[OF_ONE].max() <= 1 / 64 + 0.5 / EDGE
