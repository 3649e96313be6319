"""The G-buffer's geometry against NumPy rays and triangles (Moeller and Trumbore 1997) in float64."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest
from gpu_tools import front_camera, random_directions, scene_of

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.simulator.camera import pack_normals, pixel_rays, unpack_normals

SIZE = (90, 61)  # rows of copies are not multiples of 256 bytes
# A packed normal turns by at most sqrt(18) / 2 / 32767 (simulator/camera.py), the geometric one, in 4095 steps from -1
# to 1, by sqrt(18) / 4095. Vertex normals are packed too: the reference takes them as they are after that.
NORMAL_ERROR, GEOMETRIC_ERROR = 6.5e-5, 1.04e-3


def soup(rng, count: int, material: int = 0) -> Mesh:
    """`count` random triangles around the origin, each with a normal of its own at every corner."""
    corners = rng.uniform(-0.7, 0.7, (count, 1, 3)) + rng.uniform(-0.6, 0.6, (count, 3, 3))
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])[:, None]
    normals = face / np.linalg.norm(face, axis=-1, keepdims=True) + 0.4 * rng.normal(size=(count, 3, 3))
    normals = (normals / np.linalg.norm(normals, axis=-1, keepdims=True)).reshape(-1, 3)
    tangents = np.concatenate([random_directions(rng, 3 * count), np.ones((3 * count, 1))], axis=1)
    indices = np.arange(3 * count, dtype=np.uint32).reshape(-1, 3)
    arrays = {"positions": corners.reshape(-1, 3), "normals": normals, "tangents": tangents}
    arrays["uvs"] = rng.uniform(0, 1, (3 * count, 2))
    return Mesh(indices=indices, material=material, **{k: v.astype(np.float32) for k, v in arrays.items()})


def placements() -> list[np.ndarray]:
    """Object to world: unmoved, mirrored, stretched and sheared, mirrored and stretched."""
    rng = np.random.default_rng(5)
    moves = [np.eye(4) for _ in range(4)]
    moves[1][:3, :3] = np.diag([-1.0, 1.0, 1.0])
    moves[2][:3, :3] = np.diag([0.5, 1.3, 0.9]) + 0.3 * rng.normal(size=(3, 3))
    moves[3][:3, :3] = np.diag([1.2, -0.6, 1.0]) + 0.2 * rng.normal(size=(3, 3))
    for i, move in enumerate(moves):
        move[:3, 3] = rng.uniform(-0.3, 0.3, 3) + np.array([0.2 * i - 0.3, 0, 0])
    assert [np.sign(np.linalg.det(m[:3, :3])) for m in moves][1::2] == [-1, -1]
    return moves


def trace(scene, camera, size) -> SimpleNamespace:
    """The nearest triangle of every pixel: t along the camera's axis, instance, barycentrics, margin to the runner-up.

    Triangles of single-sided materials count from their front only.
    """
    origins, directions = (a.reshape(-1, 3) for a in pixel_rays(camera, *size))
    directions = directions / (directions @ camera.forward)[:, None]
    parts = []
    for number, instance in enumerate(scene.instances):
        mesh, m = scene.meshes[instance.mesh], instance.transform
        world = mesh.positions.astype(np.float64) @ m[:3, :3].T + m[:3, 3]
        two_sided = scene.materials[mesh.material].double_sided
        normals = unpack_normals(pack_normals(mesh.normals)) @ np.linalg.inv(m[:3, :3])
        side = np.sign(np.linalg.det(m[:3, :3]))
        parts += [(number, two_sided, side, world[t], normals[t]) for t in mesh.indices]
    hits = [_meet(part, origins, directions, camera.near) for part in parts]
    t = np.stack([h[0] for h in hits])
    order = np.minimum(np.sort(t, axis=0)[:2], 1e9)
    first = t.argmin(axis=0)
    pick = (first, np.arange(len(first)))
    shape = (size[1], size[0])
    edge = np.stack([h[1] for h in hits]).reshape(-1, *shape)
    slope = np.hypot(*np.gradient(edge, axis=(1, 2)))
    return SimpleNamespace(
        depth=np.where((order[0] < 1e9), order[0], 0).reshape(shape),
        gap=((order[1] - order[0] > 1e-4) | (order[0] == 1e9)).reshape(shape),
        # A centre that is clearly, by 1/50 pixel, within or outside every triangle: rasterisers snap to 1/256.
        clear=(np.abs(edge) > 0.02 * slope).all(axis=0),
        instance=np.where((order[0] < 1e9), np.array([p[0] for p in parts])[first] + 1, 0).reshape(shape),
        normal=np.stack([h[2] for h in hits])[pick].reshape(*shape, 3),
        geometric=np.stack([h[3] for h in hits])[pick].reshape(*shape, 3),
    )


def _meet(part, origins, directions, near):
    """t, signed distance to the edges in barycentric units, shading and geometric normal towards the ray's origin."""
    _, two_sided, side, (a, b, c), normals = part
    e1, e2 = b - a, c - a
    p = np.cross(directions, e2)
    determinant = p @ e1
    s = origins - a
    with np.errstate(divide="ignore", invalid="ignore"):
        u = np.sum(p * s, axis=1) / determinant
        q = np.cross(s, e1)
        v = np.sum(q * directions, axis=1) / determinant
        t = q @ e2 / determinant
    edge = np.minimum(np.minimum(u, v), 1 - u - v)
    front = side * determinant > 0
    seen = (edge >= 0) & (t > near) & (two_sided | front)
    weights = np.stack([1 - u - v, u, v], axis=1)
    normal = weights @ normals
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    face = side * np.cross(e1, e2) / np.linalg.norm(np.cross(e1, e2))
    flip = np.where(directions @ face > 0, -1.0, 1.0)[:, None]
    return np.where(seen, t, np.inf), edge, flip * normal, flip * face


