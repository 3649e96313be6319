"""What a user can mend is one line on stderr and exit code 2; nothing is written, no file that was there is lost."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import octolux
from octolux import output
from octolux.cli import app
from octolux.data import data_folder
from octolux.gpu import device as device_module
from octolux.output.options import FileOptions

COMMANDS = [command.callback.__name__ for command in app.registered_commands if command.callback]


def check_refused(result, *words: str) -> None:
    assert result.code == 2
    assert result.out == ""
    assert result.err.startswith("error: ")
    assert result.err.count("\n") == 1
    for word in words:
        assert word in result.err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["cornel-box"], ["cornel-box", "'cornell-box'"]),
        (["nothing.obj"], ["nothing.obj", "no such file"]),
        (["cornell-box", "--technique", "unifrom-lpv"], ["'uniform-lpv'"]),
        (["cornell-box", "--preset", "thsis"], ["'thesis'"]),
        (["cornell-box", "--set", "itrations=3"], ["'iterations'"]),
        (["cornell-box", "--set", "n=17"], ["'n'", "16, 32, 64", "17"]),
        (["cornell-box", "--set", "n=many"], ["'n'", "16, 32, 64", "many"]),
        (["cornell-box", "--set", "iterations=-1"], ["'iterations'", "0 to 256"]),
        (["cornell-box", "--set", "damping=perhaps"], ["'damping'"]),
        (["cornell-box", "--set", "n"], ["key=value"]),
        (["cornell-box", "--technique", "none", "--set", "n=16"], ["'n'"]),
        (["cornell-box", "--technique", "octree-lpv", "--set", "n=48"], ["'n'", "16, 32, 64, 128", "48"]),
        (["cornell-box", "--technique", "octree-lpv", "--set", "iterations=-1"], ["'iterations'", "0 to 256", "-1"]),
        (["cornell-box", "--technique", "octree-lpv", "--set", "propagation=gathers"], ["'propagation'", "gather"]),
        (["cornell-box", "--technique", "octree-lpv", "--preset", "thesiss"], ["'thesis'"]),
        (["cornell-box", "--size", "big"], ["--size", "1280x720", "big"]),
        (["cornell-box", "--size", "100"], ["--size"]),
        (["cornell-box", "--size=-4x4"], ["width", "-4"]),
        (["cornell-box", "--size", "4x²"], ["--size"]),
        (["cornell-box", "--size", "0x4"], ["width", "8192"]),
        (["cornell-box", "--size", "4x9000"], ["height", "9000"]),
        (["cornell-box", "--camera", "back"], ["'back'", "'front'"]),
        (["cornell-box", "--camera", "1"], ["'1'", "'front'"]),
        (["cornell-box", "--rsm-resolution", "100"], ["100", "1024"]),
        (["cornell-box", "--shadow-filter", "3"], ["shadow_filter", "1 or 2", "3"]),
        (["cornell-box", "--out", "missing/a.png"], ["missing/a.png", "mkdir"]),
        (["cornell-box", "--out", "a.bmp"], ["a.bmp", ".png or .exr or .npz or .mp4 or .webm or .gif"]),
        (["cornell-box", "--out", "a"], [".png or .exr"]),
        (["cornell-box", "--out", "a.png", "--stats", "a.txt"], ["a.txt", ".json"]),
        (["cornell-box", "--adapter", "abacus"], ["'abacus'"]),
    ],
    ids=lambda value: " ".join(value) if isinstance(value, list) else "",
)
def test_wrong_words(run, folder, words, says):
    check_refused(run("render", *words), *says)
    assert list(folder.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [[], ["cornell-box", "--fps", "0"], ["cornell-box", "--fps", "x"], ["cornell-box", "--sise", "4x4"],
     ["cornell-box", "--normal-maps=no"], ["cornell-box", "--inverse-square=1"]],
    ids=" ".join,
)
def test_wrong_usage(run, folder, words):
    result = run("render", *words)
    assert (result.code, result.out) == (2, "")
    assert "Error: " in result.err
    assert "Traceback" not in result.err
    assert list(folder.iterdir()) == []


def test_a_wrong_option_is_led_to_the_right_one(run):
    assert "--size" in run("render", "cornell-box", "--sise", "4x4").err
    assert "render" in run("rendr").err


def test_a_file_that_was_there_survives_a_failed_render(run, folder):
    (folder / "broken.gltf").write_text("{")
    for name in ("old.png", "old.json"):
        (folder / name).write_text("precious")
    check_refused(run("render", "broken.gltf", "--out", "old.png", "--stats", "old.json"), "broken.gltf")
    check_refused(run("render", "cornell-box", "--camera", "no", "--out", "old.png", "--stats", "old.json"))
    assert {p.name: p.read_text() for p in folder.iterdir() if p.name != "broken.gltf"} == {
        "old.png": "precious", "old.json": "precious",
    }  # fmt: skip


def test_a_file_that_was_there_survives_a_full_disk(render, folder, monkeypatch):
    def fill_the_disk(picture, path: Path, options: FileOptions) -> None:
        path.write_text("half a pict")
        raise OSError(28, "No space left on device")

    monkeypatch.setitem(output.FORMATS, ".png", output.FORMATS[".png"]._replace(write=fill_the_disk))
    (folder / "old.png").write_text("precious")
    result = render("cornell-box", "--technique", "none", "--out", "old.png")
    check_refused(result, "old.png", "No space left")
    assert [(p.name, p.read_text()) for p in folder.iterdir()] == [("old.png", "precious")]


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs /dev/full")
@pytest.mark.parametrize(
    "suffix", [pytest.param(s, marks=pytest.mark.covers(f"output {s}", broken=True)) for s in sorted(output.FORMATS)]
)
def test_writers_report_a_full_disk_as_an_os_error(device, suffix):
    scene = octolux.load("furnace")
    picture = octolux.Renderer(scene, "none", size=(64, 64), device=device).render()
    with pytest.raises(OSError, match="No space left"):
        output.FORMATS[suffix].write(picture, Path("/dev/full"), FileOptions())


def test_output_that_is_a_folder(run, folder):
    (folder / "a.png").mkdir()
    check_refused(run("render", "cornell-box", "--out", "a.png"), "a.png")


def test_every_broken_file_is_refused(run, folder):
    broken = data_folder() / "scenes" / "broken"
    if not broken.is_dir():
        pytest.skip("needs OCTOLUX_DATA")
    scenes = sorted(p for p in broken.rglob("*") if p.suffix.lower() in {".obj", ".gltf", ".glb", ".toml"})
    assert scenes
    for scene in scenes:
        check_refused(run("render", str(scene)), scene.name)
    assert list(folder.iterdir()) == []


def test_the_installed_program(folder):
    """As a process of its own: the same line, the same code, no traceback."""
    (folder / "broken.glb").write_bytes(b"glTF")
    program = Path(sys.executable).with_name("octolux")
    done = subprocess.run([program, "render", "broken.glb"], capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith("error: broken.glb")
    assert done.stderr.count("\n") == 1
    assert [p.name for p in folder.iterdir()] == ["broken.glb"]


@pytest.mark.parametrize("command", COMMANDS)
def test_help(run, command):
    result = run(command, "--help")
    assert (result.code, result.err) == (0, "")
    assert f"octolux {command}" in result.out
    documented = next(c for c in app.registered_commands if c.callback and c.callback.__name__ == command).callback
    assert documented.__doc__.strip().splitlines()[0] in result.out


def test_help_names_every_command_and_version(run):
    overview = run("--help").out
    assert all(command in overview for command in COMMANDS)
    assert run("--version").out.startswith("octolux ")


def test_techniques_are_listed_with_presets_and_settings(run):
    listed = run("techniques")
    assert listed.code == 0
    for word in ("none:", "constant:", "uniform-lpv:", "presets: default, paper, thesis", "n = 32", "iterations = 16"):
        assert word in listed.out


def test_scenes_are_listed(run):
    listed = run("scenes")
    assert listed.code == 0
    assert "cornell-box: The classic box" in listed.out
    assert "34 triangles, cameras front" in listed.out
    assert all(name in listed.out for name in ("furnace", "atrium"))


def test_devices_are_listed(run, device):
    listed = run("devices")
    assert (listed.code, len(listed.out.splitlines())) == (0, len(device_module.adapters()))


def test_without_an_adapter(run, folder, monkeypatch):
    monkeypatch.setattr(device_module, "adapters", list)
    for words in (["devices"], ["render", "cornell-box"]):
        check_refused(run(*words), "No graphics adapter", "mesa-vulkan-drivers")
    assert list(folder.iterdir()) == []
