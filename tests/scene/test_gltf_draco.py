"""KHR_draco_mesh_compression: what is decoded, and what broken data says."""

from __future__ import annotations

import DracoPy
import numpy as np
import pytest
from compressed import POSITIONS, TRIANGLES, UVS, corners, error_of, outcomes

from octolux.scene.gltf.loader import load_gltf

pytestmark = pytest.mark.covers("glTF KHR_draco_mesh_compression")


@pytest.fixture
def draco(gltf):
    """A primitive with Draco data; the accessors have no buffer views. Returns the extension."""
    data = DracoPy.encode(
        POSITIONS,
        TRIANGLES,
        quantization_bits=14,
        compression_level=7,
        tex_coord=UVS.astype(float),
        preserve_order=False,
    )
    ids = {attribute["attribute_type"]: attribute["unique_id"] for attribute in DracoPy.decode(data).attributes}
    extension = {
        "bufferView": gltf.view(np.frombuffer(data, np.uint8)),
        "attributes": {"POSITION": ids[0], "TEXCOORD_0": ids[3]},
    }
    count = len(DracoPy.decode(data).points)
    gltf.json |= {
        "accessors": [
            {"componentType": 5126, "type": "VEC3", "count": count},
            {"componentType": 5126, "type": "VEC2", "count": count},
            {"componentType": 5123, "type": "SCALAR", "count": TRIANGLES.size},
        ],
        "meshes": [
            {
                "primitives": [
                    {
                        "attributes": {"POSITION": 0, "TEXCOORD_0": 1},
                        "indices": 2,
                        "extensions": {"KHR_draco_mesh_compression": extension},
                    }
                ]
            }
        ],
        "nodes": [{"mesh": 0}],
        "extensionsRequired": ["KHR_draco_mesh_compression"],
    }
    return extension


def test_draco(gltf, draco):
    mesh = load_gltf(gltf.write()).meshes[0]
    # 14 bits over an edge of 6: half a step is 0.0002, so three digits are those of the whole numbers put in.
    assert corners(mesh.positions, mesh.indices) == corners(POSITIONS, TRIANGLES)
    np.testing.assert_allclose(mesh.uvs, mesh.positions[:, :2] / 8, atol=1e-3)


@pytest.mark.parametrize("options", [{"preserve_order": True}, {"preserve_order": False, "create_metadata": True}])
def test_draco_in_sequence_and_with_metadata(gltf, draco, options):
    data = DracoPy.encode(POSITIONS, TRIANGLES, quantization_bits=14, tex_coord=UVS.astype(float), **options)
    assert (data[8], data[10] >> 7) == (not options["preserve_order"], options.get("create_metadata", False))
    gltf.data, gltf.json["bufferViews"] = b"", []
    gltf.view(np.frombuffer(data, np.uint8))
    count = len(DracoPy.decode(data).points)
    gltf.json["accessors"][0]["count"] = gltf.json["accessors"][1]["count"] = count
    mesh = load_gltf(gltf.write()).meshes[0]
    assert corners(mesh.positions, mesh.indices) == corners(POSITIONS, TRIANGLES)


def test_draco_beside_plain_attributes(gltf, draco):
    """What the extension does not list comes from its accessor, in the order of the decoded vertices."""
    colors = np.linspace(0, 1, 3 * gltf.json["accessors"][0]["count"], dtype=np.float32).reshape(-1, 3)
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = gltf.add(colors)
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = gltf.add(np.float32([[0, 0, 1]] * len(colors)))
    mesh = load_gltf(gltf.write()).meshes[0]
    np.testing.assert_allclose(mesh.colors[:, :3], colors)


@pytest.mark.covers("glTF KHR_draco_mesh_compression", broken=True)
def test_draco_needs_indices_and_triangles(gltf, draco):
    primitive = gltf.json["meshes"][0]["primitives"][0]
    primitive["mode"] = 5
    assert "strips" in error_of(gltf.write()).problem
    del primitive["mode"], primitive["indices"]
    assert "'indices' is missing" in error_of(gltf.write()).problem


def spoil(gltf, change) -> None:
    """Changes the bytes of the first buffer view."""
    view = gltf.json["bufferViews"][0]
    data = bytearray(gltf.data)
    part = data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]]
    part = change(part) or part
    data[view["byteOffset"] : view["byteOffset"] + view["byteLength"]] = part
    view["byteLength"] = len(part)
    gltf.data = bytes(data)


def put(place: int, values: bytes):
    def change(data: bytearray) -> None:
        data[place : place + len(values)] = values

    return change


@pytest.mark.covers("glTF KHR_draco_mesh_compression", broken=True)
@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda data: data[: len(data) // 2], "broken"),
        (lambda data: data[:11], "header"),
        (lambda data: data[:5], "header"),
        (put(0, b"DRACP"), "no Draco data"),
        (put(5, bytes([2, 1])), "version 2.2"),
        (put(7, bytes([0])), "no mesh"),
        (put(12, b"\xff\xff\xff\xff\x0f"), "broken"),
        (put(13, b"\xff\xff\xff\xff\x0f"), "room for"),
        (put(13, b"\xff\xff\xff\xff\xff\xff\xff"), "no end"),
        (put(14, b"\0\0\0\0\0\0\0\0"), "broken"),
    ],
)
def test_broken_draco(gltf, draco, change, problem):
    spoil(gltf, change)
    error = error_of(gltf.write())
    assert error.place == "mesh 0 primitive 0: extensions: KHR_draco_mesh_compression"
    assert problem in error.problem


@pytest.mark.covers("glTF KHR_draco_mesh_compression", broken=True)
@pytest.mark.parametrize(
    ("keys", "value", "place"),
    [
        (("attributes", "POSITION"), 77, "KHR_draco_mesh_compression"),
        (("attributes", "NORMAL"), 0, "attributes"),
        (("attributes",), None, "KHR_draco_mesh_compression"),
        (("bufferView",), 9, "KHR_draco_mesh_compression"),
        (("bufferView",), None, "KHR_draco_mesh_compression"),
    ],
)
def test_wrong_draco_extension(gltf, draco, keys, value, place):
    owner = draco
    for key in keys[:-1]:
        owner = owner[key]
    owner[keys[-1]] = value
    if value is None:
        del owner[keys[-1]]
    assert error_of(gltf.write()).place.endswith(place)


@pytest.mark.covers("glTF KHR_draco_mesh_compression", broken=True)
@pytest.mark.parametrize(
    ("accessor", "key", "value", "place"),
    [
        (0, "count", 10, "accessor 0"),
        (0, "count", 10**8, "KHR_draco_mesh_compression"),
        (1, "count", 50, "accessor 1"),
        (1, "type", "VEC3", "accessor 1"),
        (2, "count", 12, "KHR_draco_mesh_compression"),
        (2, "count", 6 * TRIANGLES.size, "accessor 2"),
        (1, "componentType", 5121, "accessor 1"),
    ],
)
def test_draco_that_does_not_fit_its_accessors(gltf, draco, accessor, key, value, place):
    gltf.json["accessors"][accessor][key] = value
    assert error_of(gltf.write()).place.endswith(place)


@pytest.mark.covers("glTF KHR_draco_mesh_compression", broken=True)
def test_mutated_draco(gltf, draco):
    model = gltf.write()
    loaded, refused = outcomes(model, gltf.folder / "model.bin", slice(0, len(gltf.data)))
    assert loaded + refused == 400
    assert refused
