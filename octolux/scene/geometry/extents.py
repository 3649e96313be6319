"""Whether a scene has a size that can be computed with."""

from __future__ import annotations

import itertools
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..scene import Scene

# Squared areas of triangles, the highest power of lengths that is taken, stay below the 3.4e38 of float32 up to
# 4e9 m; what is done in float64 alone up to 1e77. A light year is 9.5e15 m: beyond this a unit is wrong.
MOST_METRES = 1e15


def check_extent(scene: Scene, source: str | Path) -> None:
    """Raises SceneError when an instance reaches further than MOST_METRES from the origin."""
    boxes: dict[int, np.ndarray] = {}
    for instance in scene.instances:
        if instance.mesh not in boxes:
            boxes[instance.mesh] = _corners(scene.meshes[instance.mesh].positions)
        with np.errstate(over="ignore", invalid="ignore"):
            world = boxes[instance.mesh] @ instance.transform[:3, :3].T + instance.transform[:3, 3]
        if not (np.abs(world) <= MOST_METRES).all():
            place = f"object '{instance.name}'" if instance.name else ""
            problem = f"reaches further than {MOST_METRES:g} m from the origin"
            raise SceneError(source, place, problem, "check its unit, scale and transforms")


def _corners(positions: np.ndarray) -> np.ndarray:
    """float64 (8, 3), or (0, 3) without positions."""
    if not len(positions):
        return np.zeros((0, 3))
    sides = zip(positions.min(axis=0).astype(np.float64), positions.max(axis=0).astype(np.float64), strict=True)
    return np.array(list(itertools.product(*sides)))
