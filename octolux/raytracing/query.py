"""Rays from the host through the BVH: for tests, figures, and whoever wants to know what a ray meets."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..frame.shader_values import surface_values
from ..gpu.bindings import storage, storage_rw
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from ..gpu.profiler import Profiler
from ..gpu_scene.gpu_scene import GpuScene
from .bvh import Bvh

_ROW = 1 << 15  # threads of a row of the dispatch

HITS = np.dtype([("t", "f4"), ("id", "u4"), ("b1", "f4"), ("b2", "f4")])


def packed_rays(origins: Any, directions: Any, t_min: Any = 0.0, t_max: Any = np.inf) -> np.ndarray:
    """float32 (rays, 8): origin, t_min, direction, t_max. t counts lengths of the direction; infinity becomes the
    largest float32, since WGSL need not know infinities."""
    origins, directions = np.atleast_2d(origins), np.atleast_2d(directions)
    rays = np.zeros((max(len(origins), len(directions)), 8), np.float32)
    rays[:, :3], rays[:, 4:7] = origins, directions
    rays[:, 3], rays[:, 7] = t_min, np.minimum(t_max, np.finfo(np.float32).max)
    return rays


class RayQuery:
    """One kind of query against a scene and its BVH as they are at present.

    any_hit: only whether something is met, as `id` 1.  cull_back: pass through the back of single-sided materials.
    alpha_seed: plus the number of the ray, which of the blended surfaces are there for it.  bvh_counts=True: b1 and b2
    are how many nodes and triangles were looked at.
    """

    def __init__(self, device: Device, scene: GpuScene, bvh: Bvh, *, any_hit: bool = False, cull_back: bool = False,
                 alpha_seed: int = 0, **values: Any):  # fmt: skip
        self.device, self.scene, self.bvh = device, scene, bvh
        self._pass = ComputePass(
            device, "ray query", "raytracing/query.wgsl",
            [storage("rays", "vec4f"), bvh.binding, storage_rw("hits", "vec4u", "write")], shared=scene.bindings,
            workgroup=(64, 1, 1), row=_ROW, any_hit=any_hit, cull_back=cull_back, alpha_seed=alpha_seed,
            **{**bvh.values, **surface_values(scene), **values},
        )  # fmt: skip

    def __call__(self, rays: np.ndarray) -> np.ndarray:
        """rays: of `packed_rays`.  Returns HITS (rays,); id 0 is nothing, and t is then t_max."""
        if not len(rays):
            return np.zeros(0, HITS)
        hits = self.device.buffer("rays", size=16 * len(rays))
        self.run(self.device.buffer("rays", rays), hits)
        return np.frombuffer(self.device.queue.read_buffer(hits), HITS)

    def run(self, rays: Any, hits: Any) -> None:
        """The same between buffers on the device; it has run when this returns."""
        count = hits.size // 16
        profiler = Profiler(self.device, "off")
        with profiler.frame(), profiler.stage("ray query") as stage:
            self._pass.run(stage, (min(count, _ROW), -(-count // _ROW)), self.scene.resources, rays=rays,
                           bvh=self.bvh.texture, hits=hits)  # fmt: skip
