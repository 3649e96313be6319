"""What valid glTF files mean."""

from __future__ import annotations

import base64
import json
import struct
from math import pi

import numpy as np
import pytest

from octolux.scene.gltf.extensions import UvUse
from octolux.scene.gltf.loader import load_gltf
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight

pytestmark = pytest.mark.covers("model .gltf")


@pytest.mark.covers("glTF nodes")
def test_hierarchy_is_flattened_and_mirroring_kept(gltf):
    gltf.triangle()
    gltf.json["nodes"] = [
        {"children": [1], "translation": [1, 2, 3], "rotation": [0, 0, 0.5**0.5, 0.5**0.5]},
        {"mesh": 0, "scale": [-2, 1, 1], "name": "mirrored"},
    ]
    scene = load_gltf(gltf.write())
    (instance,) = scene.instances
    assert instance.name == "mirrored"
    assert np.linalg.det(instance.transform[:3, :3]) == pytest.approx(-2)
    # (1, 0, 0): scaled to (-2, 0, 0), turned by 90 degrees about z to (0, -2, 0), moved.
    np.testing.assert_allclose(instance.transform @ (1, 0, 0, 1), (1, 0, 3, 1), atol=1e-12)


@pytest.mark.covers("glTF nodes")
def test_matrices_are_column_major_and_only_the_shown_scene_is_taken(gltf):
    gltf.triangle()
    gltf.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1]}]
    gltf.json |= {"scenes": [{"nodes": [0]}, {"nodes": [1]}], "scene": 1}
    (instance,) = load_gltf(gltf.write()).instances
    np.testing.assert_allclose(instance.transform[:3, 3], (7, 8, 9))


@pytest.mark.covers("glTF triangle strips and fans")
@pytest.mark.parametrize(
    ("mode", "expected"),
    [(4, [[0, 1, 2]]), (5, [[0, 1, 2], [1, 3, 2], [2, 3, 4]]), (6, [[1, 2, 0], [2, 3, 0], [3, 4, 0]])],
)
def test_modes_of_triangles(gltf, mode, expected):
    random = np.random.default_rng(2)
    attributes = {"POSITION": gltf.add(random.normal(size=(5, 3)).astype(np.float32))}
    attributes["NORMAL"] = gltf.add(random.normal(size=(5, 3)).astype(np.float32))
    gltf.json |= {"meshes": [{"primitives": [{"attributes": attributes, "mode": mode}]}], "nodes": [{"mesh": 0}]}
    scene = load_gltf(gltf.write())
    assert scene.meshes[0].indices.tolist() == expected
    assert len(scene.warnings) == (mode == 4)  # five vertices make one triangle and two that are left over


def test_points_and_lines_are_left_out_with_a_warning(gltf):
    gltf.triangle()
    gltf.json["meshes"][0]["primitives"] += [{"attributes": {"POSITION": 0}, "mode": mode} for mode in (0, 1, 2, 3)]
    scene = load_gltf(gltf.write())
    assert scene.triangle_count == 1
    assert scene.warnings == [
        "mesh 0 primitive 1: points are left out",
        "mesh 0 primitive 2 and 2 more places: lines are left out",
    ]


@pytest.mark.covers("glTF interleaved and normalized attributes", "glTF sparse accessors")
def test_interleaved_normalized_and_sparse_attributes(gltf):
    gltf.triangle()
    vertex = np.dtype([("normal", "<f4", 3), ("uv", "<u2", 2)])
    vertices = np.zeros(3, vertex)
    vertices["normal"] = [0, 0, 1]
    vertices["uv"] = [[0, 65535], [65535, 65535], [0, 0]]
    view = gltf.view(vertices, byteStride=vertex.itemsize)
    shared = {"bufferView": view, "count": 3}
    gltf.json["accessors"] += [
        {**shared, "componentType": 5126, "type": "VEC3"},
        {**shared, "componentType": 5123, "type": "VEC2", "byteOffset": 12, "normalized": True},
    ]
    gltf.json["accessors"][0]["sparse"] = {
        "count": 1,
        "indices": {"bufferView": gltf.view(np.array([1], np.uint8)), "componentType": 5121},
        "values": {"bufferView": gltf.view(np.array([[5, 0, 0]], np.float32))},
    }
    gltf.json["meshes"][0]["primitives"][0]["attributes"] |= {"NORMAL": 2, "TEXCOORD_0": 3}
    mesh = load_gltf(gltf.write()).meshes[0]
    np.testing.assert_allclose(mesh.positions, [[0, 0, 0], [5, 0, 0], [0, 1, 0]])
    np.testing.assert_allclose(mesh.uvs, [[0, 1], [1, 1], [0, 0]])
    np.testing.assert_allclose(mesh.tangents, [[1, 0, 0, 1]] * 3, atol=1e-6)


