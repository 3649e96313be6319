"""Damaged files of every kind: a scene or one error. `python -m benchmarks mutated` renders 5,000; here are fewer, and
what those have found."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tracemalloc
from pathlib import Path

import numpy as np
import pytest
from PIL import Image as Pillow

from octolux.data import data_folder
from octolux.scene.errors import OctoluxError, SceneError, one_line
from octolux.scene.images import decode as images
from octolux.scene.load import load_scene
from octolux.scene.obj import image_maps

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # benchmarks is not installed

from benchmarks.mutations import mutated, original_of, write_case
from benchmarks.originals import ORIGINALS, files_of

CASES = 300
REPOSITORY = Path(__file__).resolve().parents[2]
HAS_DATA = (data_folder() / "scenes").is_dir()


def formats(with_data: bool) -> set[str]:
    """The formats of models among the cases below."""
    return {Path(ORIGINALS[original_of(10_000 + case, with_data)].main).suffix for case in range(CASES)}


MUTATED = sorted(f"model {suffix}" for suffix in formats(False) & formats(True))


@pytest.mark.parametrize("number", [n for n, o in enumerate(ORIGINALS) if HAS_DATA or not o.needs_data])
def test_originals_are_valid(number, tmp_path):
    for name, content in files_of(number).items():
        (tmp_path / name).write_bytes(content)
    scene = load_scene(tmp_path / ORIGINALS[number].main)
    assert scene.triangle_count
    assert not [warning for warning in scene.warnings if "missing" in warning]


@pytest.mark.covers(*MUTATED, broken=True)
@pytest.mark.parametrize("first", range(0, CASES, 50))
def test_a_scene_or_one_error(first, tmp_path):
    """Cases beyond those of the benchmark. Without the data folder other originals take the place of those in it."""
    refused = 0
    for case in range(10_000 + first, 10_000 + first + 50):
        folder = tmp_path / str(case)
        folder.mkdir()
        path = write_case(case, folder, HAS_DATA)
        try:
            scene = load_scene(path)
            low, high = scene.at(1.0).bounds()
            assert np.isfinite([low, high]).all(), case
        except OctoluxError as error:
            refused += 1
            assert str(error).isprintable() and len(str(error)) < 1000, case
    assert 10 <= refused < 50


def test_a_case_is_the_same_each_time_and_differs_from_its_original():
    cases = range(10_000, 10_200)
    assert all(mutated(case, HAS_DATA) == mutated(case, HAS_DATA) for case in cases[:20])
    unchanged = [case for case in cases if mutated(case, HAS_DATA) == files_of(original_of(case, HAS_DATA))]
    assert len(unchanged) < len(cases) / 20


# What they have found ----------------------------------------------------------------------------------------------

OBJ = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n"


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="needs pipes")
@pytest.mark.parametrize("place", ["mtl", "image", "buffer", "ktx2", "environment", "exr", "main"])
def test_what_is_no_ordinary_file_is_not_read(place, tmp_path, gltf):
    """A scene may name /dev/zero, which has no end, or a pipe that nobody writes to."""
    endless = {"ktx2": "pipe.ktx2", "exr": "pipe.exr", "main": "pipe.obj"}.get(place, "pipe.hdr")
    os.mkfifo(tmp_path / endless)
    (tmp_path / "m.obj").write_text(OBJ.replace("m.mtl", endless) if place == "mtl" else OBJ)
    (tmp_path / "m.mtl").write_text(f"newmtl m\nmap_Kd {endless}\n" if place == "image" else "newmtl m\n")
    (tmp_path / "scene.toml").write_text(f'[[model]]\nfile = "m.obj"\n[environment]\nimage = "{endless}"\n')
    gltf.triangle()
    if place == "ktx2":
        texture = {"extensions": {"KHR_texture_basisu": {"source": 0}}}
        material = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
        gltf.json |= {"images": [{"uri": endless}], "textures": [texture], "materials": [material]}
    gltf.write()
    if place == "buffer":
        gltf.json["buffers"][0]["uri"] = endless
        (tmp_path / "model.gltf").write_text(json.dumps(gltf.json))
    main = {"mtl": "m.obj", "image": "m.obj", "main": endless, "buffer": "model.gltf", "ktx2": "model.gltf"}
    path = tmp_path / main.get(place, "scene.toml")
    with pytest.raises(SceneError):
        load_scene(path)


def test_errors_are_one_short_line():
    error = SceneError("a.gltf", "node 'x\ny'", "'a\nerror: b\x1b[2J\ud800' " + "9" * 5000 + " is wrong", "mend it")
    assert str(error).startswith("a.gltf: node 'x\\ny': 'a\\nerror: b\\x1b[2J\\ud800' 999")
    assert str(error).endswith("9 is wrong. mend it.")
    assert len(str(error)) < 600 and str(error).isprintable()
    assert one_line("as it is", 8) == "as it is"


def test_numbers_of_thousands_of_digits_in_toml(tmp_path):
    (tmp_path / "scene.toml").write_text("exposure = " + "9" * 5000)
    with pytest.raises(SceneError, match="too long"):
        load_scene(tmp_path / "scene.toml")


def test_halves_of_surrogate_pairs_in_names(gltf):
    gltf.triangle().json["nodes"][0]["name"] = "half \ud800"
    assert load_scene(gltf.write()).instances[0].name == "half ?"


def test_coordinates_beyond_all_images(gltf, tmp_path):
    """1e38 squared is infinite, in a shader too, and the picture then not a number."""
    (tmp_path / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 1e38 0.25\nf 1/1 2/1 3/1\n")
    np.testing.assert_array_equal(load_scene(tmp_path / "m.obj").meshes[0].uvs, [[0.0, 0.75]] * 3)
    gltf.triangle()
    uvs = gltf.add(np.array([[3e9, 0.5]] * 3, np.float32))
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs
    np.testing.assert_array_equal(load_scene(gltf.write()).meshes[0].uvs, [[0.0, 0.5]] * 3)
    far = {"KHR_texture_transform": {"scale": [1e20, 1]}}
    gltf.json |= {"materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0, "extensions": far}}}],
                  "textures": [{}]}  # fmt: skip
    with pytest.raises(SceneError, match="beyond"):
        load_scene(gltf.write())


def test_many_primitives_of_the_same_accessor(gltf):
    """A kilobyte of JSON asks for a thousand million vertices."""
    gltf.triangle()
    gltf.json["accessors"][0]["count"] = 1 << 20
    del gltf.json["accessors"][0]["bufferView"]
    gltf.json["meshes"][0]["primitives"] *= 1000
    with pytest.raises(SceneError, match="vertices, more than"):
        load_scene(gltf.write())


def test_toml_files_that_include_each_other_twice(tmp_path):
    for link in range(30):
        other = f'[[model]]\nfile = "{link + 1}.toml"\n'
        (tmp_path / f"{link}.toml").write_text(other * 2)
    (tmp_path / "30.toml").write_text("")
    with pytest.raises(SceneError, match="more than 256"):
        load_scene(tmp_path / "0.toml")


def test_pictures_that_pillow_has_no_code_for(tmp_path):
    header = bytearray(files_of(next(n for n, o in enumerate(ORIGINALS) if "wood.dds" in o.make()))["wood.dds"])
    header[80:84] = (1 << 14).to_bytes(4, "little")  # flags of a pixel format that does not exist
    (tmp_path / "a.dds").write_bytes(header)
    with pytest.raises(SceneError, match="no readable picture"):
        images.load_image(tmp_path / "a.dds", "a.dds")


def test_large_pictures_take_little_more_than_their_pixels(tmp_path, monkeypatch):
    """Colour, mask and heights; what is worked on at once is made as small against them as it is for the largest."""
    for module in (images, image_maps):
        monkeypatch.setattr(module, "_BAND", module._BAND >> 6)
    Pillow.new("1", (1024, 1024), 1).save(tmp_path / "a.png")
    (tmp_path / "m.obj").write_text("mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n")
    (tmp_path / "m.mtl").write_text("newmtl m\nmap_Kd a.png\nmap_d a.png\nbump a.png\n")
    material = load_scene(tmp_path / "m.obj").materials[0]
    for texture in (material.base_color_texture, material.normal_texture):
        tracemalloc.start()
        assert texture.image.pixels.shape == (1024, 1024, 4)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 3 * texture.image.pixels.nbytes


def test_names_that_are_not_utf8(tmp_path):
    text = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\ng Tür\nusemtl Grün\nf 1 2 3\n"
    (tmp_path / "m.obj").write_bytes(text.encode("latin-1"))
    (tmp_path / "m.mtl").write_bytes("newmtl Grün\nKd 0 1 0\n".encode("latin-1"))
    scene = load_scene(tmp_path / "m.obj")
    assert scene.instances[0].name == "T\ufffdr"
    assert scene.materials[0].base_color == (0.0, 1.0, 0.0)
    assert not scene.warnings


def test_a_case_is_written_by_its_number(tmp_path):
    case = next(case for case in range(100) if original_of(case) < 10)  # none of the data folder
    words = [sys.executable, "-m", "benchmarks.mutations", str(case), str(tmp_path / "case")]
    done = subprocess.run(words, cwd=REPOSITORY, capture_output=True, text=True, timeout=60)
    assert Path(done.stdout.strip()).parent == tmp_path / "case", done.stderr
    assert {path.name: path.read_bytes() for path in (tmp_path / "case").iterdir()} == mutated(case)


@pytest.mark.filterwarnings("error")
def test_tangents_of_any_length(gltf):
    attributes = gltf.triangle().json["meshes"][0]["primitives"][0]["attributes"]
    attributes["NORMAL"] = gltf.add(np.array([[0, 0, 1]] * 3, np.float32))
    attributes["TANGENT"] = gltf.add(np.array([[1e38, 0, 0, 1], [1, 0, 0, 1], [0.5, 0, 0, 1]], np.float32))
    np.testing.assert_array_equal(load_scene(gltf.write()).meshes[0].tangents, [[1, 0, 0, 1]] * 3)
