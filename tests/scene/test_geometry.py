"""Normals, tangents and triangles without area."""

from __future__ import annotations

import numpy as np

from octolux.scene.geometry import triangles as geometry

CORNER = np.array([[0, 0, 0], [2, 0, 0], [0, 1, 0], [0, 0, 1]], np.float32)


def test_triangles_without_area_are_told_from_thin_ones():
    positions = np.array([[0, 0, 0], [1, 0, 0], [2, 0, 0], [1, 1e-5, 0]], np.float32)
    indices = np.array([[0, 1, 2], [0, 2, 3], [1, 1, 3]], np.uint32)
    assert geometry.has_area(positions, indices).tolist() == [False, True, False]
    assert geometry.has_area(positions * np.float32(1e-6), indices).tolist() == [False, True, False]


def test_smooth_normals_are_weighted_by_area():
    # The triangles around vertex 0 have areas 1 (normal +z) and 1/2 (normal +x).
    normals = geometry.smooth_normals(CORNER, np.array([[0, 1, 2], [0, 2, 3]], np.uint32))
    np.testing.assert_allclose(normals[0], np.array([1, 0, 2]) / 5**0.5, atol=1e-6)
    np.testing.assert_allclose(normals[1], [0, 0, 1], atol=1e-6)


def test_bad_normals_are_replaced_and_long_ones_shortened():
    indices = np.array([[0, 1, 2]], np.uint32)
    stored = np.array([[0, 0, 0], [np.nan, 0, 1], [3, 0, 4], [0, 5, 0]], np.float32)
    repaired = geometry.repair_normals(CORNER, stored, indices)
    np.testing.assert_allclose(repaired, [[0, 0, 1], [0, 0, 1], [0.6, 0, 0.8], [0, 1, 0]], atol=1e-6)


def test_tangents_follow_u_and_bitangents_rise_against_v():
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    normals = np.array([[0, 0, 1]] * 3, np.float32)
    indices = np.array([[0, 1, 2]], np.uint32)
    upright = np.array([[0, 1], [1, 1], [0, 0]], np.float32)  # v points down: the picture stands upright
    np.testing.assert_allclose(geometry.tangents(positions, normals, upright, indices), [[1, 0, 0, 1]] * 3, atol=1e-6)
    mirrored = upright * np.float32([-1, 1])
    np.testing.assert_allclose(
        geometry.tangents(positions, normals, mirrored, indices), [[-1, 0, 0, -1]] * 3, atol=1e-6
    )


def test_tangents_on_random_meshes_are_orthonormal_and_match_the_uv_gradient():
    random = np.random.default_rng(1)
    positions = random.normal(size=(300, 3)).astype(np.float32)
    uvs = random.normal(size=(300, 2)).astype(np.float32)
    indices = np.arange(300, dtype=np.uint32).reshape(-1, 3)
    positions, normals, uvs, indices = geometry.flat(positions, uvs, indices)
    tangents = geometry.tangents(positions, normals, uvs, indices).astype(np.float64)
    np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(np.sum(tangents[:, :3] * normals, axis=1), 0, atol=1e-6)
    bitangents = np.cross(normals, tangents[:, :3]) * tangents[:, 3:]
    for triangle in indices:
        edges = (positions[triangle[1:]] - positions[triangle[0]]).astype(np.float64)
        changes = (uvs[triangle[1:]] - uvs[triangle[0]]).astype(np.float64)
        along_u, along_v = np.linalg.solve(changes, edges)  # dP/du and dP/dv in the plane of the triangle
        expected = along_u / np.linalg.norm(along_u)
        np.testing.assert_allclose(tangents[triangle[0], :3], expected, atol=1e-4)
        assert bitangents[triangle[0]] @ along_v < 0


def test_tangents_without_uvs_are_valid():
    normals = np.eye(3, dtype=np.float32)
    positions = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], np.float32)
    tangents = geometry.tangents(positions, normals, np.zeros((3, 2), np.float32), np.array([[0, 1, 2]], np.uint32))
    np.testing.assert_allclose(np.linalg.norm(tangents[:, :3], axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(np.sum(tangents[:, :3] * normals, axis=1), 0, atol=1e-6)
    assert (tangents[:, 3] == 1).all()
