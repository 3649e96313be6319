"""Extensions of glTF materials: texture transforms, specular-glossiness, specular, unlit; and how warnings read."""

from __future__ import annotations

import numpy as np
import pytest
from PIL import Image as Pillow

from octolux.scene.gltf.loader import load_gltf
from octolux.scene.gltf.specular_glossiness import base_and_metallic
from octolux.scene.materials import IDENTITY_UV
from octolux.scene.warning_lines import merged
from octolux.simulator.tonemap import srgb_decode

TRANSFORM = "KHR_texture_transform"
OLDER = "KHR_materials_pbrSpecularGlossiness"


def slot(index: int = 0, **transform) -> dict:
    return {"index": index, "extensions": {TRANSFORM: transform}} if transform else {"index": index}


@pytest.fixture
def textured(gltf, picture):
    """A triangle with normals, tangents, two sets of uvs and texture 0; gives a loader of one material."""
    gltf.triangle()
    picture("0.png", (200, 100, 50))
    uvs = np.array([[0.1, 0.2], [0.9, 0.3], [0.4, 0.8]], np.float32)
    attributes = {"NORMAL": gltf.add(np.float32([[0, 0, 1]] * 3)), "TEXCOORD_0": gltf.add(uvs)}
    attributes["TEXCOORD_1"] = gltf.add(uvs[::-1].copy())
    attributes["TANGENT"] = gltf.add(np.float32([[0, 1, 0, 1]] * 3))
    gltf.json["meshes"][0]["primitives"][0] |= {"material": 0}
    gltf.json["meshes"][0]["primitives"][0]["attributes"] |= attributes
    gltf.json |= {"images": [{"uri": "0.png"}], "textures": [{"source": 0}]}

    def load(material: dict):
        gltf.json["materials"] = [material]
        scene = load_gltf(gltf.write())
        return scene, scene.meshes[0], scene.materials[0]

    load.uvs = uvs
    return load


def read_at(mesh, texture) -> np.ndarray:
    """Where a texture is read at the vertices."""
    a, b, c, d, e, f = texture.transform
    return mesh.uvs.astype(np.float64) @ np.array([[a, d], [b, e]]) + (c, f)


@pytest.mark.covers("glTF KHR_texture_transform")
def test_each_slot_is_read_where_its_own_transform_says(textured):
    transforms = {
        "base": {"scale": [4, 2], "offset": [0.5, 0]},
        "normal": {"scale": [2, 3], "offset": [0, 0.25], "rotation": np.pi / 2},
        "emissive": {"offset": [0.1, 0.1]},
    }
    scene, mesh, material = textured(
        {
            "pbrMetallicRoughness": {
                "baseColorTexture": slot(**transforms["base"]),
                "metallicRoughnessTexture": slot(),
            },
            "normalTexture": slot(**transforms["normal"]),
            "emissiveTexture": slot(**transforms["emissive"]),
        }
    )
    uvs = textured.uvs.astype(np.float64)
    assert scene.warnings == []
    assert material.normal_texture.transform == IDENTITY_UV
    # A quarter turn, counter-clockwise with v down: (u, v) to (v, -u), after the scale.
    turned = (uvs * (2, 3))[:, ::-1] * (1, -1) + (0, 0.25)
    np.testing.assert_allclose(mesh.uvs, turned, atol=1e-6)
    np.testing.assert_allclose(read_at(mesh, material.base_color_texture), uvs * (4, 2) + (0.5, 0), atol=1e-6)
    np.testing.assert_allclose(read_at(mesh, material.metallic_roughness_texture), uvs, atol=1e-6)
    np.testing.assert_allclose(read_at(mesh, material.emissive_texture), uvs + 0.1, atol=1e-6)
    # The triangle's edges are x and y: d(uv) = M d(xy), and the first column of M's inverse is the way u rises.
    tangent = np.linalg.inv((turned[1:] - turned[0]).T)[:, 0]
    np.testing.assert_allclose(mesh.tangents[0, :2], tangent / np.linalg.norm(tangent), atol=1e-6)


@pytest.mark.covers("glTF KHR_texture_transform")
def test_without_a_normal_map_the_first_slot_is_baked(textured):
    shared = {"scale": [3, 3], "offset": [0.25, 0]}
    _, mesh, material = textured(
        {"pbrMetallicRoughness": {"baseColorTexture": slot(**shared)}, "emissiveTexture": slot(**shared)}
    )
    np.testing.assert_allclose(mesh.uvs, textured.uvs * 3 + (0.25, 0), rtol=1e-6)
    assert material.base_color_texture.transform == material.emissive_texture.transform == IDENTITY_UV
    np.testing.assert_array_equal(mesh.tangents, [[0, 1, 0, 1]] * 3)  # the file's: u and v keep their directions


