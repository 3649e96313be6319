"""`load_scene`: names of built-in scenes, and files by extension."""

from __future__ import annotations

import pytest

from octolux.scene.builtin import BUILTIN
from octolux.scene.errors import SceneError
from octolux.scene.load import load_scene

TRIANGLE = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"


def remedy_of(source) -> SceneError:
    with pytest.raises(SceneError) as caught:
        load_scene(source)
    assert caught.value.file == str(source)
    return caught.value


def test_built_in_scenes_by_name():
    name = next(iter(BUILTIN))
    assert load_scene(name).triangle_count > 0


def test_files_by_extension(tmp_path, gltf):
    (tmp_path / "a.OBJ").write_text(TRIANGLE)
    assert load_scene(tmp_path / "a.OBJ").triangle_count == 1
    assert load_scene(str(gltf.triangle().write())).triangle_count == 1


def test_nearly_a_built_in_name_or_a_file():
    name = next(iter(BUILTIN))
    assert f"'{name}'" in remedy_of(name[:-1]).remedy


def test_nearly_a_file(tmp_path):
    (tmp_path / "Sponza.obj").write_text(TRIANGLE)
    assert "Sponza.obj" in remedy_of(tmp_path / "sponsa.obj").remedy


def test_nothing_near(tmp_path):
    assert next(iter(BUILTIN)) in remedy_of(tmp_path / "zzz" / "q.obj").remedy


def test_directories_unknown_kinds_and_impossible_names(tmp_path):
    assert "directory" in remedy_of(tmp_path).problem
    (tmp_path / "a.xyz").write_text("")
    error = remedy_of(tmp_path / "a.xyz")
    assert "'.xyz'" in error.problem
    assert ".gltf" in error.remedy
    (tmp_path / "plain").write_text("")
    assert "no extension" in remedy_of(tmp_path / "plain").problem
    remedy_of("a\0b.obj")
    remedy_of("a" * 5000 + ".obj")
