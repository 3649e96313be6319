"""What voxel-cones costs: memory of bricks, time by triangles, and frames of Crytek Sponza beside a clipmap's."""

from __future__ import annotations

import statistics
from dataclasses import replace

import numpy as np

from octolux.compare.choices import choice
from octolux.gpu.profiler import Profiler
from octolux.renderer import Renderer
from octolux.scene.lights import DirectionalLight
from octolux.scene.meshes import Mesh
from octolux.scene.scene import Scene

from . import scenes_on_disk
from . import vct_thesis as thesis
from .comparison_set import VIEWS, scene_of
from .crytek_child import MAPS
from .lab import device
from .registry import aim, at_least, at_most, figure
from .stages import interleaved_stages
from .vct_frames import PLACES, TECHNIQUE, built, lit, maps

PARTS = 10
"""Into which each edge is cut: PARTS^2 triangles of one."""
ROUNDS, WARM_UP = 7, 2
SIZE, CRYTEK_SIZE = (320, 180), (1280, 720)

CRYTEK = {
    "full": "voxel-cones:full,bounces=1,cones=8,width=1.0,samples=2,screen=0",
    "half": "voxel-cones:full,bounces=1,cones=8,width=1.0,samples=2,screen=0,resolution=2,glossy_resolution=2",
    "default": "voxel-cones",
}  # fmt: skip
"""The first two with 8 diffuse cones and a specular one a pixel of theirs, through voxels alone, as the clipmap has."""


@figure("vct_memory", group="vct", unit="MB", bound={"axial": at_most(108.0), "lobes": at_most(72.0)})
def vct_memory() -> dict[str, float]:
    """The bricks of Crytek Sponza, 8 levels: 108 MB in table 6.6 of VCT, 72 as lobes; and all else of the octree."""
    kinds = (thesis.AXIAL, thesis.LOBES)
    octrees = dict(zip(kinds, built("crytek", [(kind, 8) for kind in kinds], 1), strict=True))
    rest = {f"{kind}_rest": one.other_megabytes for kind, one in octrees.items()}
    return {**{kind: one.megabytes for kind, one in octrees.items()}, **rest}


def tessellated(mesh: Mesh, parts: int = PARTS) -> Mesh:
    """The same surface: each triangle as parts^2 of its shape, with attributes in between."""
    places = {(i, j): k for k, (i, j) in enumerate((i, j) for i in range(parts + 1) for j in range(parts + 1 - i))}
    weights = np.array([(parts - i - j, i, j) for i, j in places], np.float64) / parts
    upright = [(places[i, j], places[i + 1, j], places[i, j + 1]) for i, j in places if i + j < parts]
    turned = [(places[i + 1, j], places[i + 1, j + 1], places[i, j + 1]) for i, j in places if i + j < parts - 1]
    own = np.array(upright + turned, np.uint32)

    def between(values: np.ndarray, unit: bool = False) -> np.ndarray:
        made = np.einsum("pc,tck->tpk", weights, values[mesh.indices].astype(np.float64)).reshape(-1, values.shape[1])
        length = np.linalg.norm(made, axis=1, keepdims=True) if unit else 1.0
        return (made / np.where(length > 0.0, length, 1.0)).astype(np.float32)

    first = np.arange(len(mesh.indices), dtype=np.uint32)[:, None, None] * len(places)
    tangents = between(mesh.tangents)
    tangents[:, :3], tangents[:, 3] = between(mesh.tangents[:, :3], unit=True), np.sign(tangents[:, 3])
    return replace(
        mesh, positions=between(mesh.positions), normals=between(mesh.normals, unit=True), uvs=between(mesh.uvs),
        tangents=tangents, indices=(first + own).reshape(-1, 3).astype(np.uint32),
        colors=None if mesh.colors is None else between(mesh.colors),
    )  # fmt: skip


