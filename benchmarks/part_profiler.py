"""Times of the parts that a paper's table names, found in any frame by the names of its passes and buffers."""

from __future__ import annotations

import statistics
import time
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from octolux.gpu.device import Device
from octolux.gpu.profiler import Profiler

PartOf = Callable[[str, str, bool], str]
"""The part that a pass belongs to: of the names of the stage and the pass, or, where the last is true, of a buffer that
is cleared or copied."""


@dataclass(frozen=True)
class Times:
    """count: executions in all frames.  average: of an execution.  median: of a frame.  Milliseconds."""

    count: int
    average: float
    median: float
    total: float


class PartProfiler(Profiler):
    """Submits what belongs to one part alone and waits for it, as OLPV did with CUDA_LAUNCH_BLOCKING: its wall time is
    what it cost, with recording it and one wait (about 0.15 ms on the software adapter)."""

    def __init__(self, device: Device, part_of: PartOf):
        super().__init__(device, "fenced")
        self.part_of = part_of
        self._counts: dict[str, int] = defaultdict(int)

    def clear(self) -> None:
        super().clear()
        self._counts.clear()

    @contextmanager
    def stage(self, name: str) -> Iterator[Any]:
        recorder = _Recorder(self, name)
        yield recorder
        recorder.turn_to("")

    def add(self, part: str, milliseconds: float) -> None:
        self._frame[part] = self._frame.get(part, 0.0) + milliseconds

    def execute(self, part: str) -> None:
        self._counts[part] += 1

    def times(self) -> dict[str, Times]:
        """By part; `Frame` is the wall time from the first command of a frame to its finished work."""
        parts = {"Frame": self._frame_times, **self._times}
        found = {}
        for name, times in parts.items():
            count = len(times) if name == "Frame" else self._counts[name]
            found[name] = Times(count, sum(times) / count, statistics.median(times), sum(times))
        return found

    def frames_of(self, parts: tuple[str, ...]) -> list[float]:
        """Milliseconds of those parts together in each frame. Parts that do not run in every frame are refused."""
        series = [self._times[part] for part in parts if part in self._times]
        return [sum(frame) for frame in zip(*series, strict=True)]


class _Recorder:
    """A stage that is submitted whenever the part changes. It is its own encoder."""

    def __init__(self, profiler: PartProfiler, name: str):
        self._profiler, self._name, self._part = profiler, name, ""
        self._recording: Any = None
        self._start = 0.0

    @property
    def encoder(self) -> _Recorder:
        return self

    def turn_to(self, part: str) -> Any:
        """The encoder to record `part` in; what was recorded of another has run. "" ends the stage."""
        if part != self._part:
            device = self._profiler.device
            if self._recording is not None:
                device.queue.submit([self._recording.finish()])
                device.wait()
                self._profiler.add(self._part, (time.perf_counter() - self._start) * 1e3)
            self._part, self._start = part, time.perf_counter()
            self._recording = device.wgpu.create_command_encoder(label=part) if part else None
        return self._recording

    def _executed(self, name: str, clears: bool = False) -> Any:
        part = self._profiler.part_of(self._name, name, clears)
        self._profiler.execute(part)
        return self.turn_to(part)

    def begin_compute_pass(self, label: str) -> Any:
        return self._executed(label).begin_compute_pass(label=label)

    def begin_render_pass(self, label: str, **attachments: Any) -> Any:
        return self._executed(label).begin_render_pass(label=label, **attachments)

    def clear_buffer(self, buffer: Any, *span: int) -> None:
        self._executed(buffer.label, clears=True).clear_buffer(buffer, *span)

    def copy_buffer_to_buffer(self, source: Any, *rest: Any) -> None:
        self._executed(source.label, clears=True).copy_buffer_to_buffer(source, *rest)