@pytest.mark.covers("glTF KHR_texture_transform")
def test_a_transform_that_cannot_be_undone_stays_with_its_slot(textured):
    _, mesh, material = textured({"normalTexture": slot(scale=[0, 1]), "emissiveTexture": slot(scale=[2, 2])})
    np.testing.assert_array_equal(mesh.uvs, textured.uvs)
    np.testing.assert_allclose(read_at(mesh, material.normal_texture), textured.uvs * (0, 1), atol=1e-7)
    np.testing.assert_allclose(read_at(mesh, material.emissive_texture), textured.uvs * 2, atol=1e-6)


@pytest.mark.covers("glTF EXT_texture_webp", "image WEBP")
def test_webp_goes_before_the_plain_image(textured, gltf):
    Pillow.new("RGB", (4, 4), (10, 20, 30)).save(gltf.folder / "1.webp", lossless=True)
    gltf.json["images"].append({"uri": "1.webp", "mimeType": "image/webp"})
    gltf.json["textures"].append({"source": 0, "extensions": {"EXT_texture_webp": {"source": 1}}})
    gltf.json["extensionsUsed"] = ["EXT_texture_webp"]
    scene, _, material = textured({"normalTexture": slot(0), "emissiveTexture": slot(1)})
    assert scene.warnings == []
    assert tuple(material.emissive_texture.image.pixels[0, 0]) == (10, 20, 30, 255)
    assert tuple(material.normal_texture.image.pixels[0, 0]) == (200, 100, 50, 255)


def test_different_sets_of_coordinates_are_noted(textured):
    scene, mesh, _ = textured({"normalTexture": slot() | {"texCoord": 1}, "emissiveTexture": slot()})
    assert scene.warnings == ["material 0: its textures use TEXCOORD_0 and TEXCOORD_1; TEXCOORD_1 is taken for all"]
    np.testing.assert_array_equal(mesh.uvs, textured.uvs[::-1])


