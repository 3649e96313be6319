"""Scenes in TOML: materials, lights, cameras and keyframes. What is refused is in test_toml_errors.py."""

from __future__ import annotations

from math import radians

import numpy as np
import pytest
from toml_files import LAMP, SPOT, SUN, model

from octolux.scene.load import load_scene

pytestmark = pytest.mark.covers("model .toml")


def test_materials_are_overridden_by_name_and_glob_in_order(toml):
    scene = toml(model() + """
[[material]]
name = "*"
base_color = 0.25
specular = 0
emissive = [1, 2, 3]
metallic = 0.5
roughness = 0.75
alpha = 0.5
normal_scale = 2
alpha_mode = "mask"
alpha_cutoff = 0.3
double_sided = false
textures = false
[[material]]
name = "oak"
base_color = [0.1, 0.2, 0.3]
""")
    oak, pine = (next(m for m in scene.materials if m.name == name) for name in ("oak", "pine"))
    assert oak.base_color == (0.1, 0.2, 0.3)
    assert pine.base_color == (0.25, 0.25, 0.25)
    for m in (oak, pine):
        assert (m.specular, m.emissive, m.metallic, m.roughness) == (0.0, (1.0, 2.0, 3.0), 0.5, 0.75)
        assert (m.alpha, m.normal_scale, m.alpha_mode, m.alpha_cutoff) == (0.5, 2.0, "mask", 0.3)
        assert m.double_sided is False
        assert m.base_color_texture is None


def test_an_override_leaves_alone_what_it_does_not_name(toml):
    before = {m.name: m for m in toml(model()).materials}
    after = {m.name: m for m in toml(model() + '[[material]]\nname = "oak"\nroughness = 0.1\n').materials}
    assert after["oak"].roughness == 0.1
    assert after["oak"].base_color == before["oak"].base_color
    assert after["oak"].base_color_texture is not None
    assert after["pine"].roughness == before["pine"].roughness


def test_lights_of_all_types(toml):
    unnamed = LAMP.replace('name = "lamp"\n', "").replace("[0, 0, 0]", "[1, 2, 3]")
    scene = toml(SUN + unnamed + SPOT + """
[[light]]
type = "area"
name = "panel"
corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]
radiance = [17, 12, 4]
""")
    sun, lamp, spot, panel = scene.lights
    assert (sun.direction, sun.illuminance, sun.name) == ((0.0, -2.0, 0.0), (3.0, 2.0, 1.0), "sun")
    assert (lamp.position, lamp.intensity, lamp.name) == ((1.0, 2.0, 3.0), (1.0, 1.0, 1.0), "light 2")
    assert (spot.inner_angle, spot.outer_angle) == pytest.approx((radians(20), radians(30)))
    assert panel.corners == ((0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.0, 1.0, 0.0))
    assert panel.radiance == (17.0, 12.0, 4.0)


def test_cameras_environment_and_exposure(toml):
    scene = toml("""
name = "hall"
exposure = 12.5
[environment]
radiance = [1, 2, 3]
[[camera]]
name = "eye"
position = [0, 0, 5]
look_at = [0, 0, 0]
up = [1, 0, 0]
vertical_fov = 60
near = 0.5
[[camera]]
position = [1, 1, 1]
look_at = [0, 0, 0]
orthographic_height = 4
""")
    eye, plan = scene.cameras
    # Columns: right, up, backward, position.
    np.testing.assert_allclose(eye.transform[:3], [[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 1, 5]], atol=1e-12)
    assert (eye.name, eye.vertical_fov, eye.near) == ("eye", pytest.approx(radians(60)), 0.5)
    assert (plan.name, plan.orthographic_height) == ("camera 2", 4.0)
    assert (scene.name, scene.exposure, scene.environment.radiance) == ("hall", 12.5, (1.0, 2.0, 3.0))


def test_keyframes_become_tracks_that_move_the_light(toml):
    scene = toml(LAMP + """
[[keyframes]]
target = "light:lamp"
property = "position"
times = [0, 4]
values = [[0, 0, 0], [8, 0, 0]]
""")
    assert scene.at(1.0).lights[0].position == (2.0, 0.0, 0.0)


def test_rotation_keyframes_are_brought_to_unit_length(toml):
    scene = toml(model() + """
[[keyframes]]
target = "instance:near"
property = "rotation"
times = [0]
values = [[0, 3, 0, 3]]
""")
    np.testing.assert_allclose(scene.tracks[0].values, [[0, 0.5**0.5, 0, 0.5**0.5]])


def test_load_scene_reads_toml_and_names_it_after_the_file(toml, tmp_path):
    (tmp_path / "yard.toml").write_text('[[model]]\nfile = "furnace"\n')
    assert load_scene(tmp_path / "yard.toml").name == "yard"