@pytest.mark.covers("glTF KHR_mesh_quantization")
@pytest.mark.parametrize("normalized", [True, False])
def test_quantized_meshes(gltf, normalized):
    """Integers that are normalized are divided by their type's largest value (glTF 2.0, section 3.11)."""
    positions = np.array([[-127, 0, 127, 0], [127, 0, 127, 0], [-127, 127, 127, 0]], np.int8)
    uvs = np.array([[0, 0], [32767, 0], [0, -32767]], np.int16)
    normals = np.array([[0, 0, 127, 0]] * 3, np.int8)
    shown = {"type": "VEC3", "count": 3, "componentType": 5120}
    gltf.json["accessors"] = [
        {**shown, "bufferView": gltf.view(positions, byteStride=4), "normalized": normalized},
        {**shown, "bufferView": gltf.view(normals, byteStride=4), "normalized": True},
    ]
    attributes = {"POSITION": 0, "NORMAL": 1, "TEXCOORD_0": gltf.add(uvs, normalized=normalized)}
    gltf.json |= {
        "meshes": [{"primitives": [{"attributes": attributes}]}],
        "nodes": [{"mesh": 0, "scale": [2, 2, 2]}],
        "extensionsUsed": ["KHR_mesh_quantization"],
        "extensionsRequired": ["KHR_mesh_quantization"],
    }
    scene = load_gltf(gltf.write())
    (mesh,), (instance,) = scene.meshes, scene.instances
    np.testing.assert_array_equal(mesh.positions, positions[:, :3] / (127 if normalized else 1))
    np.testing.assert_array_equal(mesh.uvs, uvs / (32767 if normalized else 1))
    np.testing.assert_array_equal(mesh.normals, [[0, 0, 1]] * 3)
    assert instance.transform[0, 0] == 2
    assert scene.warnings == []


@pytest.mark.covers("model .glb", "glTF embedded data", "image PNG")
def test_glb_with_embedded_image(gltf, picture):
    gltf.triangle()
    png = np.frombuffer(picture("t.png", (9, 8, 7)).read_bytes(), np.uint8)
    gltf.json |= {
        "images": [{"bufferView": gltf.view(png), "mimeType": "image/png"}],
        "samplers": [{"wrapS": 33071, "wrapT": 33648}],
        "textures": [{"source": 0, "sampler": 0}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "buffers": [{"byteLength": len(gltf.data)}],
    }
    gltf.json["meshes"][0]["primitives"][0]["material"] = 0
    text = json.dumps(gltf.json).encode()
    text += b" " * (-len(text) % 4)
    data = gltf.data + b"\0" * (-len(gltf.data) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    path = gltf.folder / "model.glb"
    path.write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks)
    scene = load_gltf(path)
    texture = scene.materials[0].base_color_texture
    assert tuple(texture.image.pixels[0, 0]) == (9, 8, 7, 255)
    assert texture.wrap == ("clamp_to_edge", "mirrored_repeat")
    assert len(scene.materials) == 1


@pytest.mark.covers("glTF embedded data")
def test_data_uris_and_encoded_file_names(gltf, picture):
    gltf.triangle()
    png = base64.b64encode(picture("my picture.png", (1, 2, 3)).read_bytes()).decode()
    gltf.json |= {
        "images": [{"uri": "my%20picture.png"}, {"uri": f"data:image/png;base64,{png}"}, {"uri": "gone.png"}],
        "textures": [{"source": 0}, {"source": 1}, {"source": 2}],
        "materials": [
            {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}, "emissiveTexture": {"index": 1}},
            {"normalTexture": {"index": 2, "scale": 0.5}},
        ],
    }
    scene = load_gltf(gltf.write())
    first, second = scene.materials[:2]
    assert tuple(first.base_color_texture.image.pixels[0, 0]) == (1, 2, 3, 255)
    assert tuple(first.emissive_texture.image.pixels[0, 0]) == (1, 2, 3, 255)
    assert tuple(second.normal_texture.image.pixels[0, 0]) == (255, 0, 255, 255)
    assert second.normal_scale == 0.5
    assert any("gone.png" in line for line in scene.warnings)


