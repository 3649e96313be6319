"""Tracks, and scenes at a time."""

from __future__ import annotations

from math import radians, sqrt

import numpy as np
import pytest

from octolux.scene.builtin.shapes import box
from octolux.scene.cameras import Camera
from octolux.scene.lights import AreaLight, DirectionalLight, PointLight
from octolux.scene.meshes import Instance
from octolux.scene.motion.moved import rotation_matrix
from octolux.scene.motion.tracks import Track, slerp
from octolux.scene.scene import Scene

QUARTER_Y = (0.0, sqrt(0.5), 0.0, sqrt(0.5))
QUAD = ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0))


def track(target, name, key, times, values) -> Track:
    return Track(target=target, name=name, property=key, times=np.array(times, dtype=np.float64),
                 values=np.array(values, dtype=np.float64))


@pytest.fixture
def scene() -> Scene:
    transform = np.eye(4)
    transform[:3, 3] = (1.0, 0.0, 0.0)
    return Scene(
        meshes=[box((0, 0, 0), (1, 1, 1))],
        instances=[Instance(0, transform, name="crate"), Instance(0, name="other")],
        lights=[
            PointLight(position=(0.0, 2.0, 0.0), intensity=(1.0, 1.0, 1.0), name="lamp"),
            DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(9.0, 9.0, 9.0), name="sun"),
            AreaLight(corners=QUAD, radiance=(3.0, 3.0, 3.0), name="panel"),
        ],
        cameras=[Camera.look_at((0.0, 1.0, 5.0), (0.0, 1.0, 0.0), name="eye", vertical_fov=radians(30.0))],
    )


@pytest.mark.parametrize(("time", "expected"), [(-5.0, 1.0), (1.0, 1.0), (1.5, 2.0), (2.0, 3.0), (3.0, 0.0), (9, -3)])
def test_tracks_are_linear_and_held_at_the_ends(time, expected):
    t = track("light", "lamp", "position", [1.0, 2.0, 4.0], [[1, 0, 0], [3, 0, 0], [-3, 0, 0]])
    np.testing.assert_allclose(t.at(time), [expected, 0.0, 0.0], atol=1e-15)


def test_a_track_of_one_key_is_constant():
    t = track("light", "lamp", "position", [2.0], [[1, 2, 3]])
    assert [t.at(time).tolist() for time in (0.0, 2.0, 5.0)] == [[1.0, 2.0, 3.0]] * 3


def test_rotation_goes_round_at_constant_speed():
    t = track("instance", "crate", "rotation", [0.0, 1.0], [[0, 0, 0, 1], QUARTER_Y])
    turned = rotation_matrix(t.at(1.0 / 3.0)) @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(turned, [np.sin(radians(30)), 0.0, np.cos(radians(30))], atol=1e-12)


def test_slerp_takes_the_shorter_way():
    halfway = slerp(np.array([0.0, 0.0, 0.0, 1.0]), -np.array(QUARTER_Y), 0.5)
    turned = rotation_matrix(halfway) @ [0.0, 0.0, 1.0]
    np.testing.assert_allclose(turned, [sqrt(0.5), 0.0, sqrt(0.5)], atol=1e-12)


def test_slerp_between_equal_rotations_stays():
    np.testing.assert_allclose(slerp(np.array(QUARTER_Y), np.array(QUARTER_Y), 0.7), QUARTER_Y, atol=1e-15)


@pytest.mark.parametrize(("name", "key"), [("lamp", "position"), ("lamp", "intensity"), ("sun", "direction"),
                                           ("sun", "illuminance"), ("panel", "radiance")])  # fmt: skip
def test_lights_move_and_change(scene, name, key):
    scene.tracks = [track("light", name, key, [0.0, 2.0], [[1, 2, 3], [3, 4, 5]])]
    after = {light.name: light for light in scene.at(1.0).lights}
    before = {light.name: light for light in scene.lights}
    assert getattr(after[name], key) == pytest.approx((2.0, 3.0, 4.0))
    assert all(after[other] is before[other] for other in after if other != name)


def test_a_camera_that_only_moves_keeps_its_orientation(scene):
    scene.tracks = [track("camera", "eye", "position", [0.0, 2.0], [[0, 1, 5], [4, 1, 5]])]
    (camera,) = scene.at(1.0).cameras
    np.testing.assert_allclose(camera.position, [2.0, 1.0, 5.0])
    np.testing.assert_allclose(camera.forward, [0.0, 0.0, -1.0], atol=1e-12)
    assert camera.vertical_fov == scene.cameras[0].vertical_fov


def test_a_camera_with_both_tracks_aims_from_where_it_is_and_stays_upright(scene):
    scene.tracks = [track("camera", "eye", "position", [0.0], [[3, 1, 0]]),
                    track("camera", "eye", "look_at", [0.0], [[0, 5, 0]])]
    (camera,) = scene.at(0.0).cameras
    np.testing.assert_allclose(camera.position, [3.0, 1.0, 0.0])
    np.testing.assert_allclose(camera.forward, [-0.6, 0.8, 0.0], atol=1e-12)
    np.testing.assert_allclose(camera.transform[:3, 0], [0.0, 0.0, -1.0], atol=1e-12)


def test_a_camera_may_look_straight_down(scene):
    scene.tracks = [track("camera", "eye", "position", [0.0], [[0, 9, 0]]),
                    track("camera", "eye", "look_at", [0.0], [[0, 0, 0]])]
    scene.cameras = [Camera.look_at((0, 9, 0), (0, 0, 0), (0, 0, -1), name="eye")]
    (camera,) = scene.at(0.0).cameras
    np.testing.assert_allclose(camera.forward, [0.0, -1.0, 0.0], atol=1e-12)
    np.testing.assert_allclose(camera.transform[:3, 1], [0.0, 0.0, -1.0], atol=1e-12)


def test_instances_are_scaled_turned_and_moved_in_the_world_after_their_own_transform(scene):
    scene.tracks = [track("instance", "crate", "scale", [0.0], [[2, 3, 4]]),
                    track("instance", "crate", "rotation", [0.0], [QUARTER_Y]),
                    track("instance", "crate", "translation", [0.0], [[10, 20, 30]])]
    crate, other = scene.at(0.0).instances
    # Its origin is at x = 1: scaled to x = 2, turned a quarter about y to z = -2, then moved.
    np.testing.assert_allclose(crate.transform @ [0, 0, 0, 1], [10.0, 20.0, 28.0, 1.0], atol=1e-12)
    np.testing.assert_allclose(crate.transform @ [0, 1, 0, 0], [0.0, 3.0, 0.0, 0.0], atol=1e-12)
    assert other is scene.instances[1]


def test_a_scene_at_a_time_shares_what_does_not_move_and_has_no_tracks_left(scene):
    scene.tracks = [track("instance", "crate", "translation", [0.0], [[1, 0, 0]])]
    later = scene.at(3.0)
    assert later.meshes is scene.meshes
    assert later.materials is scene.materials
    assert later.tracks == []
    assert len(scene.tracks) == 1
    np.testing.assert_array_equal(scene.instances[0].transform[:3, 3], [1.0, 0.0, 0.0])


def test_tracks_of_objects_that_are_gone_do_nothing(scene):
    scene.tracks = [track("light", "lamp", "position", [0.0], [[5, 5, 5]])]
    del scene.lights[0]
    assert scene.at(0.0).lights == scene.lights
