"""Vertex colours, unlit materials and transforms of texture coordinates, in the G-buffer and the picture."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad, quads
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import PointLight
from octolux.scene.materials import Image, Material, Texture
from octolux.simulator import tonemap

CORNERS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
STRAIGHT = Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), orthographic_height=2.0)
LAMP = PointLight(position=(0.0, 0.0, 1.5), intensity=(5.0, 5.0, 5.0))
EDGE = 32


def render(device, scene, technique="none", **rest):
    rest = {"size": (EDGE, EDGE), "default_light": False, "frame_settings": small_settings(sky_lights=0), **rest}
    return Renderer(scene, technique, device=device, **rest).render(STRAIGHT)


def coloured(colors) -> object:
    return replace(quad(CORNERS), colors=np.asarray(colors, np.float32))


def across() -> np.ndarray:
    return (np.arange(EDGE) + 0.5) / EDGE


def test_vertex_colours_are_linear(device):
    """They multiply the base colour; a ramp from 0 on the left to 1 on the right is one in linear light."""
    ramp = [(0, 0.25, 1, 1), (1, 0.25, 0.5, 1), (1, 0.25, 0.5, 1), (0, 0.25, 1, 1)]
    scene = scene_of([coloured(ramp)], [Material(base_color=(1.0, 0.5, 1.0), specular=0.0)])
    found = render(device, scene).layers["albedo"]
    expected = np.stack([across(), np.full(EDGE, 0.125), 1 - across() / 2], axis=-1)
    # Corners hold square roots in 8 bits: an error of at most 2 * 0.5 / 255; the G-buffer has 16 bits.
    np.testing.assert_allclose(found, np.broadcast_to(expected, found.shape), atol=1 / 255 + 1e-4)


def test_dark_vertex_colours_keep_their_steps(device):
    """0.001 in 8 linear bits would be 0: as a square root it is 8 of 255."""
    scene = scene_of([coloured([(0.001, 0.002, 0.004, 1)] * 4)], [Material(specular=0.0)])
    found = render(device, scene).layers["albedo"][5, 5]
    expected = np.array([0.001, 0.002, 0.004])
    assert (np.abs(np.sqrt(found) - np.sqrt(expected)) <= 0.5 / 255 + 1e-4).all()


def test_meshes_without_colours_are_white_beside_those_with(device):
    left = quads([[(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0)]])
    right = quads([[(0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0)]])
    right = replace(right, colors=np.full((4, 4), 0.25, np.float32))
    albedo = render(device, scene_of([left, right], [Material(base_color=(1, 1, 1), specular=0.0)])).layers["albedo"]
    assert (albedo[:, : EDGE // 2] == 1).all()
    np.testing.assert_allclose(albedo[:, EDGE // 2 :], 0.25, atol=1 / 255)


@pytest.mark.parametrize(("alpha", "cutoff"), [(1.0, 0.5), (0.5, 0.25)])
def test_vertex_alpha_in_masks(device, alpha, cutoff):
    """Alpha of the vertices, from 0 to 1, times the material's, against the cutoff; opaque materials ignore it."""
    ramp = [(1, 1, 1, 0), (1, 1, 1, 1), (1, 1, 1, 1), (1, 1, 1, 0)]
    cut = Material(alpha=alpha, alpha_mode="mask", alpha_cutoff=cutoff)
    mask = render(device, scene_of([coloured(ramp)], [cut])).mask
    sure = np.abs(alpha * across() - cutoff) > 1e-3
    assert np.array_equal(mask[:, sure], np.broadcast_to(alpha * across() > cutoff, mask.shape)[:, sure])
    assert render(device, scene_of([coloured(ramp)], [Material()])).mask.all()


@pytest.mark.parametrize("exposure", [-3.0, 0.0, 9.0])
@pytest.mark.parametrize("lights", [[], [LAMP]], ids=["dark", "lit"])
def test_unlit_shows_its_base_colour(device, exposure, lights):
    """Whatever the light and the exposure: that of the material times the vertices', as the tone map shows it."""
    scene = scene_of([coloured([(0.5, 1.0, 1.0, 1.0)] * 4)], [Material(base_color=(0.8, 0.5, 0.2), unlit=True)],
                     lights=lights, environment=Environment((3.0, 3.0, 3.0)))  # fmt: skip
    picture = render(device, scene, exposure=exposure, tone_map="none", frame_settings=small_settings())
    expected = 255 * tonemap.srgb_encode([0.4, 0.5, 0.2])
    # The root of 0.5 in 8 bits is off by up to half a step, 0.3 %, which is less than a step of the display.
    assert np.abs(picture.display[..., :3] - expected).max() <= 1.5
    assert not picture.layers["direct"].any() and not picture.layers["albedo"].any()


