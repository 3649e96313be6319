"""Motion vectors against closed forms: camera, instances and vertices that move."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gpu_tools import front_camera, scene_of, small_settings

from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import box, grid, quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import PointLight
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance
from octolux.simulator.camera import pixel_rays

WIDTH, HEIGHT = 40, 30
FOV = 0.9
FOCAL = HEIGHT / 2 / np.tan(FOV / 2)  # pixels
# A depth is a float32 of a quotient of float32 numbers: a few roundings of the distances, in pixels.
PIXELS = 32 * 2.0**-24 * WIDTH
WALL = quad([(-9, -9, 0), (9, -9, 0), (9, 9, 0), (-9, 9, 0)])
LIGHT = PointLight(position=(0, 0, 3), intensity=(1, 1, 1))


def camera_at(position, towards=(0.0, 0.0, -1.0), **rest) -> Camera:
    position = np.asarray(position, float)
    return Camera.look_at(position, position + towards, vertical_fov=FOV, **rest)


def renderer_of(device, scene, **rest) -> Renderer:
    return Renderer(scene, "none", size=(WIDTH, HEIGHT), device=device,
                    frame_settings=small_settings(sky_lights=0, emitter_lights=0), **rest)  # fmt: skip


def motion(renderer: Renderer, scene, camera=None) -> np.ndarray:
    renderer.scene = scene
    return renderer.render(camera).layers["motion"]


def pixels(camera: Camera, points: np.ndarray) -> np.ndarray:
    """Where a camera shows points (..., 3): x right, y down, pixels."""
    x, y, z = np.moveaxis((points - camera.position) @ camera.transform[:3, :3], -1, 0)
    if camera.orthographic_height is not None:
        scale = HEIGHT / camera.orthographic_height
        return np.stack([WIDTH / 2 + scale * x, HEIGHT / 2 - scale * y], axis=-1)
    return np.stack([WIDTH / 2 + FOCAL * x / -z, HEIGHT / 2 - FOCAL * y / -z], axis=-1)


def wall_with(camera: Camera):
    return scene_of([WALL], lights=[LIGHT], cameras=[camera])


@pytest.mark.parametrize("height", [None, 3.0], ids=["perspective", "orthographic"])
def test_a_camera_that_slides_along_a_wall(device, height):
    """By (a, b) at distance d: all moves by -a f / d to the right and b f / d down; orthographic by the scale."""
    before, after = (camera_at((x, y, 4.0), orthographic_height=height) for x, y in ((0.1, 0.2), (0.4, -0.1)))
    renderer = renderer_of(device, wall_with(before))
    motion(renderer, wall_with(before))
    found = motion(renderer, wall_with(after))
    scale = FOCAL / 4.0 if height is None else HEIGHT / height
    np.testing.assert_allclose(found, np.broadcast_to([-0.3 * scale, -0.3 * scale], found.shape), atol=PIXELS)


@pytest.mark.parametrize("height", [None, 3.0], ids=["perspective", "orthographic"])
def test_a_camera_that_turns_and_goes(device, height):
    """In each pixel the ray meets the wall at z = 0; where the camera before has seen that point says how it moved."""
    before = camera_at((0.2, 0.0, 4.0), (0.1, 0.05, -1.0), orthographic_height=height)
    after = camera_at((-0.1, 0.3, 3.5), (-0.1, 0.0, -1.0), orthographic_height=height)
    renderer = renderer_of(device, wall_with(before))
    motion(renderer, wall_with(before))
    found = motion(renderer, wall_with(after))
    origin, direction = pixel_rays(after, WIDTH, HEIGHT)
    points = origin - direction * (origin[..., 2:] / direction[..., 2:])
    expected = pixels(after, points) - pixels(before, points)
    assert np.ptp(expected[..., 0]) > 0.1 if height is None else np.abs(expected).max() > 1
    np.testing.assert_allclose(found, expected, atol=4 * PIXELS)


def test_a_camera_given_by_hand(device):
    """Cameras that are passed to `render`: motion is counted from the one of the frame before."""
    renderer = renderer_of(device, wall_with(camera_at((0, 0, 9))))
    assert not motion(renderer, renderer.scene, camera_at((0.0, 0.0, 4.0))).any()
    found = motion(renderer, renderer.scene, camera_at((0.4, 0.0, 4.0)))
    np.testing.assert_allclose(found[..., 0], -0.4 * FOCAL / 4.0, atol=PIXELS)
    assert not motion(renderer, renderer.scene, camera_at((0.4, 0.0, 4.0))).any()


def room() -> tuple:
    """A wall, and a block before it that moves."""
    block = box((-0.4, -0.4, 0.5), (0.4, 0.4, 1.0))
    scene = scene_of([WALL, block], lights=[LIGHT], cameras=[camera_at((0.0, 0.0, 4.0))])
    return scene, block


def placed(scene, transform: np.ndarray, **rest):
    return replace(scene, instances=[scene.instances[0], Instance(1, transform)], **rest)


def test_nothing_moves(device):
    """Exactly 0: in the first frame, and when nothing or only the light has changed."""
    scene, _ = room()
    renderer = renderer_of(device, scene)
    assert not motion(renderer, scene).any()
    assert not motion(renderer, replace(scene, instances=list(scene.instances), lights=[])).any()
    assert not motion(renderer, replace(scene, materials=[Material(base_color=(1, 0, 0))])).any()


def test_a_block_that_is_pushed(device):
    """Its front, at a distance of 3, moves by a known number of pixels; the wall behind stays."""
    scene, _ = room()
    renderer = renderer_of(device, scene)
    motion(renderer, scene)
    step = np.eye(4)
    step[:3, 3] = (0.2, -0.1, 0.0)
    picture_scene = placed(scene, step)
    found = motion(renderer, picture_scene)
    picture = renderer.render()
    front = (picture.layers["object_id"] == 2) & (np.abs(picture.layers["position"][..., 2] - 1.0) < 1e-4)
    assert front.sum() > 20
    expected = np.array([0.2, 0.1]) * FOCAL / 3.0
    np.testing.assert_allclose(found[front], np.tile(expected, (front.sum(), 1)), atol=4 * PIXELS)
    assert not found[picture.layers["object_id"] == 1].any()
    assert not picture.layers["motion"].any()  # it lies still again


def test_a_block_that_turns_and_comes_nearer(device):
    """Every point of it was where the inverse of its step leads, and is seen from a camera that moves, too."""
    scene, _ = room()
    c, s = np.cos(0.3), np.sin(0.3)
    turned = np.array([[c, 0, s, 0.1], [0, 1, 0, 0.2], [-s, 0, c, 0.3], [0, 0, 0, 1]])
    after = camera_at((0.2, 0.1, 4.2))
    renderer = renderer_of(device, scene)
    motion(renderer, scene)
    found = motion(renderer, placed(scene, turned, cameras=[after]))
    picture = renderer.render()
    block = picture.layers["object_id"] == 2
    points = picture.layers["position"][block].astype(np.float64)
    earlier = (points - turned[:3, 3]) @ turned[:3, :3]
    expected = pixels(after, points) - pixels(scene.cameras[0], earlier)
    assert block.sum() > 50 and np.ptp(expected) > 1
    np.testing.assert_allclose(found[block], expected, atol=4 * PIXELS)


def test_a_mesh_that_bends(device):
    """Positions replaced, the same triangles: barycentric coordinates say where each point was. All move alike here,
    by a wave that is even across the grid's triangles, which lie in a plane."""
    at = np.linspace(-1, 1, 9)
    points = np.stack([*np.meshgrid(at, at), np.zeros((9, 9))], axis=-1)
    before = grid(points, points[..., :2])
    # Affine in x and y: so it is in every triangle.
    lean = np.array([[1.0, 0.2, 0.1], [-0.1, 0.9, 0.3], [0.0, 0.0, 1.0]])
    bent = replace(before, positions=(before.positions @ lean.astype(np.float32)).astype(np.float32))
    camera = camera_at((0.0, 0.0, 3.0))
    scene = scene_of([before], [Material(double_sided=True)], lights=[LIGHT], cameras=[camera])
    renderer = renderer_of(device, scene)
    motion(renderer, scene)
    found = motion(renderer, replace(scene, meshes=[bent]))
    picture = renderer.render()
    points = picture.layers["position"][picture.mask].astype(np.float64)
    earlier = points @ np.linalg.inv(lean)
    expected = pixels(camera, points) - pixels(camera, earlier)
    assert picture.mask.sum() > 200 and np.ptp(expected) > 2
    # Vertices are float32 after the bend, too.
    np.testing.assert_allclose(found[picture.mask], expected, atol=8 * PIXELS)


