"""Real models and real broken files from the data folder; skipped without it."""

from __future__ import annotations

import numpy as np
import pytest

from octolux.scene.errors import SceneError
from octolux.scene.gltf import load_gltf
from octolux.scene.obj import load_obj

CORNELL = {
    "Empty-CO": 12,
    "Empty-RG": 12,
    "Empty-Squashed": 12,
    "Empty-White": 12,
    "Glossy": 1112,
    "Glossy-Floor": 1112,
    "Mirror": 36,
    "Original": 36,
    "Sphere": 2188,
    "Water": 7088,
}


def check_vectors(scene) -> None:
    for mesh in scene.meshes:
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)
        np.testing.assert_allclose(np.linalg.norm(mesh.tangents[:, :3], axis=1), 1, atol=1e-5)
        assert set(np.unique(mesh.tangents[:, 3])) <= {-1.0, 1.0}


def test_crytek_sponza(scenes):
    scene = load_obj(scenes / "crytek-sponza" / "sponza.obj")
    assert (scene.triangle_count, len(scene.materials), len(scene.instances)) == (262_267, 26, 393)
    assert scene.warnings == []
    masked = {material.name for material in scene.materials if material.alpha_mode == "mask"}
    assert masked == {"leaf", "Material__57", "chain"}
    assert sum(material.normal_texture is not None for material in scene.materials) == 9
    assert all(material.base_color == (1.0, 1.0, 1.0) for material in scene.materials if material.base_color_texture)
    assert {"sponza_00", "sponza_379"} <= {instance.name for instance in scene.instances}
    check_vectors(scene)


def test_dabrovic_sponza(scenes):
    scene = load_obj(scenes / "dabrovic-sponza" / "sponza.obj")
    assert (scene.triangle_count, len(scene.materials)) == (66_454, 1)
    check_vectors(scene)


@pytest.mark.parametrize(("name", "triangles"), CORNELL.items())
def test_cornell_boxes(scenes, name, triangles):
    scene = load_obj(scenes / "cornell-box" / f"CornellBox-{name}.obj")
    assert scene.triangle_count == triangles
    check_vectors(scene)


def test_cornell_box_materials(scenes):
    scene = load_obj(scenes / "cornell-box" / "CornellBox-Original.obj")
    np.testing.assert_allclose(scene.bounds(), [(-1.02, 0, -1.04), (1, 1.99, 0.99)], atol=1e-6)
    by_name = {material.name: material for material in scene.materials}
    assert by_name["leftWall"].base_color == (0.63, 0.065, 0.05)
    assert by_name["light"].emissive == (17.0, 12.0, 4.0)
    assert all(material.specular == 0.0 for material in scene.materials)
    lamps = [mesh for mesh in scene.meshes if scene.materials[mesh.material].name == "light"]
    np.testing.assert_allclose(lamps[0].normals, np.broadcast_to((0, -1, 0), lamps[0].normals.shape), atol=1e-6)


@pytest.mark.parametrize(
    ("file", "triangles", "meshes", "materials"),
    [
        ("cornell-box/bevy-CornellBox.glb", 36, 6, 5),
        ("cornell-box/kajiya-gltf/scene.gltf", 32, 8, 8),
        ("gltf/FlightHelmet/FlightHelmet.gltf", 94_722, 6, 6),
        ("gltf/MixedLightingExample/MixedLightingExample.gltf", 40_898, 6, 8),
        ("gltf/01_alpha_mask/01_alpha_mask.gltf", 2, 1, 1),
        ("gltf/14_emission_strength/14_emission_strength.gltf", 17_280, 18, 18),
        ("gltf/23_sparse_multi_prim/23_multi_prim_vertex_attribute.gltf", 6, 2, 2),
        ("gltf/Fox/Fox.glb", 576, 1, 1),
    ],
)
def test_gltf_models(scenes, file, triangles, meshes, materials):
    scene = load_gltf(scenes / file)
    assert (scene.triangle_count, len(scene.meshes), len(scene.materials)) == (triangles, meshes, materials)
    check_vectors(scene)


def test_gltf_details(scenes):
    mask = load_gltf(scenes / "gltf/01_alpha_mask/01_alpha_mask.gltf")
    assert mask.materials[0].alpha_mode == "mask"
    strong = load_gltf(scenes / "gltf/14_emission_strength/14_emission_strength.gltf")
    by_name = {material.name: material for material in strong.materials}
    np.testing.assert_allclose(by_name["pbrEmissiveStrength"].emissive, (4.5, 4.0, 3.5), rtol=1e-6)
    (sun,) = load_gltf(scenes / "gltf/MixedLightingExample/MixedLightingExample.gltf").lights
    assert sun.illuminance == (2049, 2049, 2049)


BROKEN = {
    "BoxWithInfinites.glb": "accessor 2",
    "assimp-IndexOutOfRange/AllIndicesOutOfRange.gltf": "mesh 0 primitive 0",
    "assimp-IndexOutOfRange/IndexOutOfRange.gltf": "mesh 0 primitive 0",
    "assimp-MissingBin/BoxTextured.gltf": "buffer 0",
    "empty.obj": "",
    "malformed.obj": "line 23",
    "validator/empty_file.glb": "",
    "validator/index_buffer_degenerate_triangle.gltf": "mesh 0 primitive 0",
    "validator/index_buffer_oob.gltf": "mesh 0 primitive 0",
    "validator/invalid_elements_float.gltf": "meshes",
    "validator/invalid_magic.glb": "header",
    "validator/length_mismatch.glb": "header",
    "validator/not_found.gltf": "buffer 0",
    "validator/truncated_chunk_data.glb": "header",
}


def test_every_broken_model_is_listed(scenes):
    folder = scenes / "broken"
    models = {str(p.relative_to(folder)) for p in folder.rglob("*") if p.suffix in (".obj", ".gltf", ".glb")}
    assert models == set(BROKEN)


@pytest.mark.parametrize(("file", "place"), BROKEN.items())
def test_broken_models(scenes, file, place):
    path = scenes / "broken" / file
    with pytest.raises(SceneError) as caught:
        (load_obj if path.suffix == ".obj" else load_gltf)(path)
    error = caught.value
    assert (error.file, error.place) == (str(path), place)
    assert error.problem
    assert error.remedy
