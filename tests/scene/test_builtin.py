"""The scenes made by code."""

from __future__ import annotations

import time
from collections import Counter

import numpy as np
import pytest
from mesh_facts import face_normals, signed_volume, triangles

from octolux.scene.builtin import BUILTIN
from octolux.scene.exposure import metered_exposure
from octolux.scene.load import load_scene


@pytest.mark.parametrize(("name", "low", "high"), [("cornell-box", 34, 34), ("furnace", 12, 12),
                                                   ("atrium", 20_000, 100_000)])  # fmt: skip
def test_builtin_triangle_counts(name, low, high):
    assert low <= load_scene(name).triangle_count <= high


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_scenes_hold_together(name):
    scene = BUILTIN[name]()
    assert scene.name == name
    assert all(0 <= m.material < len(scene.materials) for m in scene.meshes)
    assert {i.mesh for i in scene.instances} == set(range(len(scene.meshes)))
    assert scene.cameras
    assert scene.exposure is not None
    for group in (scene.instances, scene.materials, scene.lights, scene.cameras):
        repeated = [n for n, count in Counter(o.name for o in group).items() if count > 1]
        assert not repeated
    named = {"light": scene.lights, "camera": scene.cameras, "instance": scene.instances}
    assert scene.at(0.0).lights == scene.lights  # the first frame is the still picture
    for track in scene.tracks:
        assert track.name in [o.name for o in named[track.target]]


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_meshes_have_no_triangle_without_area_and_front_sided_normals(name):
    for mesh in BUILTIN[name]().meshes:
        facing = np.einsum("ij,ikj->ik", face_normals(mesh), mesh.normals[mesh.indices])
        assert facing.min() > 0, mesh.name
        assert np.isfinite(mesh.uvs).all()


@pytest.mark.parametrize("name", BUILTIN)
def test_cameras_stand_inside_and_outside_of_all_stone(name):
    """A ray from each camera along its view meets a front face first, except through the open roof."""
    scene = BUILTIN[name]()
    for camera in scene.cameras:
        nearest, facing = np.inf, -1.0
        for instance in scene.instances:
            mesh = scene.meshes[instance.mesh]
            if scene.materials[mesh.material].double_sided:
                continue
            corners = triangles(mesh) @ instance.transform[:3, :3].T + instance.transform[:3, 3]
            distance, cosine = first_hit(corners, camera.position, camera.forward)
            if distance < nearest:
                nearest, facing = distance, cosine
        assert np.isfinite(nearest)
        assert facing < 0, camera.name


def first_hit(corners: np.ndarray, origin: np.ndarray, direction: np.ndarray) -> tuple[float, float]:
    """Distance to the first triangle and direction times its normal (Moeller and Trumbore); infinity when none."""
    a, e1, e2 = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(direction, e2)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1.0 / np.einsum("ij,ij->i", e1, p)
        u = np.einsum("ij,ij->i", origin - a, p) * inverse
        q = np.cross(origin - a, e1)
        v, t = q @ direction * inverse, np.einsum("ij,ij->i", e2, q) * inverse
        hit = (u >= 0) & (v >= 0) & (u + v <= 1) & (t > 1e-6)
    if not hit.any():
        return np.inf, 0.0
    first = np.flatnonzero(hit)[t[hit].argmin()]
    return float(t[first]), float(direction @ np.cross(e1[first], e2[first]))


def test_furnace_is_closed_and_its_walls_face_inwards():
    scene = BUILTIN["furnace"]()
    (mesh,) = scene.meshes
    assert signed_volume(mesh) == pytest.approx(-8.0)
    edges = Counter(edge for t in triangles(mesh) for edge in directed_edges(t))
    assert all(edges[b, a] == count for (a, b), count in edges.items())


def directed_edges(triangle: np.ndarray) -> list[tuple]:
    a, b, c = (tuple(corner) for corner in triangle)
    return [(a, b), (b, c), (c, a)]


def test_furnace_exposure_meters_its_closed_form():
    (material,) = (scene := BUILTIN["furnace"]()).materials
    radiance = material.emissive[0] / (1.0 - material.base_color[0])
    assert scene.exposure == pytest.approx(metered_exposure(radiance))
    assert material.specular == 0.0


def test_cornell_box_is_lambertian_and_its_lamp_stays_inside():
    scene = BUILTIN["cornell-box"]()
    assert all(m.specular == 0.0 for m in scene.materials)
    low, high = scene.bounds()
    (track,) = scene.tracks
    assert (track.values > low).all() and (track.values < high).all()


def test_atrium_is_built_in_time():
    start = time.process_time()
    BUILTIN["atrium"]()
    assert time.process_time() - start < 4.0


def test_atrium_sun_reaches_floor_wall_and_a_curtain_but_not_the_shade_side():
    scene = BUILTIN["atrium"]()
    to_sun = -np.array(scene.lights[0].direction)
    everything = np.concatenate([triangles(scene.meshes[i.mesh]) for i in scene.instances])
    cloth = next(m for m in scene.meshes if m.name == "curtain 2 (sun)")
    front = triangles(cloth).mean(axis=(0, 1))

    def lit(point) -> bool:
        return not np.isfinite(first_hit(everything, np.array(point, dtype=np.float64), to_sun)[0])

    assert lit((3.0, 0.01, 2.5)), "floor"
    assert lit((1.25, 3.8, 2.6)), "arcade of the sun side"
    assert lit(front - [0.0, 0.0, 0.4]), "curtain"
    assert not lit((3.0, 0.01, -2.0)), "floor of the shade side"
    assert not lit((1.25, 3.8, -2.6)), "arcade of the shade side"


def test_builtin_scenes_are_the_same_every_time():
    first, second = BUILTIN["atrium"](), BUILTIN["atrium"]()
    assert all(np.array_equal(a.positions, b.positions) for a, b in zip(first.meshes, second.meshes, strict=True))
    one, other = (s.materials[0].base_color_texture.image.pixels for s in (first, second))
    assert np.array_equal(one, other)


def test_metered_exposure_of_mid_grey_in_the_sun():
    """EV 15 is the sunny-16 rule's: 4096 nits, K = 12.5."""
    assert metered_exposure(4096.0) == pytest.approx(15.0)


@pytest.mark.parametrize("luminance", [0.0, -1.0, float("nan")])
def test_metered_exposure_of_darkness_is_an_error(luminance):
    with pytest.raises(ValueError, match="positive"):
        metered_exposure(luminance)
