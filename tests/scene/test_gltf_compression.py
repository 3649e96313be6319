"""Draco, meshopt and Basis Universal: what is decoded, and what broken data says."""

from __future__ import annotations

import json
import struct
import subprocess
import sys
from pathlib import Path

import DracoPy
import meshopt
import numpy as np
import pytest

from octolux.scene import gltf_basisu
from octolux.scene.errors import SceneError
from octolux.scene.gltf import load_gltf

SIDE = 7
Y, X = (axis.ravel() for axis in np.mgrid[0:SIDE, 0:SIDE])
POSITIONS = np.column_stack([X, Y, (X * Y) % 3]).astype(np.float32)
UVS = np.column_stack([X, Y]).astype(np.float32) / 8
FIRST = (np.arange(SIDE - 1)[:, None] * SIDE + np.arange(SIDE - 1)).ravel()
TRIANGLES = np.concatenate(
    [np.column_stack([FIRST, FIRST + 1, FIRST + SIDE]), np.column_stack([FIRST + 1, FIRST + SIDE + 1, FIRST + SIDE])]
).astype(np.uint32)
DATA = Path(__file__).parent / "data"


def corners(positions, triangles) -> list:
    """The triangles by the places of their corners, whichever triangle, corner or vertex comes first."""
    listed = np.asarray(positions, np.float64)[triangles].round(3).tolist()
    return sorted(min(triangle[turn:] + triangle[:turn] for turn in range(3)) for triangle in listed)


def error_of(path) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_gltf(path)
    assert caught.value.remedy
    return caught.value


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


def test_meshopt_bomb(gltf):
    """A count that a short view may well hold: zeros are two bits for each byte of 256 elements."""
    extension = meshopt_model(gltf)[0]
    extension["count"] = 1 << 24
    gltf.json["bufferViews"][0]["byteLength"] = 12 << 24
    assert "when decompressed" in error_of(write_meshopt(gltf)).problem


def test_wrong_meshopt_triangles(gltf):
    extension = meshopt_model(gltf)[1]
    extension["filter"] = "EXPONENTIAL"
    assert "not for mode TRIANGLES" in error_of(write_meshopt(gltf)).problem
    del extension["filter"]
    extension["count"] -= 1
    gltf.json["bufferViews"][1]["byteLength"] -= 4
    assert "whole triangles" in error_of(write_meshopt(gltf)).problem


def test_a_buffer_that_stands_in_holds_nothing(gltf):
    meshopt_model(gltf)
    del gltf.json["bufferViews"][0]["extensions"]
    assert "buffer 1 has 0" in error_of(write_meshopt(gltf)).problem


needs_decoder = pytest.mark.skipif(not gltf_basisu.is_available(), reason="opengl-basisu has no wheel for this system")


def basis_model(gltf, data: bytes | None, required: bool = True, source: int | None = None) -> None:
    gltf.triangle()
    if data is not None:
        (gltf.folder / "picture.ktx2").write_bytes(data)
    texture = {"extensions": {"KHR_texture_basisu": {"source": 0}}} | ({} if source is None else {"source": source})
    gltf.json |= {
        "images": [{"uri": "picture.ktx2", "mimeType": "image/ktx2"}, {"uri": "plain.png"}],
        "textures": [texture],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "extensionsUsed": ["KHR_texture_basisu"],
    }
    if required:
        gltf.json["extensionsRequired"] = ["KHR_texture_basisu"]


@needs_decoder
@pytest.mark.parametrize("name", ["etc1s", "uastc", "uastc-zstd"])
def test_basis(gltf, name):
    """Pictures of 8 x 12: red, green and half transparent blue stripes, the right half darker."""
    basis_model(gltf, (DATA / f"{name}.ktx2").read_bytes())
    image = load_gltf(gltf.write()).materials[0].base_color_texture.image
    assert image.size == (8, 12)
    expected = [[(200, 40, 40, 255), (100, 20, 20, 255)], [(40, 200, 40, 255), (20, 100, 20, 255)]]
    expected.append([(40, 40, 200, 128), (20, 20, 100, 128)])
    # ETC1S has five bits for a block's colour and shares colours among blocks.
    tolerance = 255 / 31 if name == "etc1s" else 1
    np.testing.assert_allclose(image.pixels[1::4, 1::4].astype(int), expected, atol=tolerance)