@pytest.mark.parametrize("change", ["a new instance", "other triangles", "another mesh"])
def test_what_was_not_there_moves_with_the_camera(device, change):
    scene, block = room()
    first = {"a new instance": replace(scene, instances=scene.instances[:1]), "other triangles": scene,
             "another mesh": scene}[change]  # fmt: skip
    renderer = renderer_of(device, first)
    motion(renderer, first)
    after = camera_at((0.3, 0.0, 4.0))
    meshes = {"other triangles": [WALL, replace(block, indices=block.indices[::-1].copy())],
              "another mesh": [WALL, box((-0.3, -0.3, 0.5), (0.3, 0.3, 1.2))]}.get(change, scene.meshes)  # fmt: skip
    step = np.eye(4)
    step[0, 3] = 0.25
    if change == "another mesh":  # the same triangles at other places count as a bend, unless their number differs
        meshes[1] = replace(meshes[1], indices=meshes[1].indices[:-1].copy())
    found = motion(renderer, placed(scene, step, meshes=meshes, cameras=[after]))
    picture = renderer.render()
    points = picture.layers["position"].astype(np.float64)
    expected = pixels(after, points) - pixels(first.cameras[0], points)
    np.testing.assert_allclose(found[picture.mask], expected[picture.mask], atol=4 * PIXELS)


def test_what_was_behind_the_camera(device):
    """It has no place in the picture before: 0."""
    renderer = renderer_of(device, wall_with(camera_at((0, 0, -5.0))))
    motion(renderer, renderer.scene)
    assert not motion(renderer, wall_with(front_camera(4.0))).any()
