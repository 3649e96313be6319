"""Sequences: a frame is the same whether the run was resumed or not, and what is complete is not rendered again."""

from __future__ import annotations

import signal
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import OpenEXR
import pytest

import octolux
from octolux import console
from octolux.frame.frame import FrameSettings
from octolux.output.options import FileOptions
from octolux.scene.motion.tracks import Track
from octolux.sequence import Made, Plan, Timeline, render_frames, render_sequence
from octolux.targets import Target

SIZE, FPS = (64, 36), 2.0
FRAME = FrameSettings(*SIZE, shadow_resolution=64, rsm_resolution=16)
FRAMES = range(2, 7)
WORDS = (
    "render", "cornell-box", "--technique", "none", "--size", "64x36", "--shadow-resolution", "64",
    "--rsm-resolution", "16", "--fps", "2", "--frames", "2..6",
)  # fmt: skip


@pytest.fixture
def scene() -> octolux.Scene:
    """The Cornell box with a lamp and a camera that move, and no exposure of its own."""
    box = octolux.load("cornell-box")
    path = Track(
        target="camera", name="front", property="position", times=np.array([0.0, 4.0]),
        values=np.array([(0.0, 1.0, 3.9), (0.3, 1.0, 2.5)]),
    )  # fmt: skip
    return replace(box, exposure=None, tracks=[*box.tracks, path])


@pytest.fixture
def renderer(device, scene):
    """Makes new renderers of that scene, as a new process has."""

    def make() -> octolux.Renderer:
        return octolux.Renderer(
            scene, "none", size=SIZE, device=device, frame_settings=FRAME, anti_aliasing="auto", sequence=True
        )

    return make


@pytest.fixture
def rendered(monkeypatch) -> list[int]:
    """The numbers of the frames as they are rendered."""
    numbers: list[int] = []
    original = Timeline.render

    def render(self: Timeline, frame: int) -> octolux.Picture:
        numbers.append(frame)
        return original(self, frame)

    monkeypatch.setattr(Timeline, "render", render)
    return numbers


def facts(folder: Path) -> dict[str, tuple[int, int]]:
    return {p.name: (p.stat().st_ino, p.stat().st_mtime_ns) for p in folder.iterdir()}


def contents(folder: Path) -> dict[str, bytes]:
    return {p.name: p.read_bytes() for p in folder.iterdir()}


def make(renderer, scene, folder: Path, *names: str, resume: bool = False) -> Made:
    return render_sequence(renderer(), scene, [folder / name for name in names], FRAMES, FPS, resume=resume)


def test_resumed_frames_are_the_same_bytes(renderer, scene, folder, rendered):
    """Exposure is that of the first frame and motion counts from the frame before, though neither is rendered."""
    make(renderer, scene, folder, "f_##.png", "f_##.exr")
    whole = contents(folder)
    assert sorted(whole) == [f"f_0{k}.{kind}" for k in FRAMES for kind in ("exr", "png")]
    for name in ("f_04.png", "f_04.exr", "f_06.exr"):
        (folder / name).unlink()
    before, rendered[:] = facts(folder), []
    made = make(renderer, scene, folder, "f_##.png", "f_##.exr", resume=True)
    assert contents(folder) == whole
    assert rendered == [4, 6]
    assert [path.name for path in made.written] == ["f_04.png", "f_04.exr", "f_06.exr"]
    assert {name: fact for name, fact in facts(folder).items() if name in before} == before


def test_the_first_frame_is_metered(renderer, scene, folder, device):
    """The test above would hold for any exposure that does not change; these do."""
    make(renderer, scene, folder, "f_##.exr")
    kept = [OpenEXR.File(str(folder / f"f_0{k}.exr")).header()["exposure_ev100"] for k in FRAMES]
    alone = [Timeline(renderer(), scene, FPS, first=k).render(k).exposure for k in FRAMES]
    assert len(set(alone)) == len(FRAMES)
    np.testing.assert_allclose(kept, alone[0], rtol=1e-7)  # float32


def test_motion_of_the_first_frame(renderer, scene):
    """It is that from the frame before it, which the sequence does not hold."""
    early, late = (Timeline(renderer(), scene, FPS, first=first) for first in (1, 2))
    early.render(1)
    motion = early.render(2).layers["motion"]
    np.testing.assert_array_equal(late.render(2).layers["motion"], motion)
    assert np.abs(motion).max() > 0.1  # pixels: the camera moves


@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=pytest.mark.covers(f"output .{k}", broken=True)) for k in ("png", "exr", "npz")]
)
def test_files_that_are_not_complete_are_rendered_again(renderer, scene, folder, rendered, kind):
    """Cut short, emptied, of another size, and something else altogether."""
    make(renderer, scene, folder, f"f_##.{kind}")
    whole = contents(folder)
    frames = {k: folder / f"f_0{k}.{kind}" for k in FRAMES}
    frames[2].write_bytes(whole[frames[2].name][:-20])
    frames[3].write_bytes(b"")
    frames[4].write_bytes(b"not a picture at all")
    small = octolux.Renderer(scene.at(1.0), "none", size=(16, 12), device=renderer().device)
    small.render().save(frames[5])
    rendered[:] = []
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        make(renderer, scene, folder, f"f_##.{kind}", resume=True)
    assert rendered == [2, 3, 4, 5]
    assert contents(folder) == whole


