"""What `octolux export` does: a scene as its user sees it, written for another program."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

from ..output import check_writable
from ..renderer import shines
from ..scene.daylight import sky, sun
from ..scene.default_camera import chosen_camera
from ..scene.errors import OctoluxError
from ..scene.load import load_scene
from .mitsuba import write_mitsuba

MOST_PIXELS = 8192
"""Along an edge: as for octolux's own pictures."""


def export_scene(
    source: str, out: Path, camera: str | None = None, size: tuple[int, int] = (1280, 720), time: float = 0.0,
    clip: str | None = None, default_light: bool = True, samples: int = 64,
) -> list[str]:  # fmt: skip
    """Load `source`, take it at `time` seconds, light it by sun and sky where nothing shines unless `default_light` is
    off, and write it for Mitsuba 3. Returns warnings: what loading had to guess, what Mitsuba cannot say.

    Raises OctoluxError.
    """
    check_writable(out, [".xml"])
    if not all(1 <= edge <= MOST_PIXELS for edge in size):
        raise OctoluxError(f"The picture's edges must be 1 to {MOST_PIXELS} pixels, not {size[0]}x{size[1]}.")
    if not math.isfinite(time):
        raise OctoluxError(f"--time is a number of seconds, not {time}.")
    loaded = load_scene(source)
    scene = loaded.at(time, clip)
    notes = list(loaded.warnings)
    if default_light and not shines(scene):
        notes.append("nothing in the scene shines: the sun and the sky of a clear day light it")
        scene = replace(scene, lights=[*scene.lights, sun()], environment=sky())
    if scene.medium:
        notes.append("the medium is left out: Mitsuba's file has clear air")
    return notes + write_mitsuba(scene, out, chosen_camera(scene, camera, size[0] / size[1]), size, samples)
