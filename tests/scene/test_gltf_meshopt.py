"""EXT_meshopt_compression: modes, filters, and what broken data says."""

from __future__ import annotations

import json
from pathlib import Path

import meshopt
import numpy as np
import pytest
from compressed import POSITIONS, TRIANGLES, corners, error_of, outcomes

from octolux.scene.gltf.loader import load_gltf

pytestmark = pytest.mark.covers("glTF EXT_meshopt_compression")


def meshopt_view(gltf, array: np.ndarray, mode: str, version: int = 0, **more) -> dict:
    """Appends a compressed buffer view with its accessor; returns the extension."""
    data = meshopt.encode_gltf_buffer(array, mode, version)
    stride = array.itemsize * (array.shape[1] if array.ndim > 1 else 1)
    stored = gltf.view(np.frombuffer(data, np.uint8))
    view = gltf.json["bufferViews"][stored]
    extension = {
        "buffer": 0,
        "byteOffset": view["byteOffset"],
        "byteLength": len(data),
        "byteStride": stride,
        "count": len(array),
        "mode": mode,
        **more,
    }
    gltf.json["bufferViews"][stored] = {
        "buffer": 1,
        "byteLength": array.nbytes,
        "extensions": {"EXT_meshopt_compression": extension},
    }
    return extension


def meshopt_model(gltf, normals=None) -> list[dict]:
    """POSITIONS and TRIANGLES compressed, and NORMAL from encoded rows; returns the extensions."""
    found = [meshopt_view(gltf, POSITIONS, "ATTRIBUTES"), meshopt_view(gltf, TRIANGLES.ravel(), "TRIANGLES")]
    gltf.json["accessors"] = [
        {"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": len(POSITIONS)},
        {"bufferView": 1, "componentType": 5125, "type": "SCALAR", "count": TRIANGLES.size},
    ]
    gltf.json["meshes"] = [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}]
    gltf.json |= {"nodes": [{"mesh": 0}], "extensionsRequired": ["EXT_meshopt_compression"]}
    return found


def write_meshopt(gltf) -> Path:
    """With the buffer that stands in for compressed data; it has no file."""
    path = gltf.write()
    fallback = {"byteLength": 1 << 20, "extensions": {"EXT_meshopt_compression": {"fallback": True}}}
    gltf.json["buffers"].append(fallback)
    path.write_text(json.dumps(gltf.json))
    return path


def test_meshopt(gltf):
    meshopt_model(gltf)
    mesh = load_gltf(write_meshopt(gltf)).meshes[0]
    assert corners(mesh.positions, mesh.indices) == corners(POSITIONS, TRIANGLES)


@pytest.mark.covers("glTF KHR_meshopt_compression")
def test_meshopt_sequence_of_indices_and_the_newer_name(gltf):
    meshopt_model(gltf)
    meshopt_view(gltf, TRIANGLES.ravel(), "INDICES")
    gltf.json["accessors"][1]["bufferView"] = 2
    extensions = gltf.json["bufferViews"][2]["extensions"]
    extensions["KHR_meshopt_compression"] = extensions.pop("EXT_meshopt_compression")
    gltf.json["extensionsRequired"].append("KHR_meshopt_compression")
    mesh = load_gltf(write_meshopt(gltf)).meshes[0]
    assert corners(mesh.positions, mesh.indices) == corners(POSITIONS, TRIANGLES)


def test_octahedral_filter(gltf):
    meshopt_model(gltf)
    wanted = np.random.default_rng(3).normal(size=(len(POSITIONS), 3))
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    rows = meshopt.encode_filter_oct(np.column_stack([wanted, np.zeros(len(wanted))]), 8, 12)
    meshopt_view(gltf, rows, "ATTRIBUTES", filter="OCTAHEDRAL")
    gltf.json["bufferViews"][2]["byteStride"] = 8
    accessor = {"bufferView": 2, "componentType": 5122, "normalized": True, "type": "VEC3", "count": len(wanted)}
    gltf.json["accessors"].append(accessor)
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 2
    mesh = load_gltf(write_meshopt(gltf)).meshes[0]
    # The octahedron unfolded is 2 wide: half of one of its 2^11 steps, along two axes, on faces up to sqrt(3) steeper.
    np.testing.assert_allclose(mesh.normals, wanted, atol=2 * 6**0.5 / 2**12)


