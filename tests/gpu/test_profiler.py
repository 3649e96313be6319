"""The profiler's table, in each mode, and its mistrust of the device's clock. No test judges how long anything took."""

from __future__ import annotations

import statistics

import numpy as np
import pytest

from octolux.gpu import profiler as profiler_module
from octolux.gpu.bindings import storage_rw
from octolux.gpu.passes import ComputePass
from octolux.gpu.profiler import Profiler

COUNT = """@compute @workgroup_size({{ workgroup }})
fn main() { values[0] += 1.0; }
"""


@pytest.fixture
def count(device, tmp_path):
    """Run one pass that adds 1 to a number."""
    (tmp_path / "count.wgsl").write_text(COUNT)
    values = storage_rw("values", "f32")
    made = ComputePass(device, "count", str(tmp_path / "count.wgsl"), [values], workgroup=(1, 1, 1))
    made.values = device.buffer("count", np.zeros(4, np.float32))
    return made


def run_frames(profiler, count, frames: int) -> None:
    for number in range(frames):
        with profiler.frame():
            with profiler.stage("first") as stage:
                count.run(stage, (1,), values=count.values)
                count.run(stage, (1,), values=count.values)
            if number % 2 == 0:
                with profiler.stage("sometimes") as stage:
                    count.run(stage, (1,), values=count.values)


@pytest.mark.parametrize("mode", ["fenced", "timestamps"])
def test_rows_of_the_table(device, count, mode):
    if mode == "timestamps" and "timestamp-query" not in device.features:
        pytest.skip("the adapter has no timestamps")
    profiler = Profiler(device, mode)
    assert profiler.mode == mode
    run_frames(profiler, count, 5)
    rows = {row["name"]: row for row in profiler.stages()}
    assert list(rows) == ["first", "sometimes"]
    assert (rows["first"]["count"], rows["sometimes"]["count"]) == (5, 3)
    assert profiler.frames == 5
    for row in rows.values():
        assert row["total_ms"] == pytest.approx(row["mean_ms"] * row["count"])
        assert 0 <= row["median_ms"] <= row["total_ms"]
    times = profiler.frame_ms()
    assert 0 < times["min"] <= times["median"] <= times["max"]
    assert device.queue.read_buffer(count.values).cast("f")[0] == 13


def test_off_runs_and_times_no_stage(device, count):
    profiler = Profiler(device, "off")
    run_frames(profiler, count, 2)
    assert profiler.stages() == [] and profiler.frames == 2
    assert device.queue.read_buffer(count.values).cast("f")[0] == 5


def test_mean_and_median(device):
    profiler = Profiler(device, "off")
    times = [1.0, 5.0, 2.0, 40.0]
    profiler._times["made up"] = list(times)
    row = profiler.stages()[0]
    assert row == {"name": "made up", "count": 4, "mean_ms": 12.0, "median_ms": 3.5, "total_ms": 48.0}
    assert statistics.fmean(times) == row["mean_ms"]
    profiler.clear()
    assert profiler.stages() == [] and profiler.frame_ms() == {"mean": 0, "median": 0, "min": 0, "max": 0}


@pytest.mark.parametrize("reported", [
    [0.1, 0.1, 0.1, 0.1],  # Mesa 22: next to nothing
    [36.0, 0.01, 0.01, 0.01],  # the first pass takes it all
    [40.0, 40.0, 40.0, 40.0],  # more than has passed
    [0.0, 0.0, 0.0, 0.0],
], ids=["too little", "uneven", "too much", "none"])  # fmt: skip
def test_a_clock_that_disagrees_is_not_trusted(device, count, monkeypatch, reported):
    monkeypatch.setattr(profiler_module, "_probe", lambda profiler: (40.0, reported))
    monkeypatch.setattr(device, "features", frozenset({"timestamp-query"} & set(device.wgpu.features)))
    if not device.features:
        pytest.skip("the adapter has no timestamps")
    profiler = Profiler(device)
    assert profiler.mode == "fenced"
    assert "timestamps are wrong" in profiler.note and "40.0 ms" in profiler.note
    run_frames(profiler, count, 1)
    assert [row["name"] for row in profiler.stages()] == ["first", "sometimes"]


def test_a_clock_that_agrees_is_trusted(device, monkeypatch):
    if "timestamp-query" not in device.features:
        pytest.skip("the adapter has no timestamps")
    monkeypatch.setattr(profiler_module, "_probe", lambda profiler: (40.0, [9.5, 9.5, 9.5, 9.5]))
    profiler = Profiler(device)
    assert (profiler.mode, profiler.note) == ("timestamps", "")


def test_an_adapter_without_timestamps(device, count, monkeypatch):
    monkeypatch.setattr(device, "features", frozenset())
    profiler = Profiler(device)
    assert profiler.mode == "fenced" and "no timestamps" in profiler.note
    run_frames(profiler, count, 1)
    assert len(profiler.stages()) == 2


def test_the_real_check_ends_in_a_mode_that_works(device, count):
    profiler = Profiler(device)
    assert profiler.mode in ("timestamps", "fenced")
    assert bool(profiler.note) == (profiler.mode == "fenced")
    assert profiler.stages() == []  # the probe has left no trace
    run_frames(profiler, count, 1)
    assert len(profiler.stages()) == 2


def test_a_frame_that_fails_does_not_count(device, count):
    profiler = Profiler(device, "fenced")
    with pytest.raises(RuntimeError), profiler.frame():
        raise RuntimeError
    assert profiler.frames == 0
    run_frames(profiler, count, 1)
    assert profiler.frames == 1
