"""Cube faces, texel solid angles and the flux of VPLs."""

from math import pi

import numpy as np

from octolux.simulator import rsm


def test_cube_face_tiles_a_sixth_of_the_sphere():
    for resolution in (1, 4, 33):
        assert abs(6 * rsm.texel_solid_angles(resolution).sum() - 4 * pi) < 1e-12 * resolution


def test_thesis_solid_angle_is_the_midpoint_rule():
    """|d2/du2 (1 + u^2 + v^2)^(-3/2)| <= 3 on a cube face, so a texel of side t = 2/N is off by at most
    t^2 (3 + 3) / 24 * t^2."""
    for resolution in (2, 8, 64):
        side = 2.0 / resolution
        error = np.abs(rsm.texel_solid_angles_thesis(resolution) - rsm.texel_solid_angles(resolution))
        assert 0.0 < error.max() <= side**4 / 4


def test_narrow_field_of_view():
    """A pyramid of half-angle t: 4 asin(sin^2 t) sr."""
    half = 0.3
    expected = 4.0 * np.arcsin(np.sin(half) ** 2)
    np.testing.assert_allclose(rsm.texel_solid_angles(16, np.tan(half)).sum(), expected, rtol=1e-12)


def test_cube_axes_are_those_of_a_cube_texture():
    """The upper left texel of a face lies half a texel, 1 / 64, from the corner along both edges."""
    np.testing.assert_array_equal(np.cross(rsm.CUBE_RIGHT, rsm.CUBE_UP), rsm.CUBE_FORWARD)
    upper_left = rsm.cube_texel_directions(64)[:, 0, 0]
    corners = [[1, 1, 1], [-1, 1, -1], [-1, 1, -1], [-1, -1, 1], [-1, 1, 1], [1, 1, -1]]
    np.testing.assert_allclose(upper_left * np.sqrt(3), corners, atol=2 / 64)


def test_directions_find_their_texel():
    resolution = 5
    directions = rsm.cube_texel_directions(resolution)
    face, across, down = rsm.cube_texel_position(directions * 7.0)
    expected_face, row, column = np.indices((6, resolution, resolution))
    np.testing.assert_array_equal(face, expected_face)
    np.testing.assert_allclose(across, (column + 0.5) / resolution)
    np.testing.assert_allclose(down, (row + 0.5) / resolution)


def test_ties_go_to_z_then_y():
    np.testing.assert_array_equal(rsm.cube_face_of([[1, 1, 1], [1, -1, 0], [-1, 0, -1], [-2, 1, 1]]), [4, 3, 5, 1])


def test_point_light_flux_adds_to_four_pi():
    solid_angles = np.broadcast_to(rsm.texel_solid_angles(8), (6, 8, 8))
    flux = rsm.vpl_flux_point([0.5, 1.0, 0.25], [2.0, 3.0, 4.0], solid_angles)
    np.testing.assert_allclose(flux.sum(axis=(0, 1, 2)), 4 * pi * np.array([1.0, 3.0, 1.0]))


def test_directional_light_flux_is_that_of_the_lit_area():
    """A 4 m square map of 16^2 texels over a plane of albedo 1/2 under 10 lx."""
    flux = rsm.vpl_flux_directional(np.full((16, 16, 3), 0.5), [10.0, 20.0, 0.0], (4.0 / 16) ** 2)
    np.testing.assert_allclose(flux.sum(axis=(0, 1)), [80.0, 160.0, 0.0])
