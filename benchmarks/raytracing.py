"""The BVH on Crytek Sponza: build, refit, and rays per second beside Mitsuba's, ray by ray the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.raytracing.bvh import Bvh, triangle_ids
from octolux.raytracing.query import RayQuery, packed_rays
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator.camera import pixel_rays

from .lab import device, interleaved, milliseconds, random_directions
from .mitsuba_variant import mitsuba
from .registry import aim, figure
from .scenes_on_disk import load

SIZE, PAIRS, BUILDS = (640, 360), 7, 5
OFFSET = 1e-3  # m, between a surface and the rays that leave it
KINDS = ("primary", "diffuse", "shadow")


@dataclass(frozen=True, eq=False)
class Traced:
    scene: Scene
    gpu_scene: GpuScene
    bvh: Bvh

    @classmethod
    def of(cls, scene: Scene) -> Traced:
        made = cls(scene, GpuScene(device()), Bvh(device()))
        made.gpu_scene.sync(scene)
        made.bvh.sync(made.gpu_scene)
        return made

    def query(self, **options: Any) -> RayQuery:
        return RayQuery(device(), self.gpu_scene, self.bvh, **options)


@cache
def crytek() -> Traced:
    """As it is, with its cut materials."""
    return Traced.of(load("crytek_sponza"))


@cache
def opaque() -> Traced:
    """With opaque, two-sided materials: what Mitsuba's meshes without materials are."""
    scene = load("crytek_sponza")
    return Traced.of(replace(scene, materials=[replace(m, alpha_mode="opaque", double_sided=True)
                                               for m in scene.materials]))  # fmt: skip


