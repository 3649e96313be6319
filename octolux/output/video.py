"""Videos: MP4 (H.264) and WebM (VP9) through FFmpeg's PyAV, GIF through Pillow.

A video is written under a temporary name and appears when it is closed.
"""

from __future__ import annotations

import importlib.util
from contextlib import ExitStack, suppress
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any, Protocol, Self

import numpy as np
from PIL import Image

from ..scene.errors import OctoluxError
from .atomic import replacing

# Constant quality; 18 and 24 are where FFmpeg's guides put "visually lossless" for each of the two.
_CODECS: dict[str, tuple[str, dict[str, str]]] = {
    ".mp4": ("libx264", {"crf": "18"}),
    ".webm": ("libvpx-vp9", {"crf": "24", "b": "0", "row-mt": "1", "deadline": "good", "cpu-used": "4"}),
}
VIDEOS = (*_CODECS, ".gif")

_BT709 = 1  # of primaries, transfer and matrix (ITU-T H.273); sRGB shares the primaries
_LIMITED = 1  # FFmpeg's AVCOL_RANGE_MPEG
_FASTEST_GIF = 50  # viewers slow down frames shorter than two hundredths of a second


class _Encoder(Protocol):
    def add(self, pixels: np.ndarray) -> None: ...

    def close(self) -> None: ...

    def discard(self) -> None: ...


def check_video(path: Path, size: tuple[int, int], fps: float) -> None:
    """Raise OctoluxError when a video of `size` (width, height) at `fps` cannot be written to `path`."""
    suffix = path.suffix.lower()
    if suffix == ".gif":
        if fps > _FASTEST_GIF:
            raise OctoluxError(f"{path}: a GIF has at most {_FASTEST_GIF} frames a second, not {fps:g}. Use .mp4.")
        return
    if importlib.util.find_spec("av") is None:
        raise OctoluxError(f"{path}: {suffix} needs PyAV. Install it: pip install av. Or use .gif.")
    import av

    codec = _CODECS[suffix][0]
    if codec not in av.codecs_available:
        raise OctoluxError(f"{path}: this PyAV has no encoder {codec}. Install the usual one: pip install av.")
    if suffix == ".mp4" and (size[0] % 2 or size[1] % 2):
        raise OctoluxError(f"{path}: MP4 has even widths and heights, not {size[0]}x{size[1]}. Change --size.")


class Video:
    """A video being written: `add` frames in order, then leave the `with` block.

    path: ends in one of VIDEOS.  size: (width, height), pixels.  fps: frames a second.
    An exception leaves nothing; without any frame nothing is written either. Raises OctoluxError when the file cannot
    be written.
    """

    def __init__(self, path: Path, size: tuple[int, int], fps: float):
        self.path, self.size, self.fps, self.frames = path, size, Fraction(fps).limit_denominator(1001), 0
        self._file = ExitStack()
        self._encoder: _Encoder | None = None

    def add(self, pixels: np.ndarray) -> None:
        """The next frame: uint8 (height, width, 3), sRGB."""
        if self._encoder is None:
            make = _Gif if self.path.suffix.lower() == ".gif" else _Stream
            self._encoder = make(self._file.enter_context(replacing(self.path)), self.size, self.fps)
        self._encoder.add(np.ascontiguousarray(pixels))
        self.frames += 1

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._encoder:
            self._file.callback(self._encoder.close if kind is None else self._encoder.discard)
        self._file.__exit__(kind, error, trace)


class _Stream:
    """H.264 or VP9: 4:2:0, 8 bits, BT.709."""

    def __init__(self, path: Path, size: tuple[int, int], fps: Fraction):
        import av

        codec, options = _CODECS[path.suffix.lower()]
        self._tick = 1 / fps
        first_index = {"movflags": "+faststart"} if path.suffix.lower() == ".mp4" else {}  # plays while it is fetched
        self._container = av.open(str(path), "w", options=first_index)
        stream: Any = self._container.add_stream(codec, rate=fps, options=options)
        stream.width, stream.height = size
        stream.pix_fmt = "yuv420p"
        context = stream.codec_context
        context.colorspace = context.color_primaries = context.color_trc = _BT709
        context.color_range = _LIMITED
        self._stream, self._next = stream, 0

    def add(self, pixels: np.ndarray) -> None:
        import av
        from av.video.reformatter import ColorRange, Colorspace

        frame = av.VideoFrame.from_ndarray(pixels, format="rgb24").reformat(
            format="yuv420p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.MPEG
        )
        frame.pts, frame.time_base, frame.duration = self._next, self._tick, 1
        self._next += 1
        self._container.mux(self._stream.encode(frame))

    def close(self) -> None:
        self._container.mux(self._stream.encode())
        self._container.close()

    def discard(self) -> None:
        with suppress(OSError):  # what made it useless
            self._container.close()


class _Gif:
    """256 colours for each frame, dithered. The frames stay in memory, a byte a pixel, until it is closed."""

    def __init__(self, path: Path, size: tuple[int, int], fps: Fraction):
        self._path, self._fps = path, fps
        self._frames: list[Image.Image] = []

    def add(self, pixels: np.ndarray) -> None:
        image = Image.fromarray(pixels)
        self._frames.append(image.quantize(palette=image.quantize(256), dither=Image.Dither.FLOYDSTEINBERG))

    def close(self) -> None:
        first, *others = self._frames
        ends = [_gif_time(number, self._fps) for number in range(len(self._frames) + 1)]
        durations = [end - start for start, end in pairwise(ends)]
        first.save(self._path, format="GIF", save_all=True, append_images=others, duration=durations, loop=0)

    def discard(self) -> None:
        self._frames.clear()


def _gif_time(frame: int, fps: Fraction) -> int:
    """When a frame begins, ms: a GIF counts in hundredths of a second, and so that the whole keeps time."""
    return round(frame * 100 / fps) * 10


def complete(path: Path, size: tuple[int, int], fps: float, frames: int) -> bool:
    """Whether `path` is a video of `size` (width, height) that holds so many frames."""
    if path.suffix.lower() == ".gif":
        return _gif_complete(path, size, Fraction(fps).limit_denominator(1001), frames)
    import av

    try:
        with av.open(str(path)) as container:
            stream = container.streams.video[0]
            held = sum(packet.size > 0 for packet in container.demux(stream))
            return (stream.width, stream.height, held) == (*size, frames)
    except (OSError, IndexError, av.FFmpegError):
        return False


def _gif_complete(path: Path, size: tuple[int, int], fps: Fraction, frames: int) -> bool:
    """By its duration, as frames that show the same are one frame."""
    try:
        with Image.open(path) as image:
            duration = 0
            for number in range(getattr(image, "n_frames", 1)):
                image.seek(number)
                duration += image.info.get("duration", 0)
            return image.size == size and duration == _gif_time(frames, fps)
    except (OSError, SyntaxError, ValueError):
        return False
