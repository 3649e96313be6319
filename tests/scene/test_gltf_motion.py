"""Skins, morph targets, vertex colours, nodes and animations of glTF files."""

from __future__ import annotations

from math import cos, pi, sin, sqrt

import numpy as np
import pytest
from figures import BENT, BENT_NORMALS, POSITIONS, QUARTER_X, add_animation, add_strip

from octolux.scene.errors import OctoluxError
from octolux.scene.gltf.loader import load_gltf

ATOL = 1e-6  # a few roundings of float32 numbers of about 1
HALFWAY_X = (sin(pi / 8), 0.0, 0.0, cos(pi / 8))


@pytest.mark.covers("glTF nodes")
def test_nodes_come_with_parents_before_children_and_instances_name_them(gltf):
    gltf.triangle()
    gltf.json["nodes"] = [{"mesh": 0, "name": "leaf", "translation": [1, 0, 0]}, {"name": "root", "children": [2]},
                          {"name": "arm", "children": [0], "scale": [2, 2, 2]}]  # fmt: skip
    gltf.json["scenes"] = [{"nodes": [1]}]
    scene = load_gltf(gltf.write())
    assert [(node.name, node.parent) for node in scene.nodes] == [("root", None), ("arm", 0), ("leaf", 1)]
    assert scene.instances[0].node == 2
    np.testing.assert_allclose(scene.instances[0].transform[:3, 3], (2, 0, 0))


@pytest.mark.covers("glTF vertex colours")
@pytest.mark.parametrize("dtype", [np.float32, np.uint8, np.uint16])
@pytest.mark.parametrize("width", [3, 4])
def test_vertex_colours(gltf, dtype, width):
    gltf.triangle()
    one = 1 if dtype == np.float32 else np.iinfo(dtype).max
    colors = np.array([[1, 0, 0, 1], [0, 1, 0, 0], [0, 0, 1, 1]], dtype)[:, :width] * dtype(one)
    index = gltf.add(colors, normalized=dtype != np.float32)
    gltf.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = index
    mesh = load_gltf(gltf.write()).meshes[0]
    assert mesh.colors.dtype == np.float32
    np.testing.assert_array_equal(mesh.colors[:, :3], np.eye(3))
    np.testing.assert_array_equal(mesh.colors[:, 3], [1, 0, 1] if width == 4 else [1, 1, 1])


@pytest.mark.covers("glTF skins")
def test_a_skin_bends_by_a_quarter(gltf):
    add_strip(gltf)
    add_animation(gltf, 2, "rotation", [0, 1, 2], [(0, 0, 0, 1), QUARTER_X, QUARTER_X])
    scene = load_gltf(gltf.write())
    (instance,) = scene.instances
    np.testing.assert_array_equal(instance.transform, np.eye(4))
    np.testing.assert_allclose(scene.meshes[0].positions, POSITIONS, atol=ATOL)
    bent = scene.at(1.0)
    np.testing.assert_allclose(bent.meshes[0].positions, BENT, atol=ATOL)
    np.testing.assert_allclose(bent.meshes[0].normals, BENT_NORMALS, atol=ATOL)
    np.testing.assert_allclose(bent.meshes[0].tangents, [[1, 0, 0, 1]] * 6, atol=ATOL)
    np.testing.assert_allclose(bent.bounds(), [BENT.min(axis=0), BENT.max(axis=0)], atol=ATOL)
    assert bent.instances[0] is instance


@pytest.mark.covers("glTF skins")
def test_the_first_pose_is_that_of_the_nodes_and_not_that_of_the_file(gltf):
    add_strip(gltf)
    gltf.json["nodes"][2]["rotation"] = QUARTER_X
    scene = load_gltf(gltf.write())
    np.testing.assert_allclose(scene.meshes[0].positions, BENT, atol=ATOL)
    np.testing.assert_allclose(scene.meshes[0].deformable.positions, POSITIONS)


