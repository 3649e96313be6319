"""Loading a scene to the device for the first time and again: what the cache of processed textures saves."""

from __future__ import annotations

import statistics
import tempfile
from collections.abc import Callable
from functools import partial
from pathlib import Path

from .lab import data
from .program import child
from .registry import at_most, figure
from .scenes_on_disk import path_of

_PAIRS = 3


def _first_and_second(path: Path, cache: str) -> tuple[float, float]:
    first, second = (child("loading_child", path, cache) for _ in range(2))
    return first["seconds"], second["seconds"]


def _medians(path: Path) -> dict[str, float]:
    """New processes throughout, the model's files in the system's cache; `off` makes no use of octolux's."""
    off = [child("loading_child", path, "off")["seconds"] for _ in range(_PAIRS)]
    pairs = []
    for _ in range(_PAIRS):
        with tempfile.TemporaryDirectory() as folder:
            pairs.append(_first_and_second(path, folder))
    first, second = (statistics.median(times) for times in zip(*pairs, strict=True))
    return {"first": first, "second": second, "off": statistics.median(off)}


def _register(name: str, path: Callable[[], Path], what: str) -> None:
    def measure() -> dict[str, float]:
        return _medians(path())

    measure.__doc__ = f"{what}: from the file to the device, with an empty cache, a filled one, and none."
    figure(name, group="loading", unit="s", bound={"first": at_most(6), "second": at_most(2)})(measure)


_register("load_crytek", partial(path_of, "crytek_sponza"), "Crytek Sponza, 34 textures of up to 512 pixels")
_register("load_helmet", lambda: data("scenes", "gltf", "FlightHelmet", "FlightHelmet.gltf"),
          "FlightHelmet, 15 textures of 512 pixels")  # fmt: skip
