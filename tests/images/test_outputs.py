"""What a picture gives for display: 8 and 16 bits, tone maps, and the cutout without its surroundings."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.daylight import sky
from octolux.scene.environment import Environment
from octolux.scene.errors import OctoluxError
from octolux.scene.lights import PointLight
from octolux.scene.materials import Material
from octolux.simulator import tonemap

SLANTED = quad([(-0.6, -0.7, 0), (0.7, -0.5, 0), (0.5, 0.6, 0), (-0.5, 0.4, 0)])
WALL = quad([(-2, -2, 0), (2, -2, 0), (2, 2, 0), (-2, 2, 0)])
BLACK = Material(base_color=(0, 0, 0), specular=0.0)
LAMP = PointLight(position=(0.5, 0.5, 0.6), intensity=(4.0, 2.0, 0.5))


def render(device, scene, **rest):
    rest = {"size": (40, 40), "default_light": False, "exposure": 0.0, **rest}
    settings = small_settings(sky_lights=0, emitter_lights=0)
    return Renderer(scene, "none", device=device, frame_settings=settings, **rest).render(front_camera(2.5))


@pytest.mark.parametrize("tone_map", tonemap.TONE_MAPS)
@pytest.mark.parametrize("samples", [1, 4])
def test_display_is_the_simulators_to_a_step(device, tone_map, samples):
    """From dark to ten times white. The device rounds a float32 signal to 8 bits: at most one step apart, and only near
    the middle between two. 16 bits say the same more finely."""
    scene = scene_of([WALL], [Material(specular=0.0)], lights=[LAMP])
    picture = render(device, scene, tone_map=tone_map, anti_aliasing=samples)
    exact = tonemap.signal(picture.radiance, 0.0, tone_map) * 255
    assert picture.radiance.max() > 1.2 and exact.min() < 60
    assert (picture.display[..., 3] == 255).all() and picture.tone_map == tone_map
    # AgX's polynomial magnifies roundings, see tests/kernels; 8 bits have 255 steps.
    assert np.abs(picture.display[..., :3] - exact).max() <= 0.5 + 255 * 2e-4
    fine = picture.display16()
    assert fine.dtype == np.uint16 and (fine[..., 3] == 65535).all()
    assert np.abs(fine[..., :3] / 257.0 - exact).max() <= 0.5 / 257 + 1e-9
    assert np.abs(fine[..., :3] / 257.0 - picture.display[..., :3]).max() <= 0.5 + 0.5 / 257 + 255 * 2e-4


def test_tone_maps_differ_and_leave_radiance_alone(device):
    scene = scene_of([WALL], [Material(specular=0.0)], lights=[LAMP])
    pictures = [render(device, scene, tone_map=name, size=(12, 12)) for name in tonemap.TONE_MAPS]
    assert all(np.array_equal(p.radiance, pictures[0].radiance) for p in pictures)
    assert len({p.display.tobytes() for p in pictures}) == len(pictures)
    with pytest.raises(OctoluxError, match="no tone map 'filmic'"):
        render(device, scene, tone_map="filmic")


@pytest.mark.parametrize("bits", [8, 16])
@pytest.mark.parametrize("samples", [1, 8])
def test_a_black_shape_before_a_bright_sky_stays_black(device, samples, bits):
    """Also at its edges, whose alpha says how much of the pixel it covers; what it covers nothing of is black, too."""
    picture = render(device, scene_of([SLANTED], [BLACK], environment=Environment((5e3, 4e3, 3e3))),
                     anti_aliasing=samples, exposure=12.0)  # fmt: skip
    cut = picture.cutout(bits)
    top = 2**bits - 1
    assert cut.dtype == (np.uint8 if bits == 8 else np.uint16)
    assert np.array_equal(cut[..., 3], np.floor(picture.alpha * top + 0.5))
    assert (((picture.alpha > 0) & (picture.alpha < 1)).sum() > 20) == (samples > 1)
    # Of 8 sums of 5000 nits, about white at EV 12, 8 roundings stay over an alpha of an eighth: 4e-6 of white, of which
    # the foot of the neutral curve, 6.25 x^2, makes nothing.
    assert not cut[..., :3].any()
    assert picture.display[picture.alpha == 0][:, :3].min() > 150


def test_edges_before_a_map(device):
    """What a map shows behind an edge is taken from the pixel's centre: off by no more than the sky changes from there
    to the next pixel, times what the division by alpha magnifies, (1 - alpha) / alpha."""
    picture = render(device, scene_of([SLANTED], [BLACK], environment=sky()), anti_aliasing=8, exposure=12.0)
    behind = render(device, scene_of([], environment=sky()), exposure=12.0).radiance
    change = sum(np.abs(np.gradient(behind, axis=axis)) for axis in (0, 1))
    edge = (picture.alpha > 0) & (picture.alpha < 1)
    alpha = picture.alpha[edge][:, None]
    # One pixel's change each way, as samples lie within half a pixel, and twice that for a bend in the map.
    worst = change[edge] * (1 - alpha) / alpha
    allowed = tonemap.signal(worst, 12.0) * 255 + 1
    assert (picture.cutout()[edge][:, :3] <= allowed).all()
    assert not picture.cutout()[picture.alpha == 0].any()


def test_a_cutout_over_its_surroundings_is_the_picture(device):
    """Radiance is a mean of samples, so that the cutout over the sky gives the picture again, before the tone map."""
    scene = scene_of([SLANTED], [Material(specular=0.0)], lights=[LAMP], environment=Environment((0.3, 0.2, 0.1)))
    picture = render(device, scene, anti_aliasing=8, tone_map="none")
    cut = picture.cutout(16) / 65535.0
    under = tonemap.srgb_decode(cut[..., :3]) * 1.2
    alpha = picture.alpha[..., None]
    rebuilt = np.minimum(under, 1.2) * alpha + np.array([0.3, 0.2, 0.1]) * (1 - alpha)
    darker = picture.radiance.max(axis=-1) < 0.15  # what is cut at white cannot be rebuilt, nor its edges
    sure = darker | (picture.alpha == 0)
    # A step of 16 bits is at most 2.2 / 65535 in linear light (the slope of sRGB's decoding), times 1.2.
    np.testing.assert_allclose(picture.radiance[sure], rebuilt[sure], atol=2.5 / 65535 * 1.2)
    assert (picture.alpha[sure] > 0).any() or (picture.alpha == 1).any()


def test_a_transparent_picture_holds_no_surroundings(device):
    """A black object before the sky is black to its edges, and lit as it was with the sky in view."""
    scene = scene_of([SLANTED], [BLACK], environment=sky())
    renderer = Renderer(scene, "none", size=(32, 24), device=device, anti_aliasing=8, exposure=12.0, transparent=True)
    black = renderer.render(front_camera())
    assert not black.radiance.any() and not black.cutout()[..., :3].any()
    assert 0 < black.alpha.min() + black.alpha.mean() < 2 and (black.alpha > 0).any() and (black.alpha < 1).any()
    renderer.scene.materials[0] = Material(specular=0.0)
    whole = Renderer(renderer.scene, "none", size=(32, 24), device=device, anti_aliasing=8, exposure=12.0)
    lit, behind = renderer.render(front_camera()), whole.render(front_camera())
    inside = lit.alpha == 1
    assert np.array_equal(lit.radiance[inside], behind.radiance[inside]) and lit.radiance[inside].max() > 0