def test_unlit_gives_no_indirect_light(device):
    """Beside a lit wall: none of its lamp's light comes back, as from a black one."""
    floor = quad([(-1, -1, 0), (1, -1, 0), (1, -1, 1), (-1, -1, 1)], material=1)
    side = [Material(unlit=True), Material(base_color=(0.0, 0.0, 0.0), specular=0.0)]
    pictures = [
        render(device, scene_of([replace(quad(CORNERS), material=0), replace(floor, material=1)],
                                [m, Material(specular=0.0, double_sided=True)], lights=[LAMP]), "uniform-lpv",
               settings={"n": 16}).layers["irradiance"]
        for m in side
    ]  # fmt: skip
    assert np.array_equal(*pictures)


def noise_image(edge: int = 256) -> Image:
    return Image(np.random.default_rng(7).integers(0, 256, (edge, edge, 4)).astype(np.uint8))


def albedo_of(device, image: Image, uvs: np.ndarray, transform=None) -> np.ndarray:
    texture = Texture(image) if transform is None else Texture(image, transform=transform)
    material = Material(base_color_texture=texture, specular=0.0)
    return render(device, scene_of([quads([CORNERS], [uvs])], [material])).layers["albedo"]


UVS = np.array([(0.1, 0.9), (0.9, 0.9), (0.9, 0.2), (0.1, 0.2)])
ANGLE = 0.5
TRANSFORMS = {
    "moved": (1.0, 0.0, 0.3, 0.0, 1.0, -0.2),
    "scaled by 4": (4.0, 0.0, 0.0, 0.0, 4.0, 0.0),
    "made small": (0.05, 0.0, 0.5, 0.0, 0.05, 0.5),
    "turned": (np.cos(ANGLE), -np.sin(ANGLE), 0.1, np.sin(ANGLE), np.cos(ANGLE), 0.2),
    "mirrored": (-1.0, 0.0, 0.9, 0.0, 1.0, 0.0),
}


@pytest.mark.parametrize("name", TRANSFORMS)
def test_a_transform_is_that_of_the_coordinates(device, name):
    """The same picture as with the vertices' coordinates transformed: place and mip level.

    Coordinates are then rounded elsewhere: 256 texels of 4 repeats by some 2^-22; weights of filters have 8 bits."""
    a, b, c, d, e, f = TRANSFORMS[name]
    image = noise_image()
    moved = np.stack([a * UVS[:, 0] + b * UVS[:, 1] + c, d * UVS[:, 0] + e * UVS[:, 1] + f], axis=-1)
    found, expected = albedo_of(device, image, UVS, TRANSFORMS[name]), albedo_of(device, image, moved)
    assert not np.array_equal(expected, albedo_of(device, image, UVS))
    assert np.abs(found - expected).max() <= 3 / 256


def test_a_stretch_takes_the_coarser_level(device):
    """u stays and v is stretched by 4: the level is right for an even footprint, log2(4) above that of u. Where v
    changes eight times less than u that is two levels too coarse, never too fine (a level of noise halves it)."""
    image, flat = noise_image(), UVS * [1, 1 / 7]
    found = albedo_of(device, image, flat, (1.0, 0.0, 0.0, 0.0, 4.0, 0.0))
    exact = albedo_of(device, image, flat * [1, 4])
    assert 0.15 < found.std() / exact.std() < 0.4


def test_each_texture_has_its_own_transform(device):
    """A ramp in both slots: shown once as it is, and once turned by a quarter, (u, v) -> (v, 1 - u)."""
    ramp = np.arange(256)
    image = Image(np.broadcast_to(ramp[None, :, None], (256, 256, 4)).astype(np.uint8).copy())
    uvs = np.array([(0.1, 0.9), (0.9, 0.9), (0.9, 0.1), (0.1, 0.1)])
    turned = Texture(image, transform=(0.0, 1.0, 0.0, -1.0, 0.0, 1.0))
    material = Material(metallic_roughness_texture=Texture(image), emissive=(1.0, 1.0, 1.0), emissive_texture=turned)
    picture = render(device, scene_of([quads([CORNERS], [uvs])], [material]))
    at = (0.1 + 0.8 * across()) * 256 - 0.5
    roughness = ((picture._surface[..., 3] >> 16) & 255) / 255.0
    np.testing.assert_allclose(roughness, np.broadcast_to(at / 255, roughness.shape), atol=2 / 255)
    glow = tonemap.srgb_encode(picture.layers["emissive"][..., 0])
    np.testing.assert_allclose(glow, np.broadcast_to((at / 255)[:, None], glow.shape), atol=2 / 255)