def _tiled(rays: np.ndarray) -> np.ndarray:
    """Pictures (height, width, 3) as lists of 4 x 2 pixels, which a software adapter's eight lanes take at once."""
    height, width = rays.shape[:2]
    return rays.reshape(height // 2, 2, width // 4, 4, 3).transpose(0, 2, 1, 3, 4).reshape(-1, 3)


@cache
def rays() -> dict[str, np.ndarray]:
    """primary: of the camera.  diffuse: from what those meet, cosine-weighted.  shadow: from there to the sun."""
    scene = opaque().scene
    primary = packed_rays(*map(_tiled, pixel_rays(scene.cameras[0], *SIZE)))
    hits = opaque().query()(primary)
    primary, hits = primary[hits["id"] > 0], hits[hits["id"] > 0]
    triangles = _world_triangles()
    corners = triangles[_triangle_numbers(hits["id"])]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    normal *= -np.sign(np.sum(normal * primary[:, 4:7], axis=1, keepdims=True))
    start = primary[:, :3] + hits["t"][:, None] * primary[:, 4:7] + OFFSET * normal
    bounce = normal + random_directions(np.random.default_rng(1), len(normal))
    sun = -np.asarray(scene.lights[0].direction) / np.linalg.norm(scene.lights[0].direction)
    return {"primary": primary, "diffuse": packed_rays(start, bounce), "shadow": packed_rays(start, sun[None])}


def _world_triangles() -> np.ndarray:
    """float64 (triangles, 3, 3), in the order of their numbers."""
    drawn = opaque().gpu_scene.drawn
    parts = []
    for instance, slot in zip(drawn.instances, drawn.slots, strict=True):
        corners = slot.mesh.positions[slot.clusters.indices].astype(np.float64)
        parts.append(corners @ instance.transform[:3, :3].T + instance.transform[:3, 3])
    return np.concatenate(parts)


def _triangle_numbers(ids: np.ndarray) -> np.ndarray:
    return np.searchsorted(triangle_ids(opaque().gpu_scene), ids - np.uint32(1))


def _works(traced: Traced) -> dict[str, Callable[[], Any]]:
    """For each kind of rays a call that traces them all between buffers of the device."""
    closest, shadow = traced.query(), traced.query(any_hit=True)
    made = {}
    for kind, given in rays().items():
        query, buffer = shadow if kind == "shadow" else closest, device().buffer("rays", given)
        hits = device().buffer("rays", size=16 * len(given))
        made[kind] = lambda q=query, b=buffer, h=hits: q.run(b, h)
    return made


@figure("bvh_build", group="raytracing", unit={"build": "ms", "refit": "ms", "memory": "MB", "nodes": "", "levels": ""})
def bvh_build() -> dict[str, float]:
    """Building the BVH of 262267 triangles, and refitting it after an instance moved; memory of what rays traverse
    and of the buffer that it is copied from."""
    traced = crytek()
    scene, builds, refits = traced.scene, [], []
    for number in range(BUILDS):
        fresh = Bvh(device())
        device().wait()
        builds.append(milliseconds(lambda bvh=fresh: (bvh.sync(traced.gpu_scene), device().wait())))
        move = np.eye(4)
        move[0, 3] = 0.01 * (number + 1)
        first = scene.instances[0]
        moved = replace(scene, instances=[Instance(first.mesh, move @ first.transform), *scene.instances[1:]])
        traced.gpu_scene.sync(moved)
        device().wait()
        refits.append(milliseconds(lambda bvh=fresh: (bvh.sync(traced.gpu_scene), device().wait())))
    traced.gpu_scene.sync(scene)
    traced.bvh.sync(traced.gpu_scene)
    levels = traced.bvh.levels
    memory = (traced.bvh.buffer.size + 16 * traced.bvh.texture.width * traced.bvh.texture.height) / 1e6
    return {"build": float(np.median(builds)), "refit": float(np.median(refits)), "memory": memory,
            "nodes": sum(levels), "levels": len(levels)}  # fmt: skip


@figure("bvh_visits", group="raytracing", unit="per ray")
def bvh_visits() -> dict[str, float]:
    """Nodes (of four boxes) and triangles that a ray looks at, on average."""
    found = {}
    for kind, given in rays().items():
        hits = crytek().query(any_hit=kind == "shadow", bvh_counts=True)(given)
        found[f"{kind}_nodes"], found[f"{kind}_triangles"] = hits["b1"].mean(), hits["b2"].mean()
    return found


@figure("bvh_rays", group="raytracing", unit="M rays/s", bound={"primary": aim("several")})
def bvh_rays() -> dict[str, float]:
    """Rays per second, with cut materials: primary and diffuse ones to what they meet first, shadow rays to the sun."""
    works = _works(crytek())
    for work in works.values():
        work()
    times = {kind: min(milliseconds(work) for _ in range(PAIRS)) for kind, work in works.items()}
    return {kind: len(rays()[kind]) / times[kind] / 1e3 for kind in KINDS}


@figure("bvh_and_mitsuba", group="raytracing", unit={k: "M rays/s" if "ratio" not in k else "" for kind in KINDS
        for k in (f"{kind}", f"{kind}_mitsuba", f"{kind}_ratio")},
        bound={f"{kind}_ratio": aim(">= 1") for kind in KINDS})  # fmt: skip
def bvh_and_mitsuba() -> dict[str, float]:
    """The same rays on opaque triangles through Mitsuba's LLVM variant (Embree), in turn; ratio of speeds.

    Mitsuba is given as many threads as the machine has cores. Its times, too, are without copies from the host.
    """
    theirs, ours, found = _mitsuba_works(), _works(opaque()), {}
    for kind in KINDS:
        times, count = interleaved(ours[kind], theirs[kind], PAIRS), len(rays()[kind])
        found[kind] = count / times["first"] / 1e3
        found[f"{kind}_mitsuba"] = count / times["second"] / 1e3
        found[f"{kind}_ratio"] = 1.0 / times["ratio"]
    return found


def _mitsuba_works() -> dict[str, Callable[[], Any]]:
    """Raises NeedsData where Mitsuba is missing."""
    mi = mitsuba()
    import drjit as dr

    corners = _world_triangles().astype(np.float32).reshape(-1, 3)
    mesh = mi.Mesh("scene", len(corners), len(corners) // 3)
    values = mi.traverse(mesh)
    values["vertex_positions"], values["faces"] = corners.ravel(), np.arange(len(corners), dtype=np.uint32)
    values.update()
    scene = mi.load_dict({"type": "scene", "mesh": mesh})
    made = {}
    for kind, given in rays().items():
        ray = mi.Ray3f(mi.Point3f(given[:, :3].T.copy()), mi.Vector3f(given[:, 4:7].T.copy()))
        dr.eval(ray)

        def work(ray: Any = ray, any_hit: bool = kind == "shadow") -> None:
            met = scene.ray_test(ray) if any_hit else scene.ray_intersect_preliminary(ray, coherent=False)
            dr.eval(met if any_hit else (met.t, met.prim_index, met.prim_uv))
            dr.sync_thread()

        made[kind] = work
    return made
