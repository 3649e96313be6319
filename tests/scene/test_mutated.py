"""Damaged files of every kind: a scene or one error. `python -m benchmarks mutated` renders 5,000; here are fewer, and
what those have found."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import numpy as np
import pytest

from octolux.data import data_folder
from octolux.scene.errors import OctoluxError, SceneError, one_line
from octolux.scene.load import load_scene

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))  # benchmarks is not installed

from benchmarks.mutations import mutated, original_of, write_case
from benchmarks.originals import ORIGINALS, files_of

CASES = 300
HAS_DATA = (data_folder() / "scenes").is_dir()


@pytest.mark.parametrize("number", [n for n, o in enumerate(ORIGINALS) if HAS_DATA or not o.needs_data])
def test_originals_are_valid(number, tmp_path):
    for name, content in files_of(number).items():
        (tmp_path / name).write_bytes(content)
    scene = load_scene(tmp_path / ORIGINALS[number].main)
    assert scene.triangle_count
    assert not [warning for warning in scene.warnings if "missing" in warning]


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
