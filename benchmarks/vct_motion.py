"""What voxel-cones makes anew when a light or a small thing moves, and whether anything of it is left (VCT 5.5, 5.7).

The frames are those of VCT's tables (vct_frames.py): a lamp and a ball of 0.5 m that go around, 9 cm a frame.
"""

from __future__ import annotations

import hashlib
import statistics
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from octolux.gpu.profiler import Profiler
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.renderer import Renderer
from octolux.techniques.voxel_cones.technique import VoxelCones
from octolux.techniques.voxel_cones.voxels.parts import Parts
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree

from .lab import device, milliseconds
from .registry import Bound, at_most, figure
from .vct_frames import DEPTH, PLACES, lit, maps

SCENE = "crytek"
WARM_UP, COUNT = 3, 10
FRAMES, EARLY = 1000, 10
SMALL, EVERY = "cornell-box", 5
"""Of the long run; EVERY: of the frames of a circle one in so many, so that EARLY frames go once around."""


def renderer_of(name: str, depth: int, size: tuple[int, int], texels: int, mode: str = "off") -> Renderer:
    made = Renderer(
        lit(name, 0), "voxel-cones", preset="fast", settings={"depth": depth, "bounces": 1}, size=size, device=device(),
        exposure=4.0, frame_settings=maps(texels), default_light=False,
    )  # fmt: skip
    made.profiler = Profiler(device(), None if mode == "timed" else mode)
    return made


def cones_of(renderer: Renderer) -> VoxelCones:
    assert isinstance(renderer.technique, VoxelCones)
    return renderer.technique


def light_shares(name: str, faces: int) -> Iterator[tuple[float, float]]:
    """Of frames in which the lamp has moved, and nothing else: time of filtering over that of filtering everything, and
    bricks that were made anew over all."""
    renderer = renderer_of(name, DEPTH, (64, 36), 512, "timed")
    base, technique = lit(name, 0), cones_of(renderer)
    for number in range(WARM_UP + COUNT):
        renderer.scene = replace(base, lights=lit(name, number, faces).lights)
        renderer.render(PLACES[name].camera)
        time, filtering = renderer.profiler.last_frame()["filtering"], technique.octree.filtering
        made = len(filtering.updates.read())
        with renderer.profiler.frame(), renderer.profiler.stage("everything") as stage:
            filtering.everything(stage, technique.injection.unit)
        if number >= WARM_UP:
            whole = renderer.profiler.last_frame()["everything"]
            yield time / whole, made / technique.octree.bricks.bricks.used


@figure("vct_moved_light", group="vct", bound={"spot": at_most(0.4), "point": at_most(0.4)})
def vct_moved_light() -> dict[str, float]:
    """A lamp moves in Crytek Sponza, 8 levels: filtering what it touches over filtering everything, in turns; of a spot
    light, and of one that shines all around. `bricks`: how many of all are made anew, below which nothing can go."""
    found = {}
    for text, faces in (("spot", 1), ("point", 6)):
        times, bricks = zip(*light_shares(SCENE, faces), strict=True)
        found |= {text: statistics.median(times), f"{text}.bricks": statistics.median(bricks)}
    return found


@figure("vct_moved_object", group="vct", unit={"moved": "ms", "full": "ms"}, bound={"ratio": at_most(0.2)})
def vct_moved_object() -> dict[str, float]:
    """A ball of 0.5 m moves in Crytek Sponza, 8 levels: making anew the octree of what moves over building that of
    everything, in turns. `nodes`, `triangles`: of what is made anew, over all."""
    scene, parts = GpuScene(device()), Parts(device(), DEPTH, 0.0, interior=True)
    whole, profiler, times = VoxelOctree(device(), DEPTH, interior=True), Profiler(device(), "off"), []

    def moved() -> None:
        with profiler.frame():
            parts.build(profiler, scene)

    def full() -> None:
        with profiler.frame():
            whole.build(profiler, scene, parts.static.grid)

    for number in range(WARM_UP + COUNT):
        scene.sync(lit(SCENE, number))
        parts.prepare(scene)
        times.append((milliseconds(moved), milliseconds(full)))
    assert parts.moving
    first, second = zip(*times[WARM_UP:], strict=True)
    nodes = parts.moving.octree.counts.nodes / whole.octree.counts.nodes
    ratio = statistics.median(a / b for a, b in zip(first, second, strict=True))
    return {"ratio": ratio, "moved": statistics.median(first), "full": statistics.median(second), "nodes": nodes}


@dataclass(frozen=True)
class LongRun:
    """pictures: a digest of each frame's radiance.  memory: bytes on the device after each.  used: nodes, bricks and
    voxels of what moves, after each but the first."""

    pictures: list[bytes]
    memory: list[int]
    used: list[tuple[int, ...]]


def long_run(frames: int, size: tuple[int, int] = (64, 48), depth: int = 6) -> LongRun:
    """Lamp and ball go around, and are back in the last of `frames` + 1 frames."""
    renderer, run = renderer_of(SMALL, depth, size, 128), LongRun([], [], [])
    technique = cones_of(renderer)
    for number in range(frames + 1):
        renderer.scene = lit(SMALL, EVERY * number)
        picture = renderer.render(PLACES[SMALL].camera)
        run.pictures.append(hashlib.sha256(np.ascontiguousarray(picture.radiance).tobytes()).digest())
        run.memory.append(device().memory.total)
        if technique.parts.moving:
            run.used.append(tuple(pool["used"] for pool in technique.parts.moving.pools().values()))
    return run


_NOTHING = at_most(0.0)


@figure("vct_long_motion", group="vct", unit={"memory": "bytes"}, bound={
    "memory": _NOTHING, "moving_part": _NOTHING, "back": _NOTHING, "two_runs": _NOTHING,
    "frames": Bound(low=FRAMES, text=f">= {FRAMES}"),
})  # fmt: skip
def vct_long_motion() -> dict[str, float]:
    """1,000 frames of the Cornell box in which the ball and the lamp move. `memory`: on the device after the last, less
    that after frame 10.  `moving_part`: nodes, bricks and voxels of what moves, the most of each in the last 10 frames
    less that in the first 10.  `back`: 1 if the last picture, with both where they were, has other bits than the first,
    in which nothing had moved yet.  `two_runs`: pictures of a second run that have other bits than those of the first.
    """
    first = long_run(FRAMES)
    second = long_run(FRAMES)
    most = [np.max(part, axis=0) for part in (first.used[-EARLY:], first.used[:EARLY])]
    return {
        "frames": len(first.used), "memory": first.memory[-1] - first.memory[EARLY],
        "moving_part": np.max(most[0] - most[1]), "back": float(first.pictures[-1] != first.pictures[0]),
        "two_runs": sum(a != b for a, b in zip(first.pictures, second.pictures, strict=True)),
    }  # fmt: skip
