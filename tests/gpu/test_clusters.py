"""Clusters of triangles and their culling, against brute force."""

from __future__ import annotations

import numpy as np
import pytest
from gpu_tools import random_directions

from octolux.frame.views import camera_view, directional_views, point_views, spot_views
from octolux.gpu_scene.clusters import CLUSTER_TRIANGLES, cluster, visible, world_boxes
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.meshes import Mesh


def random_mesh(triangles: int, seed: int = 0) -> Mesh:
    rng = np.random.default_rng(seed)
    vertices = max(3, triangles)
    zeros = {"normals": (vertices, 3), "uvs": (vertices, 2), "tangents": (vertices, 4)}
    return Mesh(
        positions=(rng.normal(size=(vertices, 3)) * [5.0, 0.1, 1.0] + [100, 0, 0]).astype(np.float32),
        indices=rng.integers(0, vertices, (triangles, 3)).astype(np.uint32),
        **{name: np.zeros(shape, np.float32) for name, shape in zeros.items()},
    )


@pytest.mark.parametrize("triangles", [1, 127, 128, 129, 1000])
def test_every_triangle_once(triangles):
    mesh = random_mesh(triangles)
    made = cluster(mesh)
    before, after = (np.sort(m.indices.view("u4,u4,u4").ravel()) for m in (mesh, made))
    assert np.array_equal(before, after)
    assert made.count.sum() == triangles and made.count.max() <= CLUSTER_TRIANGLES
    assert np.array_equal(made.first, np.cumsum(made.count) - made.count)


def test_boxes_hold_their_triangles():
    mesh = random_mesh(500)
    made = cluster(mesh)
    for first, count, low, high in zip(made.first, made.count, made.low, made.high, strict=True):
        corners = mesh.positions[made.indices[first : first + count]].reshape(-1, 3)
        assert np.array_equal(corners.min(axis=0), low) and np.array_equal(corners.max(axis=0), high)


def test_flat_and_degenerate_meshes():
    mesh = random_mesh(300)
    flat = Mesh(positions=mesh.positions * np.float32([1, 0, 0]), normals=mesh.normals, uvs=mesh.uvs,
                tangents=mesh.tangents, indices=mesh.indices)  # fmt: skip
    assert cluster(flat).count.sum() == 300
    point = Mesh(positions=mesh.positions * np.float32(0), normals=mesh.normals, uvs=mesh.uvs,
                 tangents=mesh.tangents, indices=mesh.indices)  # fmt: skip
    assert cluster(point).count.sum() == 300


def test_clusters_lie_close_together():
    """Small triangles spread along a line: the clusters' boxes hardly overlap."""
    rng = np.random.default_rng(1)
    places = rng.uniform(0, 1000, (1280, 1, 3)) * [1, 0.001, 0.001] + rng.uniform(0, 0.1, (1280, 3, 3))
    base = random_mesh(3840)
    mesh = Mesh(positions=places.reshape(-1, 3).astype(np.float32), normals=base.normals, uvs=base.uvs,
                tangents=base.tangents, indices=np.arange(3840, dtype=np.uint32).reshape(-1, 3))  # fmt: skip
    made = cluster(mesh)
    assert (made.high - made.low)[:, 0].sum() < 1.1 * 1000


def test_world_boxes_hold_what_is_moved():
    rng = np.random.default_rng(2)
    low = rng.normal(size=(50, 3))
    high = low + rng.uniform(0, 2, (50, 3))
    transform = np.eye(4)
    transform[:3] = rng.normal(size=(3, 4))
    low_world, high_world = world_boxes(low, high, transform)
    for corner in np.ndindex(2, 2, 2):
        moved = np.where(corner, high, low) @ transform[:3, :3].T + transform[:3, 3]
        assert np.all(moved >= low_world - 1e-12) and np.all(moved <= high_world + 1e-12)


BOUNDS = (np.full(3, -4.0), np.full(3, 4.0))


def views() -> list:
    rng = np.random.default_rng(3)
    made = []
    for _ in range(6):
        position, target = rng.uniform(-4, 4, 3), rng.uniform(-1, 1, 3)
        fov, height = rng.uniform(0.2, 2.5), rng.uniform(0.5, 4)
        made.append(camera_view(Camera.look_at(position, target, vertical_fov=fov, near=0.1), 16, 9, 20.0))
        made.append(camera_view(Camera.look_at(position, target, orthographic_height=height), 9, 16, 20.0))
        direction = tuple(random_directions(rng, 1)[0])
        place, angle = tuple(position), rng.uniform(0.1, 1.4)
        spot = SpotLight(position=place, direction=direction, intensity=(1, 1, 1), outer_angle=angle)
        made += spot_views(spot, BOUNDS, 64)
        made += directional_views(DirectionalLight(direction=direction, illuminance=(1, 1, 1)), BOUNDS, 64)
        made += point_views(PointLight(position=place, intensity=(1, 1, 1)), BOUNDS, 64)
    return made


def seen_points(view, points: np.ndarray) -> np.ndarray:
    """Which points the view shows, from its axes alone."""
    relative = points - view.position
    depth = relative @ view.forward
    reach = depth if view.perspective else 1.0
    across = np.abs(relative @ view.right) <= reach * (view.right @ view.right)
    upward = np.abs(relative @ view.up) <= reach * (view.up @ view.up)
    return across & upward & (depth >= view.near) & (view.perspective | (depth <= view.far))


@pytest.mark.parametrize("number", range(0, 60, 7))
def test_no_box_with_a_visible_point_is_culled(number):
    view = views()[number]
    rng = np.random.default_rng(number)
    low = rng.uniform(-4, 3.5, (400, 3))
    high = low + rng.uniform(0, 1, (400, 3)) ** 2
    inside = rng.uniform(0, 1, (60, 400, 3)) * (high - low) + low
    shown = seen_points(view, inside.reshape(-1, 3)).reshape(60, 400).any(axis=0)
    kept = visible(low, high, view.view_projection)
    assert shown.any() and not (shown & ~kept).any()
    # What lies wholly behind is culled: all corners are.
    corners = np.stack([np.where(c, high, low) for c in np.ndindex(2, 2, 2)])
    behind = ((corners - view.position) @ view.forward < min(view.near, 0.0) - 1e-9).all(axis=0)
    assert not (behind & kept).any()


def test_culling_culls():
    """Of boxes all around a camera most are behind it or beside its picture."""
    view = camera_view(Camera.look_at((0, 0, 0), (0, 0, -1), vertical_fov=0.5), 16, 16, 100.0)
    centre = 10 * random_directions(np.random.default_rng(4), 2000)
    kept = visible(centre - 0.1, centre + 0.1, view.view_projection)
    # The picture's pyramid has 4 asin(sin^2(0.25)) = 0.245 sr of 4 pi, and the boxes are 0.02 wide at that distance.
    assert 0.019 < kept.mean() < 0.03
