"""Small valid glTF files that between them use all that octolux reads of the format."""

from __future__ import annotations

import importlib.util
import json
import struct
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from .written_pictures import picture

_TESTS = Path(__file__).resolve().parents[1] / "tests" / "scene"
Files = dict[str, bytes]


@cache
def of_tests(name: str) -> ModuleType:
    """A module of tests/scene, which is no package: it holds the smallest valid files of many formats."""
    spec = importlib.util.spec_from_file_location(name, _TESTS / f"{name}.py")
    if spec is None or spec.loader is None:
        raise ImportError(f"there is no {_TESTS / name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


class Gltf:
    """A glTF of one buffer, as `figures.add_strip` of the tests fills it."""

    def __init__(self) -> None:
        self.data = b""
        self.json: dict[str, Any] = {"asset": {"version": "2.0"}, "bufferViews": [], "accessors": []}

    def view(self, raw: bytes, **more: Any) -> int:
        self.data += bytes(-len(self.data) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw), **more})
        self.data += raw
        return len(self.json["bufferViews"]) - 1

    def add(self, array: np.ndarray, **more: Any) -> int:
        kinds = {"int8": 5120, "uint8": 5121, "int16": 5122, "uint16": 5123, "uint32": 5125, "float32": 5126}
        width = 1 if array.ndim == 1 else array.shape[1]
        self.json["accessors"].append({
            "bufferView": self.view(array.tobytes()), "componentType": kinds[array.dtype.name], "count": len(array),
            "type": {1: "SCALAR", 2: "VEC2", 3: "VEC3", 4: "VEC4", 16: "MAT4"}[width], **more,
        })  # fmt: skip
        return len(self.json["accessors"]) - 1

    def files(self, **more: bytes) -> Files:
        """model.gltf and model.bin; other files by name, "_" for the dot."""
        self.json["buffers"] = [{"uri": "model.bin", "byteLength": len(self.data)}]
        others = {name.replace("_", "."): content for name, content in more.items()}
        return {"model.gltf": json.dumps(self.json, indent=1).encode(), "model.bin": self.data, **others}

    def glb(self) -> bytes:
        self.json["buffers"] = [{"byteLength": len(self.data)}]
        return glb(json.dumps(self.json).encode(), self.data)


def glb(text: bytes, binary: bytes) -> bytes:
    """A GLB 2.0 file of a JSON and a binary chunk (glTF 2.0, section 4.4)."""
    text, binary = text + b" " * (-len(text) % 4), binary + bytes(-len(binary) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(binary), b"BIN\0") + binary
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks


def figure() -> Gltf:
    """A skinned strip with morph targets, animations of every path, a camera and lights of every type."""
    made, strip = Gltf(), of_tests("figures")
    primitive = strip.add_strip(made)
    moved = np.zeros((6, 3), np.float32)
    moved[4:, 2] = 1.0
    primitive["targets"] = [{"POSITION": made.add(moved), "NORMAL": made.add(moved)}]
    rows = made.view(np.array([0, 3], np.uint16).tobytes())
    made.json["accessors"].append({
        "componentType": 5126, "count": 6, "type": "VEC4", "bufferView": made.view(np.ones((6, 4), "<f4").tobytes()),
        "sparse": {"count": 2, "indices": {"bufferView": rows, "componentType": 5123},
                   "values": {"bufferView": made.view(np.zeros((2, 4), "<f4").tobytes())}},
    })  # fmt: skip
    primitive["attributes"]["COLOR_0"] = len(made.json["accessors"]) - 1
    strip.add_animation(made, 2, "rotation", [0, 1, 2], [[0, 0, 0, 1], strip.QUARTER_X, [0, 0, 0, 1]], name="bend")
    strip.add_animation(made, 1, "translation", [0, 2], np.zeros((6, 3)), "CUBICSPLINE")
    strip.add_animation(made, 0, "weights", [0, 1], [[0.0], [1.0]], "STEP")
    lights = [{"type": "spot", "spot": {"innerConeAngle": 0.1, "outerConeAngle": 0.6}, "intensity": 50, "name": "s"},
              {"type": "point", "color": [1, 0.5, 0.2]}, {"type": "directional", "intensity": 3}]  # fmt: skip
    made.json["extensions"] = {"KHR_lights_punctual": {"lights": lights}}
    made.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1, "aspectRatio": 1.7}},
                            {"type": "orthographic", "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}]
    for number in range(3):
        extension = {"extensions": {"KHR_lights_punctual": {"light": number}}}
        camera = {"camera": number} if number < 2 else {}
        made.json["nodes"].append({"translation": [0, 1, 3], **camera, **extension})
        made.json["scenes"][0]["nodes"].append(3 + number)
    return made


def textured() -> Files:
    """All texture slots, PNG, JPEG, WebP and KTX2, inside and beside the file, and every extension of materials."""
    made = figure()
    ktx = (_TESTS / "data" / "uastc.ktx2").read_bytes()
    made.json["images"] = [
        {"uri": "a.png"}, {"bufferView": made.view(picture("JPEG")), "mimeType": "image/jpeg"}, {"uri": "b.webp"},
        {"bufferView": made.view(ktx), "mimeType": "image/ktx2"}, {"uri": "c.ktx2"},
    ]  # fmt: skip
    made.json["samplers"] = [{"wrapS": 33071, "wrapT": 33648, "magFilter": 9729}]
    made.json["textures"] = [
        {"source": 0, "sampler": 0}, {"source": 1}, {"extensions": {"EXT_texture_webp": {"source": 2}}},
        {"extensions": {"KHR_texture_basisu": {"source": 3}}}, {"extensions": {"KHR_texture_basisu": {"source": 4}}},
    ]  # fmt: skip
    turned = {"KHR_texture_transform": {"offset": [0.1, 0.2], "rotation": 0.3, "scale": [2, 3], "texCoord": 0}}
    strength = {"KHR_materials_emissive_strength": {"emissiveStrength": 4}, "KHR_materials_specular": {}}
    older = {"diffuseTexture": {"index": 2}, "specularGlossinessTexture": {"index": 1}, "glossinessFactor": 0.5,
             "specularFactor": [0.2, 0.3, 0.4], "diffuseFactor": [1, 1, 1, 0.5]}  # fmt: skip
    made.json["materials"] = [
        {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": turned}, "metallicFactor": 0.5,
                                  "metallicRoughnessTexture": {"index": 1}, "baseColorFactor": [1, 0.5, 1, 1]},
         "normalTexture": {"index": 3, "scale": 0.7}, "emissiveTexture": {"index": 4}, "emissiveFactor": [1, 1, 1],
         "alphaMode": "MASK", "alphaCutoff": 0.4, "doubleSided": True, "extensions": strength},
        {"extensions": {"KHR_materials_pbrSpecularGlossiness": older}, "alphaMode": "BLEND"},
        {"extensions": {"KHR_materials_unlit": {}}, "pbrMetallicRoughness": {"baseColorTexture": {"index": 2}}},
    ]  # fmt: skip
    first = made.json["meshes"][0]["primitives"][0]
    first["material"] = 0
    made.json["meshes"].append({"primitives": [{**first, "material": 1}, {**first, "material": 2}]})
    made.json["nodes"].append({"mesh": 1, "scale": [1, 2, 1]})
    made.json["scenes"][0]["nodes"].append(len(made.json["nodes"]) - 1)
    etc1s = (_TESTS / "data" / "etc1s.ktx2").read_bytes()
    return made.files(a_png=picture("PNG"), b_webp=picture("WEBP", lossless=True), c_ktx2=etc1s)


