"""Sequences: the frames of a scene that moves, written to files, and gone on with after an interruption.

Frame k shows the scene at k / fps seconds. Its picture does not depend on which frames were rendered before it: the
exposure is metered at the first frame of the sequence, and motion is counted from frame k - 1, rendered or not.
"""

from __future__ import annotations

import json
import signal
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from . import __version__
from .output import complete, exr, png, video, write_picture
from .output.atomic import remove_leftovers
from .output.options import FileOptions
from .picture import Picture
from .renderer import Renderer
from .scene.cameras import Camera
from .scene.scene import Scene
from .targets import Target, check_targets

Track = Callable[[Sequence[int]], Iterable[int]]
"""Hands on the frames, and shows how far they are."""


class Timeline:
    """Renders the frames of a scene in any order.

    renderer: made for the scene, and used by nothing else meanwhile.  first: the frame that is metered when neither
    the renderer nor the scene has an exposure.  camera, clip: as in Renderer.render and Scene.at.
    Raises OctoluxError for an unknown clip.
    """

    def __init__(
        self, renderer: Renderer, scene: Scene, fps: float, *, first: int = 0,
        camera: str | int | Camera | None = None, clip: str | None = None,
    ):  # fmt: skip
        self.renderer, self.scene, self.fps, self.first = renderer, scene, fps, first
        self.camera, self.clip = camera, clip
        scene.at(0.0, clip)  # raises where there is no such clip, also for a scene that does not move
        self._last: int | None = None

    def scene_at(self, frame: int) -> Scene:
        if not self.scene.tracks:
            return self.scene
        return self.scene.at(frame / self.fps, self.clip)

    def render(self, frame: int) -> Picture:
        """The frame's picture. Raises OctoluxError as Renderer.render does."""
        if self.renderer.exposure is None and frame != self.first:
            self.renderer.scene = self.scene_at(self.first)
            self.renderer.meter(self.camera)
        if self._last is None or self._last != frame - 1:
            self.renderer.previous = self.scene_at(frame - 1)
        self.renderer.scene = self.scene_at(frame)
        self._last = frame
        return self.renderer.render(self.camera)

    def metadata(self, frame: int) -> dict[str, Any]:
        """What the header of an EXR file says of the frame: texts, whole numbers, and the rate as a fraction."""
        statistics = self.renderer.statistics()
        return {
            "software": f"octolux {__version__}",
            "scene": self.scene.name,
            "camera": self._camera_name(),
            "technique": statistics["technique"],
            "settings": json.dumps(statistics["settings"]),
            "frame_settings": json.dumps(statistics["frame_settings"]),
            "adapter": statistics["adapter"],
            "frame": frame,
            "framesPerSecond": Fraction(self.fps).limit_denominator(1001),
        }

    def _camera_name(self) -> str:
        if isinstance(self.camera, Camera):
            return self.camera.name
        names = [camera.name for camera in self.scene.cameras]
        if self.camera in names or not names:
            return str(self.camera or "")
        return names[int(self.camera or 0)]


@dataclass(frozen=True)
class Plan:
    """What a sequence writes.

    frames: with a step of 1.  size: (width, height), pixels.  resume: files that are complete stay as they are.
    Raises OctoluxError when something could not be written.
    """

    targets: tuple[Target, ...]
    frames: range
    fps: float
    size: tuple[int, int]
    options: FileOptions = field(default_factory=FileOptions)
    resume: bool = False

    def __post_init__(self) -> None:
        check_targets(self.targets, self.frames, self.size, self.fps)

    @cached_property
    def missing(self) -> dict[int, list[Path]]:
        """The frames to render, each with the files to write then. Without `resume` all frames are rendered."""
        if not self.resume:
            return {frame: self._files(frame) for frame in self.frames}
        lacking = {frame: [p for p in self._files(frame) if not self._complete(p)] for frame in self.frames}
        if self.options.paths:  # of a picture that more paths go into, all files are made anew
            lacking = {frame: self._files(frame) if paths else [] for frame, paths in lacking.items()}
        return {frame: paths for frame, paths in lacking.items() if paths or (self.videos and not self._stored(frame))}

    @cached_property
    def videos(self) -> list[Path]:
        """The videos to write."""
        paths = [target.path for target in self.targets if target.video]
        return [path for path in paths if not (self.resume and self._video_complete(path))]

    @property
    def filtered(self) -> bool:
        """Whether a filter on the 8-bit picture is anti-aliasing enough: for sequences without more bits or alpha."""
        return len(self.frames) > 1 and self.options.bits == 8 and not self.options.alpha

    def remove_leftovers(self) -> None:
        """Delete what killed runs left in the folders that are written to."""
        for folder in {target.path.parent for target in self.targets}:
            remove_leftovers(folder)

    def stored_display(self, frame: int) -> np.ndarray:
        """uint8 (height, width, 3) of a frame that need not be rendered for a video, as its PNG holds it."""
        return png.read_display(self._stored(frame)[0])

    def _files(self, frame: int) -> list[Path]:
        """The files of a frame; those without a number are of the last."""
        pictures = [target for target in self.targets if not target.video]
        return [target.of(frame) for target in pictures if target.numbered or frame == self.frames[-1]]

    def _stored(self, frame: int) -> list[Path]:
        """The frame's PNG files that hold what a video would show."""
        plain = self.options.bits == 8 and not self.options.alpha
        return [path for path in self._files(frame) if path.suffix.lower() == ".png"] if plain else []

    def _complete(self, path: Path) -> bool:
        return complete(path, self.size, self.options)

    def _video_complete(self, path: Path) -> bool:
        return path.is_file() and video.complete(path, self.size, self.fps, len(self.frames))


