"""Broken glTF files: one SceneError that names file, place, problem and remedy, whatever the file holds."""

from __future__ import annotations

import copy
import json
import random
import struct
import tracemalloc

import numpy as np
import pytest

from octolux.scene.errors import SceneError
from octolux.scene.gltf.loader import load_gltf

pytestmark = pytest.mark.covers("model .gltf", broken=True)


def error_of(path) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_gltf(path)
    error = caught.value
    assert error.file == str(path)
    assert error.problem
    assert error.remedy
    return error


def change(gltf, keys, value) -> None:
    target = gltf.json
    for key in keys[:-1]:
        target = target[key]
    target[keys[-1]] = value


PRIMITIVE = ("meshes", 0, "primitives", 0)


@pytest.mark.parametrize(
    ("keys", "value", "place"),
    [
        (("asset",), {"version": "1.0"}, "asset"),
        (("extensionsRequired",), ["KHR_materials_volume"], "extensionsRequired"),
        (("accessors", 0, "count"), 4, "accessor 0"),
        (("accessors", 0, "count"), -1, "accessor 0"),
        (("accessors", 0, "byteOffset"), 2**40, "accessor 0"),
        (("accessors", 0, "type"), "VEC2", "accessor 0"),
        (("accessors", 0, "componentType"), 7, "accessor 0"),
        (("accessors", 0, "bufferView"), 9, "accessor 0"),
        (("accessors", 1, "componentType"), 5122, "accessor 1"),
        (("bufferViews", 0, "byteLength"), 10**6, "bufferView 0"),
        (("bufferViews", 0, "buffer"), "x", "bufferView 0"),
        ((*PRIMITIVE, "indices"), 77, "mesh 0 primitive 0"),
        ((*PRIMITIVE, "mode"), 7, "mesh 0 primitive 0"),
        ((*PRIMITIVE, "material"), 0, "mesh 0 primitive 0"),
        ((*PRIMITIVE, "attributes"), [], "mesh 0 primitive 0"),
        (("meshes", 0, "primitives"), [], "mesh 0"),
        (("nodes", 0, "mesh"), 3, "node 0"),
        (("nodes", 0, "scale"), [1, 1], "node 0"),
        (("nodes", 0, "rotation"), [0, 0, 0, 0], "node 0"),
        (("nodes", 0, "children"), [0], "node 0"),
        (("nodes",), [{"mesh": 0, "children": [1]}, {"children": [2]}, {"children": [1]}], "node 1"),
        (("nodes",), [], "nodes"),
        (("images",), [5], ""),
    ],
)
def test_a_wrong_value_is_named(gltf, keys, value, place):
    gltf.triangle()
    change(gltf, keys, value)
    assert error_of(gltf.write()).place == place


def test_indices_positions_and_buffers(gltf):
    gltf.triangle()
    path = gltf.write()
    data = bytearray(gltf.data)
    (gltf.folder / "model.bin").write_bytes(data[:-1])
    assert error_of(path).place == "buffer 0"
    (gltf.folder / "model.bin").write_bytes(data[:-2] + struct.pack("<H", 3))
    assert "index 3 of only 3" in error_of(path).problem
    (gltf.folder / "model.bin").write_bytes(struct.pack("<f", np.nan) + data[4:])
    assert error_of(path).place == "accessor 0"
    (gltf.folder / "model.bin").write_bytes(bytes(36) + data[36:])
    assert "area" in error_of(path).problem
    (gltf.folder / "model.bin").unlink()
    assert "model.bin" in error_of(path).problem


def test_huge_counts_allocate_nothing(gltf):
    gltf.triangle()
    gltf.json["accessors"][0] = {"componentType": 5126, "type": "VEC3", "count": 2**40}
    path = gltf.write()
    tracemalloc.start()
    error_of(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 10 * 2**20


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"{",
        b"[]",
        b"\xff\xfe\x00",
        b"[" * 100_000,
        b'{"asset": {"version": "2.0"}, "nodes": [{"scale": [NaN, 1, 1]}]}',
        b'{"asset": {"version": "2.0"}, "scene": ' + b"9" * 5000 + b"}",
        b"glTF\x02\0\0\0",
        struct.pack("<4sII", b"glTF", 1, 20) + bytes(8),
        struct.pack("<4sIIII", b"glTF", 2, 20, 2**31, 0x4E4F534A),
        struct.pack("<4sIIII", b"glTF", 2, 20, 0, 0x004E4942),
        struct.pack("<4sIIII", b"glTF", 2, 12, 0, 0x4E4F534A),
    ],
)
def test_containers(tmp_path, content):
    path = tmp_path / "model.gltf"
    path.write_bytes(content)
    error_of(path)


def test_a_file_that_is_not_there(tmp_path):
    assert "No such file" in error_of(tmp_path / "none.gltf").problem


BAD = [
    None,
    -1,
    0,
    1,
    2**31,
    2**63,
    10**400,
    1e308,
    "x",
    "",
    True,
    [],
    {},
    [[]],
    1.5,
    [None] * 3,
    "\0",
    "data:;base64,A",
]


def _paths(value, path=()):
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    return [path, *(found for key, below in inside for found in _paths(below, (*path, key)))]


@pytest.mark.parametrize("seed", range(4))
def test_mutated_files_load_or_raise_scene_error(gltf, picture, seed):
    gltf.triangle()
    picture("t.png", (1, 2, 3))
    gltf.json |= {
        "images": [{"uri": "t.png"}],
        "textures": [{"source": 0, "sampler": 0}],
        "samplers": [{"wrapS": 33071}],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "texCoord": 0}}}],
        "cameras": [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}],
        "extensions": {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}, "color": [1, 1, 1]}]}},
        "scenes": [{"nodes": [0, 1]}],
    }
    gltf.json["nodes"].append({"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}, "matrix": [1] * 16})
    gltf.write()
    dice, whole, refused = random.Random(seed), copy.deepcopy(gltf.json), 0
    for _ in range(150):
        gltf.json = copy.deepcopy(whole)
        change(gltf, dice.choice(_paths(gltf.json)[1:]), copy.deepcopy(dice.choice(BAD)))
        path = gltf.folder / "mutated.gltf"
        path.write_text(json.dumps(gltf.json))
        try:
            load_gltf(path)
        except SceneError:
            refused += 1
    assert refused > 50
