"""The shapes and textures that the built-in scenes are made of."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from mesh_facts import face_normals, signed_volume, triangles

from octolux.scene.builtin.architecture import arched_wall, archivolt, balustrade, column, curtain, moved
from octolux.scene.builtin.lamps import NEUTRAL_WHITE, WARM_WHITE, pendulum, point_intensity, spot_intensity
from octolux.scene.builtin.placing import aimed, placed, tilted, transformed
from octolux.scene.builtin.plant_textures import lattice, twig
from octolux.scene.builtin.plants import twigs
from octolux.scene.builtin.round_shapes import (
    cylinder,
    plate,
    polygon,
    rounded_path,
    rounded_rectangle,
    sphere,
    tube,
)
from octolux.scene.builtin.shapes import box, extrude, merge, quad, revolve
from octolux.scene.builtin.textures import masonry, normal_texture
from octolux.scene.lights import SpotLight
from octolux.scene.motion.moved import rotation_matrix
from octolux.simulator.direct import spot_attenuation

MOULDING = [(0.0, 0.0), (0.1, 0.1), (0.1, 0.3), (0.0, 0.3)]

FLAT_SHAPES = {
    "quad": quad([(0, 0, 0), (2, 0, 0), (2, 1, 0), (0, 1, 0)], tile=0.5),
    "box": box((-1, 0, 2), (1, 3, 4)),
    "inward box": box((-1, 0, 2), (1, 3, 4), inward=True),
    "extrude": extrude(MOULDING, (0, 0, 0), (3, 0, 4)),
    "archivolt": archivolt(1.0, 2.0, 0.5),
    "plate": plate(rounded_rectangle(2.0, 1.0, 0.2), 0.5, 0.6),
    "polygon": polygon([(0, 0, 0), (2, 0, 0), (3, 1, 0), (2, 2, 0), (0, 2, 0), (-1, 1, 0)]),
    "tilted box": transformed(box((-1, 0, 2), (1, 3, 4)), tilted(35.0, y=2.0) @ placed(1, 2, 3, 50.0, 0.5)),
    "turned box": moved(box((-1, 0, 2), (1, 3, 4)), (5, 6, 7), quarter_turns=3),
}
SMOOTH_SHAPES = {
    "revolve": revolve([(0.5, 0.0), (0.5, 1.0), (0.5, 1.0), (0.3, 1.5), (0.3, 2.0)]),
    "arched wall": arched_wall(4.0, 1.0, 2.0, 0.0, 4.0, 0.5),
    "column": column(2.5, 0.25),
    "balustrade": balustrade(2.0, 1.0, 5),
    "sphere": sphere(0.5),
    "cylinder": cylinder(0.5, 1.0),
    "tube": tube(rounded_path([(0, 0, 0), (0, 1, 0), (1, 1, 0), (1, 1, 1)]), 0.05),
    "twigs": twigs(np.zeros((3, 3)), np.eye(3), [1.0, 2.0, 3.0], np.random.default_rng(1)),
    "curtain": curtain(2.0, 2.4, 6.0, gather=0.2),
}
SHAPES = FLAT_SHAPES | SMOOTH_SHAPES


@pytest.mark.parametrize("name", SHAPES)
def test_shapes_have_unit_orthogonal_frames(name):
    mesh = SHAPES[name]
    tangents = mesh.tangents[:, :3]
    np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
    np.testing.assert_allclose(np.linalg.norm(tangents, axis=1), 1.0, atol=1e-6)
    np.testing.assert_allclose(np.einsum("ij,ij->i", mesh.normals, tangents), 0.0, atol=1e-6)
    assert set(np.unique(mesh.tangents[:, 3])) <= {-1.0, 1.0}


@pytest.mark.parametrize("name", SHAPES)
def test_shading_normals_are_on_the_side_of_the_front(name):
    mesh = SHAPES[name]
    facing = np.einsum("ij,ikj->ik", face_normals(mesh), mesh.normals[mesh.indices])
    assert facing.min() > (0.999999 if name in FLAT_SHAPES else 0.0)


@pytest.mark.parametrize("name", SHAPES)
def test_tangents_follow_the_uvs(name):
    """Along the tangent u grows; along cross(n, t) * w v shrinks (up in the image)."""
    mesh = SHAPES[name]
    corner, uv = triangles(mesh), mesh.uvs[mesh.indices].astype(np.float64)
    edges, uv_edges = corner[:, 1:] - corner[:, :1], uv[:, 1:] - uv[:, :1]
    # Gradients of u and v over the triangle: edges @ gradient = uv_edges, and no component along the normal.
    rows = np.concatenate([edges, face_normals(mesh)[:, None]], axis=1)
    gradients = np.linalg.solve(rows, np.concatenate([uv_edges, np.zeros((len(uv), 1, 2))], axis=1))
    tangent, normal = mesh.tangents[mesh.indices[:, 0]], mesh.normals[mesh.indices[:, 0]]
    bitangent = np.cross(normal, tangent[:, :3]) * tangent[:, 3:]
    assert np.einsum("ij,ij->i", gradients[:, :, 0], tangent[:, :3]).min() > 0
    assert np.einsum("ij,ij->i", gradients[:, :, 1], bitangent).max() < 0


def test_a_box_is_closed_and_faces_out_or_in():
    assert signed_volume(box((-1, 0, 2), (1, 3, 4))) == pytest.approx(12.0)
    assert signed_volume(box((-1, 0, 2), (1, 3, 4), inward=True)) == pytest.approx(-12.0)


def test_surface_of_revolution_has_the_volume_of_its_polygon():
    segments, rim = 48, 1e-4
    profile = [(rim, 0.0), (1.0, 0.0), (1.0, 0.0), (1.0, 2.0), (1.0, 2.0), (rim, 2.0)]
    cylinder = revolve(profile, segments=segments)
    polygon = 0.5 * segments * np.sin(2.0 * pi / segments)
    assert signed_volume(cylinder) == pytest.approx(2.0 * polygon, rel=1e-4)


def test_arched_wall_leaves_the_arch_open():
    mesh = arched_wall(4.0, 1.0, 2.0, 0.0, 4.0, 0.5)
    front = np.einsum("ij,j->i", face_normals(mesh), [0.0, 0.0, 1.0]) > 0.99
    a, b, c = np.moveaxis(triangles(mesh)[front], 1, 0)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    half_disc = 0.5 * 24 * np.sin(pi / 24)  # of the polygon with 24 segments over half a turn
    assert area == pytest.approx(4.0 * 4.0 - 2.0 * 2.0 - half_disc, rel=1e-5)


def test_merge_keeps_all_triangles_in_place():
    a, b = box((0, 0, 0), (1, 1, 1)), box((5, 0, 0), (6, 1, 1))
    both = merge([a, b], "both")
    np.testing.assert_array_equal(triangles(both), np.concatenate([triangles(a), triangles(b)]))
    assert both.name == "both"


def test_merge_of_different_materials_is_an_error():
    with pytest.raises(ValueError, match="same material"):
        merge([box((0, 0, 0), (1, 1, 1)), box((0, 0, 0), (1, 1, 1), material=1)])


def test_normal_texture_of_a_ramp_leans_downhill():
    """Heights rising to the right and to the top: normals lean left and down, with green up."""
    ramp = np.linspace(0.0, 1.0, 64)
    inner = normal_texture(ramp[None, :] + ramp[::-1, None], 5.0, "").image.pixels[32, 32]
    assert inner[0] < 128 and inner[1] < 128 and inner[2] > 128


def test_textures_tile():
    """The step over the edge is no larger than the largest steps inside."""
    pixels = masonry(1, (0.5, 0.4, 0.3), size=128).normal.image.pixels.astype(np.float64)
    for axis in (0, 1):
        steps = np.abs(np.diff(pixels, axis=axis)).mean(axis=(1 - axis, 2))
        seam = np.abs(np.take(pixels, 0, axis=axis) - np.take(pixels, -1, axis=axis)).mean()
        assert seam <= 1.5 * steps.max()


def test_sphere_has_exact_normals_and_its_polyhedrons_volume_near_the_balls():
    """The chords of 14 cells over a quarter turn are below the arc by at most r (1 - cos(pi / 56)) for each of two
    directions: the volume lacks less than six times that share."""
    ball = sphere(0.5, rows=14)
    np.testing.assert_allclose(ball.normals, ball.positions / 0.5, atol=1e-6)
    share = 1.0 - np.cos(pi / 56)
    assert (4.0 / 3.0 * pi * 0.125) * (1.0 - 6.0 * share) < signed_volume(ball) < 4.0 / 3.0 * pi * 0.125


def test_plate_and_cylinder_are_closed():
    """Their volumes are those of their polygons; an open surface's would depend on where the origin is."""
    outline = rounded_rectangle(2.0, 1.0, 0.2)
    x, z = outline.T
    area = -0.5 * float(np.sum(x * np.roll(z, -1) - z * np.roll(x, -1)))  # counter-clockwise from above, z downwards
    assert signed_volume(transformed(plate(outline, 0.5, 0.6), placed(3, 4, 5))) == pytest.approx(0.1 * area, rel=1e-4)
    polygon_area = 0.5 * 24 * np.sin(2.0 * pi / 24) * 0.25
    can = transformed(cylinder(0.5, 2.0), placed(3, 4, 5))
    assert signed_volume(can) == pytest.approx(2.0 * polygon_area, rel=1e-4)


