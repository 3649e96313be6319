"""Real models and real broken files from the data folder; skipped without it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from octolux.scene.errors import SceneError
from octolux.scene.gltf.loader import load_gltf
from octolux.scene.obj.loader import load_obj

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


def sample(file: str, *values, features=(), broken: bool = False):
    """The parameters of a file below the folder `scenes`, which cover its format and `features`."""
    covers = pytest.mark.covers(f"model {Path(file).suffix}", *features, files=[file], broken=broken)
    return pytest.param(file, *values, marks=covers)


def check_vectors(scene) -> None:
    for mesh in scene.meshes:
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=1e-5)
        np.testing.assert_allclose(np.linalg.norm(mesh.tangents[:, :3], axis=1), 1, atol=1e-5)
        assert set(np.unique(mesh.tangents[:, 3])) <= {-1.0, 1.0}


@pytest.mark.covers("model .obj", files=["crytek-sponza/sponza.obj"])
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


@pytest.mark.covers("model .obj", files=["dabrovic-sponza/sponza.obj"])
def test_dabrovic_sponza(scenes):
    scene = load_obj(scenes / "dabrovic-sponza" / "sponza.obj")
    assert (scene.triangle_count, len(scene.materials)) == (66_454, 1)
    check_vectors(scene)


@pytest.mark.parametrize(
    ("file", "triangles"),
    [sample(f"cornell-box/CornellBox-{name}.obj", triangles) for name, triangles in CORNELL.items()],
)
def test_cornell_boxes(scenes, file, triangles):
    scene = load_obj(scenes / file)
    assert scene.triangle_count == triangles
    check_vectors(scene)


@pytest.mark.covers("model .obj", files=["cornell-box/CornellBox-Original.obj"])
def test_cornell_box_materials(scenes):
    scene = load_obj(scenes / "cornell-box" / "CornellBox-Original.obj")
    np.testing.assert_allclose(scene.bounds(), [(-1.02, 0, -1.04), (1, 1.99, 0.99)], atol=1e-6)
    by_name = {material.name: material for material in scene.materials}
    assert by_name["leftWall"].base_color == (0.63, 0.065, 0.05)
    assert by_name["light"].emissive == (17.0, 12.0, 4.0)
    assert all(material.specular == 0.0 for material in scene.materials)
    lamps = [mesh for mesh in scene.meshes if scene.materials[mesh.material].name == "light"]
    np.testing.assert_allclose(lamps[0].normals, np.broadcast_to((0, -1, 0), lamps[0].normals.shape), atol=1e-6)


GLTF = {  # triangles, meshes, materials, images that materials use
    "cornell-box/bevy-CornellBox.glb": (36, 6, 5, 0),
    "cornell-box/kajiya-gltf/scene.gltf": (32, 8, 8, 0),
    "gltf/01_alpha_mask/01_alpha_mask.gltf": (2, 1, 1, 1),
    "gltf/14_emission_strength/14_emission_strength.gltf": (17_280, 18, 18, 1),
    "gltf/23_sparse_multi_prim/23_multi_prim_vertex_attribute.gltf": (6, 2, 2, 0),
    "gltf/Draco-2CylinderEngine/2CylinderEngine.gltf": (110_336, 34, 34, 0),
    "gltf/FlightHelmet/FlightHelmet.gltf": (94_722, 6, 6, 15),
    "gltf/Fox/Fox.glb": (576, 1, 1, 1),
    "gltf/MixedLightingExample/MixedLightingExample.gltf": (40_898, 6, 8, 7),
    "gltf/pirate-meshopt/pirate.glb": (5_010, 1, 1, 0),
}


def test_every_gltf_model_is_listed(scenes):
    folders = (scenes / "gltf", scenes / "cornell-box")
    found = {str(p.relative_to(scenes)) for f in folders for p in f.rglob("*") if p.suffix in (".gltf", ".glb")}
    assert found == set(GLTF)


FEATURES = {
    "cornell-box/bevy-CornellBox.glb": ("glTF KHR_materials_emissive_strength", "glTF vertex colours"),
    "cornell-box/kajiya-gltf/scene.gltf": ("glTF materials",),
    "gltf/01_alpha_mask/01_alpha_mask.gltf": ("glTF alpha modes", "image PNG"),
    "gltf/14_emission_strength/14_emission_strength.gltf": (
        "glTF KHR_materials_emissive_strength",
        "glTF KHR_materials_pbrSpecularGlossiness",
    ),
    "gltf/23_sparse_multi_prim/23_multi_prim_vertex_attribute.gltf": (
        "glTF generated normals",
        "glTF sparse accessors",
    ),
    "gltf/Draco-2CylinderEngine/2CylinderEngine.gltf": ("glTF KHR_draco_mesh_compression",),
    "gltf/FlightHelmet/FlightHelmet.gltf": ("glTF materials", "image PNG"),
    "gltf/Fox/Fox.glb": ("glTF generated normals", "glTF embedded data"),
    "gltf/MixedLightingExample/MixedLightingExample.gltf": (
        "glTF KHR_lights_punctual",
        "glTF KHR_texture_transform",
        "image JPEG",
    ),
    "gltf/pirate-meshopt/pirate.glb": ("glTF EXT_meshopt_compression", "glTF KHR_mesh_quantization"),
}


@pytest.mark.parametrize("file", GLTF)
def test_gltf_models_use_the_extensions_that_they_are_to_cover(scenes, file):
    text = (scenes / file).read_bytes()
    used = [name.split()[1] for name in FEATURES[file] if name.startswith(("glTF KHR_", "glTF EXT_"))]
    assert all(f'"{name}"'.encode() in text for name in used)


@pytest.mark.parametrize(
    ("file", "expected"),
    [sample(file, expected, features=FEATURES[file]) for file, expected in GLTF.items()],
)
def test_gltf_models(scenes, file, expected):
    scene = load_gltf(scenes / file)
    slots = ("base_color_texture", "metallic_roughness_texture", "normal_texture", "emissive_texture")
    textures = [getattr(material, slot) for material in scene.materials for slot in slots]
    images = {id(texture.image) for texture in textures if texture}
    assert (scene.triangle_count, len(scene.meshes), len(scene.materials), len(images)) == expected
    check_vectors(scene)
    named = ("KHR_materials_sheen", "KHR_materials_variants") if "MixedLighting" in file else ()
    assert scene.warnings == [f"extension {name} is not supported; what it says is left out" for name in named]


def test_compressed_models_have_the_extent_that_their_accessors_say(scenes):
    """Accessors repeat the least and the greatest position of the model before it was compressed."""
    engine = load_gltf(scenes / "gltf/Draco-2CylinderEngine/2CylinderEngine.gltf")
    first = engine.meshes[0].positions
    # 11 bits over the longest edge of 106.6 are steps of 0.0521, by one of which the accessors' bounds are wider.
    np.testing.assert_allclose(first.min(axis=0), (-43.1827, -37.0259, -46.5520), atol=0.053)
    np.testing.assert_allclose(first.max(axis=0), (63.4045, 56.0884, 46.5622), atol=0.053)
    pirate = load_gltf(scenes / "gltf/pirate-meshopt/pirate.glb").meshes[0].positions
    assert (pirate.min(axis=0).tolist(), pirate.max(axis=0).tolist()) == ([0, 0, 0], [13081, 16383, 3915])


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


@pytest.mark.parametrize(
    ("file", "place"), [sample(f"broken/{file}", place, broken=True) for file, place in BROKEN.items()]
)
def test_broken_models(scenes, file, place):
    path = scenes / file
    with pytest.raises(SceneError) as caught:
        (load_obj if path.suffix == ".obj" else load_gltf)(path)
    error = caught.value
    assert (error.file, error.place) == (str(path), place)
    assert error.problem
    assert error.remedy
