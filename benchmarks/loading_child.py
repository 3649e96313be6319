"""`python -m benchmarks.loading_child SCENE CACHE`: seconds from a scene's file to the device, as JSON.

CACHE: what OCTOLUX_CACHE is set to. A process of its own, so that nothing is in memory yet.
"""

from __future__ import annotations

import json
import os
import sys
import time

from octolux.gpu.device import Device
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.scene.load import load_scene


def main(path: str, cache: str) -> dict[str, float]:
    os.environ["OCTOLUX_CACHE"] = cache
    device = Device()
    start = time.perf_counter()
    scene = load_scene(path)
    loaded = time.perf_counter()
    GpuScene(device).sync(scene)
    device.wait()
    end = time.perf_counter()
    return {"seconds": end - start, "load": loaded - start, "sync": end - loaded}


if __name__ == "__main__":
    print(json.dumps(main(sys.argv[1], sys.argv[2])))