def test_exponential_filter(gltf):
    meshopt_model(gltf)
    rows = meshopt.encode_filter_exp(POSITIONS * 1000 + 7, 15)
    meshopt_view(gltf, rows, "ATTRIBUTES", filter="EXPONENTIAL")
    gltf.json["accessors"][0]["bufferView"] = 2
    mesh = load_gltf(write_meshopt(gltf)).meshes[0]
    # 15 bits with a sign, one exponent for a vector below 8192: steps of 1/2, half of them lost. Flat shading keeps
    # the order of corners, here that of the compressed triangles, which may begin elsewhere in each.
    found = np.sort(mesh.positions[mesh.indices].sum(axis=1), axis=0)
    np.testing.assert_allclose(found, np.sort((POSITIONS * 1000 + 7)[TRIANGLES].sum(axis=1), axis=0), atol=0.75)


def test_quaternion_filter(gltf):
    """As rotations of an animation are stored."""
    meshopt_model(gltf)
    angles = np.linspace(0, 3, 16)
    turns = np.column_stack([np.sin(angles / 2), 0 * angles, 0 * angles, np.cos(angles / 2)])
    meshopt_view(gltf, meshopt.encode_filter_quat(turns, 8, 16), "ATTRIBUTES", filter="QUATERNION")
    times = gltf.add(np.arange(16, dtype=np.float32))
    output = {"bufferView": 2, "componentType": 5122, "normalized": True, "type": "VEC4", "count": 16}
    gltf.json["accessors"].append(output)
    target = {"node": 0, "path": "rotation"}
    gltf.json["animations"] = [
        {"samplers": [{"input": times, "output": times + 1}], "channels": [{"sampler": 0, "target": target}]}
    ]
    turned = load_gltf(write_meshopt(gltf)).at(5.0).instances[0].transform
    expected = [[np.cos(angles[5]), -np.sin(angles[5])], [np.sin(angles[5]), np.cos(angles[5])]]
    np.testing.assert_allclose(turned[1:3, 1:3], expected, atol=2e-4)  # 2^-15 in a component, twice in an angle


@pytest.mark.covers("glTF EXT_meshopt_compression", broken=True)
@pytest.mark.parametrize(
    ("key", "value", "problem"),
    [
        ("mode", "POINTS", "'mode'"),
        ("mode", "TRIANGLES", "'byteStride' is 12"),
        ("mode", 3, "text"),
        ("filter", "GAUSSIAN", "'filter'"),
        ("filter", "OCTAHEDRAL", "'byteStride' is 12"),
        ("filter", "QUATERNION", "'byteStride' is 12"),
        ("byteStride", 6, "'byteStride' is 6"),
        ("byteStride", 16, "'byteLength'"),
        ("byteStride", 260, "must be in"),
        ("count", 0, "must be in"),
        ("count", 48, "'byteLength'"),
        ("count", 2**40, "'byteLength'"),
        ("byteLength", 10**6, "are asked for"),
        ("byteLength", 20, "broken"),
        ("byteOffset", 10**6, "are asked for"),
        ("buffer", 1, "are asked for"),
        ("buffer", 2, "asks for buffer"),
    ],
)
def test_wrong_meshopt_extension(gltf, key, value, problem):
    meshopt_model(gltf)[0][key] = value
    error = error_of(write_meshopt(gltf))
    assert error.place.startswith("bufferView 0")
    assert problem in error.problem


@pytest.mark.covers("glTF EXT_meshopt_compression", broken=True)
def test_meshopt_bomb(gltf):
    """A count that a short view may well hold: zeros are two bits for each byte of 256 elements."""
    extension = meshopt_model(gltf)[0]
    extension["count"] = 1 << 24
    gltf.json["bufferViews"][0]["byteLength"] = 12 << 24
    assert "when decompressed" in error_of(write_meshopt(gltf)).problem


@pytest.mark.covers("glTF EXT_meshopt_compression", broken=True)
def test_wrong_meshopt_triangles(gltf):
    extension = meshopt_model(gltf)[1]
    extension["filter"] = "EXPONENTIAL"
    assert "not for mode TRIANGLES" in error_of(write_meshopt(gltf)).problem
    del extension["filter"]
    extension["count"] -= 1
    gltf.json["bufferViews"][1]["byteLength"] -= 4
    assert "whole triangles" in error_of(write_meshopt(gltf)).problem


@pytest.mark.covers("glTF EXT_meshopt_compression", broken=True)
def test_a_buffer_that_stands_in_holds_nothing(gltf):
    meshopt_model(gltf)
    del gltf.json["bufferViews"][0]["extensions"]
    assert "buffer 1 has 0" in error_of(write_meshopt(gltf)).problem


@pytest.mark.covers("glTF EXT_meshopt_compression", broken=True)
def test_mutated_meshopt(gltf):
    meshopt_model(gltf)
    model = write_meshopt(gltf)
    loaded, refused = outcomes(model, gltf.folder / "model.bin", slice(0, len(gltf.data)))
    assert loaded + refused == 400
    assert refused
