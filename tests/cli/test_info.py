"""`octolux info`: what is inside, and what is wrong."""

from __future__ import annotations

import base64
import json
import struct

import numpy as np
import pytest
from PIL import Image as Pillow

from octolux.data import data_folder
from octolux.info import _extensions, scene_facts, size_hint
from octolux.scene.builtin import BUILTIN

OBJ = "mtllib m.mtl\nv 0 0 0\nv 3000 0 0\nv 0 2000 0\nvt 0 0\nusemtl leaf\nf 1/1 2/1 3/1\n"


@pytest.fixture
def model(folder):
    (folder / "m.obj").write_text(OBJ)
    (folder / "m.mtl").write_text("newmtl leaf\nmap_Kd c.png\nmap_d d.png\nbump gone.png\n")
    for name in ("c.png", "d.png"):
        Pillow.fromarray(np.zeros((300, 200, 3), np.uint8)).save(folder / name)
    return folder


def test_a_model_as_text(run, model):
    result = run("info", "m.obj")
    assert result.code == 0
    for text in ("m.obj: obj, ", "1 triangles, 3 vertices, 1 meshes", "size 3000 x 2000 x 0 m", "centimetres", "30 m",
                 "leaf: mask, double sided; textures: base_color, normal", "200 x 300, base color", "gone.png",
                 "exposure: metered"):  # fmt: skip
        assert text in result.out


def test_the_same_as_json(run, model):
    facts = json.loads(run("info", "m.obj", "--json").out)
    assert (facts["triangles"], facts["format"], facts["size"]) == (1, "obj", [3000, 2000, 0])
    assert facts["file_bytes"] == len(OBJ)
    (first, second) = facts["textures"]
    # 512 across is the next class above 300; levels of 512 to 1 texel hold (4^10 - 1) / 3 texels of four bytes.
    assert (first["width"], first["height"], first["bytes"]) == (200, 300, 4 * (4**10 - 1) // 3)
    assert second["used_as"] == ["normal"]
    assert any("gone.png" in warning for warning in facts["warnings"])


@pytest.mark.parametrize("name", ["cornell-box", "furnace"])
def test_a_built_in_scene(run, name):
    facts = json.loads(run("info", name, "--json").out)
    scene = BUILTIN[name]()
    assert facts["format"] == "built-in" and facts["file_bytes"] is None
    assert facts["triangles"] == scene.triangle_count
    assert [light["unit"] for light in facts["lights"]] == ["candela"] * len(scene.lights)
    assert facts["exposure"] == scene.exposure
    assert len(facts["cameras"]) == len(scene.cameras)


def test_lights_cameras_and_clips(run, folder):
    (folder / "s.toml").write_text(
        '[environment]\nradiance = 2\n'
        '[[light]]\ntype = "directional"\nname = "sun"\ndirection = [0, -1, 0]\nilluminance = 7\n'
        '[[light]]\ntype = "area"\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nradiance = 3\n'
        '[[camera]]\nname = "eye"\nposition = [0, 0, 5]\nlook_at = [0, 0, 0]\nvertical_fov = 30\n'
        '[[keyframes]]\ntarget = "light:sun"\nproperty = "direction"\ntimes = [0, 2.5]\nvalues = [[0,-1,0],[1,-1,0]]\n'
    )
    text = run("info", "s.toml").out
    for line in ("sun: directional, (7, 7, 7) lux", "area, (3, 3, 3) nits", "eye: at (0, 0, 5), 30 degrees",
                 "2.5 s, 1 tracks", "environment: (2, 2, 2) nits"):  # fmt: skip
        assert line in text


def test_extensions(folder):
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0)], np.float32).tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(points).decode()
    text = json.dumps({
        "asset": {"version": "2.0"}, "extensionsUsed": ["KHR_materials_unlit"], "nodes": [{"mesh": 0}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", "count": 3}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": uri, "byteLength": 36}],
    })  # fmt: skip
    (folder / "s.gltf").write_text(text)
    chunk = text.encode() + b" " * (-len(text) % 4)
    head = b"glTF" + struct.pack("<III4s", 2, 20 + len(chunk), len(chunk), b"JSON")
    (folder / "s.glb").write_bytes(head + chunk)
    for name in ("s.gltf", "s.glb"):
        assert scene_facts(str(folder / name))["extensions"] == ["KHR_materials_unlit"]


def test_bad_files_are_one_line_and_exit_2(run, folder):
    (folder / "bad.ply").write_text("ply\n")
    for name in ("bad.ply", "none.obj", "cornell-bx"):
        result = run("info", name)
        assert (result.code, result.out) == (2, "")
        assert result.err.startswith("error: ") and result.err.count("\n") == 1


def test_hints():
    assert size_hint(3721) == 'perhaps it is in centimetres: unit = "cm" in a TOML scene makes it 37.2 m'
    assert "millimetres" in size_hint(60_000)
    assert size_hint(40.0) == size_hint(0.15) == ""
    assert "larger than a metre" in size_hint(0.001)


def test_names_are_printed_on_one_line(run, folder):
    (folder / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    (folder / "a.toml").write_text('[[model]]\nfile = "m.obj"\n[[light]]\ntype = "point"\nposition = [0, 0, 0]\n'
                                   'intensity = 1\nname = "la\\nmp"\n')  # fmt: skip
    assert "  la\\nmp: point" in run("info", "a.toml").out


def test_a_binary_gltf_by_another_name(run, folder):
    text = b'{"asset": {"version": "2.0"}, "extensionsUsed": ["X_y"], "meshes": [], "nodes": []}'
    chunk = struct.pack("<I4s", len(text), b"JSON") + text
    (folder / "a.gltf").write_bytes(struct.pack("<4sII", b"glTF", 2, 12 + len(chunk)) + chunk)
    assert _extensions(folder / "a.gltf") == ["X_y"]


def test_a_picture_that_is_too_large_is_one_line(run, folder):
    """Pillow warns of it on stderr in its own words."""
    (folder / "m.obj").write_text(OBJ)
    (folder / "m.mtl").write_text("newmtl leaf\nmap_Kd c.ppm\n")
    (folder / "c.ppm").write_bytes(b"P6 16384 8192 255 \0")
    result = run("info", "m.obj")
    assert (result.code, result.err.count("\n")) == (2, 1)
    assert "16384 x 8192 pixels" in result.err


def test_every_broken_file_is_refused(run, folder):
    broken = data_folder() / "scenes" / "broken"
    if not broken.is_dir():
        pytest.skip("needs OCTOLUX_DATA")
    for scene in sorted(p for p in broken.rglob("*") if p.suffix in {".obj", ".gltf", ".glb"}):
        result = run("info", str(scene))
        assert (result.code, result.out, result.err.count("\n")) == (2, "", 1)
        assert result.err.startswith("error: ") and scene.name in result.err
