"""Ranges of frames and names of files: they parse, or fail with one clear error."""

from __future__ import annotations

from pathlib import Path

import pytest

from octolux.output.options import LAYERS, FileOptions, layer_names
from octolux.scene.errors import OctoluxError
from octolux.targets import Target, check_targets, frame_range


@pytest.mark.parametrize(
    ("text", "frames"),
    [("1", range(1)), ("40", range(40)), ("0..39", range(40)), ("7..7", range(7, 8)), (" 3..12 ", range(3, 13))],
)
def test_ranges(text, frames):
    assert frame_range(text) == frames


@pytest.mark.parametrize("text", ["", "0", "x", "-3", "5..4", "1..", "..3", "1..2..3", "1.5", "²", "9" * 5000])
def test_ranges_without_a_frame(text):
    with pytest.raises(OctoluxError, match=r"--frames is A\.\.B, such as 0\.\.39"):
        frame_range(text)


@pytest.mark.parametrize(
    ("name", "first", "later"),
    [
        ("frame_####.png", "frame_0007.png", "frame_12345.png"),
        ("#.exr", "7.exr", "12345.exr"),
        ("a{frame:04d}b.png", "a0007b.png", "a12345b.png"),
        ("{frame}.npz", "7.npz", "12345.npz"),
        ("{frame:d}.png", "7.png", "12345.png"),
        ("still.png", "still.png", "still.png"),
    ],
)
def test_names_of_frames(name, first, later):
    target = Target(Path("folder#", name))
    assert [target.of(7), target.of(12345)] == [Path("folder#", first), Path("folder#", later)]
    assert target.numbered == (first != later)
    assert not target.video


@pytest.mark.parametrize("name", ["##_##.png", "{frame}_##.png", "{farme}.png", "{frame:x}.png", "{.png", "a}.exr"])
def test_names_with_a_wrong_number(name):
    with pytest.raises(OctoluxError, match=r"a frame's number is one #### or \{frame:04d\}"):
        Target(Path(name))


def check_one(*names: str, size: tuple[int, int] = (64, 36), fps: float = 24.0) -> None:
    check_targets([Target(Path(name)) for name in names], range(3), size, fps)


@pytest.mark.parametrize(
    ("names", "says"),
    [
        (["a_##.mp4"], "a video holds all frames"),
        (["a.png", "./a.png"], "is named twice"),
        (["none/a_##.png"], "mkdir -p 'none'"),
        (["a_##.jpg"], "'.jpg' are not written"),
        (["taken_##.png"], "cannot be written"),
    ],
)
def test_targets_that_cannot_be(folder, names, says):
    (folder / "taken_02.png").mkdir()
    with pytest.raises(OctoluxError) as error:
        check_one(*names)
    assert says in str(error.value)


def test_videos_that_cannot_be(folder):
    check_one("a.mp4", "a.webm", "a.gif")
    check_one("a.webm", "a.gif", size=(63, 37), fps=50)
    with pytest.raises(OctoluxError, match="even widths and heights, not 63x36"):
        check_one("a.mp4", size=(63, 36))
    with pytest.raises(OctoluxError, match="at most 50 frames a second, not 60"):
        check_one("a.gif", fps=60)


def test_without_pyav(folder, monkeypatch):
    """The error names the command; GIF does without."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    check_one("a.gif")
    with pytest.raises(OctoluxError, match="pip install av"):
        check_one("a.mp4")


def test_layers_and_bits():
    assert layer_names(" depth, normal,depth,") == ("depth", "normal")
    assert layer_names(None) is None
    with pytest.raises(OctoluxError, match=r"There are: radiance, direct"):
        layer_names(" ,")
    with pytest.raises(OctoluxError, match=r"'dept'.*'depth'"):
        FileOptions(layers=("dept",))
    with pytest.raises(OctoluxError, match="8 or 16 bits a channel, not 12"):
        FileOptions(bits=12)
    assert all(FileOptions().wants(layer) for layer in LAYERS)
    assert [layer for layer in LAYERS if FileOptions(layers=("depth",)).wants(layer)] == ["depth"]
