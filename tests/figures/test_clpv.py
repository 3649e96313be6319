"""Measurements of CLPV: what an onlooker reads, what counts as a change or a jump, the table, a figure's colours."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import octolux
from benchmarks import clpv_stability, clpv_table1
from benchmarks.clpv_motion import cell_sizes, moving_lamp, second_differences, table_top
from benchmarks.clpv_peeling import found_and_more
from benchmarks.clpv_peeling import turn as turn_around
from benchmarks.clpv_stability import Change, measured_steps, shares, slide, summary, turn
from benchmarks.clpv_stability import Path as Way
from benchmarks.onlooker import Onlooker
from octolux.scene.cameras import Camera
from octolux.techniques.lpv.cascaded.settings import CascadedLpvSettings

SIZE = (48, 27)
DEFAULT = CascadedLpvSettings()


def test_what_is_found_of_what_blocks():
    every = np.array([1.0, 0.5, 0.5, 0.0])
    assert found_and_more(every, every) == (1.0, 0.0)
    assert found_and_more(np.array([0.5, 0.5, 1.0, 0.1]), every) == (0.75, 0.3)
    assert found_and_more(0.0 * every, every) == (0.0, 0.0)


def test_a_turn_looks_all_around():
    eye = Camera.look_at((1.0, 2.0, 3.0), (3.0, 2.5, 4.0), vertical_fov=0.8)
    cameras = list(turn_around(eye))
    angles = [np.arctan2(camera.forward[2], camera.forward[0]) for camera in cameras]
    steps = np.diff([np.arctan2(eye.forward[2], eye.forward[0]), *angles])
    np.testing.assert_allclose(np.abs((steps + np.pi) % (2 * np.pi) - np.pi), 2 * np.pi / len(cameras))
    np.testing.assert_allclose(cameras[-1].transform, eye.transform, atol=1e-12)
    assert all(camera.vertical_fov == eye.vertical_fov for camera in cameras)
    end = list(turn_around(eye, 10, 6.0))[-1]
    np.testing.assert_allclose(end.position - eye.position, 6.0 * eye.forward * (1.0, 0.0, 1.0), atol=1e-12)
    np.testing.assert_allclose(end.forward, eye.forward, atol=1e-12)


@pytest.mark.parametrize("text", ["uniform-lpv", "cascaded-lpv:default,bounces=1"])
def test_the_onlooker_reads_what_the_viewer_sees(text):
    """Where both are one camera, the light is the picture's own."""
    scene = octolux.load("cornell-box")
    onlooker = Onlooker(scene, text, scene.cameras[0], SIZE)
    light, seen = onlooker.light(scene.cameras[0])
    picture = onlooker.renderer.render(scene.cameras[0])
    own = picture.layers["irradiance"][picture.mask].mean(axis=-1)
    assert seen.mean() > 0.5
    assert np.abs(light - own).max() <= 1e-5 * own.mean()


def test_what_the_viewer_does_not_see_is_said():
    scene = octolux.load("cornell-box")
    eye = scene.cameras[0]
    onlooker = Onlooker(scene, "uniform-lpv", eye, SIZE)
    backwards = Camera.look_at(eye.position, eye.position - eye.forward, vertical_fov=eye.vertical_fov)
    assert not onlooker.light(backwards)[1].any()


@pytest.mark.parametrize("path_of", [slide, turn])
def test_windows_move_on_the_path(path_of):
    """Each cascade but the last moves at least once, and every such step is measured."""
    windows = path_of(DEFAULT).windows(DEFAULT)
    steps = measured_steps(windows)
    for number in range(DEFAULT.cascades - 1):
        moved = [k for k in range(len(windows) - 1) if windows[k][number].origin != windows[k + 1][number].origin]
        assert moved and set(moved) <= set(steps)