@pytest.mark.covers("glTF materials", "glTF alpha modes", "glTF KHR_materials_emissive_strength")
def test_materials(gltf):
    gltf.triangle()
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 5.0}}
    older = {"KHR_materials_pbrSpecularGlossiness": {"diffuseFactor": [0.25, 0.5, 0.75, 1], "specularFactor": [0] * 3}}
    gltf.json["materials"] = [
        {
            "pbrMetallicRoughness": {
                "baseColorFactor": [0.1, 0.2, 0.3, 0.4],
                "metallicFactor": 0,
                "roughnessFactor": 0.7,
            },
            "emissiveFactor": [0.2, 0.4, 1.0],
            "extensions": strength,
            "alphaMode": "MASK",
            "alphaCutoff": 0.25,
            "doubleSided": True,
        },
        {"extensions": older},
    ]
    scene = load_gltf(gltf.write())
    first, second, default = scene.materials
    assert (first.base_color, first.alpha, first.metallic, first.roughness) == ((0.1, 0.2, 0.3), 0.4, 0.0, 0.7)
    np.testing.assert_allclose(first.emissive, (1.0, 2.0, 5.0))
    assert (first.alpha_mode, first.alpha_cutoff, first.double_sided) == ("mask", 0.25, True)
    assert (second.metallic, second.roughness) == (0.0, 0.0)
    np.testing.assert_allclose(second.base_color, np.array([0.25, 0.5, 0.75]) / 0.96)
    assert scene.meshes[0].material == 2
    assert (default.metallic, default.roughness) == (1.0, 1.0)


@pytest.mark.covers("glTF cameras", "glTF KHR_lights_punctual")
def test_cameras_lose_scale_and_lights_keep_their_units(gltf):
    gltf.triangle()
    turn = [0, 0.5**0.5, 0, 0.5**0.5]  # by 90 degrees about y: -z becomes -x
    lights = [
        {"type": "directional", "color": [1, 0.5, 0], "intensity": 100},
        {"type": "point", "intensity": 40},
        {"type": "spot", "intensity": 3, "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.2}},
    ]
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    gltf.json["cameras"] = [
        {"type": "perspective", "perspective": {"yfov": pi / 3, "znear": 0.1}},
        {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 2, "znear": 0, "zfar": 9}},
    ]
    gltf.json["nodes"] += [{"camera": 0, "rotation": turn, "scale": [2, 3, 4], "name": "eye"}, {"camera": 1}]
    carried = [{"KHR_lights_punctual": {"light": index}} for index in range(3)]
    gltf.json["nodes"] += [{"rotation": turn, "translation": [1, 2, 3], "extensions": light} for light in carried]
    scene = load_gltf(gltf.write())
    eye, plan = scene.cameras
    np.testing.assert_allclose(eye.transform[:3, :3] @ eye.transform[:3, :3].T, np.eye(3), atol=1e-12)
    np.testing.assert_allclose(eye.forward, (-1, 0, 0), atol=1e-12)
    assert (eye.vertical_fov, eye.near, eye.name) == (pi / 3, 0.1, "eye")
    assert plan.orthographic_height == 4.0
    sun, lamp, spot = scene.lights
    assert isinstance(sun, DirectionalLight)
    assert sun.illuminance == (100, 50, 0)
    np.testing.assert_allclose(sun.direction, (-1, 0, 0), atol=1e-12)
    assert isinstance(lamp, PointLight)
    assert (lamp.position, lamp.intensity) == ((1, 2, 3), (40, 40, 40))
    assert isinstance(spot, SpotLight)
    assert (spot.inner_angle, spot.outer_angle) == (0.1, 0.2)


@pytest.mark.covers("glTF KHR_texture_transform")
def test_texture_transform_scales_then_turns_counter_clockwise_then_moves():
    # v points down, so that a counter-clockwise quarter turn takes (2, 0), to the right, to (0, -2), upwards.
    use = UvUse(0, (0.5, 0.25), pi / 2, (2.0, 1.0))
    np.testing.assert_allclose(use.apply(np.array([[1, 0]], np.float32)), [[0.5, -1.75]], atol=1e-6)


def test_what_is_left_out_is_noted(gltf):
    gltf.triangle()
    gltf.json |= {"extensionsUsed": ["KHR_materials_sheen"]}
    (noted,) = load_gltf(gltf.write()).warnings
    assert "KHR_materials_sheen" in noted
