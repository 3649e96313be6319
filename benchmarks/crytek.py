"""Crytek Sponza as a user meets it: time of a frame and of its stages, loading, memory. Aims, not bounds."""

from __future__ import annotations

import statistics
from functools import cache
from typing import Any

from .program import child
from .registry import aim, figure
from .scenes_on_disk import path_of

FRAMES, LOADS = 15, 3

@cache
def _rendered() -> dict[str, Any]:
    return child("crytek_child", path_of("crytek_sponza"), str(FRAMES))


@figure("crytek_frame", group="crytek", unit="ms", bound={"frame": aim("245, C++ takes 490")})
def crytek_frame() -> dict[str, float]:
    """A frame at 1280x720, one sun, maps 512 / 256, 32^3, k = 12: median from first command to finished work.

    490 ms is a C++ OpenGL LPV program with the same software rasteriser, without ambient occlusion; the aim is half.
    `frame_least` is the fastest of the frames, the one least disturbed by what else the machine does. `render` is
    Renderer.render(), which also culls, and reads all layers back to the host.
    """
    return {key: _rendered()["plain"][key] for key in ("frame", "frame_least", "render")}


@figure("crytek_stages", group="crytek", unit="ms")
def crytek_stages() -> dict[str, float]:
    """Median time of every stage of that frame; where stages are timed by fences each waits for the one before.

    The C++ program: RSM 28, injection 49, propagation 11.6 an iteration for a quarter of the cells, G-buffer 90,
    deferred shading with lookup 46.
    """
    stages = _rendered()["profiled"]["stages"]
    return {**{name.replace(" ", "_"): t for name, t in stages.items()}, "sum": sum(stages.values())}


@figure("crytek_load", group="crytek", unit="s", bound={"scene": aim("6")})
def crytek_load() -> dict[str, float]:
    """From the scene file to a Scene, then to the device: medians over new processes, with the files in cache."""
    runs = [child("crytek_child", path_of("crytek_sponza"), "0") for _ in range(LOADS)]
    load, upload = (statistics.median(run[key] for run in runs) for key in ("load_s", "upload_s"))
    return {"scene": load, "upload": upload, "scene_and_upload": load + upload}


@figure("crytek_memory", group="crytek", unit="MB", bound=aim("800"))
def crytek_memory() -> float:
    """Peak resident memory of a process that loads and renders it; a software adapter's textures are in it too."""
    return _rendered()["peak_bytes"] / 1e6
