"""What Mitsuba sees of an exported scene against octolux's own layers: places, normals, textures and direct light."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import scene_of
from mitsuba_tools import Witness, needs_llvm

from octolux.renderer import Renderer
from octolux.scene.builtin.cornell_box import cornell_box
from octolux.scene.builtin.shapes import box, quad, revolve
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight
from octolux.scene.materials import Image, Material, Texture
from octolux.scene.meshes import Instance, Mesh

SIZE = (64, 48)
FACING = DirectionalLight(direction=(0.0, 0.0, -1.0), illuminance=(np.pi,) * 3)
"""A Lambertian surface that faces it has the radiance of its albedo."""


def eroded(mask: np.ndarray) -> np.ndarray:
    """Pixels whose eight neighbours are in the mask too."""
    padded = np.pad(mask, 1)
    shifts = [padded[i : i + mask.shape[0], j : j + mask.shape[1]] for i in range(3) for j in range(3)]
    return np.logical_and.reduce(shifts)


def smooth(values: np.ndarray, most: float) -> np.ndarray:
    """Where a picture (height, width, 3) changes by at most `most` over a pixel and its neighbours."""
    padded = np.pad(values, ((1, 1), (1, 1), (0, 0)), mode="edge")
    shifts = [padded[i : i + values.shape[0], j : j + values.shape[1]] for i in range(3) for j in range(3)]
    return (np.max(shifts, axis=0) - np.min(shifts, axis=0)).max(axis=-1) <= most


def moved(x: float, y: float, scale: tuple[float, float, float], shear: float = 0.0) -> np.ndarray:
    transform = np.diag([*scale, 1.0])
    transform[0, 1], transform[:2, 3] = shear, (x, y)
    return transform


CAMERAS = {
    "perspective": Camera.look_at((0.8, 1.1, 3.0), (0.0, 0.1, 0.0), vertical_fov=0.65),
    "orthographic": Camera.look_at((0.8, 1.1, 3.0), (0.0, 0.1, 0.0), orthographic_height=2.0),
}


@pytest.mark.parametrize("name", list(CAMERAS))
def test_camera_and_placing(name, device):
    """Positions, normals and coverage of placed, mirrored and sheared instances. float32 leaves some 1e-6 m of
    positions; octolux packs normals twice, each time they turn by up to 6.5e-5 rad. Smooth meshes are scaled evenly:
    else normals are normalised before they are interpolated in Mitsuba, and after it in octolux. The rasteriser moves
    corners by up to 1/256 of a pixel: that many of the pixels on edges, at most a quarter of all here, may see
    something else."""
    angles = np.linspace(-np.pi / 2, np.pi / 2, 17)
    ball = revolve(np.stack([0.4 * np.cos(angles).clip(1e-4), 0.4 * np.sin(angles)], axis=1), segments=24)
    brick = box((-0.4, -0.3, -0.2), (0.4, 0.2, 0.3))
    scene = scene_of([ball, brick], [Material(specular=0.0, double_sided=True)], lights=[FACING])
    scene.instances = [
        Instance(0, moved(-0.6, 0.5, (1.2, 1.2, 1.2))), Instance(1, moved(0.7, 0.4, (-1.0, 1.2, 1.0), shear=0.3)),
        Instance(1, moved(-0.5, -0.5, (1.0, 0.5, 1.0))), Instance(0, moved(0.5, -0.5, (0.9, -0.9, 0.9))),
    ]  # fmt: skip
    layers = Renderer(scene, "none", size=SIZE, device=device).render(CAMERAS[name]).layers
    seen = Witness(scene, CAMERAS[name], SIZE).seen()
    assert 0.2 < seen["mask"].mean() < 0.9
    same = (np.abs(seen["position"] - layers["position"]).max(axis=-1) < 1e-5) & (seen["mask"] == (layers["depth"] > 0))
    same |= ~seen["mask"] & (layers["depth"] == 0)
    assert (~same).mean() < 0.25 * 2 / 256
    both = same & seen["mask"]
    facing = np.sign((seen["normal"] * layers["normal"]).sum(axis=-1, keepdims=True))
    assert np.all(facing[both] > 0)
    assert np.linalg.norm(seen["normal"] - layers["normal"], axis=-1)[both].max() < 1.3e-4 + 1e-6


def test_direct_light_of_the_cornell_box(device):
    """Rasterised with shadow maps and traced: away from the edges of shadows and surfaces the same. Albedo has 16 bits
    of 1, the least is 0.05: 1.5e-4. Normals turn by 6.5e-5 rad: 6.5e-4 of light that comes at a slant of 1 to 10."""
    scene = replace(cornell_box(), tracks=[])
    camera = scene.cameras[0]
    layers = Renderer(scene, "none", size=SIZE, device=device).render(camera).layers
    witness = Witness(scene, camera, SIZE)
    seen, radiance = witness.seen(), witness.at_centres()
    to_light = np.asarray(scene.lights[0].position) - seen["position"]
    cosine = np.abs((to_light * layers["normal"]).sum(axis=-1)) / np.linalg.norm(to_light, axis=-1)
    lit = radiance.max(axis=-1) > 0
    inside = smooth(layers["normal"], 1e-3) & seen["mask"]
    keep = eroded(lit) & inside & (cosine > 0.1)
    dark = eroded(~lit & seen["mask"]) & inside
    assert keep.sum() > 500
    assert dark.sum() > 50
    assert np.abs(layers["direct"] / np.where(lit[..., None], radiance, 1.0) - 1.0)[keep].max() < 1e-3
    assert not layers["direct"][dark].any()


def blocks(seed: int, low: int = 0, alpha: int = 255) -> Image:
    """A picture of 4 x 4 patches of 64 x 64 texels, each of one random colour."""
    colors = np.random.default_rng(seed).integers(low, 256, (4, 4, 4), dtype=np.uint8)
    colors[..., 3] = alpha
    return Image(np.kron(colors, np.ones((64, 64, 1), np.uint8)), f"blocks {seed}")


LARGE = (160, 120)


def wall(**material) -> Mesh:
    """A wall at z = 0 whose texture coordinates reach from -0.7 to 1.6, upright."""
    corners = [(-1, -0.75, 0), (1, -0.75, 0), (1, 0.75, 0), (-1, 0.75, 0)]
    mesh = quad(corners)
    return replace(mesh, uvs=(mesh.positions[:, :2] * (1.15, -1.5) + (0.45, 0.475)).astype(np.float32), **material)


FRONT = Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), vertical_fov=2 * np.arctan(0.75 / 2.0))


@pytest.mark.parametrize(
    ("wrap", "transform", "factor"),
    [
        ("repeat", (1, 0, 0, 0, 1, 0), (1.0, 1.0, 1.0)),
        ("mirrored_repeat", (1, 0, 0, 0, 1, 0), (1.0, 1.0, 1.0)),
        ("clamp_to_edge", (1, 0, 0, 0, 1, 0), (0.5, 0.8, 1.0)),
        ("repeat", (0.6, 0.3, 0.1, -0.2, 0.9, 0.4), (1.0, 1.0, 1.0)),
    ],
)  # fmt: skip
def test_color_textures(wrap, transform, factor, device):
    """Orientation, wrapping, transform, factor and sRGB: inside patches the colour is exact but for octolux's 16 bits
    (and its 8-bit mip levels, a unit of which near white is 0.009)."""
    texture = Texture(blocks(1), (wrap, wrap), tuple(float(x) for x in transform))
    material = Material(specular=0.0, base_color=factor, base_color_texture=texture)
    scene = scene_of([wall()], [material], lights=[FACING])
    albedo = Renderer(scene, "none", size=LARGE, device=device).render(FRONT).layers["albedo"]
    radiance = Witness(scene, FRONT, LARGE).at_centres()
    inside = smooth(albedo, 1e-3)
    assert inside.mean() > 0.2
    assert len(np.unique(np.round(albedo[inside], 3), axis=0)) >= (8 if wrap == "clamp_to_edge" else 14)
    assert np.abs(radiance - albedo)[inside].max() < 0.009


def test_vertex_colors(device):
    """Linear, times the base colour; octolux stores their square roots in 8 bits: a step is 2 / 255."""
    colors = np.random.default_rng(3).uniform(0.1, 1.0, (4, 4)).astype(np.float32)
    scene = scene_of([wall(colors=colors)], [Material(specular=0.0, base_color=(0.5, 0.8, 1.0))], lights=[FACING])
    albedo = Renderer(scene, "none", size=LARGE, device=device).render(FRONT).layers["albedo"]
    assert np.abs(Witness(scene, FRONT, LARGE).at_centres() - albedo).max() < 2 / 255


def test_masks(device):
    """What is cut out lets the wall behind be seen, and light through to it."""
    alpha = np.kron(255 * np.eye(4), np.ones((64, 64)))
    image = Image(np.dstack([blocks(2).pixels[..., :3], alpha]).astype(np.uint8), "screen")
    screen = Material(specular=0.0, base_color_texture=Texture(image), alpha_mode="mask", double_sided=True)
    behind = quad([(-3, -3, -1), (3, -3, -1), (3, 3, -1), (-3, 3, -1)], material=1)
    plain = Material(specular=0.0, base_color=(0.3, 0.6, 0.9))
    scene = scene_of([wall(), behind], [screen, plain], lights=[FACING])
    direct = Renderer(scene, "none", size=LARGE, device=device).render(FRONT).layers["direct"]
    radiance = Witness(scene, FRONT, LARGE).at_centres()
    inside = eroded(smooth(direct, 1e-3) & smooth(radiance, 1e-3))
    assert inside.mean() > 0.05
    assert (radiance[inside].min(axis=-1) > 0.0).mean() > 0.1
    assert np.abs(radiance - direct)[inside].max() < 0.009


@needs_llvm
def test_glossy_materials_and_normal_maps(device):
    """The BRDF, with textures of roughness, metallic and normals: patches of each. octolux's 8-bit mip levels and
    G-buffer leave 1/255 of a roughness of 0.35 or more: 1.1 %, and the lobe goes with its fourth power; the same of
    metallic; normals turn by 6.5e-5 rad, which slopes of ln D of at most 2 / alpha = 17 raise to 1e-3."""
    normals = blocks(6).pixels.copy()
    normals[..., :2] = 128 + (normals[..., :2].astype(int) - 128) // 4
    normals[..., 2] = 255
    roughness = Texture(blocks(7, low=90))
    material = Material(base_color=(0.8, 0.5, 0.3), metallic=0.9, roughness=0.95, metallic_roughness_texture=roughness,
                        normal_texture=Texture(Image(normals, "normals")), double_sided=True)  # fmt: skip
    lamp = PointLight(position=(0.3, 0.5, 1.5), intensity=(5.0, 4.0, 3.0))
    scene = scene_of([wall()], [material], lights=[lamp])
    picture = Renderer(scene, "none", size=LARGE, device=device).render(FRONT)
    radiance, direct = Witness(scene, FRONT, LARGE).at_centres(), picture.layers["direct"]
    inside = smooth(picture.layers["normal"], 1e-4) & smooth(picture.layers["albedo"], 1e-4)
    assert inside.mean() > 0.2
    assert np.abs(radiance / direct - 1.0)[inside].max() < 0.06
