"""Morph targets and skins against closed forms."""

from __future__ import annotations

from dataclasses import replace
from math import sqrt

import numpy as np
import pytest

from octolux.scene.meshes import Deformable, Mesh, MorphTarget
from octolux.scene.motion.deformation import deformed

ATOL = 1e-6  # a few roundings of float32 numbers of about 1


def corner(normal=(0, 0, 1), tangent=(1, 0, 0), **more) -> Mesh:
    """A triangle whose vertices all have the given normal and tangent."""
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    normals = np.tile(np.array(normal, np.float32), (3, 1))
    tangents = np.tile(np.array([*tangent, -1.0], np.float32), (3, 1))
    base = Deformable(positions=positions, normals=normals, tangents=tangents, **more)
    return Mesh(positions=positions, normals=normals, tangents=tangents, uvs=np.zeros((3, 2), np.float32),
                indices=np.array([[0, 1, 2]], np.uint32), deformable=base)  # fmt: skip


def skinned(matrix, **more) -> Mesh:
    """The corner moved by one joint's matrix, (3, 3) or (4, 4)."""
    palette = np.eye(4)[None].copy()
    palette[0, : len(matrix), : len(matrix)] = matrix
    weights = np.ones((3, 1), np.float32)
    return deformed(corner(joints=np.zeros((3, 1), np.uint16), weights=weights, **more), (), palette)


@pytest.mark.covers("glTF morph targets")
def test_a_morph_by_half_moves_by_half():
    shift = np.array([[0, 0, 2], [0, 0, 0], [4, 0, 0]], np.float32)
    target = MorphTarget(positions=shift, normals=np.tile(np.array([0, 2, 0], np.float32), (3, 1)))
    mesh = corner(targets=(MorphTarget(), target))
    result = deformed(mesh, (1.0, 0.5))
    np.testing.assert_allclose(result.positions, mesh.positions + 0.5 * shift)
    np.testing.assert_allclose(result.normals, [[0, sqrt(0.5), sqrt(0.5)]] * 3, atol=ATOL)
    assert result.indices is mesh.indices
    assert result.uvs is mesh.uvs
    np.testing.assert_array_equal(mesh.deformable.positions, corner().positions)


@pytest.mark.covers("glTF morph targets")
def test_targets_add_up_and_tangents_follow():
    along = np.tile(np.array([0, 1, 0], np.float32), (3, 1))
    result = deformed(corner(targets=(MorphTarget(tangents=along), MorphTarget(tangents=along))), (0.25, 0.75))
    np.testing.assert_allclose(result.tangents, [[sqrt(0.5), sqrt(0.5), 0, -1]] * 3, atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_a_stretched_surface_keeps_its_normal_upright_on_it():
    tilted = {"normal": (sqrt(0.5), sqrt(0.5), 0), "tangent": (sqrt(0.5), -sqrt(0.5), 0)}
    result = skinned(np.diag([2.0, 1.0, 1.0]), **tilted)
    np.testing.assert_allclose(result.normals[0], np.array([1, 2, 0]) / sqrt(5), atol=ATOL)
    np.testing.assert_allclose(result.tangents[0], [2 / sqrt(5), -1 / sqrt(5), 0, -1], atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_a_mirrored_surface_looks_the_other_way_and_its_bitangent_with_it():
    result = skinned(np.diag([1.0, 1.0, -1.0]))
    np.testing.assert_allclose(result.normals[0], [0, 0, -1], atol=ATOL)
    normal, tangent = result.normals[0], result.tangents[0]
    # Before, the bitangent cross(n, t) * w was (0, -1, 0), which the mirror leaves alone.
    np.testing.assert_allclose(np.cross(normal, tangent[:3]) * tangent[3], [0, -1, 0], atol=ATOL)


@pytest.mark.covers("glTF skins")
@pytest.mark.parametrize("scale", [1e-2, 1e3, 1e-12])
def test_size_does_not_matter(scale):
    result = skinned(scale * np.eye(3))
    np.testing.assert_allclose(result.normals, [[0, 0, 1]] * 3, atol=ATOL)
    np.testing.assert_allclose(result.tangents, [[1, 0, 0, -1]] * 3, atol=ATOL)
    np.testing.assert_allclose(result.positions, scale * corner().positions, rtol=1e-6)


@pytest.mark.covers("glTF skins")
def test_where_a_joint_shrinks_all_to_a_point_the_directions_stay():
    result = skinned(np.zeros((3, 3)))
    np.testing.assert_array_equal(result.positions, np.zeros((3, 3)))
    np.testing.assert_allclose(result.normals, [[0, 0, 1]] * 3, atol=ATOL)
    np.testing.assert_allclose(result.tangents, [[1, 0, 0, -1]] * 3, atol=ATOL)


@pytest.mark.covers("glTF skins")
def test_random_vertices_are_weighted_means_of_what_their_joints_do():
    random = np.random.default_rng(5)
    count, bones = 200, 7
    mesh = corner()
    positions = random.normal(size=(count, 3)).astype(np.float32)
    normals = random.normal(size=(count, 3))
    normals = (normals / np.linalg.norm(normals, axis=1, keepdims=True)).astype(np.float32)
    tangents = np.hstack([np.cross(normals, np.roll(normals, 1, axis=1)), np.ones((count, 1))]).astype(np.float32)
    joints = random.integers(0, bones, (count, 6)).astype(np.uint16)
    weights = random.dirichlet(np.ones(6), count).astype(np.float32)
    palette = np.tile(np.eye(4), (bones, 1, 1))
    palette[:, :3] += 0.3 * random.normal(size=(bones, 3, 4))
    base = Deformable(positions=positions, normals=normals, tangents=tangents, joints=joints, weights=weights)
    mesh = replace(mesh, positions=positions, normals=normals, tangents=tangents, uvs=np.zeros((count, 2), np.float32),
                   deformable=base)  # fmt: skip
    result = deformed(mesh, (), palette)
    blended = np.einsum("vk,vkij->vij", weights.astype(np.float64), palette[joints])
    expected = np.einsum("vij,vj->vi", blended[:, :3, :3], positions) + blended[:, :3, 3]
    upright = np.einsum("vji,vj->vi", np.linalg.inv(blended[:, :3, :3]), normals)
    upright /= np.linalg.norm(upright, axis=1, keepdims=True)
    np.testing.assert_allclose(result.positions, expected, atol=1e-5)
    # float32 cofactors lose what is common to their terms: the condition of the blended matrices, at most 100 here.
    assert np.linalg.cond(blended[:, :3, :3]).max() < 100
    np.testing.assert_allclose(result.normals, upright, atol=100 * 2**-22)
    np.testing.assert_allclose(np.einsum("vi,vi->v", result.normals, result.tangents[:, :3]), 0, atol=1e-5)


def test_a_mesh_that_nothing_deforms_is_refused():
    with pytest.raises(ValueError, match="neither"):
        deformed(replace(corner(), deformable=None))
