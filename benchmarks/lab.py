"""What figures share: the device, the data, passes outside a frame, and interleaved timing."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from octolux.data import data_folder
from octolux.gpu.device import Device
from octolux.gpu.profiler import Profiler, Stage

from .registry import NeedsData


@cache
def device() -> Device:
    """One device for all figures. Raises DeviceError when there is none."""
    return Device()


def data(*parts: str) -> Path:
    """A file or folder of the data folder. Raises NeedsData when it is not there."""
    path = data_folder().joinpath(*parts)
    if not path.exists():
        raise NeedsData("/".join(parts))
    return path


@contextmanager
def submitted() -> Iterator[Stage]:
    """A stage to record passes in; they have run when the block ends."""
    profiler = Profiler(device(), "off")
    with profiler.frame(), profiler.stage("figure") as stage:
        yield stage


def read_buffer(buffer: Any, dtype: Any = np.float32) -> np.ndarray:
    return np.frombuffer(device().queue.read_buffer(buffer), dtype)


def milliseconds(work: Callable[[], Any]) -> float:
    """Wall time of one call."""
    start = time.perf_counter()
    work()
    return (time.perf_counter() - start) * 1e3


def interleaved(first: Callable[[], Any], second: Callable[[], Any], pairs: int) -> dict[str, float]:
    """Median times of two works that wait for their results, ms, and the median of first / second pair by pair.

    The works alternate, so that what else the machine does meets both alike; the first three pairs warm up.
    """
    times = [(milliseconds(first), milliseconds(second)) for _ in range(pairs + 3)][3:]
    a, b = zip(*times, strict=True)
    ratios = [x / y for x, y in times]
    return {"first": statistics.median(a), "second": statistics.median(b), "ratio": statistics.median(ratios)}


def random_directions(rng: np.random.Generator, *shape: int) -> np.ndarray:
    """Unit vectors (*shape, 3), uniform on the sphere."""
    v = rng.normal(size=(*shape, 3))
    return v / np.linalg.norm(v, axis=-1, keepdims=True)