def _grid() -> tuple[np.ndarray, np.ndarray]:
    """float32 (49, 3) and uint32 (72, 3): a bent sheet of 7 x 7 points."""
    y, x = (axis.ravel() for axis in np.mgrid[0:7, 0:7])
    first = (np.arange(6)[:, None] * 7 + np.arange(6)).ravel()
    triangles = np.concatenate([[first, first + 1, first + 7], [first + 1, first + 8, first + 7]], axis=1).T
    return np.column_stack([x, y, (x * y) % 3]).astype(np.float32), triangles.astype(np.uint32)


def draco(in_order: bool) -> Files:
    """A sheet with Draco data; coded in the order of its faces, or with connectivity of its own (Edgebreaker)."""
    import DracoPy

    made, (points, triangles) = Gltf(), _grid()
    coded = DracoPy.encode(points, triangles, quantization_bits=14, compression_level=7, preserve_order=in_order,
                           tex_coord=points[:, :2].astype(float))  # fmt: skip
    found = DracoPy.decode(coded)
    ids = {attribute["attribute_type"]: attribute["unique_id"] for attribute in found.attributes}
    count, name = len(found.points), "KHR_draco_mesh_compression"
    extension = {"bufferView": made.view(coded), "attributes": {"POSITION": ids[0], "TEXCOORD_0": ids[3]}}
    made.json |= {
        "accessors": [{"componentType": 5126, "type": "VEC3", "count": count},
                      {"componentType": 5126, "type": "VEC2", "count": count},
                      {"componentType": 5123, "type": "SCALAR", "count": triangles.size}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0, "TEXCOORD_0": 1}, "indices": 2,
                                    "extensions": {name: extension}}]}],
        "nodes": [{"mesh": 0}], "extensionsUsed": [name], "extensionsRequired": [name],
    }  # fmt: skip
    return made.files()


def compressed() -> Files:
    """A sheet with meshopt's three modes: attributes, triangles, and a strip's plain indices."""
    import meshopt

    made, (points, triangles) = Gltf(), _grid()
    padded = np.pad(points, ((0, 0), (0, 1)))

    def view(array: np.ndarray, mode: str) -> int:
        stride = array.itemsize * (array.shape[1] if array.ndim > 1 else 1)
        coded = made.view(bytes(meshopt.encode_gltf_buffer(array, mode, 0)))
        listed = made.json["bufferViews"][coded]
        extension = {**listed, "byteStride": stride, "count": len(array), "mode": mode}
        listed |= {"byteOffset": 0, "byteLength": array.nbytes, "extensions": {"EXT_meshopt_compression": extension}}
        if mode == "ATTRIBUTES":
            listed["byteStride"] = stride
        return coded

    flat = triangles.ravel()
    views = view(padded, "ATTRIBUTES"), view(flat, "TRIANGLES"), view(flat[:30].copy(), "INDICES")
    made.json["accessors"] = [{"bufferView": views[0], "componentType": 5126, "type": "VEC3", "count": len(points)}]
    for number, count in ((views[1], triangles.size), (views[2], 30)):
        made.json["accessors"].append({"bufferView": number, "componentType": 5125, "type": "SCALAR", "count": count})
    primitives = [{"attributes": {"POSITION": 0}, "indices": n, "mode": 3 + n} for n in (1, 2)]
    made.json |= {"meshes": [{"primitives": primitives}], "nodes": [{"mesh": 0}],
                  "extensionsRequired": ["EXT_meshopt_compression"]}  # fmt: skip
    return made.files()
