"""Solid angles and moments of the faces against their defining integrals."""

from math import atan, pi, sqrt

import numpy as np

from octolux.simulator.lpv import transfer
from octolux.simulator.solid_angles import polygon_moment, rectangle_solid_angle

ROUNDING = 1e-13
NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)


def face_moments(centre: np.ndarray, normal: np.ndarray) -> tuple[float, np.ndarray]:
    """Solid angle and integral of w dw of the unit face, dw = n.r / r^3 dA, by Gauss quadrature. The nearest
    singularity is 0.5 away in a square of half-width 0.5, so 40 nodes leave less than (1 + sqrt(2))^-80 = 1e-30."""
    u = np.roll(np.abs(normal), 1)
    v = np.roll(np.abs(normal), 2)
    points = centre + 0.5 * (NODES[:, None, None] * u + NODES[None, :, None] * v)
    distance = np.linalg.norm(points, axis=-1)
    element = 0.25 * np.outer(WEIGHTS, WEIGHTS) * (points @ normal) / distance**3
    return element.sum(), np.einsum("uv,uvk->k", element / distance, points)


def test_faces_against_quadrature():
    for travel in range(6):
        for face in range(5):
            solid_angle, moment = face_moments(transfer.FACE_CENTRES[travel, face], transfer.NORMALS[travel, face])
            np.testing.assert_allclose(transfer.SOLID_ANGLES[travel, face], solid_angle, atol=ROUNDING)
            np.testing.assert_allclose(transfer.MOMENTS[travel, face], moment, atol=ROUNDING)


def test_published_solid_angles():
    assert abs(transfer.SOLID_ANGLE_FAR - 0.400670) < 0.5e-6
    assert abs(transfer.SOLID_ANGLE_SIDE - 0.423431) < 0.5e-6
    assert abs(transfer.SOLID_ANGLE_FAR - 4 * atan(1 / (3 * sqrt(11)))) < ROUNDING


def test_faces_tile_the_sphere():
    np.testing.assert_allclose(transfer.SOLID_ANGLES.sum(axis=1), np.full(6, 4 * pi / 6), atol=ROUNDING)
    np.testing.assert_allclose(transfer.MOMENTS.sum(axis=(0, 1)), np.zeros(3), atol=ROUNDING)


def test_order_of_directions_and_faces():
    np.testing.assert_array_equal(transfer.DIRECTIONS, np.kron(np.eye(3), [[1], [-1]]))
    np.testing.assert_array_equal(transfer.FACES[3], [3, 0, 1, 4, 5])
    np.testing.assert_allclose(transfer.CENTRE_DIRECTIONS[:, 0], transfer.DIRECTIONS)
    np.testing.assert_allclose(transfer.CENTRE_DIRECTIONS[0, 1], np.array([2, 1, 0]) / sqrt(5))


def test_faces_never_face_back():
    toward_source = np.einsum("tfk,tk->tf", transfer.NORMALS, transfer.DIRECTIONS)
    assert (toward_source >= 0).all()
    assert (np.einsum("tfk,tfk->tf", transfer.NORMALS, transfer.MOMENTS) > 0).all()


def test_whole_plane_is_half_the_sphere():
    """A square of half-width R at distance 1 leaves the ring outside it, at most 2 pi / sqrt(1 + R^2)."""
    half_width = 1e6
    solid_angle = rectangle_solid_angle(-half_width, half_width, -half_width, half_width, 1.0)
    assert 0.0 < 2 * pi - solid_angle < 2 * pi / half_width


def test_polygon_moment_changes_sign_with_orientation():
    square = np.array([[-1.0, -1, 2], [1, -1, 2], [1, 1, 2], [-1, 1, 2]])
    forward = polygon_moment(square)
    assert forward[2] > 0
    np.testing.assert_allclose(polygon_moment(square[::-1]), -forward, atol=ROUNDING)
