"""What the real models hold: triangles, materials, textures, meshes, as counted in their files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from octolux.scene.load import load_scene
from octolux.scene.scene import Scene

# Triangles and materials are those of the files: `f` lines (quadrilaterals twice), `newmtl` lines, the PLY's header.
# Glossy and Glossy-Floor use a material "light" that the first one's library lacks; grey stands in, so 7 + 1.
MODELS = {
    "cornell-box/CornellBox-Empty-CO.obj": (12, 8, 0, 6),
    "cornell-box/CornellBox-Empty-RG.obj": (12, 6, 0, 6),
    "cornell-box/CornellBox-Empty-Squashed.obj": (12, 7, 0, 6),
    "cornell-box/CornellBox-Empty-White.obj": (12, 6, 0, 6),
    "cornell-box/CornellBox-Glossy-Floor.obj": (1112, 8, 0, 8),
    "cornell-box/CornellBox-Glossy.obj": (1112, 8, 0, 8),
    "cornell-box/CornellBox-Mirror.obj": (36, 8, 0, 8),
    "cornell-box/CornellBox-Original.obj": (36, 8, 0, 8),
    "cornell-box/CornellBox-Sphere.obj": (2188, 8, 0, 8),
    "cornell-box/CornellBox-Water.obj": (7088, 9, 0, 9),
    "crytek-sponza/sponza.obj": (262_267, 26, 34, 393),
    "dabrovic-sponza/sponza.obj": (66_454, 1, 0, 34),
    "stanford-bunny/bun_zipper.ply": (69_451, 1, 0, 1),
}


def images(scene: Scene) -> set[int]:
    slots = ("base_color_texture", "metallic_roughness_texture", "normal_texture", "emissive_texture")
    used = (getattr(material, slot) for material in scene.materials for slot in slots)
    return {id(texture.image) for texture in used if texture}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=pytest.mark.covers(f"model {Path(name).suffix}", files=[name])) for name in MODELS],
)
def test_counts(scenes, name):
    scene = load_scene(scenes / name)
    assert (scene.triangle_count, len(scene.materials), len(images(scene)), len(scene.meshes)) == MODELS[name]


def test_every_obj_of_the_cornell_box_is_listed(scenes):
    assert {f"cornell-box/{path.name}" for path in (scenes / "cornell-box").glob("*.obj")} <= set(MODELS)


@pytest.mark.covers("model .ply", files=["stanford-bunny/bun_zipper.ply"])
def test_the_bunny_is_smooth_and_in_metres(scenes):
    scene = load_scene(scenes / "stanford-bunny" / "bun_zipper.ply")
    low, high = scene.bounds()
    assert 0.15 < (high - low).max() < 0.16  # about 15.6 cm, as its README says of the scan
    (mesh,) = scene.meshes
    corners = mesh.positions[mesh.indices].astype(np.float64)
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    faces /= np.linalg.norm(faces, axis=1, keepdims=True)
    apart = np.einsum("ijk,ik->ij", mesh.normals[mesh.indices], faces)
    assert np.median(apart) < np.cos(np.radians(2))  # they are not those of the faces,
    assert (apart > 0).mean() > 0.999  # and on their side
    assert len(mesh.positions) < 1.1 * 34_834  # few of the vertices with faces are split


@pytest.mark.covers("environment .hdr", files=["env/spiaggia_di_mondello_1k.hdr"])
def test_the_environment_picture(toml, scenes):
    environment = toml('[environment]\nimage = "data:env/spiaggia_di_mondello_1k.hdr"\n').environment
    assert environment.image.shape == (512, 1024, 3)
    sky, sand = environment.image[:200].mean(axis=(0, 1)), environment.image[300:].mean(axis=(0, 1))
    assert sky[2] > sky[0] and sand[0] > sand[2]  # blue above, yellow below
    row, column = np.unravel_index(environment.image.sum(axis=2).argmax(), (512, 1024))
    assert row < 256 and environment.image[row, column].min() > 1000  # the sun
