"""docs/formats.md says what the tests cover, and they cover every format, extension and output."""

from __future__ import annotations

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).resolve().parent.parent / "scripts" / "formats_table.py"


@pytest.fixture(scope="module")
def table():
    spec = importlib.util.spec_from_file_location("formats_table", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    sys.modules["formats_table"] = module  # its dataclass looks itself up there
    spec.loader.exec_module(module)
    return module


def test_the_page_is_what_the_tests_say_and_nothing_is_left_out():
    """In a process of its own, as pytest collects there."""
    done = subprocess.run([sys.executable, str(SCRIPT), "--check"], capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.fixture
def found(table):
    """All that is known, each with one test."""
    collector = table.Collector()
    for kind, names in table.KINDS.items():
        for name in names:
            collector.add(f"{kind} {name}", "tests/test_formats.py")
    assert table.problems(collector.found) == []
    return collector.found


@pytest.mark.parametrize("feature", ["model .fbx", "glTF KHR_texture_basisu", "glTF skins", "image DDS", "output .gif"])
def test_what_no_test_covers_is_named(table, found, feature):
    del found[feature]
    assert table.problems(found) == [f"no test covers '{feature}'"]
    collector = table.Collector()
    collector.found = found
    collector.add(feature, "tests/test_formats.py", broken=True)  # that it fails does not say that it works
    assert table.problems(found) == [f"no test covers '{feature}'"]


def test_unknown_features_and_missing_files_are_named(table, found, tmp_path, monkeypatch):
    (tmp_path / "scenes").mkdir()
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path))
    found["image JPG"] = table.Coverage()
    found["image PNG"].files = {"tests/test_formats.py", "gone.png"}
    unknown, gone = table.problems(found)
    assert "'image JPG'" in unknown
    assert "'gone.png'" in gone


def test_the_page_has_a_row_of_each(table, found):
    found["model .ply"].files = {"a/1.ply", "a/2.ply", "a/3.ply", "a/4.ply", "b.ply"}
    found["model .ply"].broken["tests/test_formats.py"] += 2
    text = table.page(found)
    test = "[test_formats.py](../tests/test_formats.py)"
    assert f"| `.ply` | made by the tests, 4 of `a/`, `b.ply` | {test} 1 | {test} 2 |" in text
    assert f"| `KHR_materials_unlit` | made by the tests | {test} 1 | |" in text
    assert text.count("\n| ") == sum(map(len, table.KINDS.values())) + len(table.KINDS)  # and heads
