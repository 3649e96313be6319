"""Videos hold the frames they were given: how many, how large, how fast, and in their colours."""

from __future__ import annotations

from pathlib import Path

import av
import numpy as np
import pytest
from av.video.reformatter import Colorspace
from PIL import Image

from octolux.output.video import Video, complete
from octolux.scene.errors import OctoluxError

SIZE = (64, 36)
COLOUR = (200, 40, 90)


def videos(*names: str, broken: bool = False) -> list:
    """The names of files, as parameters that cover their formats."""
    marks = [pytest.mark.covers(f"output {Path(name).suffix.lower()}", broken=broken) for name in names]
    return [pytest.param(name, marks=mark) for name, mark in zip(names, marks, strict=True)]


def frames(count: int, size: tuple[int, int] = SIZE) -> list[np.ndarray]:
    """A bar of another colour moves over a plain picture, four pixels a frame."""
    pictures = []
    for number in range(count):
        picture = np.full((size[1], size[0], 3), COLOUR, np.uint8)
        picture[:, 4 * number : 4 * number + 4] = (10, 200, 30)
        pictures.append(picture)
    return pictures


def write(path: Path, pictures: list[np.ndarray], fps: float = 24.0) -> None:
    size = pictures[0].shape[1::-1]
    with Video(path, (size[0], size[1]), fps) as video:
        for picture in pictures:
            video.add(picture)


@pytest.mark.parametrize("name", videos("a.mp4", "a.webm", "A.MP4"))
@pytest.mark.parametrize("fps", [24.0, 24000 / 1001])
def test_mp4_and_webm(folder, name, fps):
    path = folder / name
    given = frames(9)
    write(path, given, fps)
    with av.open(str(path)) as container:
        stream = container.streams.video[0]
        found = list(container.decode(video=0))
        assert (stream.width, stream.height, len(found)) == (*SIZE, 9)
        assert float(stream.average_rate) == pytest.approx(fps, rel=1e-4)  # a WebM's times are in milliseconds
        for number, frame in enumerate(found):
            assert frame.time == pytest.approx(number / fps, abs=6e-4)
    for frame, picture in zip(found, given, strict=True):
        rgb = frame.reformat(format="rgb24", src_colorspace=Colorspace.ITU709).to_ndarray().astype(int)
        # Plain areas lose a step of the 8-bit limited range in each of Y, Cb, Cr, at most 1.9 codes of RGB a step,
        # and what the quantiser takes at this quality: 8 codes hold both. BT.601 would be off by 20.
        assert np.abs(rgb[:, 44:] - picture[:, 44:]).max() <= 8
    assert complete(path, SIZE, fps, 9)
    assert not complete(path, SIZE, fps, 10)
    assert not complete(path, (64, 38), fps, 9)
    assert [p.name for p in folder.iterdir()] == [name]


@pytest.mark.covers("output .webm")
def test_webm_of_odd_size(folder):
    write(folder / "a.webm", frames(3, (63, 37)))
    assert complete(folder / "a.webm", (63, 37), 24.0, 3)


@pytest.mark.covers("output .gif")
@pytest.mark.parametrize("fps", [24.0, 10.0, 50.0])
def test_gif(folder, fps):
    path = folder / "a.gif"
    given = frames(9)
    write(path, given, fps)
    with Image.open(path) as image:
        assert (image.size, image.n_frames, image.info["loop"]) == (SIZE, 9, 0)
        duration = 0
        for number, picture in enumerate(given):
            image.seek(number)
            duration += image.info["duration"]
            np.testing.assert_array_equal(np.asarray(image.convert("RGB")), picture)  # two colours fit a palette
    assert duration == pytest.approx(9000 / fps, abs=5)  # hundredths of a second, rounded once for all
    assert complete(path, SIZE, fps, 9)
    assert not complete(path, SIZE, fps, 10)
    assert not complete(path, (36, 64), fps, 9)


@pytest.mark.covers("output .gif")
def test_gif_of_many_colours(folder):
    """Dithered to 256 colours: means of areas stay, to a step of the palette."""
    rows, columns = np.mgrid[0:36, 0:64]
    picture = np.stack([columns * 4, rows * 7, 255 - columns * 2], axis=-1).astype(np.uint8)
    write(folder / "a.gif", [picture, picture[::-1]])
    with Image.open(folder / "a.gif") as image:
        found = np.asarray(image.convert("RGB")).astype(float)
    blocks = (picture - found).reshape(3, 12, 4, 16, 3).mean(axis=(1, 3))
    assert np.abs(blocks).max() < 8  # 2304 colours on 256: boxes of about 2 x 2 steps of (4, 7), half a box off


@pytest.mark.covers("output .gif")
def test_frames_that_are_the_same(folder):
    """A GIF makes one of them, shown for as long."""
    write(folder / "a.gif", [frames(1)[0]] * 5)
    assert complete(folder / "a.gif", SIZE, 24.0, 5)


@pytest.mark.parametrize("name", videos("a.mp4", "a.webm", "a.gif", broken=True))
def test_nothing_half_written(folder, name):
    """Neither after an error nor without a frame; and no file before it is complete."""
    path = folder / name
    path.write_bytes(b"precious")
    with pytest.raises(ValueError, match="stop"), Video(path, SIZE, 24.0) as video:
        video.add(frames(1)[0])
        assert path.read_bytes() == b"precious"
        raise ValueError("stop")
    with Video(path, SIZE, 24.0):
        pass
    assert [(p.name, p.read_bytes()) for p in folder.iterdir()] == [(name, b"precious")]
    assert not complete(path, SIZE, 24.0, 1)


@pytest.mark.parametrize("name", ["a.mp4", "a.gif"])
def test_a_folder_that_is_gone(tmp_path, name):
    with pytest.raises(OctoluxError, match="cannot be written"), Video(tmp_path / "none" / name, SIZE, 24.0) as video:
        video.add(frames(1)[0])


@pytest.mark.parametrize("name", videos("a.mp4", "a.webm", "a.gif", broken=True))
def test_a_video_cut_short_is_not_complete(folder, name):
    path = folder / name
    write(path, frames(9))
    path.write_bytes(path.read_bytes()[: path.stat().st_size * 2 // 3])
    assert not complete(path, SIZE, 24.0, 9)


@pytest.mark.covers("output .png", "output .mp4", "output .gif")
def test_video_on_the_command_line(run, folder):
    """A video of a resumed run is the one of a run in one piece: its frames come from the PNG files that are there."""
    words = ("render", "cornell-box", "--technique", "none", "--size", "64x36", "--shadow-resolution", "64",
             "--rsm-resolution", "16", "--frames", "5", "--fps", "5")  # fmt: skip
    first = run(*words, "--out", "f_#.png", "--out", "a.mp4", "--out", "a.gif")
    assert first.code == 0, first.err
    assert "wrote a.mp4\nwrote a.gif\n" in first.out
    whole = {p.name: p.read_bytes() for p in folder.iterdir()}
    for name in ("f_3.png", "a.mp4", "a.gif"):
        (folder / name).unlink()
    second = run(*words, "--out", "f_#.png", "--out", "a.mp4", "--out", "a.gif", "--resume")
    assert "wrote f_3.png, 1 of 5 frames\nwrote a.mp4\nwrote a.gif\n" in second.out
    assert {p.name: p.read_bytes() for p in folder.iterdir()} == whole
    third = run(*words, "--out", "a.mp4", "--resume")
    assert third.out == "nothing to do: all files are complete\n"