def test_tube_keeps_its_radius_around_its_path():
    path = np.array([(0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 3.0, 0.0)])
    points = tube(path, [0.2, 0.1, 0.3], sides=8).positions.reshape(3, 9, 3)
    radii = np.linalg.norm(points - path[:, None], axis=2)
    np.testing.assert_allclose(radii, [[0.2] * 9, [0.1] * 9, [0.3] * 9], rtol=1e-6)


def test_aimed_points_downwards_along_the_direction():
    transform = aimed((1.0, 2.0, 3.0), (1.0, 2.0, -2.0))
    np.testing.assert_allclose(transform @ [0.0, -3.0, 0.0, 1.0], [2.0, 4.0, 1.0, 1.0], atol=1e-12)
    assert np.linalg.det(transform) == pytest.approx(1.0)


def test_spot_intensity_gives_the_lumens_that_were_asked_for():
    """Integrated over the sphere with KHR_lights_punctual's falloff as the simulator has it."""
    inner, outer = 0.4, 1.2
    light = SpotLight(position=(0, 0, 0), direction=(0, -1, 0), intensity=spot_intensity(1000.0, inner, outer),
                      inner_angle=inner, outer_angle=outer)
    cosine = (np.arange(200_000) + 0.5) / 200_000  # midpoints; the other half is dark
    towards = np.stack([np.sqrt(1.0 - cosine**2), cosine, 0.0 * cosine], axis=1)
    flux = light.intensity[0] * 2.0 * pi * spot_attenuation(light, towards).mean()
    assert flux == pytest.approx(1000.0, rel=1e-4)  # the midpoint rule's error at the ramp's two kinks is below 1e-5
    assert 4.0 * pi * point_intensity(800.0)[0] == pytest.approx(800.0)


