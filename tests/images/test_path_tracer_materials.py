"""What the path tracer does with masks, blending, sides, unlit materials, vertex colours, textures and normal maps."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from gpu_tools import scene_of
from path_tracing import ABOVE, WHITE, Tracer, assert_mean, ceiling, floor, floor_scene, luminance

from octolux.scene.builtin.shapes import quads
from octolux.scene.cameras import Camera
from octolux.scene.environment import Environment
from octolux.scene.lights import DirectionalLight
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.scene import Scene

SUN = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(pi, pi, pi))
LIT = 0.8  # of a white floor under SUN
BELOW = Camera.look_at((0.0, 0.4, 0.0), (0.0, 0.0, 0.0), up=(0.0, 0.0, -1.0), orthographic_height=2.0)
"""Under what lies at y = 0.5."""
BLACK = Material(base_color=(0, 0, 0), specular=0.0)


@pytest.fixture(scope="module")
def trace(device) -> Tracer:
    return Tracer(device)


def sheet(y: float = 0.5, material: int = 1, size: float = 2.0):
    """Faces up; its picture's left half lies at x < 0."""
    s = 0.5 * size
    corners = [(-s, y, s), (s, y, s), (s, y, -s), (-s, y, -s)]
    return quads([corners], uvs=[[(0, 1), (1, 1), (1, 0), (0, 0)]], material=material)