@pytest.mark.covers("glTF KHR_materials_unlit", "glTF KHR_materials_specular")
def test_unlit_and_specular(gltf):
    gltf.triangle()
    gltf.json["extensionsRequired"] = ["KHR_materials_unlit", "KHR_materials_specular"]
    coloured = {"specularFactor": 0.25, "specularColorFactor": [1, 0, 0]}
    gltf.json["materials"] = [
        {"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {"baseColorFactor": [0.1, 0.2, 0.3, 1]}},
        {"extensions": {"KHR_materials_specular": coloured}},
        {},
    ]
    scene = load_gltf(gltf.write())
    assert [material.unlit for material in scene.materials] == [True, False, False, False]
    assert scene.materials[0].base_color == (0.1, 0.2, 0.3)
    assert [material.specular for material in scene.materials] == [1.0, 0.25, 1.0, 1.0]
    assert scene.warnings == ["material 1: specularColorFactor of KHR_materials_specular is left out"]


@pytest.mark.covers("glTF KHR_materials_pbrSpecularGlossiness")
def test_metallic_and_base_solve_the_equations_of_the_conversion():
    random = np.random.default_rng(5)
    base, metallic = random.random((500, 1)) * np.ones(3), random.random(500)  # greys: brightness is linear in them
    diffuse = base * 0.96 * (1 - metallic[:, None])
    specular = 0.04 + (base - 0.04) * metallic[:, None]
    found_base, found_metallic = base_and_metallic(diffuse / (1 - specular), specular)
    shining = specular[:, 0] > 0.04  # darker ones are no mixture of a dielectric and a metal; they become dielectric
    np.testing.assert_allclose(found_metallic[shining], metallic[shining], atol=1e-6)
    np.testing.assert_allclose(found_base[shining], base[shining], atol=1e-6)
    assert not found_metallic[~shining].any()


@pytest.mark.covers("glTF KHR_materials_pbrSpecularGlossiness")
def test_specular_glossiness_textures_are_converted_texel_by_texel(gltf, picture):
    random = np.random.default_rng(6)
    diffuse = random.integers(0, 256, (8, 4, 4), np.uint8)
    shine = random.integers(0, 256, (4, 8, 4), np.uint8).repeat(2, axis=0)
    picture("0.png", diffuse.repeat(2, axis=1))  # 8 x 8, like the other one
    picture("1.png", shine)
    gltf.triangle()
    older = {
        "diffuseTexture": {"index": 0},
        "specularGlossinessTexture": {"index": 1},
        "diffuseFactor": [0.5, 0.75, 1.0, 0.25],
        "specularFactor": [1.0, 0.5, 0.25],
        "glossinessFactor": 0.5,
    }
    gltf.json |= {
        "images": [{"uri": "0.png"}, {"uri": "1.png"}],
        "textures": [{"source": 0}, {"source": 1}],
        "materials": [{"extensions": {OLDER: older}}, {"extensions": {OLDER: older}}],
    }
    scene = load_gltf(gltf.write())
    material = scene.materials[0]
    assert scene.warnings == []
    assert (material.base_color, material.alpha, material.metallic, material.roughness) == ((1, 1, 1), 0.25, 1, 1)
    base, rough = material.base_color_texture.image, material.metallic_roughness_texture.image
    assert scene.materials[1].base_color_texture.image is base
    upper, lower = diffuse.repeat(2, axis=1), shine
    color, metallic = base_and_metallic(
        srgb_decode(upper[..., :3] / 255) * (0.5, 0.75, 1.0), srgb_decode(lower[..., :3] / 255) * (1.0, 0.5, 0.25)
    )
    # Rounding to 8 bits, and the float32 of the conversion where a value lies between two codes.
    np.testing.assert_allclose(srgb_decode(base.pixels[..., :3] / 255), color, atol=0.51 / 255 * 2.4)
    np.testing.assert_array_equal(base.pixels[..., 3], upper[..., 3])
    np.testing.assert_allclose(rough.pixels[..., 2], metallic * 255, atol=0.51)
    np.testing.assert_allclose(rough.pixels[..., 1], 255 - lower[..., 3] * 0.5, atol=0.51)


@pytest.mark.covers("glTF KHR_materials_pbrSpecularGlossiness")
def test_images_of_different_sizes_become_as_large_as_the_larger(gltf, picture):
    picture("1.png", np.full((4, 2, 4), (255, 255, 255, 51), np.uint8))
    picture("0.png", (0, 0, 0), (8, 2))
    gltf.triangle()
    older = {"diffuseTexture": {"index": 0}, "specularGlossinessTexture": {"index": 1}}
    gltf.json |= {
        "images": [{"uri": "0.png"}, {"uri": "1.png"}],
        "textures": [{"source": 0}, {"source": 1}],
        "materials": [{"extensions": {OLDER: older}}],
    }
    material = load_gltf(gltf.write()).materials[0]
    base, rough = material.base_color_texture.image, material.metallic_roughness_texture.image
    assert base.size == rough.size == base.pixels.shape[1::-1] == (8, 4)
    # A mirror: white base, fully metallic; its glossiness does not dim it where images are resampled.
    assert (base.pixels == 255).all()
    assert (rough.pixels == (0, 204, 255, 255)).all()


@pytest.mark.covers("glTF KHR_materials_pbrSpecularGlossiness")
def test_without_a_diffuse_texture_the_factor_alone_is_converted(gltf, picture):
    picture("1.png", np.full((4, 4, 4), (0, 0, 0, 255), np.uint8))
    gltf.triangle()
    older = {"specularGlossinessTexture": {"index": 0}, "diffuseFactor": [0.25, 0.5, 0.75, 1]}
    gltf.json |= {
        "images": [{"uri": "1.png"}],
        "textures": [{"source": 0}],
        "materials": [{"extensions": {OLDER: older}}],
    }
    material = load_gltf(gltf.write()).materials[0]
    pixels = material.base_color_texture.image.pixels
    expected = np.array([0.25, 0.5, 0.75]) / 0.96
    np.testing.assert_allclose(srgb_decode(pixels[0, 0, :3] / 255), expected, atol=0.51 / 255 * 2.4)
    assert tuple(material.metallic_roughness_texture.image.pixels[0, 0]) == (0, 0, 0, 255)


def test_warnings_of_one_kind_are_one_line():
    lines = [
        "mesh 0 primitive 1: lines are left out",
        "light 2: its 'range' is left out; light reaches everywhere",
        "mesh 0 primitive 2: lines are left out",
        "mesh 3 primitive 0: lines are left out",
        "extension KHR_materials_sheen is not supported; what it says is left out",
        "material 1: extensions: KHR_materials_x: it differs",
        "material 2: extensions: KHR_materials_x: it differs",
        "mesh 0 primitive 1: lines are left out",
    ]
    assert merged(lines) == [
        "mesh 0 primitive 1 and 2 more places: lines are left out",
        "light 2: its 'range' is left out; light reaches everywhere",
        "extension KHR_materials_sheen is not supported; what it says is left out",
        "material 1: extensions: KHR_materials_x and material 2: extensions: KHR_materials_x: it differs",
    ]
