"""The frames that VCT's tables are measured on: a lamp and a ball move through a scene, and each part is timed alone.

As in the thesis: 512 x 512 pixels, 6 diffuse cones at each and a specular one, 8 levels, and one lamp that shines all
around, every texel of whose 512 x 512 shadow maps is injected; nothing else shines.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from math import cos, pi, radians, sin
from typing import Any

import numpy as np

import octolux
from octolux.compare.choices import choice
from octolux.frame.frame import FrameSettings
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.renderer import Renderer
from octolux.scene.builtin.round_shapes import sphere
from octolux.scene.environment import Environment
from octolux.scene.lights import Light, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.voxels.surfaces import around
from octolux.techniques import technique_class
from octolux.techniques.technique import Technique
from octolux.techniques.voxel_cones.voxels.structure import VoxelOctree

from . import scenes_on_disk
from . import vct_thesis as thesis
from .lab import device
from .part_profiler import PartProfiler

SIZE, SHADOWS, DEPTH = (512, 512), 512, 8
TECHNIQUE = "voxel-cones:full,bounces=1,cones=6,width=1.0,samples=2,screen=0"
"""As many cones as the thesis traces, as wide, through voxels alone, at all pixels."""

WARM_UP = 2
OTHER = "other"
"""What the thesis does not time: the G-buffer, direct light, composite."""

COPIES = "CP inside, edge"
"""Both in one pass here."""

OCTREE = "octree: "
"""What names of parts begin with that build an octree: of what moves, where it is in a frame."""

_BUILDING = {
    "fragments": thesis.FRAGMENTS, "octree": thesis.BUILD, "voxels": thesis.LEAVES, "averaging": thesis.CHILDREN,
    "bricks": COPIES, "edge copy": COPIES,
}  # fmt: skip
_STAGES = {
    "RSM rendering": thesis.RENDER, "RSM surfaces": thesis.TRAVERSE, "injection": thesis.INSERT,
    "diffuse cones": thesis.DIFFUSE, "cone filter": thesis.DIFFUSE, "specular cones": thesis.SPECULAR,
    "filtering": COPIES,
}  # fmt: skip
_PASSES = {
    ("injection", "inject"): thesis.TRAVERSE, ("filtering", "climb"): thesis.CHILDREN,
    ("filtering", "average_light"): thesis.CHILDREN,
}  # fmt: skip


def part_of(stage: str, name: str, clears: bool = False) -> str:
    """The part of the thesis's that a pass, or the clearing or copying of a buffer, of that name in that stage belongs
    to. Of the update list only that shows: it is made in passes that average, too."""
    if stage in _BUILDING:
        if clears and stage == "voxels":
            return OCTREE + thesis.RESET
        return OCTREE + (thesis.CHILDREN if name == "average_light" else _BUILDING[stage])
    if clears and stage == "filtering":
        return thesis.LIST
    return _PASSES.get((stage, name), _STAGES.get(stage, OTHER))


@dataclass(frozen=True)
class Place:
    """thesis: the scene's name there, or "".  camera: that sees it.  lamp: where it is, of how many candela, and the
    metres of the circle that it goes around; on its other side, `below` the lamp, is a ball of the radius `ball`."""

    thesis: str
    camera: str
    lamp: tuple[float, float, float]
    candela: float
    reach: float
    below: float
    ball: float


PLACES = {
    "cornell-box": Place("Cornell box", "front", (0.0, 1.6, 0.2), 60.0, 0.2, 0.8, 0.15),
    "corridor": Place("Dungeon", "lit", (-0.93, 1.5, 0.3), 100.0, 0.3, 0.8, 0.15),
    "atrium": Place("", "hall", (0.5, 1.6, -1.4), 1000.0, 0.7, 0.8, 0.25),
    "crytek": Place("Sponza", "nave", (0.5, 1.6, -1.4), 1000.0, 0.7, 0.8, 0.25),
}
_PERIOD = 50  # frames of the lamp's circle


@cache
def scene_of(name: str) -> Scene:
    """In the dark, at 0 s, with the ball as its last mesh. Raises NeedsData when its model is not there."""
    scene = scenes_on_disk.load("crytek_lamps") if name == "crytek" else octolux.load(name)
    still = scene.at(0.0) if scene.tracks else scene
    ball = sphere(PLACES[name].ball, material=len(still.materials), name="ball")
    return replace(
        still, lights=[], environment=Environment((0.0, 0.0, 0.0)), exposure=4.0, meshes=[*still.meshes, ball],
        materials=[*still.materials, Material(base_color=(0.6, 0.6, 0.6), specular=0.0)],
    )  # fmt: skip


def lit(name: str, frame: int, faces: int = 6) -> Scene:
    """The scene in frame number `frame`: lamp and ball have moved. It shines all around, or down with one face."""
    place, turn, base = PLACES[name], 2.0 * pi * frame / _PERIOD, scene_of(name)
    x, y, z = place.lamp
    aside = np.array([place.reach * cos(turn), 0.0, place.reach * sin(turn)])
    at, intensity = tuple(place.lamp + aside), (place.candela,) * 3
    lamp: Light = PointLight(position=at, intensity=intensity)
    if faces == 1:
        lamp = SpotLight(position=at, direction=(0.0, -1.0, 0.0), intensity=intensity, outer_angle=radians(45.0))
    transform = np.eye(4)
    transform[:3, 3] = (x, y - place.below, z) - aside
    ball = Instance(len(base.meshes) - 1, transform, name="ball")
    return replace(base, lights=[lamp], instances=[*base.instances, ball])


@dataclass(frozen=True)
class Case:
    """What a row is measured with: changes of TECHNIQUE, pixels, texels along the edge of shadow maps, and how many of
    these the lamp has."""

    changes: str = ""
    size: tuple[int, int] = SIZE
    shadows: int = SHADOWS
    faces: int = 6

    def technique(self) -> Technique:
        one = choice(f"{TECHNIQUE},{self.changes}" if self.changes else TECHNIQUE)
        return technique_class(one.technique)(device(), one.settings)


def maps(texels: int) -> FrameSettings:
    return FrameSettings(shadow_resolution=texels, rsm_resolution=texels, sky_lights=0, emitter_lights=0)


def frames_of(name: str, cases: Sequence[Case], count: int) -> list[dict[str, float]]:
    """Median milliseconds by part of the cases' frames, which take turns. Cases of one size and one shadow map share a
    renderer. Raises NeedsData, or DeviceError where a case does not fit on the device."""
    renderers: dict[Any, Renderer] = {}
    techniques, profilers = [], []
    for case in cases:
        key = (case.size, case.shadows)
        if key not in renderers:
            renderers[key] = Renderer(
                lit(name, 0), "none", size=case.size, device=device(), frame_settings=maps(case.shadows)
            )
        techniques.append(case.technique())
        profilers.append(PartProfiler(device(), part_of))
    for number in range(-WARM_UP, count):
        for case, technique, profiler in zip(cases, techniques, profilers, strict=True):
            renderer = renderers[case.size, case.shadows]
            if number == 0:
                profiler.clear()
            renderer.technique, renderer.profiler = technique, profiler
            renderer.scene = lit(name, number, case.faces)
            renderer.render(PLACES[name].camera)
    return [{part: times.median for part, times in profiler.times().items()} for profiler in profilers]


@dataclass(frozen=True)
class Built:
    """parts: median milliseconds.  nodes, bricks: how many.  megabytes: of the bricks' texture, 10^6 bytes; of all else
    that the octree holds."""

    parts: dict[str, float]
    nodes: int
    bricks: int
    megabytes: float
    other_megabytes: float


def built(name: str, kinds: Sequence[tuple[str, int]], count: int) -> list[Built]:
    """Octrees of everything, by representation and depth, each built `count` times. Raises NeedsData."""
    found = []
    scene = GpuScene(device())
    scene.sync(lit(name, 0))
    for representation, depth in kinds:
        before = device().memory.total
        octree = VoxelOctree(device(), depth, 0.0, representation, interior=True)  # as by default
        profiler = PartProfiler(device(), part_of)
        for number in range(-1, count):  # the first makes room
            if number == 0:
                profiler.clear()
            with profiler.frame():
                octree.build(profiler, scene, around(*scene.bounds, depth))
        bricks = octree.bricks.bricks
        parts = {part: times.median for part, times in profiler.times().items()}
        size = texture_bytes(bricks.resource)
        rest = device().memory.total - before - size
        found.append(Built(parts, octree.octree.counts.nodes, bricks.used, size / 1e6, rest / 1e6))
        del octree, bricks
    return found


def texture_bytes(texture: Any) -> int:
    """Of an rgba8unorm texture."""
    width, height, depth = texture.size
    return 4 * width * height * depth