@dataclass
class Made:
    """What came of a sequence. last: the last picture that was rendered."""

    rendered: int = 0
    last: Picture | None = None
    written: list[Path] = field(default_factory=list)
    interrupted: bool = False

    def summary(self, plan: Plan) -> list[str]:
        """A line for each target with what was written to it, for people."""
        written = set(self.written)
        return [line for target in plan.targets if (line := _summary(target, plan.frames, written))]


def _summary(target: Target, frames: range, written: set[Path]) -> str:
    if target.video or not target.numbered:
        return f"wrote {target.path}" if target.path in written else ""
    numbers = [frame for frame in frames if target.of(frame) in written]
    if not numbers:
        return ""
    ends = " to ".join(dict.fromkeys(target.of(frame).name for frame in (numbers[0], numbers[-1])))
    count = f", {len(numbers)} of {len(frames)} frames" if len(frames) > 1 else ""
    return f"wrote {target.path.parent / ends}{count}"


def render_frames(plan: Plan, timeline: Timeline, track: Track = iter) -> Made:
    """Render what is missing of the plan, and write it. Ctrl-C ends it after the frame that is being made.

    Raises OctoluxError; files that are complete by then stay, of others nothing is left.
    """
    plan.remove_leftovers()
    made = Made()
    frames = plan.frames if plan.videos else list(plan.missing)
    with ExitStack() as stack, _ctrl_c() as pressed:
        videos = [stack.enter_context(video.Video(path, plan.size, plan.fps)) for path in plan.videos]
        stack.enter_context(_stopped_by(timeline.renderer, pressed))
        for frame in track(frames):
            pixels = _frame(plan, timeline, frame, made)
            for file in videos:
                file.add(pixels)
            if pressed.is_set() and (frame != frames[-1] or _unfinished(plan, made.last)):
                made.interrupted = True
                break
    made.written += [file.path for file in videos if file.frames]
    return made


@contextmanager
def _stopped_by(renderer: Renderer, pressed: threading.Event) -> Iterator[None]:
    """Let a long frame end early, with what is there of it, when the event is set."""
    ask = renderer.progress
    renderer.progress = lambda done, total: (ask is None or ask(done, total)) and not pressed.is_set()
    try:
        yield
    finally:
        renderer.progress = ask


def _unfinished(plan: Plan, picture: Picture | None) -> bool:
    options = plan.options
    return picture is not None and picture.paths < options.paths and not picture.relative_error <= options.noise


def _frame(plan: Plan, timeline: Timeline, frame: int, made: Made) -> np.ndarray:
    """Make one frame and write its files; uint8 (height, width, 3) for videos."""
    if frame not in plan.missing:
        return plan.stored_display(frame)
    if plan.resume and plan.options.paths:
        made_with = (timeline.renderer.technique.settings.as_dict(), timeline.renderer.frame_settings)
        starts = (exr.traced(path, *made_with) for path in plan.missing[frame] if path.suffix.lower() == ".exr")
        timeline.renderer.start = next((s for s in starts if s and s.radiance.shape[:2] == plan.size[::-1]), None)
    made.last = picture = timeline.render(frame)
    made.rendered += 1
    about = {**plan.options.metadata, **timeline.metadata(frame)}
    for path in plan.missing[frame]:
        write_picture(picture, path, replace(plan.options, metadata=about))
        made.written.append(path)
    return picture.display[..., :3]


def render_sequence(
    renderer: Renderer, scene: Scene, out: str | Path | Sequence[str | Path], frames: range, fps: float = 24.0, *,
    camera: str | int | Camera | None = None, clip: str | None = None, resume: bool = False,
    options: FileOptions | None = None,
) -> Made:  # fmt: skip
    """Render frames of a scene to files: `render_sequence(renderer, scene, "frame_####.png", range(48))`.

    renderer: made for the scene.  out: one path or several, as for `--out`; without a number in its name a picture is
    the last frame's.  frames: with a step of 1.  Raises OctoluxError.
    """
    paths = [out] if isinstance(out, (str, Path)) else out
    targets = tuple(Target(Path(path)) for path in paths)
    plan = Plan(targets, frames, fps, renderer.targets.size, options or FileOptions(), resume)
    return render_frames(plan, Timeline(renderer, scene, fps, first=frames[0], camera=camera, clip=clip))


@contextmanager
def _ctrl_c() -> Iterator[threading.Event]:
    """An event that the first Ctrl-C sets; the second one interrupts at once. Python has signals in its main thread."""
    pressed = threading.Event()
    ignored = signal.getsignal(signal.SIGINT) is signal.SIG_IGN
    if ignored or threading.current_thread() is not threading.main_thread():
        yield pressed
        return

    def press(number: int, frame: object) -> None:
        pressed.set()
        signal.signal(signal.SIGINT, before)

    before = signal.signal(signal.SIGINT, press)
    try:
        yield pressed
    finally:
        signal.signal(signal.SIGINT, before)
