"""`python -m benchmarks.crytek_child SCENE FRAMES`: load and render once in this process, and print times as JSON.

A process of its own, so that peak memory is that of a user's program and loading meets cold caches of Python's.
"""

from __future__ import annotations

import json
import statistics
import sys
import time
from typing import Any

from octolux.frame.frame import FrameSettings
from octolux.gpu.device import Device
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.renderer import Renderer
from octolux.scene.load import load_scene
from octolux.scene.scene import Scene

SIZE, WARM_UP = (1280, 720), 3
# As in the C++ program that the aim comes from: one sun, and a sky that is seen but lights nothing.
MAPS = FrameSettings(shadow_resolution=512, rsm_resolution=256, sky_lights=0)
SETTINGS = {"n": 32, "iterations": 12}


def peak_bytes() -> int:
    """Largest resident memory of this process so far; the unit getrusage reports differs by system."""
    import resource  # not on Windows

    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024


def first_upload(scene: Scene, device: Device) -> float:
    """Seconds to bring a scene to the device."""
    start = time.perf_counter()
    GpuScene(device).sync(scene)
    device.wait()
    return time.perf_counter() - start


def frames(scene: Scene, device: Device, count: int, profile: bool) -> dict[str, Any]:
    """Times, ms, of `count` frames after the warm-up: median and least `frame` from the first command to finished work,
    median `render` with culling and with the layers read back; and of every stage when `profile` is set. Maps of lights
    are drawn in all of them, as if the sun had moved."""
    renderer = Renderer(
        scene, "uniform-lpv", settings=dict(SETTINGS), size=SIZE, device=device, profile=profile, frame_settings=MAPS
    )
    for _ in range(WARM_UP):
        renderer.render()
    renderer.profiler.clear()
    walls = []
    for _ in range(count):
        renderer.forget()
        start = time.perf_counter()
        renderer.render()
        walls.append((time.perf_counter() - start) * 1e3)
    times = renderer.profiler.frame_ms()
    return {
        "frame": times["median"],
        "frame_least": times["min"],
        "render": statistics.median(walls),
        "stages": {row["name"]: row["median_ms"] for row in renderer.profiler.stages()},
    }


def main(path: str, count: int) -> dict[str, Any]:
    """Everything that the figures of crytek.py show. With no frames only loading is measured."""
    start = time.perf_counter()
    scene = load_scene(path)
    loaded, device = time.perf_counter() - start, Device()
    if not count:
        return {"load_s": loaded, "upload_s": first_upload(scene, device)}
    plain = frames(scene, device, count, profile=False)
    peak = peak_bytes()
    profiled = frames(scene, device, count, profile=True)
    return {"load_s": loaded, "peak_bytes": peak, "plain": plain, "profiled": profiled}


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], int(sys.argv[2]))))
