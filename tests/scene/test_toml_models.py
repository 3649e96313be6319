"""[[model]] tables: where models come from, where they stand and what of them is used."""

from __future__ import annotations

import numpy as np
import pytest
from toml_files import model

from octolux.scene.builtin import BUILTIN
from octolux.scene.toml.loader import load_toml

pytestmark = pytest.mark.covers("model .toml")


def world_vertex(scene) -> np.ndarray:
    """Where the model's last vertex, (0, 2, 3) in its file, ends up."""
    far = next(i for i in scene.instances if i.name == "far")
    positions = scene.meshes[far.mesh].positions
    vertex = positions[(positions == [0, 2, 3]).all(axis=1)][0]
    return far.transform[:3, :3] @ vertex + far.transform[:3, 3]


@pytest.mark.parametrize(("keys", "expected"), [
    ("", (0, 2, 3)),
    ('unit = "m"', (0, 2, 3)),
    ('unit = "cm"', (0, 0.02, 0.03)),
    ('unit = "mm"', (0, 0.002, 0.003)),
    ('unit = "in"', (0, 0.0508, 0.0762)),
    ('unit = "ft"', (0, 0.6096, 0.9144)),
    ("unit = 2.5", (0, 5, 7.5)),
    ('up = "z"', (0, 3, -2)),
    ("scale = 2", (0, 4, 6)),
    ("scale = [1, 10, 100]", (0, 20, 300)),
    ("translate = [1, 2, 3]", (1, 4, 6)),
    ("rotate = [90, 0, 0]", (0, -3, 2)),
    ("rotate = [0, 90, 0]", (3, 2, 0)),
    ("rotate = [0, 0, 90]", (-2, 0, 3)),
    ("rotate = [90, 90, 0]", (2, -3, 0)),
    ("rotate = { axis = [0, 0, 5], degrees = 90 }", (-2, 0, 3)),
    ('unit = "cm"\nup = "z"\nscale = 10\nrotate = [0, 90, 0]\ntranslate = [1, 0, 0]', (0.8, 0.3, 0)),
    ("matrix = [[0, 1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]]", (7, 6, 13)),
    ('unit = "cm"\nmatrix = [[0, 1, 0, 5], [1, 0, 0, 6], [0, 0, 2, 7], [0, 0, 0, 1]]', (5.02, 6, 7.06)),
])  # fmt: skip
def test_models_are_placed(toml, keys, expected):
    np.testing.assert_allclose(world_vertex(toml(model(keys))), expected, atol=1e-7)


@pytest.mark.parametrize("pattern", ["near", "oak", "n*", "o?k", "[n]ear"])
def test_drop_by_group_or_material_removes_mesh_and_material(toml, pattern):
    scene = toml(model(f'drop = ["{pattern}"]'))
    assert [i.name for i in scene.instances] == ["far"]
    assert [m.name for m in scene.materials] == ["pine"]
    assert scene.meshes[scene.instances[0].mesh].material == 0
    assert scene.triangle_count == 1


def test_flat_normals_are_those_of_the_faces(toml):
    files_own, flat = toml(model()), toml(model('normals = "flat"'))
    # All vertices of the file have the normal (0, 0, 1); its second face leans.
    assert all((m.normals == [0, 0, 1]).all() for m in files_own.meshes)
    far = next(m for m in flat.meshes if m.name == "far")
    expected = np.cross([1, 2, 0], [0, 2, 3]) / np.linalg.norm(np.cross([1, 2, 0], [0, 2, 3]))
    np.testing.assert_allclose(far.normals, np.tile(expected, (3, 1)), atol=1e-6)


def test_flat_normals_give_each_triangle_its_own_vertices(tmp_path):
    (tmp_path / "s.toml").write_text('[[model]]\nfile = "cornell-box"\nnormals = "flat"\n')
    for mesh in load_toml(tmp_path / "s.toml").meshes:
        assert len(np.unique(mesh.indices)) == mesh.indices.size == len(mesh.positions)


def test_textures_can_be_left_out(toml):
    assert all(m.base_color_texture is not None for m in toml(model()).materials)
    assert all(m.base_color_texture is None for m in toml(model("textures = false")).materials)


def test_a_model_brings_its_lights_cameras_tracks_environment_and_exposure(toml):
    scene, atrium = toml('[[model]]\nfile = "atrium"\n'), BUILTIN["atrium"]()
    assert scene.triangle_count == atrium.triangle_count
    assert [light.name for light in scene.lights] == ["sun"]
    assert [c.name for c in scene.cameras] == ["hall", "gallery"]
    assert [t.name for t in scene.tracks] == ["sun"]
    assert (scene.environment.radiance, scene.exposure) == (atrium.environment.radiance, atrium.exposure)


def test_a_models_lights_and_cameras_can_be_left_out_and_its_sky_replaced(toml):
    scene = toml('exposure = 3\n[environment]\nradiance = 0\n[[model]]\nfile = "atrium"\nlights = false\n'
                 "cameras = false\n")
    assert (scene.lights, scene.cameras, scene.tracks) == ([], [], [])
    assert (scene.exposure, scene.environment.radiance) == (3.0, (0.0, 0.0, 0.0))


def test_a_models_lights_cameras_and_tracks_move_with_it(toml):
    scene = toml('[[model]]\nfile = "cornell-box"\nrotate = [0, 90, 0]\nscale = 2\ntranslate = [10, 0, 0]\n')
    own = BUILTIN["cornell-box"]()

    def moved(point) -> np.ndarray:
        x, y, z = point
        return np.array([10.0 + 2 * z, 2 * y, -2 * x])

    np.testing.assert_allclose(scene.lights[0].position, moved(own.lights[0].position), atol=1e-12)
    np.testing.assert_allclose(scene.at(1.0).lights[0].position, moved(own.at(1.0).lights[0].position), atol=1e-12)
    np.testing.assert_allclose(scene.cameras[0].position, moved(own.cameras[0].position), atol=1e-12)
    np.testing.assert_allclose(scene.cameras[0].forward, [-1.0, 0.0, 0.0], atol=1e-12)
    assert scene.lights[0].intensity == own.lights[0].intensity
    assert scene.cameras[0].near == pytest.approx(2 * own.cameras[0].near)


def test_a_mirrored_area_light_still_shines_into_the_mirrored_scene(toml, tmp_path):
    (tmp_path / "lit.toml").write_text(
        '[[light]]\ntype = "area"\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nradiance = 1\n'
    )
    (light,) = toml('[[model]]\nfile = "lit.toml"\nscale = [-1, 1, 1]\n').lights
    a, b, _, d = (np.array(c) for c in light.corners)
    assert np.cross(b - a, d - a)[2] > 0  # towards +z, as before: x was mirrored


def test_scenes_include_scenes_and_materials_keep_to_their_models(toml, tmp_path):
    (tmp_path / "inner.toml").write_text('[[model]]\nfile = "cornell-box"\ntranslate = [5, 0, 0]\n')
    scene = toml('[[model]]\nfile = "inner.toml"\n' + model())
    assert scene.triangle_count == 34 + 2
    by_name = {i.name: scene.materials[scene.meshes[i.mesh].material].name for i in scene.instances}
    assert (by_name["left wall"], by_name["near"], by_name["far"]) == ("red", "oak", "pine")


def test_data_files_are_found_in_the_data_folder(toml, tmp_path, monkeypatch):
    (tmp_path / "data" / "scenes" / "deep").mkdir(parents=True)
    (tmp_path / "data" / "scenes" / "deep" / "m.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path / "data"))
    assert toml('[[model]]\nfile = "data:deep/m.obj"\n').triangle_count == 1