CAMERAS = [
    Camera.look_at((0.5, 0.8, 2.2), (0.0, 0.0, 0.0), vertical_fov=0.9),
    Camera.look_at((-1.5, -0.6, -1.8), (0.1, 0.0, 0.1), up=(0.2, 1.0, 0.0), vertical_fov=1.2),
    Camera.look_at((0.3, 0.4, 3.0), (0.0, 0.0, 0.0), orthographic_height=2.2),
    Camera.look_at((0.02, 0.1, 0.05), (0.5, 0.0, -1.0), orthographic_height=1.5),  # among the triangles
]


@pytest.fixture(scope="module")
def triangles(device):
    rng = np.random.default_rng(11)
    materials = [Material(double_sided=True), Material(double_sided=False)]
    moves = placements()
    scene = scene_of([soup(rng, 9), soup(rng, 9, material=1)], materials)
    scene.instances = [Instance(i % 2, m) for i, m in enumerate(moves)] + [Instance(1, moves[1] @ moves[2])]
    return Renderer(scene, "none", size=SIZE, device=device)


@pytest.mark.parametrize("camera", CAMERAS, ids=["front", "behind", "orthographic", "inside"])
def test_random_triangles(triangles, camera):
    picture = triangles.render(camera)
    expected = trace(triangles.scene, camera, SIZE)
    layers, sure = picture.layers, expected.clear & expected.gap
    assert sure.mean() > 0.7 and 0.1 < (expected.instance[sure] > 0).mean() < 0.97
    assert np.array_equal(layers["object_id"][sure], expected.instance[sure])
    assert np.array_equal(picture.mask[sure], expected.instance[sure] > 0)
    hit = sure & (expected.instance > 0)
    # Depth is a ratio of triple products in float32; where a triangle is seen edge-on they cancel.
    facing = np.abs(np.sum(expected.geometric * view_directions(camera), axis=-1))[hit]
    assert np.all(np.abs(layers["depth"] - expected.depth)[hit] <= 2e-6 * (1 + expected.depth[hit]) / facing)
    assert angles(picture.geometric_normal, expected.geometric)[hit].max() <= GEOMETRIC_ERROR
    # Barycentric coordinates err by some 1e-6 / facing, and turn the normal by a few times as much.
    assert np.all(angles(layers["normal"], expected.normal)[hit] <= NORMAL_ERROR + 5e-6 / facing)


def view_directions(camera: Camera) -> np.ndarray:
    return pixel_rays(camera, *SIZE)[1]


def angles(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.linalg.norm(np.cross(a, b), axis=-1) + 2.0 * (np.sum(a * b, axis=-1) < 0)


def test_positions_lie_on_the_surface(device):
    """A plane askew: its points fulfil its equation."""
    corners = [(-2, -1, 0.5), (2, -1, -0.7), (2, 1, -0.9), (-2, 1, 0.3)]
    picture = Renderer(scene_of([quad(corners)]), "none", size=SIZE, device=device).render(front_camera())
    a, b, c = (np.array(corners[i], float) for i in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal)
    distance = (picture.layers["position"][picture.mask] - a) @ normal
    assert picture.mask.mean() > 0.5
    assert np.abs(distance).max() <= 2e-6 * 4  # float32 positions of some 4 m


def test_orthographic_scene_far_from_the_world_s_origin(device):
    """What lies before the camera is seen wherever the two are."""
    away = np.array([0.0, 0.0, -500.0])
    wall = quad(np.array([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]) + away)
    camera = Camera.look_at((0.0, 0.0, 2.0), (0.0, 0.0, 0.0), orthographic_height=1.0)
    picture = Renderer(scene_of([wall]), "none", size=(8, 8), device=device).render(camera)
    np.testing.assert_allclose(picture.layers["depth"], 502.0, rtol=1e-5)
