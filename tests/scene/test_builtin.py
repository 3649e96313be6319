"""The scenes made by code."""

from __future__ import annotations

import time
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from mesh_facts import face_normals, signed_volume, triangles
from ray_casts import first_hit, sphere_directions, world_triangles

from octolux.scene.builtin import BUILTIN, description
from octolux.scene.exposure import metered_exposure
from octolux.scene.load import load_scene

TRIANGLES = {
    "cornell-box": (34, 34), "furnace": (12, 12), "atrium": (60_000, 100_000), "corridor": (5_000, 20_000),
    "two-rooms": (10_000, 40_000), "foliage": (25_000, 80_000), "conference": (20_000, 60_000),
    "spheres": (40_000, 100_000),
}  # fmt: skip
MOST_LIGHTS = 8


@pytest.fixture(scope="module")
def scenes():
    return {name: make() for name, make in BUILTIN.items()}


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_triangle_counts(name):
    low, high = TRIANGLES[name]
    assert low <= load_scene(name).triangle_count <= high


@pytest.mark.parametrize("name", BUILTIN)
def test_descriptions_are_one_sentence_of_at_most_a_line(name):
    text = description(name)
    assert 20 < len(text) <= 115
    assert text.endswith(".")


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_scenes_hold_together(name, scenes):
    scene = scenes[name]
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
    assert len(scene.lights) <= MOST_LIGHTS


@pytest.mark.parametrize("name", [name for name in BUILTIN if name != "furnace"])
def test_animations_move_and_end_where_they_began(name, scenes):
    """At time 0 and at the end all is as in the still picture; in between something is not."""
    scene = scenes[name]
    assert scene.tracks
    end = max(float(track.times[-1]) for track in scene.tracks)
    for moved in (scene.at(0.0), scene.at(end)):
        for now, still in zip(moved.instances, scene.instances, strict=True):
            np.testing.assert_allclose(now.transform, still.transform, atol=1e-12)
        for lamp, still in zip(moved.lights, scene.lights, strict=True):
            np.testing.assert_allclose(_place(lamp), _place(still), atol=1e-12)
    for track in scene.tracks:
        assert np.ptp(track.values, axis=0).max() > 0.05, track.name


def _place(light) -> np.ndarray:
    return np.array([*getattr(light, "position", ()), *getattr(light, "direction", ())])


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_meshes_are_sound(name, scenes):
    """No triangle without area, normals unit and on the side of the front, tangents unit, uvs finite."""
    for mesh in scenes[name].meshes:
        a, b, c = np.moveaxis(triangles(mesh), 1, 0)
        # Vertices are rounded to 2^-24 of their distance from the origin, 10 m: an area below 1e-9 would be rounding.
        assert np.linalg.norm(np.cross(b - a, c - a), axis=1).min() / 2.0 > 1e-9, mesh.name
        facing = np.einsum("ij,ikj->ik", face_normals(mesh), mesh.normals[mesh.indices])
        assert facing.min() > 0, mesh.name
        np.testing.assert_allclose(np.linalg.norm(mesh.normals, axis=1), 1.0, atol=1e-6)
        np.testing.assert_allclose(np.linalg.norm(mesh.tangents[:, :3], axis=1), 1.0, atol=1e-6)
        assert np.isfinite(mesh.uvs).all()


@pytest.mark.parametrize("name", BUILTIN)
def test_albedos_are_those_of_real_materials(name, scenes):
    """Nothing reflects more than fresh snow (0.9) or, diffusely, less than soot (0.02); metals are another matter."""
    for material in scenes[name].materials:
        if not material.metallic and material.base_color_texture is None and material.name != "water":
            assert max(material.base_color) <= 0.9 and max(material.base_color) >= 0.02, material.name


@pytest.mark.parametrize("name", BUILTIN)
def test_cameras_stand_outside_of_all_stone(name, scenes):
    """A ray from each camera along its view meets a front face first, or the sky."""
    scene = scenes[name]
    double = [m.double_sided for m in scene.materials]
    solid = replace(scene, instances=[i for i in scene.instances if not double[scene.meshes[i.mesh].material]])
    everything = world_triangles(solid)
    for camera in scene.cameras:
        nearest, facing = first_hit(everything, camera.position, camera.forward)
        assert facing < 0 or (np.isinf(nearest) and not scene.environment.is_black), camera.name


@pytest.mark.parametrize("name", ["corridor", "two-rooms", "conference"])
def test_lamps_and_cameras_are_inside_closed_rooms(name, scenes):
    """Every ray from them meets a surface from its front: it is in the open, and the room is closed around it. The
    conference room has windows, through which rays leave sideways; none leaves steeply."""
    scene = scenes[name]
    everything = world_triangles(scene)
    places = {o.name: o.position for o in (*scene.lights, *scene.cameras) if hasattr(o, "position")}
    directions = sphere_directions(60)
    for what, place in places.items():
        for direction in directions if name != "conference" else directions[np.abs(directions[:, 1]) > 0.8]:
            distance, facing = first_hit(everything, place, direction)
            assert np.isfinite(distance) and facing < 0, (what, direction)


