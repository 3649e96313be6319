"""Moving, joining and thinning out scenes that move."""

from __future__ import annotations

import numpy as np
import pytest
from figures import POSITIONS, QUARTER_X, add_animation, add_strip

from octolux.scene.builtin.shapes import box
from octolux.scene.compose import combined, flat_shaded, placed, without
from octolux.scene.gltf.loader import load_gltf
from octolux.scene.meshes import Instance
from octolux.scene.motion.tracks import Track
from octolux.scene.scene import Scene

ATOL = 1e-5  # a few roundings of float32 numbers of about 10
MOVED = np.array([[0, 0, 2, 5], [0, 2, 0, -1], [-2, 0, 0, 3], [0, 0, 0, 1]], np.float64)
SHEARED = np.array([[1, 0.5, 0, 0], [0, 3, 0, 1], [0, 0, 1, 0], [0, 0, 0, 1]], np.float64)
MIRRORED = np.diag([-1.0, 1.0, 2.0, 1.0])


@pytest.fixture
def scene(gltf) -> Scene:
    """A skinned and morphed strip, a rigid one, a light and a camera on the joint that turns."""
    primitive = add_strip(gltf)
    primitive["targets"] = [{"POSITION": gltf.add(np.tile(np.array([0, 0, 1], np.float32), (6, 1)))}]
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "spot", "spot": {}}]}}
    gltf.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    gltf.json["nodes"] += [{"mesh": 0, "name": "rigid", "translation": [0, 0, -4]},
                           {"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]  # fmt: skip
    gltf.json["nodes"][2]["children"] = [4]
    gltf.json["scenes"] = [{"nodes": [0, 1, 3]}]
    add_animation(gltf, 2, "rotation", [0, 1, 2], [(0, 0, 0, 1), QUARTER_X, QUARTER_X])
    gltf.json["animations"][0]["channels"] += [{"sampler": 1, "target": {"node": 3, "path": "translation"}},
                                               {"sampler": 2, "target": {"node": 0, "path": "weights"}}]  # fmt: skip
    times = gltf.add(np.array([0, 2], np.float32))
    gltf.json["animations"][0]["samplers"] += [
        {"input": times, "output": gltf.add(np.array([[0, 0, -4], [2, 0, -4]], np.float32))},
        {"input": times, "output": gltf.add(np.array([0, 1], np.float32))},
    ]
    result = load_gltf(gltf.write())
    result.tracks.append(
        Track(target="instance", name="rigid", property="rotation", times=np.zeros(1), values=np.array([QUARTER_X]))
    )
    return result


def world(scene: Scene) -> list[np.ndarray]:
    """The vertices of each instance, where they are."""
    return [scene.meshes[i.mesh].positions @ i.transform[:3, :3].T + i.transform[:3, 3] for i in scene.instances]


def put(matrix: np.ndarray, points) -> np.ndarray:
    return points @ matrix[:3, :3].T + matrix[:3, 3]


@pytest.mark.parametrize("time", [None, 0.5, 1.0])
@pytest.mark.parametrize("matrix", [MOVED, SHEARED, MIRRORED, MOVED @ MIRRORED])
def test_a_moved_scene_moves_as_the_scene_does_and_then_where_it_is_put(scene, matrix, time):
    before, after = (s if time is None else s.at(time) for s in (scene, placed(scene, matrix)))
    for points, moved in zip(world(before), world(after), strict=True):
        np.testing.assert_allclose(moved, put(matrix, points), atol=ATOL)
    (light,), (moved_light,) = before.lights, after.lights
    np.testing.assert_allclose(moved_light.position, put(matrix, light.position), atol=ATOL)
    along = matrix[:3, :3] @ light.direction
    np.testing.assert_allclose(np.cross(moved_light.direction, along), 0, atol=ATOL)
    assert np.dot(moved_light.direction, along) > 0
    (camera,), (moved_camera,) = before.cameras, after.cameras
    np.testing.assert_allclose(moved_camera.position, put(matrix, camera.position), atol=ATOL)
    assert np.dot(moved_camera.forward, matrix[:3, :3] @ camera.forward) > 0
    assert after.warnings == []


def test_moving_twice_is_moving_by_the_product(scene):
    twice, once = placed(placed(scene, MIRRORED), MOVED).at(1.0), placed(scene, MOVED @ MIRRORED).at(1.0)
    for points, others in zip(world(twice), world(once), strict=True):
        np.testing.assert_allclose(points, others, atol=ATOL)


def test_normals_of_a_moved_figure_stay_in_its_own_space(scene):
    (figure, _), (moved, _) = scene.at(1.0).meshes, placed(scene, MIRRORED).at(1.0).meshes
    np.testing.assert_allclose(moved.normals, figure.normals, atol=ATOL)
    np.testing.assert_allclose(moved.tangents, figure.tangents, atol=ATOL)


def test_a_moved_scene_shares_its_meshes(scene):
    assert all(a is b for a, b in zip(placed(scene, MOVED).meshes, scene.meshes, strict=True))


def test_objects_that_turn_about_the_origin_turn_about_the_models_own_when_it_is_moved():
    turn = Track(target="instance", name="crate", property="rotation", times=np.zeros(1), values=np.array([QUARTER_X]))
    lone = Scene(meshes=[box((0, 0, 0), (1, 1, 1))], instances=[Instance(0, name="crate")], tracks=[turn])
    both = combined([lone, placed(lone, SHEARED)])
    first, second = world(both.at(0.0))
    np.testing.assert_allclose(second, put(SHEARED, first), atol=ATOL)


def test_objects_of_one_name_in_two_scenes_keep_apart_when_one_of_them_moves():
    crate = Scene(meshes=[box((0, 0, 0), (1, 1, 1))], instances=[Instance(0, name="crate")])
    slide = Track(target="instance", name="crate", property="translation", times=np.zeros(1), values=np.eye(1, 3))
    moving = Scene(**{**vars(crate), "tracks": [slide]})
    for scenes, shifts in (((crate, moving, moving), (0, 1, 1)), ((moving, crate), (1, 0)), ((crate, crate), (0, 0))):
        both = combined(scenes)
        assert [i.transform[0, 3] for i in both.at(0.0).instances] == list(shifts)
    assert [i.name for i in combined([crate, moving, moving]).instances] == ["crate", "crate 2", "crate 3"]
    assert [i.name for i in combined([crate, crate]).instances] == ["crate", "crate"]


def test_scenes_in_one_move_as_each_alone(scene):
    both = combined([scene, placed(scene, MOVED), scene])
    both.tracks = [track for track in both.tracks if track.target == "node"]
    alone = Scene(**{**vars(scene), "tracks": [track for track in scene.tracks if track.target == "node"]})
    expected = world(alone.at(0.7))
    found = world(both.at(0.7))
    for points, others in zip(found, [*expected, *(put(MOVED, p) for p in expected), *expected], strict=True):
        np.testing.assert_allclose(points, others, atol=ATOL)
    assert [light.node for light in both.lights] == [3, 9, 14]
    np.testing.assert_allclose(both.at(0.7).lights[2].direction, alone.at(0.7).lights[0].direction, atol=ATOL)


def test_a_figure_that_is_shaded_flat_bends_alike(scene):
    flat = flat_shaded(scene)
    figure = flat.meshes[0]
    assert len(figure.positions) == len(figure.deformable.positions) == 12
    corners = scene.meshes[0].indices.ravel()
    for time in (0.0, 1.0):
        np.testing.assert_allclose(world(flat.at(time))[0], world(scene.at(time))[0][corners], atol=ATOL)
    assert flat.at(1.0).meshes[0].normals.shape == (12, 3)
    np.testing.assert_allclose(np.linalg.norm(flat.at(1.0).meshes[0].normals, axis=1), 1, atol=ATOL)


def test_what_is_left_of_a_scene_still_moves(scene):
    left = without(scene, ["rigid"])
    assert len(left.meshes) == 1
    np.testing.assert_allclose(world(left.at(1.0))[0], world(scene.at(1.0))[0], atol=ATOL)
    assert world(left.at(1.0))[0][4][2] == pytest.approx(1.0, abs=ATOL)
    np.testing.assert_allclose(world(left)[0], POSITIONS, atol=ATOL)
