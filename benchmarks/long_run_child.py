"""`python -m benchmarks.long_run_child SCENE FRAMES EARLY [TECHNIQUE PRESET EDGE]`: render many frames of EDGE^2
pixels, and print memory early and late."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

import octolux
from octolux.frame.frame import FrameSettings

FPS = 24.0
DEFAULTS = ["uniform-lpv", "default", "160"]


def resident_bytes() -> int:
    """What of this process is in memory now (Linux)."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGE_SIZE")


def main() -> None:
    source, frames, early = sys.argv[1], int(sys.argv[2]), int(sys.argv[3])
    technique, preset, edge = sys.argv[4:] or DEFAULTS
    scene = octolux.load(source)
    renderer = octolux.Renderer(
        scene, technique, preset=preset, size=(int(edge), int(edge)), sequence=True, anti_aliasing="auto",
        frame_settings=FrameSettings(shadow_resolution=256, rsm_resolution=64),
    )  # fmt: skip
    found = {}
    for number in range(1, frames + 1):
        renderer.scene = scene.at(number / FPS)
        picture = renderer.render()
        if number in (early, frames):
            mean = float(picture.radiance.mean())
            found[number] = {"resident": resident_bytes(), "device": renderer.device.memory.total, "mean": mean}
    print(json.dumps({"early": found[early], "late": found[frames]}))


if __name__ == "__main__":
    main()