@pytest.mark.covers("glTF skins")
def test_joints_place_a_skinned_mesh_and_its_own_node_does_not(gltf):
    add_strip(gltf)
    gltf.json["nodes"][0] |= {"translation": [50, 0, 0], "scale": [9, 9, 9]}
    gltf.json["nodes"][1]["translation"] = [0, 0, 3]
    scene = load_gltf(gltf.write())
    np.testing.assert_array_equal(scene.instances[0].transform, np.eye(4))
    np.testing.assert_allclose(scene.meshes[0].positions, POSITIONS + np.array([0, 0, 3]), atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_a_mirrored_figure_shows_its_front(gltf):
    add_strip(gltf)
    gltf.json["nodes"] += [{"children": [0, 1], "scale": [-1, 1, 1], "translation": [5, 0, 0]}]
    gltf.json["scenes"] = [{"nodes": [3]}]
    scene = load_gltf(gltf.write())
    (instance,), (mesh,) = scene.instances, scene.meshes
    world = mesh.positions @ instance.transform[:3, :3].T + instance.transform[:3, 3]
    np.testing.assert_allclose(world, POSITIONS * [-1, 1, 1] + [5, 0, 0], atol=ATOL)
    assert np.linalg.det(instance.transform) == pytest.approx(-1)
    np.testing.assert_allclose(mesh.normals @ instance.transform[:3, :3], [[0, 0, 1]] * 6, atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_without_inverse_bind_matrices_vertices_are_in_the_joints_spaces(gltf):
    add_strip(gltf)
    del gltf.json["skins"][0]["inverseBindMatrices"]
    scene = load_gltf(gltf.write())
    raised = np.repeat([0, 0.5, 1], 2)  # the second joint stands at y = 1, and row 1 follows it by half
    np.testing.assert_allclose(scene.meshes[0].positions[:, 1], POSITIONS[:, 1] + raised, atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_more_sets_of_weights_that_do_not_sum_to_one(gltf):
    attributes = add_strip(gltf)["attributes"]
    joints, weights = np.zeros((6, 4), np.uint16), np.zeros((6, 4), np.uint8)
    joints[:, 1], weights[:, 1] = 1, 255  # the second joint again, as much as all weights so far
    attributes["JOINTS_1"], attributes["WEIGHTS_1"] = gltf.add(joints), gltf.add(weights, normalized=True)
    mesh = load_gltf(gltf.write()).meshes[0]
    assert mesh.deformable.joints.dtype == np.uint16
    of_second = np.where(mesh.deformable.joints == 1, mesh.deformable.weights, 0).sum(axis=1)
    np.testing.assert_allclose(of_second, np.repeat([0.5, 0.75, 1], 2), atol=ATOL)
    np.testing.assert_allclose(mesh.deformable.weights.sum(axis=1), 1, atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_numbers_beside_weights_of_zero_do_not_count_and_vertices_without_weight_follow_the_first_joint(gltf):
    attributes = add_strip(gltf)["attributes"]
    joints = np.full((6, 4), 99, np.uint8)
    joints[:, 0] = [1, 0, 1, 0, 1, 0]
    weights = np.zeros((6, 4), np.float32)
    weights[1:, 0] = 1
    attributes["JOINTS_0"], attributes["WEIGHTS_0"] = gltf.add(joints), gltf.add(weights)
    scene = load_gltf(gltf.write())
    assert scene.meshes[0].deformable.joints.ravel().tolist() == [1, 0, 1, 0, 1, 0]
    assert any("1 vertices have no weight" in line for line in scene.warnings)


@pytest.mark.covers("glTF skins")
def test_nodes_that_share_a_deformed_mesh_get_their_own(gltf):
    add_strip(gltf)
    gltf.json["nodes"] += [{"mesh": 0}, {"mesh": 0}, {"mesh": 0, "skin": 1}, {"translation": [0, 0, 7]}]
    gltf.json["skins"] += [{"joints": [6, 6]}]
    gltf.json["scenes"] = [{"nodes": [0, 1, 3, 4, 5, 6]}]
    scene = load_gltf(gltf.write())
    first, rigid, same, other = (scene.meshes[i.mesh] for i in scene.instances)
    assert rigid is same
    assert rigid.deformable is None
    assert len({id(mesh) for mesh in (first, rigid, other)}) == len(scene.meshes) == 3
    assert first.indices is other.indices
    np.testing.assert_allclose(other.positions, POSITIONS + np.array([0, 0, 7]), atol=ATOL)


def morphed(gltf, **more) -> None:
    """The triangle with two targets: up along z, of which the second is sparse and lifts one vertex alone."""
    gltf.triangle()
    primitive = gltf.json["meshes"][0]["primitives"][0]
    primitive["attributes"]["NORMAL"] = gltf.add(np.tile(np.array([0, 0, 1], np.float32), (3, 1)))
    up = gltf.add(np.tile(np.array([0, 0, 1], np.float32), (3, 1)))
    gltf.json["accessors"].append({"componentType": 5126, "type": "VEC3", "count": 3, "sparse": {
        "count": 1, "indices": {"bufferView": gltf.view(np.array([2], np.uint8)), "componentType": 5121},
        "values": {"bufferView": gltf.view(np.array([[0, 0, 8]], np.float32))}}})  # fmt: skip
    primitive["targets"] = [{"POSITION": up}, {"POSITION": up + 1}]
    gltf.json["meshes"][0] |= more


@pytest.mark.covers("glTF morph targets")
def test_weights_of_the_node_go_before_those_of_the_mesh(gltf):
    morphed(gltf, weights=[0.5, 0])
    gltf.json["nodes"] = [{"mesh": 0}, {"mesh": 0, "weights": [0, 0.25]}]
    scene = load_gltf(gltf.write())
    first, second = (scene.meshes[i.mesh] for i in scene.instances)
    np.testing.assert_allclose(first.positions[:, 2], [0.5, 0.5, 0.5])
    np.testing.assert_allclose(second.positions[:, 2], [0, 0, 2])
    assert first.indices is second.indices


@pytest.mark.covers("glTF morph targets", "glTF animation")
@pytest.mark.parametrize("dtype", [np.float32, np.uint8])
def test_animated_weights(gltf, dtype):
    morphed(gltf)
    one = 1 if dtype == np.float32 else 255
    add_animation(gltf, 0, "weights", [0, 1, 2], np.array([[0, 0], [1, 1], [0, 0]], dtype) * dtype(one))
    scene = load_gltf(gltf.write())
    later = scene.at(0.5)
    np.testing.assert_allclose(later.meshes[0].positions[:, 2], [0.5, 0.5, 4.5], atol=ATOL)
    assert later.instances[0].morph_weights == (0.5, 0.5)
    assert scene.at(0.0).meshes[0] is scene.meshes[0]


@pytest.mark.covers("glTF morph targets", "glTF animation")
def test_cubic_weights(gltf):
    morphed(gltf)
    values = np.arange(12).reshape(2, 3, 2)
    add_animation(gltf, 0, "weights", [0, 2], values, "CUBICSPLINE")
    (track,) = load_gltf(gltf.write()).tracks
    t = 0.25
    expected = ((2 * t**3 - 3 * t**2 + 1) * values[0, 1] + 2 * (t**3 - 2 * t**2 + t) * values[0, 2]
                + (3 * t**2 - 2 * t**3) * values[1, 1] + 2 * (t**3 - t**2) * values[1, 0])  # fmt: skip
    np.testing.assert_allclose(track.at(0.5), expected, atol=1e-12)


@pytest.mark.covers("glTF morph targets", "glTF generated normals")
def test_a_flat_shaded_mesh_takes_flat_normals_in_its_target(gltf):
    gltf.triangle()
    lift = gltf.add(np.array([[0, 0, 0], [0, 0, 0], [0, 0, 1]], np.float32))
    primitive = gltf.json["meshes"][0]["primitives"][0]
    primitive["targets"] = [{"POSITION": lift, "COLOR_0": lift}]
    add_animation(gltf, 0, "weights", [0, 1, 2], [[0], [1], [1]])
    scene = load_gltf(gltf.write())
    np.testing.assert_allclose(scene.at(1.0).meshes[0].normals, [[0, -sqrt(0.5), sqrt(0.5)]] * 3, atol=ATOL)
    assert any("COLOR_0" in line for line in scene.warnings)


@pytest.mark.covers("glTF animation")
@pytest.mark.parametrize(("interpolation", "expected"), [("LINEAR", HALFWAY_X), ("STEP", (0, 0, 0, 1))])
@pytest.mark.parametrize("dtype", [np.float32, np.int8, np.int16])
def test_rotations_halfway_and_stored_as_integers(gltf, interpolation, expected, dtype):
    gltf.triangle()
    one = 1 if dtype == np.float32 else np.iinfo(dtype).max
    values = np.array([(0, 0, 0, one), np.array(QUARTER_X) * one, np.array(QUARTER_X) * one])
    values = values.astype(dtype) if dtype == np.float32 else np.rint(values).astype(dtype)
    add_animation(gltf, 0, "rotation", [0, 1, 2], values, interpolation)
    scene = load_gltf(gltf.write())
    # Rounding an 8-bit quaternion moves its parts by half of 1/127.
    np.testing.assert_allclose(scene.tracks[0].at(0.5), expected, atol=1e-6 if dtype == np.float32 else 1 / 127)
    assert scene.at(0.5).instances[0].transform[2, 1] == pytest.approx(2 * expected[0] * expected[3], abs=2 / 127)


@pytest.mark.covers("glTF animation", "glTF KHR_lights_punctual", "glTF cameras")
def test_lights_and_cameras_ride_on_nodes_below_animated_ones(gltf):
    gltf.triangle()
    light = {"KHR_lights_punctual": {"light": 0}}
    spot = {"type": "spot", "intensity": 3, "spot": {}}
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [spot]}}
    gltf.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    gltf.json["nodes"] += [{"children": [2, 3], "translation": [1, 0, 0]},
                           {"extensions": light, "translation": [0, 0, -1], "name": "lamp"},
                           {"camera": 0, "scale": [2, 2, 2]}, {"extensions": light, "name": "still"}]  # fmt: skip
    add_animation(gltf, 1, "rotation", [0, 1, 2], [(0, 0, 0, 1), QUARTER_X, QUARTER_X])
    scene = load_gltf(gltf.write())
    later = scene.at(1.0)
    lamp, still = later.lights
    # (0, 0, -1) goes to (0, 1, 0), where the light and the camera now look.
    np.testing.assert_allclose(lamp.position, (1, 1, 0), atol=ATOL)
    np.testing.assert_allclose(lamp.direction, (0, 1, 0), atol=ATOL)
    np.testing.assert_allclose(later.cameras[0].forward, (0, 1, 0), atol=ATOL)
    np.testing.assert_allclose(later.cameras[0].position, (1, 0, 0), atol=ATOL)
    assert still is scene.lights[1]
    assert later.instances[0] is scene.instances[0]


@pytest.mark.covers("glTF animation")
def test_a_node_that_shrinks_to_nothing_leaves_light_and_camera_their_direction(gltf):
    gltf.triangle()
    gltf.json["extensions"] = {"KHR_lights_punctual": {"lights": [{"type": "directional"}]}}
    gltf.json["cameras"] = [{"type": "perspective", "perspective": {"yfov": 1, "znear": 0.1}}]
    gltf.json["nodes"] += [{"camera": 0, "extensions": {"KHR_lights_punctual": {"light": 0}}}]
    add_animation(gltf, 1, "scale", [0, 1, 2], [(1, 1, 1), (0, 0, 0), (0, 0, 0)])
    later = load_gltf(gltf.write()).at(1.0)
    np.testing.assert_allclose(later.lights[0].direction, (0, 0, -1))
    np.testing.assert_allclose(later.cameras[0].forward, (0, 0, -1))


@pytest.mark.covers("glTF animation")
def test_what_does_not_move_stays_the_same_object(gltf):
    primitive = add_strip(gltf)
    primitive["attributes"]["COLOR_0"] = gltf.add(np.ones((6, 3), np.float32))
    gltf.json["nodes"] += [{"mesh": 0, "name": "moved"}, {"mesh": 0, "name": "stands"}]
    gltf.json["scenes"] = [{"nodes": [0, 1, 3, 4]}]
    add_animation(gltf, 2, "rotation", [0, 1, 2], [(0, 0, 0, 1), QUARTER_X, QUARTER_X], name="bend")
    add_animation(gltf, 3, "translation", [0, 1], [(0, 0, 0), (2, 0, 0)], name="slide")
    scene = load_gltf(gltf.write())
    bent, slid = scene.at(1.0, "bend"), scene.at(0.5, "slide")
    assert bent.instances == scene.instances
    figure, rigid = scene.instances[0].mesh, scene.instances[1].mesh
    for array in ("indices", "uvs", "colors"):
        assert getattr(bent.meshes[figure], array) is getattr(scene.meshes[figure], array)
    assert bent.meshes[figure] is not scene.meshes[figure]
    assert bent.meshes[rigid] is scene.meshes[rigid]
    assert slid.meshes is scene.meshes
    assert [a is b for a, b in zip(slid.instances, scene.instances, strict=True)] == [True, False, True]
    np.testing.assert_allclose(slid.instances[1].transform[:3, 3], (1, 0, 0))
    assert slid.tracks == []
    assert len(scene.tracks) == 2
    np.testing.assert_allclose(scene.meshes[figure].positions, POSITIONS, atol=ATOL)


@pytest.mark.covers("glTF animation")
def test_clips_are_named_and_repeat(gltf):
    gltf.triangle()
    for name, length in (("walk", 2), ("", 3), ("walk", 4)):
        add_animation(gltf, 0, "translation", [0, length], [(0, 0, 0), (length, 0, 0)], name=name)
    scene = load_gltf(gltf.write())
    assert scene.clips == ["walk", "animation 1", "walk 2"]
    assert (scene.duration, [track.period for track in scene.tracks]) == (2.0, [2.0, 3.0, 4.0])
    for time, clip, expected in ((1.5, None, 1.5), (2.5, None, 0.5), (2.5, "walk 2", 2.5), (3.5, "animation 1", 0.5)):
        assert scene.at(time, clip).instances[0].transform[0, 3] == pytest.approx(expected)
    with pytest.raises(OctoluxError, match="no animation 'run'; it has 'walk', 'animation 1', 'walk 2'"):
        scene.at(0, "run")


def test_a_scene_without_animation_says_so(gltf):
    scene = load_gltf(gltf.triangle().write())
    assert (scene.clips, scene.duration) == ([], 0.0)
    assert scene.at(1.0).instances[0] is scene.instances[0]
    with pytest.raises(OctoluxError, match="it has none"):
        scene.at(0, "walk")


def test_paths_of_extensions_and_what_cannot_be_animated_are_noted(gltf):
    gltf.triangle()
    gltf.json["nodes"] += [{"matrix": np.eye(4).ravel().tolist()}]
    add_animation(gltf, 0, "pointer", [0, 1], np.zeros((2, 1)))
    add_animation(gltf, 1, "scale", [0, 1], np.ones((2, 3)))
    add_animation(gltf, 0, "weights", [0, 1], np.ones((2, 1)))
    scene = load_gltf(gltf.write())
    assert scene.tracks == []
    for words in ("'pointer' is not supported", "node 1 has a matrix", "no mesh with morph targets"):
        assert any(words in line for line in scene.warnings)


@pytest.mark.covers("model .glb", "glTF skins", "glTF animation", files=["gltf/Fox/Fox.glb"])
def test_fox(scenes):
    scene = load_gltf(scenes / "gltf" / "Fox" / "Fox.glb")
    assert (scene.clips, scene.triangle_count, scene.warnings) == (["Survey", "Walk", "Run"], 576, [])
    assert (len(scene.skins[0].joints), len(scene.nodes)) == (24, 26)
    low, high = scene.bounds()
    assert (high - low)[1] == pytest.approx(79.0, abs=0.1)
    for clip in scene.clips:
        poses = [scene.at(time, clip) for time in (0.0, 0.3, 0.6)]
        for pose in poses:
            (mesh,) = pose.meshes
            np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1, atol=ATOL)
            assert np.abs(pose.bounds()).max() < 120  # it stays where it is and whole
            # Skinned flat triangles are nearly flat: its normals are those of the faces, but for the bending of joints.
            a, b, c = (mesh.positions[mesh.indices[:, corner]] for corner in range(3))
            faces = np.cross(b - a, c - a)
            agree = np.einsum("ij,ij->i", faces, mesh.normals[mesh.indices[:, 0]]) > 0
            assert agree.mean() > 0.95
        assert not np.allclose(poses[0].meshes[0].positions, poses[1].meshes[0].positions, atol=1.0)
