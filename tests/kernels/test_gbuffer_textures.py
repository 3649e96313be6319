"""Textures in the G-buffer: coordinates, wrap modes, mip levels, normal maps, alpha masks; against NumPy."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import front_camera, material_of, scene_of

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quads
from octolux.scene.cameras import Camera
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance
from octolux.simulator.tonemap import srgb_decode

EDGE = 256  # the smallest size class, so that level 0 holds the image as it is
CORNERS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
STRAIGHT = Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), orthographic_height=2.0)


def rgba(red, green=None, blue=None, alpha=255) -> np.ndarray:
    """A uint8 image (EDGE, EDGE, 4) from channels that broadcast."""
    green, blue = (red if c is None else c for c in (green, blue))
    channels = [np.broadcast_to(np.asarray(c), (EDGE, EDGE)) for c in (red, green, blue, alpha)]
    return np.stack(channels, axis=-1).astype(np.uint8)


def render(device, material: Material, uvs, *, size=(64, 64), camera=STRAIGHT, transform=None, corners=CORNERS):
    """A picture of one quad that fills the view, whose corners have texture coordinates `uvs` (4, 2)."""
    instance = Instance(0, np.eye(4) if transform is None else transform)
    scene = scene_of([quads([corners], [uvs])], [material], instances=[instance])
    return Renderer(scene, "none", size=size, device=device).render(camera)


def uv_range(low: float, high: float) -> list:
    """Coordinates from `low` to `high` across the quad, (low, low) at its upper left."""
    return [(low, high), (high, high), (high, low), (low, low)]


def wrapped(index: np.ndarray, mode: str) -> np.ndarray:
    """Texel indices as OpenGL and Vulkan wrap them (Vulkan specification, "Wrapping Operation")."""
    if mode == "clamp_to_edge":
        return np.clip(index, 0, EDGE - 1)
    if mode == "repeat":
        return index % EDGE
    folded = index % (2 * EDGE)
    return np.where(folded < EDGE, folded, 2 * EDGE - 1 - folded)


def bilinear(values: np.ndarray, u, v, modes) -> np.ndarray:
    """`values` (EDGE, EDGE, k) filtered at `u`, `v` (texture coordinates)."""
    x, y = u * EDGE - 0.5, v * EDGE - 0.5
    x0, y0 = np.floor(x).astype(int), np.floor(y).astype(int)
    result = 0.0
    for dx, dy in np.ndindex(2, 2):
        weight = np.abs(1 - dx - (x - x0)) * np.abs(1 - dy - (y - y0))
        result = result + weight[..., None] * values[wrapped(y0 + dy, modes[1]), wrapped(x0 + dx, modes[0])]
    return result


@pytest.mark.parametrize("modes", [
    ("repeat", "repeat"), ("clamp_to_edge", "clamp_to_edge"), ("mirrored_repeat", "mirrored_repeat"),
    ("repeat", "clamp_to_edge"), ("clamp_to_edge", "mirrored_repeat"),
])  # fmt: skip
@pytest.mark.parametrize("corner", [0.0, 1.0, -3.0])
def test_wrap_modes_around_a_corner_of_the_image(device, modes, corner):
    """A random image magnified ten times around texture coordinate `corner`: what lies beyond follows the wrap mode."""
    pixels = np.random.default_rng(3).integers(0, 256, (EDGE, EDGE, 4)).astype(np.uint8)
    reach = 3.2 / EDGE
    material = Material(base_color_texture=Texture(Image(pixels), modes), specular=0.0)
    picture = render(device, material, uv_range(corner - reach, corner + reach))
    across = corner + reach * ((np.arange(64) + 0.5) / 32 - 1)
    u, v = np.meshgrid(across, across)
    expected = bilinear(srgb_decode(pixels[..., :3] / 255.0), u, v, modes)
    # Adapters round the two weights to 1/256; a coordinate of 3 is known to 2.4e-7 of 256 texels.
    assert np.abs(picture.layers["albedo"] - expected).max() <= 2 / 512 + 1e-3


def test_coordinates_are_perspective_correct(device):
    """A ramp of u in roughness and of v in metallic (linear), on a quad seen at a slant."""
    ramp = np.arange(EDGE)
    image = Image(rgba(0, ramp[None, :], ramp[:, None]))
    material = Material(metallic=1.0, metallic_roughness_texture=Texture(image, ("clamp_to_edge",) * 2))
    corners = [(-1, -1, 1.2), (1, -1, 0.4), (1, 1, -1.5), (-1, 1, -0.7)]
    picture = render(device, material, uv_range(0.0, 1.0), camera=front_camera(3.0), size=(96, 64), corners=corners)
    mask = picture.mask
    a, right, up = (np.array(v, float) for v in (corners[3], np.subtract(corners[2], corners[3]),
                                                 np.subtract(corners[0], corners[3])))  # fmt: skip
    uv = np.linalg.lstsq(np.stack([right, up], axis=1), (picture.layers["position"][mask] - a).T.astype(float))[0].T
    inner = np.all(np.abs(uv - 0.5) < 0.45, axis=1)  # mip levels blur the rim
    expected = (uv[inner] * EDGE - 0.5) / (EDGE - 1)
    found = np.stack([material_of(picture)[name][mask][inner] for name in ("roughness", "metallic")], axis=1)
    assert inner.sum() > 500
    # 8-bit output (1/510), and 8-bit texels of higher mip levels, whose ramp is rounded once more (1/510).
    assert np.abs(found - expected).max() <= 2 / 510 + 1e-3


def test_a_far_checker_averages_to_its_mean(device):
    """512 repeats of a black and white checker in 32 pixels: mip maps give the mean in linear light, without noise."""
    checker = rgba(255 * ((np.arange(EDGE)[:, None] // 16 + np.arange(EDGE)[None, :] // 16) % 2))
    material = Material(base_color_texture=Texture(Image(checker)), specular=0.0)
    albedo = render(device, material, uv_range(0.0, 512.0), size=(32, 32)).layers["albedo"]
    # sRGB 8-bit codes near linear 0.5 are 1/113 apart in linear light.
    np.testing.assert_allclose(albedo, 0.5, atol=0.5 / 113 + 1e-3)


@pytest.mark.parametrize("texels_per_pixel", [1, 2, 4, 8, 16])
def test_mip_level_follows_the_footprint(device, texels_per_pixel):
    """Stripes as wide as a pixel's footprint are still seen at half their contrast or more one level below, and stripes
    of half its width, which fit into the footprint twice, are grey."""
    pixels = 32
    repeats = texels_per_pixel * pixels / EDGE
    contrast = {}
    for width in (4 * texels_per_pixel, max(1, texels_per_pixel // 2)):
        stripes = rgba(255 * (np.arange(EDGE)[None, :] // width % 2))
        material = Material(metallic=1.0, metallic_roughness_texture=Texture(Image(stripes)))
        picture = render(device, material, uv_range(0.0, repeats), size=(pixels, pixels))
        contrast[width] = np.ptp(material_of(picture)["roughness"], axis=1).min()
    assert contrast[4 * texels_per_pixel] > 0.9
    if texels_per_pixel > 1:
        assert contrast[texels_per_pixel // 2] < 0.02


def test_size_classes_keep_apart(device):
    """Images of 100 and 600 pixels lie in different arrays; each surface gets its own."""
    small, large = (Image(np.full((n, n, 4), value, np.uint8)) for n, value in ((100, 60), (600, 200)))
    materials = [Material(base_color_texture=Texture(i), specular=0.0) for i in (small, large)]
    halves = [[(-1, -1, 0), (0, -1, 0), (0, 1, 0), (-1, 1, 0)], [(0, -1, 0), (1, -1, 0), (1, 1, 0), (0, 1, 0)]]
    scene = scene_of([quads([h], material=i) for i, h in enumerate(halves)], materials)
    albedo = Renderer(scene, "none", size=(8, 8), device=device).render(STRAIGHT).layers["albedo"]
    # The G-buffer has 16 bits; sRGB decoding in hardware may err by half a code of 8 bits (WebGPU inherits Vulkan's).
    np.testing.assert_allclose(albedo[:, :4], srgb_decode(60 / 255), atol=2e-3)
    np.testing.assert_allclose(albedo[:, 4:], srgb_decode(200 / 255), atol=4e-3)


TILT = np.array([0.48, 0.36, 0.8])


@pytest.mark.parametrize("scale", [1.0, 0.5])
@pytest.mark.parametrize("mirror", [(1, 1), (-1, 1), (1, -1), (-1, -1)], ids=str)
def test_normal_map(device, mirror, scale):
    """A normal map that says TILT everywhere: x along growing u, y to the image's top, z out of the surface (glTF).
    A mirrored instance mirrors what the map shows, too."""
    codes = np.round((TILT * 0.5 + 0.5) * 255)
    material = Material(normal_texture=Texture(Image(rgba(*codes))), normal_scale=scale, double_sided=True)
    transform = np.diag([*mirror, 1.0, 1.0])
    local = codes / 255 * 2 - 1
    local[:2] *= scale
    expected = transform[:3, :3] @ (local / np.linalg.norm(local))  # u runs along +x, the image's top is +y
    normal = render(device, material, uv_range(0.0, 1.0), transform=transform).layers["normal"]
    # Normal and tangent, 6.5e-5 rad each (the tangent loses its lowest bit), and the result once more.
    np.testing.assert_allclose(normal, np.broadcast_to(expected, normal.shape), atol=3e-4)


def test_normal_map_seen_from_behind(device):
    """glTF 2.0, 3.9.2: the back of a double-sided surface has the reversed normal."""
    codes = np.round((TILT * 0.5 + 0.5) * 255)
    material = Material(normal_texture=Texture(Image(rgba(*codes))), double_sided=True)
    behind = Camera.look_at((0.0, 0.0, -2.0), (0.0, 0.0, 0.0), orthographic_height=2.0)
    normal = render(device, material, uv_range(0.0, 1.0), camera=behind).layers["normal"]
    local = codes / 255 * 2 - 1
    np.testing.assert_allclose(normal, np.broadcast_to(-local / np.linalg.norm(local), normal.shape), atol=3e-4)


def test_single_sided_surfaces_have_no_back(device):
    behind = Camera.look_at((0.0, 0.0, -2.0), (0.0, 0.0, 0.0), orthographic_height=2.0)
    for double_sided in (False, True):
        material = Material(double_sided=double_sided)
        mask = render(device, material, uv_range(0.0, 1.0), camera=behind, size=(8, 8)).mask
        assert mask.all() if double_sided else not mask.any()


@pytest.mark.parametrize(("alpha", "cutoff"), [(1.0, 0.5), (0.6, 0.5), (1.0, 0.9)])
def test_alpha_mask(device, alpha, cutoff):
    """A ramp in alpha from left to right: what is below the cutoff is not there."""
    ramp = np.arange(EDGE)
    image = Image(rgba(128, alpha=ramp[None, :]))
    material = Material(
        base_color_texture=Texture(image), alpha=alpha, alpha_mode="mask", alpha_cutoff=cutoff, double_sided=True
    )
    mask = render(device, material, uv_range(0.0, 1.0)).mask
    value = alpha * (((np.arange(64) + 0.5) / 64 * EDGE) - 0.5) / 255
    sure = np.abs(value - cutoff) > 2 / 255  # mip levels are 8 bits
    sure[[0, -1]] = False  # the ramp's two ends meet there
    assert np.array_equal(mask[:, sure], np.broadcast_to(value >= cutoff, (64, 64))[:, sure])
    assert 0 < mask.mean() < 1


def test_opaque_materials_ignore_alpha(device):
    image = Image(rgba(128, alpha=0))
    assert render(device, Material(base_color_texture=Texture(image)), uv_range(0.0, 1.0), size=(8, 8)).mask.all()