def test_files_of_another_kind_are_rendered_again(renderer, scene, folder, rendered):
    """Eight bits where sixteen are asked for, and a layer that is missing."""
    out = [folder / "f_##.png", folder / "f_##.exr"]
    few = FileOptions(layers=("depth",))
    render_sequence(renderer(), scene, out, range(2), FPS, options=few)
    for options in (FileOptions(bits=16, layers=("depth",)), FileOptions(bits=16), FileOptions(bits=16, alpha=True)):
        rendered[:] = []
        render_sequence(renderer(), scene, out, range(2), FPS, options=options, resume=True)
        assert rendered == [0, 1]
        render_sequence(renderer(), scene, out, range(2), FPS, options=options, resume=True)
        assert rendered == [0, 1]


def test_a_still_is_the_last_frame(renderer, scene, folder):
    make(renderer, scene, folder, "f_##.png", "still.png")
    assert (folder / "still.png").read_bytes() == (folder / "f_06.png").read_bytes()


def test_resume_on_the_command_line(run, folder, rendered):
    words = (*WORDS, "--out", "f_####.png", "--resume")
    first = run(*words)
    assert (first.code, rendered) == (0, [2, 3, 4, 5, 6])
    assert "wrote f_0002.png to f_0006.png, 5 of 5 frames" in first.out
    whole, before = contents(folder), facts(folder)
    again = run(*words)
    assert (again.code, again.out, again.err) == (0, "nothing to do: all files are complete\n", "")
    assert (facts(folder), rendered) == (before, [2, 3, 4, 5, 6])
    (folder / "f_0003.png").write_bytes(whole["f_0003.png"][:100])
    (folder / ".octolux-f_0004-x.png").write_bytes(b"left by a killed run")
    mended = run(*words)
    assert "wrote f_0003.png, 1 of 5 frames" in mended.out
    assert contents(folder) == whole


def interrupting(after: int):
    """Follows frames; presses Ctrl-C while the frame after so many is made."""

    def track(frames):
        for done, frame in enumerate(frames):
            if done == after:
                signal.raise_signal(signal.SIGINT)
            yield frame

    return track


def test_ctrl_c_finishes_the_frame(run, folder, monkeypatch):
    handler = signal.getsignal(signal.SIGINT)
    monkeypatch.setattr(console, "track", interrupting(2))
    done = run(*WORDS, "--out", "f_#.png", "--out", "film.gif", "--out", "still.png", "--stats", "s.json")
    assert (done.code, done.err.splitlines()[-1]) == (130, "stopped; --resume renders what is missing")
    assert done.out.splitlines() == ["wrote f_2.png to f_4.png, 3 of 5 frames", "wrote film.gif"]
    assert sorted(p.name for p in folder.iterdir()) == ["f_2.png", "f_3.png", "f_4.png", "film.gif"]
    assert signal.getsignal(signal.SIGINT) is handler


def test_ctrl_c_during_the_last_frame_is_too_late(renderer, scene, folder):
    plan = Plan((Target(folder / "f_#.png"),), FRAMES, FPS, SIZE)
    made = render_frames(plan, Timeline(renderer(), scene, FPS, first=2), interrupting(len(FRAMES) - 1))
    assert (made.interrupted, made.rendered) == (False, len(FRAMES))


def test_a_second_ctrl_c_stops_at_once(renderer, scene, folder):
    def track(frames):
        yield frames[0]
        signal.raise_signal(signal.SIGINT)
        signal.raise_signal(signal.SIGINT)

    plan = Plan((Target(folder / "f_#.png"), Target(folder / "f.gif")), FRAMES, FPS, SIZE)
    with pytest.raises(KeyboardInterrupt):
        render_frames(plan, Timeline(renderer(), scene, FPS, first=2), track)
    assert [p.name for p in folder.iterdir()] == ["f_2.png"]


def test_an_unknown_clip(run, folder):
    refused = run(*WORDS, "--clip", "walk", "--out", "f_#.png")
    assert (refused.code, refused.out) == (2, "")
    assert "'walk'" in refused.err
    assert list(folder.iterdir()) == []


def test_lines_while_frames_are_made(monkeypatch, capsys):
    """One every ten seconds at most, with the time left; a frame takes six seconds here."""
    clock = iter(np.arange(0.0, 600.0, 6.0))
    monkeypatch.setattr(console.time, "monotonic", lambda: next(clock))
    assert list(console.track(range(8))) == list(range(8))
    # The clock is read once before the first frame and once before each: frame k begins at 6 (k + 1) seconds.
    assert capsys.readouterr().err.splitlines() == [
        "1 of 8 frames, 84 s left", "3 of 8 frames, 40 s left", "5 of 8 frames, 22 s left", "7 of 8 frames, 7 s left",
    ]  # fmt: skip


def test_frame_rate_in_headers(renderer, scene, folder):
    render_sequence(renderer(), scene, folder / "a.exr", range(1), 24000 / 1001)
    rate = OpenEXR.File(str(folder / "a.exr")).header()["framesPerSecond"]
    assert (rate.numerator, rate.denominator) == (24000, 1001)
