"""What each stage of a frame costs: GPU timestamps where they can be trusted, else fenced wall time."""

from __future__ import annotations

import statistics
import time
from collections import defaultdict
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
import wgpu

from .bindings import storage, storage_rw
from .device import Device
from .passes import ComputePass

QUERIES = 4096  # the most a query set may hold (WebGPU, createQuerySet): 2048 passes a frame
# Timestamps are trusted when each of some equal passes reports at least half of its share of the wall time, and all
# together no more than the wall time (but for the resolution of the clocks).
_TRUSTED, _CLOCK_SLACK = 0.5, 1.05
_PROBE_PASSES, _PROBE_MS, _MOST_ROUNDS = 3, 20.0, 1 << 20


class Stage:
    """One entry of the table while it is being recorded; passes begin on it."""

    def __init__(self, encoder: Any, profiler: Profiler, name: str):
        self.encoder, self._profiler, self.name = encoder, profiler, name

    def begin_compute_pass(self, label: str) -> Any:
        return self.encoder.begin_compute_pass(label=label, **self._profiler._timestamp_writes(self.name))

    def begin_render_pass(self, label: str, **attachments: Any) -> Any:
        writes = self._profiler._timestamp_writes(self.name)
        return self.encoder.begin_render_pass(label=label, **attachments, **writes)


class Profiler:
    """Times the stages of frames.

    `mode` is "timestamps" (GPU clock, frame submitted whole), "fenced" (each stage is submitted alone and waited for,
    so its wall time is what it cost), or "off". By default timestamps, checked once against the wall clock, else
    fenced.
    """

    def __init__(self, device: Device, mode: str | None = None):
        self.device = device
        self.note = ""
        self._queries: list[str] = []
        self._times: dict[str, list[float]] = defaultdict(list)
        self._frame_times: list[float] = []
        self._frame: dict[str, float] = {}
        self._encoder: Any = None
        self._query_set: Any = None
        self.mode = mode or "timestamps"
        if self.mode == "timestamps":
            self._open_queries()
        if mode is None and self.mode == "timestamps":
            self._check_timestamps()

    def _open_queries(self) -> None:
        if "timestamp-query" not in self.device.features:
            self.mode, self.note = "fenced", "the adapter has no timestamps: stages are timed by fenced wall clock"
            return
        self._query_set = self.device.wgpu.create_query_set(type="timestamp", count=QUERIES)
        usage = wgpu.BufferUsage.QUERY_RESOLVE | wgpu.BufferUsage.COPY_SRC
        self._query_buffer = self.device.wgpu.create_buffer(size=QUERIES * 8, usage=usage)

    def _check_timestamps(self) -> None:
        """Compare both clocks on a frame of a few equal passes that takes at least 20 ms. Every pass must report its
        share: the clock of Mesa 22's software adapter does not wait for the work once anything was rasterised."""
        wall, reported = _probe(self)
        self.clear()
        if not (min(reported) >= _TRUSTED * wall / _PROBE_PASSES and sum(reported) <= wall * _CLOCK_SLACK):
            self.mode = "fenced"
            shares = ", ".join(f"{ms:.1f}" for ms in reported)
            self.note = (
                f"GPU timestamps are wrong here (equal passes of together {wall:.1f} ms report {shares} ms): "
                "stages are timed by fenced wall clock"
            )

    def clear(self) -> None:
        """Forget all times so far."""
        self._times.clear()
        self._frame_times.clear()

    @contextmanager
    def frame(self) -> Iterator[None]:
        """Around one frame: submits what the stages recorded and waits for it."""
        start = time.perf_counter()
        self._frame, self._queries = {}, []
        self._encoder = None if self.mode == "fenced" else self.device.wgpu.create_command_encoder()
        try:
            yield
            if self._encoder is not None:
                self._finish()
        finally:
            self._encoder = None
        self._frame_times.append((time.perf_counter() - start) * 1e3)
        for name, milliseconds in self._frame.items():
            self._times[name].append(milliseconds)

    def _finish(self) -> None:
        count = len(self._queries) * 2
        if count:
            self._encoder.resolve_query_set(self._query_set, 0, count, self._query_buffer, 0)
        self.device.queue.submit([self._encoder.finish()])
        if not count:
            self.device.wait()
            return
        ticks = np.frombuffer(self.device.queue.read_buffer(self._query_buffer, 0, count * 8), np.uint64)
        for name, begin, end in zip(self._queries, ticks[::2].tolist(), ticks[1::2].tolist(), strict=True):
            self._frame[name] = self._frame.get(name, 0.0) + (end - begin) * 1e-6

    def submit(self) -> None:
        """Submit what was recorded so far: what is written to buffers from now on is seen by later stages alone."""
        if self._encoder is not None:
            self.device.queue.submit([self._encoder.finish()])
            self._encoder = self.device.wgpu.create_command_encoder()

    @contextmanager
    def stage(self, name: str) -> Iterator[Stage]:
        """Around the passes of one named stage; call inside `frame()`."""
        if self.mode != "fenced":
            yield Stage(self._encoder, self, name)
            return
        encoder = self.device.wgpu.create_command_encoder(label=name)
        start = time.perf_counter()
        yield Stage(encoder, self, name)
        self.device.queue.submit([encoder.finish()])
        self.device.wait()
        self._frame[name] = self._frame.get(name, 0.0) + (time.perf_counter() - start) * 1e3

    def _timestamp_writes(self, name: str) -> dict[str, Any]:
        if self.mode != "timestamps" or 2 * len(self._queries) + 2 > QUERIES:
            return {}
        first = 2 * len(self._queries)
        self._queries.append(name)
        indices = {"beginning_of_pass_write_index": first, "end_of_pass_write_index": first + 1}
        return {"timestamp_writes": {"query_set": self._query_set, **indices}}

    def stages(self) -> list[dict[str, Any]]:
        """One row per stage in order of appearance: name, count (frames it ran in), mean_ms, median_ms, total_ms."""
        return [{"name": name, "count": len(t), **_summary(t), "total_ms": sum(t)} for name, t in self._times.items()]

    def last_frame(self) -> dict[str, float]:
        """Milliseconds of each stage of the frame just finished."""
        return dict(self._frame)

    @property
    def frames(self) -> int:
        """How many frames were timed."""
        return len(self._frame_times)

    def frame_ms(self) -> dict[str, float]:
        """Wall time of whole frames, from first command to finished work: mean, median, min, max."""
        t = self._frame_times or [0.0]
        return {"mean": statistics.fmean(t), "median": statistics.median(t), "min": min(t), "max": max(t)}