@needs_decoder
@pytest.mark.parametrize(
    ("change", "problem"),
    [
        (lambda data: b"", "does not begin"),
        (lambda data: data[:90], "does not begin"),
        (lambda data: data[:-40], "no readable"),
        (lambda data: b"\x89PNG" + data[4:], "does not begin"),
        (lambda data: data[:20] + struct.pack("<2I", 60000, 60000) + data[28:], "more than"),
        (lambda data: data[:20] + struct.pack("<2I", 0, 12) + data[28:], "two dimensions"),
        (lambda data: data[:36] + struct.pack("<I", 6) + data[40:], "two dimensions"),
        (lambda data: data[:88] + struct.pack("<Q", 2**40) + data[96:], "within its pixels"),
        (lambda data: data[:96] + struct.pack("<Q", 2**40) + data[104:], "too many"),
        (lambda data: data[:44] + struct.pack("<I", 99) + data[48:], "no readable"),
    ],
)
def test_broken_basis(gltf, change, problem):
    basis_model(gltf, change((DATA / "uastc-zstd.ktx2").read_bytes()))
    error = error_of(gltf.write())
    assert error.place == "image 0"
    assert problem in error.problem


@needs_decoder
def test_missing_basis_picture(gltf):
    basis_model(gltf, None)
    scene = load_gltf(gltf.write())
    assert tuple(scene.materials[0].base_color_texture.image.pixels[0, 0]) == (255, 0, 255, 255)
    assert "picture.ktx2 is missing" in scene.warnings[0]


def test_basis_without_its_decoder(gltf, picture, monkeypatch):
    monkeypatch.setattr(gltf_basisu, "opengl_basisu", None)
    picture("plain.png", (1, 2, 3))
    basis_model(gltf, b"", required=False, source=1)
    scene = load_gltf(gltf.write())
    assert tuple(scene.materials[0].base_color_texture.image.pixels[0, 0]) == (1, 2, 3, 255)
    assert scene.warnings == ["texture 0: KHR_texture_basisu needs the package opengl-basisu; its plain image is taken"]
    del gltf.json["textures"][0]["source"]
    assert "opengl-basisu" in error_of(gltf.write()).remedy


# Loads copies of a model with bytes changed; prints how many loads ended how. 2 GiB of address space beyond what the
# imports take is the most that any may use: allocations above it fail and would be a MemoryError, not a SceneError.
MUTATE = """
import random, sys
from collections import Counter
from pathlib import Path

from octolux.scene.errors import SceneError
from octolux.scene.gltf import load_gltf

model, target, first, last = Path(sys.argv[1]), Path(sys.argv[2]), int(sys.argv[3]), int(sys.argv[4])
if sys.platform == "linux":
    import resource
    taken = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (taken + (2 << 30),) * 2)
good, chance, ends = target.read_bytes(), random.Random(7), Counter()
for _ in range(400):
    data = bytearray(good)
    for _ in range(chance.choice((1, 1, 2, 5))):
        place = chance.randrange(first, last)
        data[place] = chance.choice((chance.randrange(256), 255, data[place] ^ 1 << chance.randrange(8)))
    target.write_bytes(data)
    try:
        load_gltf(model)
        ends["loaded"] += 1
    except SceneError:
        ends["refused"] += 1
print(ends["loaded"], ends["refused"])
"""


def outcomes(model: Path, target: Path, part: slice) -> tuple[int, int]:
    command = [sys.executable, "-c", MUTATE, str(model), str(target), str(part.start), str(part.stop)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    loaded, refused = map(int, done.stdout.split())
    return loaded, refused


def test_mutated_draco(gltf, draco):
    model = gltf.write()
    loaded, refused = outcomes(model, gltf.folder / "model.bin", slice(0, len(gltf.data)))
    assert loaded + refused == 400
    assert refused


def test_mutated_meshopt(gltf):
    meshopt_model(gltf)
    model = write_meshopt(gltf)
    loaded, refused = outcomes(model, gltf.folder / "model.bin", slice(0, len(gltf.data)))
    assert loaded + refused == 400
    assert refused


@needs_decoder
@pytest.mark.parametrize("name", ["etc1s", "uastc-zstd"])
def test_mutated_basis(gltf, name):
    data = (DATA / f"{name}.ktx2").read_bytes()
    basis_model(gltf, data)
    loaded, refused = outcomes(gltf.write(), gltf.folder / "picture.ktx2", slice(0, len(data)))
    assert loaded + refused == 400
    assert refused