def halves(left, right, size: int = 64) -> Texture:
    pixels = np.empty((size, size, 4), np.uint8)
    pixels[:, : size // 2], pixels[:, size // 2 :] = left, right
    return Texture(Image(pixels), wrap=("clamp_to_edge", "clamp_to_edge"))


@pytest.mark.parametrize("camera", [BELOW, ABOVE], ids=["its shadow", "seen"])
def test_mask(trace, camera):
    """Light and sight go through the hole, to the pixel: the texture's ramp crosses the cutoff in the middle."""
    texture = halves((255, 255, 255, 0), (255, 255, 255, 255))
    leaf = replace(BLACK, alpha_mode="mask", base_color_texture=texture, double_sided=True)
    picture = trace(floor_scene(sheet(), materials=(WHITE, leaf), lights=[SUN]), camera, pixel="centre", samples=4)
    radiance = picture.layers["direct"][..., 0]
    np.testing.assert_allclose(radiance[:, :8], LIT, rtol=1e-5)
    assert not radiance[:, 8:].any()


@pytest.mark.parametrize("alpha", [0.0, 0.3, 1.0])
@pytest.mark.parametrize("camera", [BELOW, ABOVE], ids=["its shadow", "seen"])
def test_blended(trace, alpha, camera):
    """Alpha 0.3 lets 0.7 of the light through: seen from above, of what goes down and of what comes back."""
    veil = replace(BLACK, alpha_mode="blend", alpha=alpha, double_sided=True)
    scene = floor_scene(sheet(), materials=(WHITE, veil), lights=[SUN])
    picture = trace(scene, camera, samples=256, paths="direct")
    share = 1 - alpha if camera is BELOW else (1 - alpha) ** 2
    assert_mean(picture, LIT * share)
    if alpha in (0.0, 1.0):
        np.testing.assert_allclose(picture.radiance, LIT * share, rtol=1e-5)


def test_two_veils(trace):
    """Independent of each other: 0.7 of 0.7."""
    veil = replace(BLACK, alpha_mode="blend", alpha=0.3, double_sided=True)
    scene = floor_scene(sheet(), sheet(0.6), materials=(WHITE, veil), lights=[SUN])
    assert_mean(trace(scene, BELOW, samples=256, paths="direct"), LIT * 0.7**2)


def test_reflected_rays_meet_veils_too(trace):
    """An even sky over a veil: its light comes through to the floor for 0.7 of the rays."""
    veil = replace(BLACK, alpha_mode="blend", alpha=0.3, double_sided=True)
    scene = floor_scene(sheet(size=200.0), materials=(WHITE, veil), environment=Environment((1.0, 1.0, 1.0)))
    # Beyond the veil's edge at 100 m stands (0.1 / 100)^2 of the sky; the floor is 4 m wide.
    assert_mean(trace(scene, BELOW, samples=256, paths="direct"), LIT * 0.7, rounding=1e-4)


@pytest.mark.parametrize("double_sided", [False, True])
def test_sides(trace, double_sided):
    """The camera sees through the back of a single-sided surface; light does not. Both sides reflect."""
    lid = replace(WHITE, base_color=(0.5, 0.5, 0.5), double_sided=double_sided)
    lamp = replace(SUN, direction=(0.0, 1.0, 0.0))
    from_below = trace(floor_scene(sheet(), materials=(WHITE, lid), lights=[SUN]), BELOW, samples=4, paths="direct")
    assert not from_below.radiance.any()
    upward = Camera.look_at((0, 0.4, 0), (0, 1, 0), up=(0, 0, 1), orthographic_height=1.0)
    scene = Scene(meshes=[sheet(material=0)], instances=scene_of([sheet()]).instances, materials=[lid], lights=[lamp],
                  environment=Environment((0.0, 0.0, 0.25)), exposure=0.0)  # fmt: skip
    picture = trace(scene, upward, samples=64, paths="direct")
    if double_sided:
        assert np.all(picture.alpha == 1)
        assert_mean(picture, np.array([0.5, 0.5, 0.5 + 0.5 * 0.25]))
    else:
        assert not picture.alpha.any()
        np.testing.assert_allclose(picture.radiance, np.broadcast_to([0, 0, 0.25], (16, 16, 3)), rtol=1e-5)


@pytest.mark.parametrize("exposure", [-2.0, 5.0])
def test_unlit(device, exposure):
    """Shown in its base colour at any exposure; it blocks light, reflects and emits none."""
    sign = Material(base_color=(0.25, 0.5, 0.75), unlit=True, double_sided=True)
    scene = floor_scene(sheet(size=1.0), materials=(WHITE, sign), lights=[SUN])
    scene.exposure = exposure
    trace = Tracer(device)
    picture = trace(scene, ABOVE, samples=4, pixel="centre")
    trace.renderer.exposure = exposure
    picture = trace(scene, ABOVE, samples=4, pixel="centre")
    seen = picture.layers["object_id"] == 2
    assert 0.2 < seen.mean() < 0.3
    shown = picture.radiance[seen] / (1.2 * 2.0**exposure)
    np.testing.assert_allclose(shown, np.broadcast_to([0.25, 0.5, 0.75], shown.shape), rtol=1e-5)
    under = trace(scene, BELOW, samples=4, pixel="centre")
    assert not under.radiance[4:12, 4:12].any()
    np.testing.assert_allclose(under.radiance[0], LIT, rtol=1e-5)


def test_vertex_colours(trace):
    """They multiply the base colour: left red, right green, even between."""
    mesh = floor(2.0)
    colors = np.where(mesh.positions[:, :1] < 0, [[1.0, 0, 0, 1]], [[0.0, 1, 0, 1]]).astype(np.float32)
    scene = scene_of([replace(mesh, colors=colors)], [WHITE], lights=[SUN])
    picture = trace(scene, samples=4, pixel="centre")
    x = (np.arange(16) + 0.5) / 16
    expected = np.stack([LIT * (1 - x), LIT * x, 0 * x], axis=-1)
    np.testing.assert_allclose(picture.radiance, np.broadcast_to(expected, (16, 16, 3)), rtol=1e-3, atol=1e-5)


def test_base_colour_texture(trace):
    """Of the seen surface and of what it reflects: half the ceiling is red."""
    half = replace(BLACK, base_color=(1, 1, 1), base_color_texture=halves((255, 0, 0, 255), (0, 0, 0, 255)))
    scene = floor_scene(materials=(half,), lights=[SUN])
    scene.meshes = [sheet(0.0, material=0)]
    picture = trace(scene, samples=4, pixel="centre")
    np.testing.assert_allclose(picture.radiance[:, :7], np.broadcast_to([1.0, 0, 0], (16, 7, 3)), rtol=1e-5, atol=1e-6)
    assert not picture.radiance[:, 9:].any()


def test_normal_map(trace):
    """A map that leans to +u: lit as the leaning surface, cos of the angle to the sun."""
    lean = np.array([0.6, 0.0, 0.8])
    pixels = np.full((4, 4, 4), 255, np.uint8)
    pixels[..., :3] = np.round((lean * 0.5 + 0.5) * 255)
    told = pixels[0, 0, :3] / 255 * 2 - 1
    told /= np.linalg.norm(told)
    material = replace(WHITE, normal_texture=Texture(Image(pixels)))
    sun = DirectionalLight(direction=(-0.5, -1.0, -0.2), illuminance=(pi, pi, pi))
    picture = trace(scene_of([sheet(0.0, material=0)], [material], lights=[sun]), samples=4, pixel="centre")
    normal = np.array([told[0], told[2], -told[1]])  # u along +x, v towards +z, so that the bitangent is -z
    towards = np.array([0.5, 1.0, 0.2]) / np.linalg.norm([0.5, 1.0, 0.2])
    np.testing.assert_allclose(picture.radiance, LIT * (normal @ towards), rtol=2e-3)  # of tangents in 16 bits
    below = trace(scene_of([sheet(0.0, material=0)], [material], lights=[replace(sun, direction=(-1, 0.1, 0))]),
                  samples=4, pixel="centre")  # fmt: skip
    assert not below.radiance.any()


def test_textures_of_roughness_and_metal(trace):
    """Left a black-diffuse metal, right a dielectric without specular part: under an even sky, 0.8 of it."""
    texture = halves((0, 255, 255, 255), (0, 255, 0, 255))
    material = Material(base_color=(0.8,) * 3, specular=0.0, metallic=1.0, metallic_roughness_texture=texture)
    scene = scene_of([sheet(0.0, material=0)], [material], environment=Environment((1.0, 1.0, 1.0)))
    picture = trace(scene, pixel="centre")
    right = np.indices((16, 16))[1] > 8
    assert_mean(picture, 0.8, right)
    left = np.indices((16, 16))[1] < 7
    assert luminance(picture.radiance[left]).mean() < 0.6  # a rough metal's lobe loses light between facets
    diffuse = trace(scene, pixel="centre", materials="diffuse")
    assert not diffuse.radiance[left].any()
    assert_mean(diffuse, 0.8, right)


def test_lamp_behind_a_ceiling_with_a_hole(trace):
    """A glowing quadrilateral seen through a mask: shadow rays and reflected rays agree about the hole."""
    texture = halves((255, 255, 255, 0), (255, 255, 255, 255))
    leaf = replace(BLACK, alpha_mode="mask", base_color_texture=texture, double_sided=True)
    glow = Material(base_color=(0, 0, 0), specular=0.0, emissive=(9.0, 9.0, 9.0))
    lamp = ceiling(4.0, material=2, y=1.0)
    masked = trace(floor_scene(sheet(), lamp, materials=(WHITE, leaf, glow)), BELOW, paths="direct", samples=128)
    corners = [(0, 0.5, 1), (1, 0.5, 1), (1, 0.5, -1), (0, 0.5, -1)]
    solid = trace(floor_scene(quads([corners], material=1), lamp, materials=(WHITE, BLACK, glow)), BELOW,
                  paths="direct", samples=128, seed=1)  # fmt: skip
    difference = luminance(masked.radiance).mean() - luminance(solid.radiance).mean()
    error = np.sqrt((masked.noise**2).sum() + (solid.noise**2).sum()) / masked.noise.size
    assert abs(difference) <= 4 * error
    assert luminance(solid.radiance).mean() > 50 * error


@pytest.mark.parametrize("height", [None, 1.5], ids=["perspective", "orthographic"])
def test_textures_are_filtered_at_a_pixels_centre(trace, height):
    """As the G-buffer has it, but for what a sampler may round: 8 bits of a place in a texel and of a mip level."""
    pixels = np.random.default_rng(3).integers(0, 256, (64, 64, 4), np.uint8)
    pixels[..., 3] = 255
    material = Material(base_color_texture=Texture(Image(pixels)), specular=0.0)
    scene = scene_of([sheet(0.0, material=0)], [material], lights=[SUN])
    camera = Camera.look_at((0.9, 1.0, 1.1), (0.0, 0.0, 0.0), vertical_fov=0.7, orthographic_height=height)
    picture = trace(scene, camera, pixel="centre", samples=1, paths="direct")
    albedo = picture.layers["albedo"]  # under SUN the radiance too
    assert picture.mask.mean() > 0.5
    np.testing.assert_allclose(picture.layers["direct"], albedo, atol=3 / 256)
    texels = trace(scene, camera, pixel="area", samples=1, paths="direct").layers["direct"]
    assert np.abs(texels - albedo)[picture.mask].mean() > 0.1
