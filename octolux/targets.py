"""Where the pictures of a sequence go: a file for each frame, for the last one, or a video of all."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from .output import FORMATS, check_writable
from .output.video import VIDEOS, check_video
from .scene.errors import OctoluxError

_NUMBER = re.compile(r"#+|\{frame(?::0?([0-9]{0,2})d)?\}")
_RANGE = re.compile(r"([0-9]{1,9})(?:\.\.([0-9]{1,9}))?")


def frame_range(text: str) -> range:
    """`A..B` is A to B with both; `N` is 0 to N - 1. Raises OctoluxError when there is no frame in it."""
    found = _RANGE.fullmatch(text.strip())
    if found:
        first, last = found.groups()
        frames = range(int(first)) if last is None else range(int(first), int(last) + 1)
        if frames:
            return frames
    raise OctoluxError(f"--frames is A..B, such as 0..39, or how many from 0 on, such as 40, not '{text}'.")


@dataclass(frozen=True)
class Target:
    """One `--out`. `####` or `{frame:04d}` in the file's name stands for the frame's number."""

    path: Path

    def __post_init__(self) -> None:
        name = self.path.name
        if len(_NUMBER.findall(name)) > 1 or re.search(r"[{}]", _NUMBER.sub("", name)):
            raise OctoluxError(f"{self.path}: a frame's number is one #### or {{frame:04d}} in the file's name.")
        if self.video and self.numbered:
            raise OctoluxError(f"{self.path}: a video holds all frames. Leave the number out of its name.")

    @property
    def numbered(self) -> bool:
        return _NUMBER.search(self.path.name) is not None

    @property
    def suffix(self) -> str:
        return self.path.suffix.lower()

    @property
    def video(self) -> bool:
        return self.suffix in VIDEOS

    def of(self, frame: int) -> Path:
        """The file of a frame, for targets that are not videos."""
        found = _NUMBER.search(self.path.name)
        if not found:
            return self.path
        digits = int(found[1] or 0) if found[0].startswith("{") else len(found[0])
        return self.path.with_name(_NUMBER.sub(f"{frame:0{digits}d}", self.path.name))


def check_targets(targets: Iterable[Target], frames: range, size: tuple[int, int], fps: float) -> None:
    """Raise OctoluxError before any work is done when something could not be written after it."""
    seen: set[Path] = set()
    for target in targets:
        check_writable(target.path, [*FORMATS, *VIDEOS])
        if target.video:
            check_video(target.path, size, fps)
        else:
            for path in {target.of(frames[0]), target.of(frames[-1])}:
                check_writable(path, FORMATS)
        if target.path.resolve() in seen:
            raise OctoluxError(f"{target.path}: is named twice. Leave one --out out.")
        seen.add(target.path.resolve())
