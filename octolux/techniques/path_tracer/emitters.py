"""What shines, as lists to choose from: glowing triangles and area lights by their power, the surroundings by texel."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ...gpu.layout import Struct
from ...gpu_scene.clusters import CLUSTER_TRIANGLES
from ...gpu_scene.instances import Drawn
from ...scene.environment import Environment
from ...scene.lights import AreaLight
from ...scene.scene import Scene
from ...simulator.environment import LUMINANCE, reduced, texel_solid_angles

# A triangle that shines to the side from which its corners run counter-clockwise. radiance: without its texture. id: as
# in the visibility buffer, 0 for an area light; turned: its second and third corner are exchanged. cumulative: of the
# powers.
EMITTER = Struct(
    "Emitter", corner="vec3f", cumulative="f32", edge1="vec3f", id="u32", edge2="vec3f", turned="u32", radiance="vec3f",
    padding="f32",
)  # fmt: skip

_WIDEST_TABLE = 1024


@dataclass(frozen=True, eq=False)
class EmitterList:
    """rows: EMITTER array, the area lights last.  area_lights: how many of them are of area lights.
    power: sum over rows of luminance * area, nits m^2."""

    rows: np.ndarray
    area_lights: int
    power: float


def emitter_list(scene: Scene, drawn: Drawn) -> EmitterList:
    """The glowing triangles of what is drawn, on both sides where their material is double-sided, and area lights."""
    corners, ids, turned, radiance = [], [], [], []
    for owner, (instance, slot) in enumerate(zip(drawn.instances, drawn.slots, strict=True)):
        material = scene.materials[slot.mesh.material] if scene.materials else None
        if material is None or max(material.emissive) <= 0 or material.unlit:
            continue
        points = slot.mesh.positions[slot.clusters.indices].astype(np.float64)
        points = points @ instance.transform[:3, :3].T + instance.transform[:3, 3]
        items = np.flatnonzero(drawn.item_instance == owner)
        number = np.arange(len(points))
        found = items[number // CLUSTER_TRIANGLES] * CLUSTER_TRIANGLES + number % CLUSTER_TRIANGLES + 1
        mirrored = bool(np.linalg.det(instance.transform[:3, :3]) < 0)
        for flip in (mirrored, not mirrored)[: 2 if material.double_sided else 1]:
            corners.append(points[:, [0, 2, 1]] if flip else points)
            ids.append(found)
            turned.append(np.full(len(points), flip))
            radiance.append(np.tile(material.emissive, (len(points), 1)))
    lamps = [light for light in scene.lights if isinstance(light, AreaLight) and max(light.radiance) > 0]
    for lamp in lamps:
        a, b, c, d = (np.asarray(corner, dtype=np.float64) for corner in lamp.corners)
        corners.append(np.array([[a, b, c], [a, c, d]]))
        ids.append(np.zeros(2, np.int64))
        turned.append(np.zeros(2, bool))
        radiance.append(np.tile(lamp.radiance, (2, 1)))
    if not corners:
        return EmitterList(EMITTER.array(1), 0, 0.0)
    rows = _packed(np.concatenate(corners), np.concatenate(ids), np.concatenate(turned), np.concatenate(radiance))
    return EmitterList(rows[0], 2 * len(lamps), rows[1])


def _packed(corners, ids, turned, radiance) -> tuple[np.ndarray, float]:
    """EMITTER rows and their power."""
    rows = EMITTER.array(len(corners))
    edge1, edge2 = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    power = radiance @ LUMINANCE * 0.5 * np.linalg.norm(np.cross(edge1, edge2), axis=1)
    rows["corner"], rows["edge1"], rows["edge2"] = corners[:, 0], edge1, edge2
    rows["id"], rows["turned"], rows["radiance"] = ids, turned, radiance
    rows["cumulative"] = np.cumsum(power) / max(power.sum(), 1e-300)
    return rows, float(power.sum())


def sky_table(environment: Environment) -> tuple[np.ndarray, float]:
    """Alias table over the texels of the surroundings (Walker 1977): float32 (height, width, 4) of the probability to
    keep a texel, its alias' number, its mean luminance, 0; and the sum of luminance times solid angle."""
    image = np.zeros((1, 2, 3), np.float32) if environment.image is None else reduced(environment.image, _WIDEST_TABLE)
    luminance = _filtered((image + np.asarray(environment.radiance, np.float32)).astype(np.float64) @ LUMINANCE)
    power = luminance * texel_solid_angles(*luminance.shape)
    keep, alias = alias_table(power.ravel())
    table = np.zeros((*luminance.shape, 4), np.float32)
    table[..., 0], table[..., 1], table[..., 2] = keep.reshape(power.shape), alias.reshape(power.shape), luminance
    return table, float(power.sum())


def _filtered(image: np.ndarray) -> np.ndarray:
    """Means over texels (height, width) of what bilinear filtering shows there: 6 parts of 8 of a texel's own and one
    of each neighbour's, both ways. Without them 7 parts in 16 of a lone bright texel would be left to chance hits."""
    rows = np.pad(image, ((1, 1), (0, 0)), mode="edge")
    image = (rows[:-2] + 6.0 * rows[1:-1] + rows[2:]) / 8.0
    return (np.roll(image, 1, axis=1) + 6.0 * image + np.roll(image, -1, axis=1)) / 8.0


def alias_table(weights: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """For n choices in proportion to `weights` (n,): take i evenly, keep it with probability keep[i], else alias[i].

    Vose's pairing of those below the mean with those above it, swept in order (Hübschle-Schneider and Sanders 2019,
    4.1), all at once: small i is filled up by the large one whose running surplus first covers the running deficit
    before i; a large one is filled up by the next when its own surplus is used up.
    """
    share = weights * (len(weights) / weights.sum())
    keep, alias = np.ones(len(share)), np.arange(len(share))
    mean = min(1.0, share.max())  # rounding may leave even the largest below 1
    small, large = np.flatnonzero(share < mean), np.flatnonzero(share >= mean)
    deficit, surplus = np.cumsum(1.0 - share[small]), np.cumsum(share[large] - 1.0)
    before = np.concatenate([[0.0], deficit[:-1]]) if len(small) else deficit
    keep[small] = share[small]
    alias[small] = large[np.minimum(np.searchsorted(surplus, before, side="left"), len(large) - 1)]
    ends = np.searchsorted(deficit, surplus, side="right")
    used = (ends < len(small)) & (np.arange(len(large)) < len(large) - 1)
    over = deficit[ends[used]] - surplus[used]
    keep[large[used]] = 1.0 - over
    alias[large[used]] = large[np.flatnonzero(used) + 1]
    return np.clip(keep, 0.0, 1.0), alias