def _probe(profiler: Profiler) -> tuple[float, list[float]]:
    """Wall time, and reported time of each pass, ms, of passes made longer until the wall clock can judge them."""
    device = profiler.device
    values = device.buffer("profiler probe", size=4096 * 4)
    spin = ComputePass(
        device, "probe", "gpu/probe.wgsl", [storage_rw("values", "f32"), storage("rounds", "u32")], workgroup=(64, 1, 1)
    )
    usage = wgpu.TextureUsage.RENDER_ATTACHMENT
    target = device.texture("profiler probe", (64, 64), "rgba8unorm", usage=usage).create_view()
    rounds, wall = 1, 0.0
    while wall < _PROBE_MS and rounds <= _MOST_ROUNDS:
        count = device.buffer("profiler probe", np.array([rounds], np.uint32))
        for _ in range(2):  # the first run of a pass may include building it
            start = time.perf_counter()
            with profiler.frame():
                with profiler.stage("clear") as stage:
                    attachment = {"view": target, "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}
                    stage.begin_render_pass("clear", color_attachments=[attachment]).end()
                for number in range(_PROBE_PASSES):
                    with profiler.stage(f"probe {number}") as stage:
                        spin.run(stage, (4096,), values=values, rounds=count)
            wall = (time.perf_counter() - start) * 1e3
        rounds *= 4
    reported = profiler.last_frame()
    return wall, [reported.get(f"probe {number}", 0.0) for number in range(_PROBE_PASSES)]


def _summary(times: list[float]) -> dict[str, float]:
    return {"mean_ms": statistics.fmean(times), "median_ms": statistics.median(times)}
