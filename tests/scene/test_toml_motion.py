"""Keyframes and clips of TOML scenes."""

from __future__ import annotations

import numpy as np
import pytest
from figures import POSITIONS, add_animation, add_strip
from toml_files import LAMP, load_text

from octolux.scene.errors import SceneError

pytestmark = pytest.mark.covers("model .toml")

FLIGHT = """
[[camera]]
name = "eye"
position = [0, 1, 5]
look_at = [0, 1, 0]
[[keyframes]]
target = "camera:eye"
property = "{key}"
times = [0, 1, 2, 4]
values = [[0, 0, 9], [1, 0, 9], [4, 0, 9], [0, 0, 9]]
{more}
"""
SLIDES = (("left", -1.0), ("right", 1.0))


@pytest.fixture
def figure(gltf):
    """fig.gltf: the strip, with two clips that slide it along x by 1 m in 1 s, one to each side."""
    add_strip(gltf)
    for name, way in SLIDES:
        add_animation(gltf, 1, "translation", [0, 1, 2], [(0, 0, 0), (way, 0, 0), (way, 0, 0)], name=name)
    return gltf.write("fig.gltf").parent


@pytest.mark.parametrize(("kind", "expected"), [("linear", 2.5), ("step", 1.0), ("smooth", None)])
def test_a_camera_path_between_its_keys(tmp_path, kind, expected):
    scene = load_text(tmp_path, FLIGHT.format(key="position", more=f'interpolation = "{kind}"'))
    (track,) = scene.tracks
    (camera,) = scene.at(1.5).cameras
    # Smooth: slopes 2 at time 1 and (3 * 2 - 2 * 1) / 3 at time 2, of which a cubic's middle takes an eighth.
    expected = 2.5 + (2 - 4 / 3) / 8 if expected is None else expected
    np.testing.assert_allclose(camera.position, (expected, 0, 9), atol=1e-12)
    assert (track.interpolation, track.period, scene.duration) == (kind, None, 4.0)


def test_what_the_camera_looks_at_may_run_smoothly_too(tmp_path):
    scene = load_text(tmp_path, FLIGHT.format(key="look_at", more='interpolation = "smooth"'))
    aim = np.array([2.5 + 1 / 12, 0, 9]) - (0, 1, 5)
    np.testing.assert_allclose(scene.at(1.5).cameras[0].forward, aim / np.linalg.norm(aim), atol=1e-12)


def test_a_path_that_loops_begins_again(tmp_path):
    scene = load_text(tmp_path, FLIGHT.format(key="position", more="loop = true"))
    np.testing.assert_array_equal(scene.at(4.5).cameras[0].position, scene.at(0.5).cameras[0].position)
    np.testing.assert_array_equal(scene.at(4.5).cameras[0].position, (0.5, 0, 9))


def test_light_that_a_spline_makes_negative_is_none(tmp_path):
    scene = load_text(tmp_path, LAMP + """
[[keyframes]]
target = "light:lamp"
property = "intensity"
interpolation = "smooth"
times = [0, 1, 2, 3]
values = [[8, 8, 8], [0, 0, 0], [0, 0, 0], [8, 8, 8]]
""")
    assert scene.tracks[0].at(1.5)[0] < 0
    assert scene.at(1.5).lights[0].intensity == (0.0, 0.0, 0.0)


@pytest.mark.covers("model .toml", broken=True)
@pytest.mark.parametrize(("more", "problem"), [
    ('interpolation = "cubic"', "is 'cubic'"),
    ("interpolation = 3", "must be text"),
    ("loop = 1", "must be true or false"),
    ("times = [-4, -3, -2, 0]\nloop = true", "the last time is 0"),
])  # fmt: skip
def test_mistakes_in_keyframes(tmp_path, more, problem):
    text = FLIGHT.format(key="position", more=more)
    if "times" in more:
        text = text.replace("times = [0, 1, 2, 4]\n", "", 1)
    with pytest.raises(SceneError) as caught:
        load_text(tmp_path, text)
    assert caught.value.place == "[[keyframes]] 1: " + more.split("\n")[-1].split(" ")[0]
    assert problem in caught.value.problem


@pytest.mark.parametrize(("chosen", "way"), [("", -1.0), ('[animation]\nclip = "right"', 1.0)])
def test_the_clip_that_plays(figure, chosen, way):
    scene = load_text(figure, f'[[model]]\nfile = "fig.gltf"\ntranslate = [0, 0, 5]\nscale = 2\n{chosen}\n')
    assert sorted(scene.clips) == ["left", "right"]
    mesh, instance = scene.at(0.5).meshes[0], scene.instances[0]
    positions = mesh.positions @ instance.transform[:3, :3].T + instance.transform[:3, 3]
    np.testing.assert_allclose(positions, 2 * (POSITIONS + np.array([way / 2, 0, 0])) + [0, 0, 5], atol=1e-5)


def test_each_model_may_play_its_own(figure):
    models = [f'[[model]]\nfile = "fig.gltf"\nclip = "{name}"\n' for name, _ in SLIDES]
    scene = load_text(figure, "\n".join(models))
    assert scene.clips == []
    for mesh, (_, way) in zip(scene.at(0.5).meshes, SLIDES, strict=True):
        np.testing.assert_allclose(mesh.positions, POSITIONS + np.array([way / 2, 0, 0]), atol=1e-5)


def test_keyframes_act_after_the_animation(figure):
    scene = load_text(figure, """
[[model]]
file = "fig.gltf"
[[keyframes]]
target = "instance:figure"
property = "scale"
times = [0]
values = [[3, 3, 3]]
""")
    low, high = scene.at(0.5).bounds()
    np.testing.assert_allclose([low[0], high[0]], [-3, 0], atol=1e-5)


@pytest.mark.covers("model .toml", broken=True)
@pytest.mark.parametrize(("text", "place"), [
    ('[[model]]\nfile = "fig.gltf"\n[animation]\nclip = "run"', "[animation]: clip"),
    ('[[model]]\nfile = "fig.gltf"\n[animation]\nspeed = 2', "[animation]: speed"),
    ('[[model]]\nfile = "fig.gltf"\nclip = "run"', "[[model]] 1: clip"),
    ('[[model]]\nfile = "fig.gltf"\n[[keyframes]]\ntarget = "node:upper"\nproperty = "scale"\ntimes = [0]\n'
     "values = [[1, 1, 1]]", "[[keyframes]] 1: target"),
])  # fmt: skip
def test_mistakes_in_clips(figure, text, place):
    with pytest.raises(SceneError) as caught:
        load_text(figure, text)
    assert caught.value.place == place
    assert "left" in caught.value.remedy or place != "[animation]: clip"