def test_a_step_is_a_tenth_of_a_cell():
    viewers = slide(DEFAULT).viewers
    step = np.linalg.norm(viewers[1].position - viewers[0].position)
    assert step == pytest.approx(0.1 * cell_sizes(clpv_stability.atrium())[0])


def test_shares_sum_to_one():
    path: Way = slide(DEFAULT)
    points = np.random.default_rng(1).uniform(-6.0, 6.0, (500, 3))
    found = shares(clpv_stability.Points(points, points * 0, points * 0), path.windows(DEFAULT)[0], DEFAULT)
    assert found.shape == (DEFAULT.cascades, 500)
    assert np.allclose(found.sum(axis=0), 1.0)


def test_summary():
    change = Change(np.array([0.0, 0.1, 0.5]), np.array([False, False, True]), (0,))
    found = summary([change, replace(change, moved=())])
    assert found["within_max"] == 0.1 and found["across_max"] == 0.5
    assert found["steps"] == 2 and found["windows_moved"] == 1


def test_a_jump_shows_in_full_and_smooth_light_hardly():
    """Light that falls off with the square of 1.7 m in steps of 1.7 cm: 6 (1 / 100)^2 = 0.06 %."""
    counted = np.ones((1, 1), bool)
    smooth = [np.full((1, 1), (1.7 + 0.017 * k) ** -2.0) for k in range(10)]
    assert second_differences(smooth, counted).max() < 6.5e-4
    jump = [light * (1.1 if k > 4 else 1.0) for k, light in enumerate(smooth)]
    assert second_differences(jump, counted).max() == pytest.approx(0.1, rel=0.05)


def test_what_moves_moves_by_a_tenth_of_a_cell():
    places = np.array([scene.lights[0].position for scene in moving_lamp()])
    assert np.allclose(np.diff(places[:, 0]), 0.1 * cell_sizes(clpv_stability.atrium())[0])
    for cascade in (0, DEFAULT.cascades - 1):
        frames = table_top(cascade)
        size = cell_sizes(frames[0])[cascade]
        places = np.array([scene.instances[-1].transform[:3, 3] for scene in frames])
        assert np.allclose(np.linalg.norm(np.diff(places, axis=0), axis=1), 0.1 * size)
        low, high = frames[0].meshes[-1].positions.min(axis=0), frames[0].meshes[-1].positions.max(axis=0)
        assert (high - low).max() == pytest.approx(0.5 * size, rel=0.01)


def test_table_1():
    """Every row of the paper is timed with occlusion, by steps and by gathering; the total is theirs."""
    texts = [clpv_table1.COLUMNS[f"{preset}, 3 x 32^3, bounces"] for preset in ("paper", "default")]
    found = clpv_table1.measured(clpv_table1.base_scene("atrium"), "hall", texts, 2, (32, 18))
    for frames in found.values():
        times = clpv_table1.medians(frames)
        assert set(clpv_table1.ROWS) <= set(times)
        assert times[clpv_table1.TOTAL] <= times[clpv_table1.FRAME]
    lines = clpv_table1.rows({"ours": clpv_table1.medians(found[texts[0]])})
    assert {len(line) for line in lines} == {len(lines[0])}
    assert [line[0] for line in lines[2:]] == [f"CLPV on a GTX285: {kind}" for kind in clpv_table1._KINDS]


def test_colours_of_the_signed_difference(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).resolve().parents[2] / "scripts"))
    import clpv_figures

    truth = np.ones((clpv_figures.BLOCK, 2 * clpv_figures.BLOCK, 3))
    found = truth.copy()
    found[:, : clpv_figures.BLOCK] = 1.5
    found[:, clpv_figures.BLOCK :] = 0.5
    picture = clpv_figures.signed(found, truth, np.ones(truth.shape[:2], bool))
    assert picture[0, 0].tolist() == [0, 128, 0]  # too bright: green
    assert picture[0, -1].tolist() == [128, 0, 0]
    sys.modules.pop("clpv_figures")
