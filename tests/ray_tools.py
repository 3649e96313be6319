"""What tests of the BVH share: scenes on the device, and rays against all triangles in float64."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from gpu_tools import random_directions

from octolux.gpu.device import Device
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.raytracing.bvh import Bvh, triangle_ids
from octolux.raytracing.query import RayQuery, packed_rays
from octolux.scene.materials import Material
from octolux.scene.meshes import Mesh
from octolux.scene.scene import Scene

# A corner seen from the ray's origin is rounded by 2^-24 of the coordinates in the instance's transform (four terms),
# the subtraction of the origin and the shear: together at most 2^-21.
ROUNDING = 2.0**-21


def soup(rng, count: int, size: float = 0.2) -> np.ndarray:
    """Corners (count, 3, 3) of random triangles in and around the unit box."""
    return (rng.uniform(-1, 1, (count, 1, 3)) + rng.uniform(-size, size, (count, 3, 3))).astype(np.float32)


def random_rays(rng, count: int, extent: float = 2.0) -> np.ndarray:
    """Rays from all around and within, directions of unequal length."""
    directions = random_directions(rng, count) * rng.uniform(0.3, 3.0, (count, 1))
    return packed_rays(extent * rng.uniform(-1, 1, (count, 3)), directions)


def triangle_mesh(corners: np.ndarray, material: int = 0, **rest: np.ndarray) -> Mesh:
    """A mesh of separate triangles (n, 3, 3); normals and tangents mean nothing here."""
    count = 3 * len(corners)
    arrays = {
        "positions": np.asarray(corners).reshape(-1, 3), "normals": np.tile([0, 1, 0], (count, 1)),
        "tangents": np.tile([1, 0, 0, 1], (count, 1)), "uvs": np.zeros((count, 2)), **rest,
    }  # fmt: skip
    indices = np.arange(count, dtype=np.uint32).reshape(-1, 3)
    return Mesh(indices=indices, material=material, **{k: np.asarray(v, np.float32) for k, v in arrays.items()})


class Traced:
    """A scene on the device with its BVH. `follow` brings another version of the scene there."""

    def __init__(self, device: Device, scene: Scene):
        self.device, self.gpu_scene, self.bvh = device, GpuScene(device), Bvh(device)
        self.follow(scene)

    def follow(self, scene: Scene) -> None:
        if not scene.materials:
            scene.materials = [Material(double_sided=True)]
        self.scene = scene
        self.gpu_scene.sync(scene)
        self.bvh.sync(self.gpu_scene)

    def query(self, rays: np.ndarray, **options) -> np.ndarray:
        return RayQuery(self.device, self.gpu_scene, self.bvh, **options)(rays)

    def triangles(self) -> SimpleNamespace:
        """In the order of their numbers: ids as hits name them, corners (n, 3, 3) in world space, float64, as float32
        vertices and transforms give them, instance (n,)."""
        drawn, corners, instances = self.gpu_scene.drawn, [], []
        for number, (instance, slot) in enumerate(zip(drawn.instances, drawn.slots, strict=True)):
            m = np.asarray(instance.transform, np.float32).astype(np.float64)
            local = slot.mesh.positions[slot.clusters.indices].astype(np.float64)
            corners.append(local @ m[:3, :3].T + m[:3, 3])
            instances.append(np.full(len(local), number))
        ids = triangle_ids(self.gpu_scene) + np.uint32(1)
        if not corners:
            return SimpleNamespace(ids=ids, corners=np.zeros((0, 3, 3)), instance=np.zeros(0, int))
        return SimpleNamespace(ids=ids, corners=np.concatenate(corners), instance=np.concatenate(instances))


def meet_all(corners: np.ndarray, rays: np.ndarray) -> SimpleNamespace:
    """Every ray against every triangle (Moeller and Trumbore 1997), float64: t, b1, b2, margin (rays, triangles).

    margin: least of the three barycentric coordinates; the ray meets the triangle where it is positive.  t is not cut.
    determinant: minus direction times normal (of twice the area's length), positive for a front face.
    """
    o, d = rays[:, None, :3].astype(np.float64), rays[:, None, 4:7].astype(np.float64)
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p, s = np.cross(d, e2), o - a
    q = np.cross(s, e1)
    determinant = np.sum(p * e1, axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        b1, b2, t = (x / determinant for x in (np.sum(s * p, -1), np.sum(q * d, -1), np.sum(q * e2, -1)))
        margin = np.minimum(np.minimum(b1, b2), 1 - b1 - b2)
    valid = np.isfinite(margin) & np.isfinite(t)
    return SimpleNamespace(t=np.where(valid, t, np.inf), b1=b1, b2=b2, margin=np.where(valid, margin, -np.inf),
                           determinant=determinant)  # fmt: skip


def check(traced: Traced, rays: np.ndarray, least_sure: float = 0.95) -> np.ndarray:
    """Closest and any hits of `rays` are right wherever float32 can tell; returns the hits."""
    triangles, hits = traced.triangles(), traced.query(rays)
    corners, met = triangles.corners, meet_all(triangles.corners, rays)
    reach = np.abs(rays[:, :3]).max(axis=1)[:, None] + np.abs(corners).max(axis=(1, 2), initial=0.0)
    length = np.linalg.norm(rays[:, None, 4:7].astype(np.float64), axis=-1)
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=-1).max(axis=1)
    normal = np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=-1)
    with np.errstate(divide="ignore", invalid="ignore"):
        # A corner's error over the least altitude of the triangle as the ray sees it; and along the ray, by the slope.
        unsure = np.nan_to_num(4 * ROUNDING * reach * sides * length / np.abs(met.determinant), nan=np.inf)
        along = np.nan_to_num(4 * ROUNDING * reach * normal / np.abs(met.determinant), nan=np.inf)
    in_range = (met.t > rays[:, None, 3] + along) & (met.t < rays[:, None, 7] - along)
    surely = (met.margin > unsure) & in_range
    outside = (met.t < rays[:, None, 3] - along) | (met.t > rays[:, None, 7] + along)
    never = (normal == 0.0) | (met.margin < -unsure) | outside
    t = np.where(surely, met.t, np.inf).min(axis=1, initial=np.inf)
    sure = ~(~surely & ~never & (met.t <= t[:, None] + along)).any(axis=1)
    assert sure.mean() >= least_sure
    hit = sure & np.isfinite(t)
    assert np.array_equal(hits["id"][sure] > 0, np.isfinite(t)[sure])
    assert np.array_equal((traced.query(rays, any_hit=True)["id"] > 0), hits["id"] > 0)
    assert np.array_equal(hits["t"][hits["id"] == 0], rays[hits["id"] == 0, 7])
    if hit.any():
        number = np.searchsorted(triangles.ids, hits["id"])
        assert np.array_equal(triangles.ids[number[hit]], hits["id"][hit])
        pick = (np.flatnonzero(hit), number[hit])
        assert (~never[pick]).all()
        assert np.all(np.abs(hits["t"][hit] - met.t[pick]) <= along[pick])
        assert np.all(hits["t"][hit] <= t[hit] + along[pick])
        for name in ("b1", "b2"):
            assert np.all(np.abs(hits[name][hit] - getattr(met, name)[pick]) <= unsure[pick])
    return hits
