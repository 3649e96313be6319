"""The valid scenes that `mutations` damages: one small file of every kind that octolux reads, with what it names.

Some are cut from the data folder's models, others are written here or by the tests of the loaders.
"""

from __future__ import annotations

import importlib.util
import io
import json
import struct
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
from PIL import Image as Pillow

from .lab import data

_TESTS = Path(__file__).resolve().parents[1] / "tests" / "scene"
Files = dict[str, bytes]


@dataclass(frozen=True)
class Original:
    """A valid scene: the name of its main file, and what makes all files by name. share: how often it is taken."""

    main: str
    make: Callable[[], Files]
    share: int = 2
    needs_data: bool = False


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


def pixels(size: int = 24) -> np.ndarray:
    """uint8 (size, size, 3): a pattern that no coder makes trivial."""
    rows, columns = np.indices((size, size))
    return np.stack([rows * 10 % 256, columns * 9 % 256, rows * columns % 251], axis=-1).astype(np.uint8)


def picture(kind: str, **options: Any) -> bytes:
    """A picture of 24 x 24 in a format of Pillow's."""
    stream = io.BytesIO()
    Pillow.fromarray(pixels()).save(stream, kind, **options)
    return stream.getvalue()


def hdr(width: int = 32, height: int = 16) -> bytes:
    """A Radiance picture, each channel of a row one literal and one run."""
    rows = b""
    for row in range(height):
        rows += bytes((2, 2, width >> 8, width & 255))
        for channel in range(4):
            first = bytes(128 if channel == 3 else (row * 9 + i) % 256 for i in range(width // 2))
            rows += bytes((len(first),)) + first + bytes((128 + width - len(first), 129))
    return b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=1.0\n\n-Y %d +X %d\n" % (height, width) + rows


def exr() -> bytes:
    """An OpenEXR picture, compressed."""
    import OpenEXR

    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "sky.exr"
        with OpenEXR.File(header, {"RGB": pixels().astype(np.float32) / 64}) as file:
            file.write(str(path))
        return path.read_bytes()


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


_KINDS = {"png": "PNG", "jpg": "JPEG", "webp": "WEBP", "tga": "TGA", "bmp": "BMP", "tif": "TIFF", "gif": "GIF",
          "dds": "DDS", "ppm": "PPM"}  # fmt: skip
_OBJ = """mtllib model.mtl
v 0 0 0
v 1 0 0
v 1 2 0
v 0 2 3
vt 0 0
vt 1 0
vt 1 1
vn 0 0 1
g near
usemtl oak
f 1/1/1 2/2/1 3/3/1
g far
usemtl pine
f -4/-3/-1 -2/-1/-1 -1/-1/-1
"""


def obj(kind: str) -> Files:
    """Two triangles with three textures of one format: colour, mask and bump."""
    name = f"wood.{kind}"
    text = (f"newmtl oak\nKd 0.5 0.4 0.3\nNs 40\nmap_Kd {name}\nmap_d {name}\nnewmtl pine\nKd 0.2 0.2 0.2\nKs 0.4\n"
            f"Ke 1 2 3\nd 0.5\nillum 3\nmap_Ke -o 1 2 3 {name}\nbump -bm 0.5 {name}\n")  # fmt: skip
    return {"model.obj": _OBJ.encode(), "model.mtl": text.encode(), name: picture(_KINDS[kind])}


_TOML = """name = "hall"
exposure = 2.5
[environment]
radiance = [0.1, 0.2, 0.3]
image = "sky.{sky}"
scale = 2.0
rotate = 30
[animation]
clip = "bend"
[[model]]
file = "model.glb"
unit = "cm"
scale = [1.0, 2.0, 1.0]
rotate = [10, 20, 30]
translate = [1, 2, 3]
normals = "flat"
[[model]]
file = "model.obj"
up = "z"
matrix = [[1, 0, 0, 2], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1]]
drop = ["far"]
[[material]]
name = "oak"
base_color = [0.5, 0.4, 0.3]
emissive = [1, 2, 3]
roughness = 0.5
alpha_mode = "blend"
[[light]]
type = "spot"
name = "spot"
position = [0, 3, 0]
direction = [0, -1, 0.1]
intensity = 100
inner_angle = 20
outer_angle = 30
[[light]]
type = "directional"
name = "sun"
direction = [0, -2, 0]
illuminance = [3, 2, 1]
[[light]]
type = "point"
name = "lamp"
position = [1, 2, 3]
intensity = 60
[[camera]]
name = "eye"
position = [0, 1, 8]
look_at = [0, 0, 0]
up = [0, 1, 0]
vertical_fov = 60
near = 0.05
[[keyframes]]
target = "light:lamp"
property = "position"
times = [0.0, 1.0, 2.0]
values = [[0, 1, 0], [1, 2, 0], [0, 1, 0]]
interpolation = "smooth"
loop = true
[[keyframes]]
target = "camera:eye"
property = "position"
times = [0.0, 2.0]
values = [[0, 1, 8], [1, 2, 8]]
[[keyframes]]
target = "instance:near"
property = "rotation"
times = [0.0, 2.0]
values = [[0, 0, 0, 1], [0, 1, 0, 0]]
"""


def toml(sky: str) -> Files:
    """Every table of a TOML scene; two models, and surroundings in a format of their own."""
    image = {"hdr": hdr, "exr": exr, "png": lambda: picture("PNG")}[sky]()
    return {"scene.toml": _TOML.format(sky=sky).encode(), f"sky.{sky}": image, "model.glb": figure().glb(),
            **obj("png")}  # fmt: skip


def binary_stl() -> bytes:
    corners = struct.pack("<12fH", 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0)
    return bytes(80) + struct.pack("<I", 2) + corners * 2


def bunny(binary: bool) -> Files:
    """The triangles among the first 3,000 vertices of the Stanford bunny."""
    lines = data("scenes", "stanford-bunny", "bun_zipper.ply").read_text().splitlines()
    start = lines.index("end_header") + 1
    count = int(next(line for line in lines if line.startswith("element vertex")).split()[2])
    points = np.array([line.split()[:3] for line in lines[start : start + 3000]], np.float32)
    faces = np.array([line.split()[1:4] for line in lines[start + count :]], np.int64)
    faces = faces[(faces < len(points)).all(axis=1)]
    kind = "binary_little_endian" if binary else "ascii"
    axes = "".join(f"property float {axis}\n" for axis in "xyz")
    head = (f"ply\nformat {kind} 1.0\nelement vertex {len(points)}\n{axes}element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n").encode()  # fmt: skip
    if binary:
        rows = np.zeros(len(faces), np.dtype([("n", "u1"), ("v", "<i4", 3)]))
        rows["n"], rows["v"] = 3, faces
        return {"bunny.ply": head + points.tobytes() + rows.tobytes()}
    texts = [" ".join(f"{v:g}" for v in point) for point in points] + [f"3 {a} {b} {c}" for a, b, c in faces]
    return {"bunny.ply": head + "\n".join(texts).encode() + b"\n"}


def _copied(*names: str) -> Callable[[], Files]:
    """Files of the data folder's `scenes`, flat."""
    return lambda: {Path(name).name: data("scenes", *name.split("/")).read_bytes() for name in names}


def _box(name: str) -> Original:
    path = f"cornell-box/CornellBox-{name}"
    return Original(f"CornellBox-{name}.obj", _copied(f"{path}.obj", f"{path}.mtl"), 3, True)


def _model(folder: str, *names: str, share: int = 4) -> Original:
    return Original(names[0], _copied(*(f"{folder}/{name}" for name in names)), share, True)


_CHAIR = [f"SheenChair{name}.jpg" for name in (
    "BaseColor", "FabricNormal", "FabricOcclusion", "LabelBaseColor", "Occlusion-SheenChairBaseColor",
    "Occlusion-SheenChairWoodMetallicRoughness", "Occlusion", "WoodBaseColor")]  # fmt: skip

ORIGINALS: tuple[Original, ...] = (
    Original("model.gltf", lambda: figure().files(), 8),
    Original("model.glb", lambda: {"model.glb": figure().glb()}, 6),
    Original("model.gltf", textured, 14),
    Original("model.gltf", lambda: draco(True), 4),
    Original("model.gltf", lambda: draco(False), 4),
    Original("model.gltf", compressed, 5),
    *(Original("model.obj", lambda kind=kind: obj(kind), 2) for kind in _KINDS),  # type: ignore[misc]
    *(Original("scene.toml", lambda sky=sky: toml(sky), share)  # type: ignore[misc]
      for sky, share in (("hdr", 5), ("exr", 5), ("png", 2))),
    *(Original(f"square{kind}", lambda kind=kind: {f"square{kind}": _encoded(kind)}, 1)  # type: ignore[misc]
      for kind in of_tests("model_files").FILES),
    Original("square.stl", lambda: {"square.stl": binary_stl()}, 1),
    _model("gltf/01_alpha_mask", "01_alpha_mask.gltf", "01_alpha_mask.bin", "01_alpha_mask.png"),
    _model("gltf/14_emission_strength", "14_emission_strength.gltf", "14_emission_strength.bin",
           "14_emission_strength.png", share=3),
    _model("gltf/23_sparse_multi_prim", "23_multi_prim_vertex_attribute.gltf", "23_multi_prim_vertex_attribute.bin"),
    _model("gltf/Fox", "Fox.glb", share=6),
    _model("gltf/pirate-meshopt", "pirate.glb", share=5),
    _model("cornell-box", "bevy-CornellBox.glb"),
    _model("cornell-box/kajiya-gltf", "scene.gltf", "scene.bin"),
    _model("gltf/Draco-2CylinderEngine", "2CylinderEngine.gltf", "2CylinderEngine.bin", share=1),
    _model("gltf/MixedLightingExample", "MixedLightingExample.gltf", "MixedLightingExample.bin", *_CHAIR, share=1),
    *(_box(name) for name in ("Original", "Mirror", "Empty-CO", "Glossy")),
    Original("bunny.ply", lambda: bunny(True), 2, True),
    Original("bunny.ply", lambda: bunny(False), 1, True),
)  # fmt: skip


def _encoded(kind: str) -> bytes:
    content = of_tests("model_files").FILES[kind]
    return content if isinstance(content, bytes) else content.encode()


@cache
def files_of(number: int) -> Files:
    """The files of ORIGINALS[number] by name. Raises NeedsData when the data folder lacks them."""
    return ORIGINALS[number].make()