def test_the_dark_room_is_sealed(scenes):
    """Its shell is a closed surface, no ray from inside leaves it, and no light is in it."""
    scene = scenes["two-rooms"]
    shell = [m for m in scene.meshes if m.name in {f"dark room: {part}" for part in ("walls", "floor", "ceiling")}]
    edges = Counter(edge for mesh in shell for t in triangles(mesh) for edge in directed_edges(t))
    assert len(shell) == 3
    assert all(edges[b, a] == count for (a, b), count in edges.items())
    corners = np.concatenate([triangles(mesh) for mesh in shell])
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    everything = world_triangles(scene)
    for origin in (low + 0.05, (low + high) / 2.0, high - 0.05):
        for direction in sphere_directions(200):
            distance, _ = first_hit(everything, origin, direction)
            reached = origin + distance * direction
            assert (reached > low - 1e-5).all() and (reached < high + 1e-5).all()
    lamps = [np.array(light.position) for light in scene.lights] + [p for t in scene.tracks for p in t.values
                                                                    if t.target == "light"]
    assert not any((lamp > low).all() and (lamp < high).all() for lamp in lamps)


def test_the_wall_between_the_rooms_is_10_cm_thick(scenes):
    everything = world_triangles(scenes["two-rooms"])
    place = (0.0, 2.3, 1.9)  # inside the wall, where nothing hangs on it
    for direction in ((1.0, 0.0, 0.0), (-1.0, 0.0, 0.0)):
        distance, facing = first_hit(everything, place, direction)
        assert distance == pytest.approx(0.05, abs=1e-6)
        assert facing > 0  # from behind: the face looks into the room


def test_the_corridors_thin_wall_is_5_cm_thick_and_ends_in_the_bend(scenes):
    everything = world_triangles(scenes["corridor"])
    for z in (-2.35, 0.1, 2.5):
        for x in (1.0, -1.0):
            distance, facing = first_hit(everything, (0.0, 2.3, z), (x, 0.0, 0.0))
            assert distance == pytest.approx(0.025, abs=1e-6)
            assert facing > 0
    distance, _ = first_hit(everything, (-1.0, 2.3, -2.6), (1.0, 0.0, 0.0))
    assert distance > 2.5  # past the wall's edge, into the far side of the bend


def test_no_lamp_of_the_corridor_shines_into_the_far_limb(scenes):
    """From points of the far limb every lamp is hidden, wherever the animation has it."""
    scene = scenes["corridor"]
    everything = world_triangles(scene)
    lamps = [np.array(light.position) for light in scene.lights]
    lamps += [place for track in scene.tracks if track.target == "light" for place in track.values]
    rng = np.random.default_rng(1)
    for point in rng.uniform((0.1, 0.1, -2.35), (1.75, 2.4, 2.55), (40, 3)):
        for lamp in lamps:
            away = np.linalg.norm(lamp - point)
            assert first_hit(everything, point, (lamp - point) / away)[0] < away


def test_spheres_are_named_after_their_materials_and_do_not_touch(scenes):
    scene = scenes["spheres"]
    balls = [m for m in scene.meshes if m.name[-1].isdigit() and scene.materials[m.material].name == m.name]
    centres = np.array([m.positions.mean(axis=0) for m in balls])
    distances = np.linalg.norm(centres[:, None] - centres[None], axis=2) + np.eye(len(balls))
    assert len(balls) == 28
    assert distances.min() > 0.4  # two radii
    assert {scene.materials[m.material].roughness for m in balls} >= {0.05, 1.0}


def test_leaves_and_lattice_are_masked_and_seen_from_both_sides(scenes):
    scene = scenes["foliage"]
    masked = {i for i, m in enumerate(scene.materials) if m.alpha_mode == "mask"}
    assert all(scene.materials[i].double_sided for i in masked)
    for i in masked:
        covered = (scene.materials[i].base_color_texture.image.pixels[..., 3] > 127).mean()
        assert 0.25 < covered < 0.75, scene.materials[i].name
    quads = sum(len(scene.meshes[i.mesh].indices) // 2 for i in scene.instances
                if scene.meshes[i.mesh].material in masked)  # fmt: skip
    assert quads > 5_000


def test_the_robot_keeps_clear_of_what_stands_below_the_table(scenes):
    """Seen from above, its circle of 16 cm never meets another thing that is lower than it and stands on the floor."""
    scene = scenes["conference"]
    track = next(t for t in scene.tracks if t.name == "robot body")
    robot = scene.instances[[i.name for i in scene.instances].index("robot body")]
    low_parts = []
    for instance in scene.instances:
        if instance.name.startswith("robot") or instance.name in ("floor",):
            continue
        mesh = scene.meshes[instance.mesh]
        points = mesh.positions @ instance.transform[:3, :3].T + instance.transform[:3, 3]
        low_parts.append(points[(points[:, 1] < 0.098) & (points[:, 1] > -0.01)])
    standing = np.concatenate(low_parts)[:, [0, 2]]
    for way in track.values:
        centre = (robot.transform[:3, 3] + way)[[0, 2]]
        assert np.linalg.norm(standing - centre, axis=1).min() > 0.16


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


@pytest.mark.parametrize("name", BUILTIN)
def test_builtin_scenes_are_built_in_time(name):
    """Processor time, which other processes do not add to; the slowest takes about 0.3 s."""
    start = time.process_time()
    BUILTIN[name]()
    assert time.process_time() - start < 4.0


def test_atrium_sun_reaches_floor_wall_and_a_curtain_but_not_the_shade_side():
    scene = BUILTIN["atrium"]()
    to_sun = -np.array(scene.lights[0].direction)
    everything = np.concatenate([triangles(scene.meshes[i.mesh]) for i in scene.instances])
    cloth = next(m for m in scene.meshes if m.name == "curtain 2 (sun)")
    front = triangles(cloth).mean(axis=(0, 1))

    def lit(point) -> bool:
        return not np.isfinite(first_hit(everything, np.array(point, dtype=np.float64), to_sun)[0])

    assert lit((3.75, 0.01, 2.5)), "floor"
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