@pytest.mark.parametrize("color", [WARM_WHITE, NEUTRAL_WHITE])
def test_lamp_colours_have_luminance_one(color):
    assert np.dot(color, (0.2126, 0.7152, 0.0722)) == pytest.approx(1.0, abs=2e-3)  # three decimals are given


def test_pendulum_keeps_its_length_and_its_lamp_to_its_instance():
    pivot, length = (1.0, 3.0, -2.0), 0.75
    lamp = (1.0, 2.25, -2.0)
    position, rotation, translation = pendulum(pivot, length, 20.0, lamps={"lamp": lamp}, instances=("bulb",))
    for seconds in np.linspace(0.0, float(position.times[-1]), 57):
        now = position.at(seconds)
        # A chord of two keys lies below its arc by length * step^2 / 8, and a step is at most 20 deg * 2 pi / 32.
        assert np.linalg.norm(now - pivot) == pytest.approx(length, rel=(np.radians(20.0) * 2.0 * pi / 32) ** 2 / 8)
        swung = rotation_matrix(rotation.at(seconds)) @ np.array(lamp) + translation.at(seconds)
        assert np.linalg.norm(swung - now) < np.linalg.norm(lamp) * (np.radians(20.0) * 2.0 * pi / 32) ** 2 / 4
    assert position.times[-1] == pytest.approx(2.0 * pi * np.sqrt(length / 9.81))


@pytest.mark.parametrize("texture", [twig(1, (0.1, 0.2, 0.03)), lattice(1, (0.4, 0.3, 0.2))])
def test_masks_are_all_or_nothing(texture):
    assert set(np.unique(texture.image.pixels[..., 3])) == {0, 255}
