"""Where what a pixel shows was in the picture before: from the visibility buffer's triangle numbers."""

from __future__ import annotations

import numpy as np

from .frame.views import View
from .gpu_scene.clusters import CLUSTER_TRIANGLES
from .gpu_scene.instances import Drawn
from .scene.scene import Scene


def motion_vectors(
    ids: np.ndarray, position: np.ndarray, drawn: Drawn, view: View, before: View, scene: Scene | None
) -> np.ndarray:  # fmt: skip
    """float32 (height, width, 2): pixels that what is seen has moved since the frame before, x right, y down.

    ids: uint32 (height, width), as the rasteriser wrote them.  position: float32 (height, width, 3), world space.
    view, before: the camera's view, and that of the frame before.  scene: as it was then, or None for the first frame.
    Where an instance or the triangles of its mesh are not the same as then, only the camera's motion counts. 0 where
    nothing is seen, and where the point was behind the camera.
    """
    motion = np.zeros((*ids.shape, 2), np.float32)
    seen = ids > 0
    if not seen.any():
        return motion
    here = position[seen].astype(np.float64)
    there = here.copy()
    numbers = ids[seen] - 1
    items = (numbers // CLUSTER_TRIANGLES).astype(np.int64)
    triangles = drawn.item_first[items] + numbers % CLUSTER_TRIANGLES
    owners = drawn.item_instance[items]
    for owner in np.unique(owners):
        of_owner = owners == owner
        earlier = _corners_before(drawn, int(owner), scene, triangles[of_owner]) if scene else None
        if earlier is not None:
            there[of_owner] = _carried(here[of_owner], _corners(drawn, int(owner), triangles[of_owner]), earlier)
    pixel, ahead = _pixels(before, there)
    moved = _pixels(view, here)[0] - pixel  # not the pixel's centre: what lies still has moved by exactly 0
    motion[seen] = np.where(ahead[:, None], moved, 0.0)
    return motion


def _corners(drawn: Drawn, owner: int, triangles: np.ndarray) -> np.ndarray:
    """World-space corners (n, 3 corners, 3) of triangles of a drawn instance, numbered as in its clusters."""
    slot = drawn.slots[owner]
    return _world(drawn.instances[owner].transform, slot.mesh.positions[slot.clusters.indices[triangles]])


def _corners_before(drawn: Drawn, owner: int, scene: Scene, triangles: np.ndarray) -> np.ndarray | None:
    """The same corners in the scene before; None where it has no such instance, or other triangles."""
    number, slot = int(drawn.numbers[owner]), drawn.slots[owner]
    if number >= len(scene.instances):
        return None
    instance = scene.instances[number]
    mesh = scene.meshes[instance.mesh]
    if mesh is slot.mesh and instance.transform is drawn.instances[owner].transform:
        return None
    if mesh.indices is not slot.mesh.indices and not np.array_equal(mesh.indices, slot.mesh.indices):
        return None
    return _world(instance.transform, mesh.positions[slot.clusters.indices[triangles]])


def _world(transform: np.ndarray, corners: np.ndarray) -> np.ndarray:
    return corners.astype(np.float64) @ transform[:3, :3].T + transform[:3, 3]


def _carried(points: np.ndarray, corners: np.ndarray, earlier: np.ndarray) -> np.ndarray:
    """Points (n, 3) of triangles at the same barycentric coordinates of the earlier triangles, (n, 3, 3) both."""
    e1, e2, offset = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0], points - corners[:, 0]
    n = np.cross(e1, e2)
    square = np.maximum(np.einsum("ij,ij->i", n, n), 1e-300)
    b1 = np.einsum("ij,ij->i", np.cross(offset, e2), n) / square
    b2 = np.einsum("ij,ij->i", np.cross(e1, offset), n) / square
    weights = np.stack([1.0 - b1 - b2, b1, b2], axis=1)
    return np.einsum("ij,ijk->ik", weights, earlier)


def _pixels(view: View, points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where the view shows points (n, 3): pixels (n, 2), and whether they lie before the camera."""
    clip = points @ view.view_projection[:, :3].T + view.view_projection[:, 3]
    ahead = clip[:, 3] > 0
    ndc = clip[:, :2] / np.where(ahead, clip[:, 3], 1.0)[:, None]
    size = np.array([view.width, view.height])
    return (ndc * [0.5, -0.5] + 0.5) * size, ahead
