"""`octolux compare`: files, exit codes, and errors in one line with nothing written."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest

from octolux.cli import main

SMALL = ("--size", "24x18", "--frames", "1", "--shadow-resolution", "64", "--rsm-resolution", "16")
RUN = ("--technique", "none", "--reference", "constant,red=2")


@pytest.fixture
def run(monkeypatch, capsys, tmp_path):
    """`run("cornell-box")`: exit code, what was printed, and what on stderr; in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")

    def call(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["octolux", "compare", *words])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(bool(stop.code))
        return code, *capsys.readouterr()

    return call


def test_a_report_and_a_limit(run, tmp_path):
    """A technique without indirect light has none of its energy: |0 - 1| is above one half, and not above one."""
    limits = ("--fail-above", "energy_error=0.5", "--fail-above", "constant:energy_error=0.5")
    code, out, err = run("cornell-box", *SMALL, *RUN, "--out", "here", *limits)
    assert code == 1
    assert err.splitlines()[-1] == "above the limit: none: energy_error is 1 (energy_error=0.5)"
    assert "wrote here/report.json and here/report.html" in out
    assert sorted(p.name for p in (tmp_path / "here").iterdir()) == ["report.html", "report.json"]
    data = json.loads((tmp_path / "here" / "report.json").read_text())
    assert data["command"].startswith("octolux compare cornell-box --size 24x18")
    assert [t["label"] for t in data["techniques"]] == ["none", "constant", "black"]
    # Again, over what is there, and within the limit.
    code, _, _ = run("cornell-box", *SMALL, *RUN, "--out", "here", "--fail-above", "energy_error=1")
    assert code == 0


def test_settings_that_all_techniques_share(run, tmp_path):
    words = ("--no-normal-maps", "--shadow-filter", "1", "--no-inverse-square")
    assert run("cornell-box", *SMALL, *RUN, *words)[0] == 0
    settings = json.loads((tmp_path / "comparison" / "report.json").read_text())["frame_settings"]
    assert (settings["normal_maps"], settings["shadow_filter"], settings["inverse_square"]) == (False, 1, False)


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["cornel-box"], ["'cornell-box'"]),
        (["cornell-box", "--technique", "unifrom-lpv"], ["'uniform-lpv'"]),
        (["cornell-box", "--reference", "unifrom-lpv"], ["'uniform-lpv'"]),
        (["cornell-box", "--reference", "a.npz"], ["a.npz", "no such file"]),
        (["cornell-box", "--reference", "nan.npz"], ["nan.npz", "NaN"]),
        (["cornell-box", "--reference", "good.npz", "--size", "32x24"], ["24x18", "32x24", "--size 24x18"]),
        (["cornell-box", "--reference", "good.npz", "--reference-samples", "4"], ["--reference-samples"]),
        (["cornell-box", "--size", "big"], ["--size"]),
        (["cornell-box", "--shadow-filter", "0", "--reference", "none"], ["shadow_filter"]),
        (["cornell-box", "--size", "8x8", "--reference", "none"], ["11x11"]),
        (["cornell-box", "--fail-above", "flap=1"], ["'flip'"]),
        (["cornell-box", "--technique", "none", "--fail-above", "uniform-lpv:flip=1"], ["not compared"]),
        (["cornell-box", "--out", "no/where"], ["mkdir"]),
        (["cornell-box", "--out", "good.npz"], ["is a file"]),
        (["cornell-box", "--camera", "back", "--reference", "none"], ["'back'", "'front'"]),
    ],
    ids=lambda value: " ".join(value),
)
def test_wrong_words(run, tmp_path, words, says):
    picture = np.ones((18, 24, 3), np.float32)
    arrays = {"direct": picture, "all_indirect": picture, "mask": np.ones((18, 24), bool)}
    np.savez(tmp_path / "good.npz", **arrays)
    np.savez(tmp_path / "nan.npz", **arrays | {"all_indirect": picture * np.nan})
    code, out, err = run(*words)
    lines = [line for line in err.splitlines() if line != "direct light"]  # how far it is
    assert (code, out, len(lines)) == (2, "", 1)
    assert lines[0].startswith("error: ")
    assert all(word in lines[0] for word in says)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["good.npz", "nan.npz"]


def test_a_full_disk_leaves_the_old_report(run, tmp_path, monkeypatch):
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "report.json").write_text("precious")

    def fail(handle: int) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("octolux.output.atomic.os.fsync", fail)
    code, _, err = run("cornell-box", *SMALL, *RUN, "--out", "here")
    assert code == 2 and "No space left" in err
    assert [(p.name, p.read_text()) for p in (tmp_path / "here").iterdir()] == [("report.json", "precious")]