@figure("vct_triangles", group="vct", unit="x", bound={
    "filtering": at_most(1.2), "gathering": at_most(1.2),
})  # fmt: skip
def vct_triangles() -> dict[str, float]:
    """The corridor as 100 times as many triangles, under a lamp that moves: filtering, and cones, over the same of the
    corridor as it is; and building the octree, which is done once."""
    parts = {"filtering": ("injection", "filtering"), "gathering": ("diffuse cones", "cone filter", "specular cones")}
    plain = lit("corridor", 0).meshes
    meshes = [plain, [tessellated(mesh) for mesh in plain]]
    made = [_renderer(replace(lit("corridor", 0), meshes=kind)) for kind in meshes]
    times: list[list[dict[str, float]]] = [[], []]
    for number in range(-WARM_UP, ROUNDS):
        for kind, renderer, found in zip(meshes, made, times, strict=True):
            renderer.scene = replace(lit("corridor", number), meshes=kind)
            renderer.render(PLACES["corridor"].camera)
            if number >= 0:
                found.append(renderer.profiler.last_frame())
    return {name: _ratio(times[1], times[0], stages) for name, stages in parts.items()}


def _renderer(scene: Scene) -> Renderer:
    one = choice(TECHNIQUE)
    made = Renderer(scene, one.technique, settings=one.settings, size=SIZE, device=device(), frame_settings=maps(256))
    made.profiler = Profiler(device(), "fenced")
    return made


def _ratio(first: list[dict[str, float]], second: list[dict[str, float]], stages: tuple[str, ...]) -> float:
    a, b = ([sum(frame[stage] for stage in stages) for frame in frames] for frames in (first, second))
    return statistics.median(x / y for x, y in zip(a, b, strict=True))


BESIDE = ("voxel-cones", "voxel-cones:fast", "cascaded-lpv", "octree-lpv")


@figure("vct_beside", group="vct", unit="x")
def vct_beside() -> dict[str, float]:
    """Frames of the atrium and of Crytek Sponza under three lamps at 1280x720, in which nothing moves, but maps of
    lights are drawn anew, over those of cascaded-lpv: medians of frames that take turns."""
    found = {}
    for view in (VIEWS["atrium"], VIEWS["crytek_lamps"]):
        times = interleaved_stages(scene_of(view), view.camera, BESIDE, CRYTEK_SIZE, ROUNDS)
        whole = times["cascaded-lpv"]["frame"]
        found |= {f"{view.name}.{text}": stages["frame"] / whole for text, stages in times.items()}
    return found


def _under_a_sun(number: int) -> Scene:
    """Crytek Sponza in frame `number`: the sun has moved a little."""
    scene = scenes_on_disk.load("crytek_sponza").at(0.0)
    suns = [light for light in scene.lights if isinstance(light, DirectionalLight)]
    turn = (0.002 * number, 0.0, 0.0)
    return replace(scene, lights=[replace(sun, direction=tuple(np.add(sun.direction, turn))) for sun in suns])


@figure("vct_crytek", group="vct", unit={"first_frame": "1 = yes", **dict.fromkeys(CRYTEK, "ms")}, bound={
    "full": aim("< 1500"), "half": aim("< 500"), "first_frame": at_least(1.0),
})  # fmt: skip
def vct_crytek() -> dict[str, float]:
    """A frame of Crytek Sponza at 1280x720 under a sun that moves, where a C++ OpenGL clipmap with as many cones takes
    6000 ms, and 30 frames for its light; and whether the first frame has all light: is it the tenth?"""
    renderers = {
        name: Renderer(
            _under_a_sun(0), one.technique, settings=one.settings, size=CRYTEK_SIZE, device=device(),
            frame_settings=MAPS,
        )
        for name, one in ((name, choice(words)) for name, words in CRYTEK.items())
    }  # fmt: skip
    first = [renderers["full"].render() for _ in range(10)]
    same = np.array_equal(first[0].radiance, first[-1].radiance)
    for renderer in renderers.values():
        renderer.profiler = Profiler(device(), "off")
    for number in range(-1, ROUNDS):
        for renderer in renderers.values():
            if number == 0:
                renderer.profiler.clear()
            renderer.scene = _under_a_sun(number)
            renderer.render()
    times = {name: renderer.profiler.frame_ms()["median"] for name, renderer in renderers.items()}
    return {**times, "first_frame": float(same)}
