"""The comparison as data: what is measured, against what, and in which words."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest
from comparisons import LPV, SIZE
from gpu_tools import small_settings

import octolux
from octolux.compare import compare
from octolux.compare.choices import choice
from octolux.compare.limits import METRICS, exceeded, limit
from octolux.compare.rendering import Studio
from octolux.scene.errors import OctoluxError

BOX = octolux.load("cornell-box")


def small(scene, techniques=(), reference="none", **rest):
    words = {"size": SIZE, "frames": 1, "frame_settings": small_settings()} | rest
    return compare(scene, techniques, reference, **words)


def test_a_technique_against_itself_has_no_error(device):
    """The same bits in every run: every figure is that of equal pictures."""
    name = "constant,red=2"
    entry = small(BOX, [name], name, device=device)[name]
    for layer in ("final", "indirect"):
        assert entry.metrics[layer].pop("flip") in (0.0, None)
        equal = {"ratio": 1.0, "relative_rmse": 0.0, "trimmed_relative_rmse": 0.0, "ssim": 1.0}
        assert entry.metrics[layer] == pytest.approx(equal, abs=1e-12)


def test_baselines_are_in_every_report(report):
    assert [entry.label for entry in report.entries] == [LPV, "constant", "black"]
    assert [entry.baseline for entry in report.entries] == [False, True, True]
    black = report["black"]
    assert not black.pictures["indirect"].any()
    assert black.metrics["indirect"]["relative_rmse"] > 1.0  # the root of a mean square is above the mean
    assert black.energy == 0.0


def test_the_constant_has_the_references_energy_in_each_channel(report):
    """Albedos are stored in 16 bits and shaded in float32, so the means agree to about 1e-5."""
    constant, mask = report["constant"], report["constant"].mask
    for channel in range(3):
        ours = constant.pictures["indirect"][..., channel][mask].mean(dtype=np.float64)
        theirs = report.reference.pictures["indirect"][..., channel][mask].mean(dtype=np.float64)
        assert ours == pytest.approx(theirs, rel=1e-4)
    assert constant.energy == pytest.approx(1.0, rel=1e-4)
    # It is no better than the best constant error: that of the picture's own spread.
    assert 0.0 < constant.metrics["indirect"]["relative_rmse"] < report["black"].metrics["indirect"]["relative_rmse"]


def test_a_known_constant_is_found_again(device):
    """The fitted irradiance of a reference that is constant is that constant, and its error is none; twice the light
    has twice the energy and, for any picture, an error of at least its mean."""
    twice = "constant,red=4,green=6,blue=8"
    found = small(BOX, ["none", twice], "constant,red=2,green=3,blue=4", device=device)
    values = found["constant"].choice.settings
    assert [values.red, values.green, values.blue] == pytest.approx([2.0, 3.0, 4.0], rel=1e-4)
    assert found["constant"].metrics["indirect"]["relative_rmse"] < 1e-4
    assert found["none"].metrics == found["black"].metrics
    assert found[twice].energy == pytest.approx(2.0, rel=1e-6)
    assert found[twice].metrics["indirect"]["relative_rmse"] >= 1.0


def test_a_reference_with_seeds_is_rendered_in_two_halves(device, dice):
    """E[(x - A)(x - B)] of constants x = 1, A and B is exactly (1 - A)(1 - B) mean(albedo^2) / pi^2."""
    found = small(BOX, ["constant,red=1"], "dice,seed=3", reference_samples=9, device=device)
    assert dice.thrown == [(5, 3), (5, 4)]  # half of nine, rounded up, with neighbouring seeds
    known = found.reference
    assert known.noise_free and found.facts["reference"]["noise_free"]
    a, b = known.halves["indirect"]
    assert not np.array_equal(a, b)
    np.testing.assert_allclose(known.pictures["indirect"], 0.5 * (a + b), rtol=1e-6, atol=1e-9)
    noise = found.facts["reference"]["noise"]["indirect"]
    mask = found.entries[0].mask
    assert noise == pytest.approx(
        0.5 * np.sqrt(np.mean(np.square(a - b)[mask].astype(float))) / known.pictures["indirect"][mask].mean(), rel=1e-4
    )
    x = found.entries[0].pictures["indirect"]
    product = ((x - a) * (x - b))[mask].mean(dtype=np.float64)
    wanted = np.sqrt(max(0.0, product)) / known.pictures["indirect"][mask].mean(dtype=np.float64)
    assert found.entries[0].metrics["indirect"]["relative_rmse"] == pytest.approx(wanted, rel=1e-4, abs=1e-9)


def test_techniques_that_draw_samples_are_compared_when_asked_for(device, dice):
    found = small(BOX, ["dice,samples=4"], device=device)
    assert found.entries[0].statistics["frames"] == 1
    assert dice.thrown == [(4, 0)]
    assert "dice" not in [entry.technique for entry in map(choice, ("uniform-lpv",))]


def test_samples_are_for_references_that_draw_them(device, tmp_path):
    with pytest.raises(OctoluxError, match="draws no samples"):
        small(BOX, ["none"], "constant", reference_samples=4, device=device)


def test_frames_are_timed(report):
    entry = report[LPV].data()
    assert entry["frames"] == 2
    assert {stage["name"] for stage in entry["stages"]} >= {"visibility", "propagation", "composite"}
    assert all(stage["count"] == 2 for stage in entry["stages"])
    assert entry["frame_ms"]["median"] > 0.0
    assert entry["memory_bytes"]["total"] > entry["technique_bytes"] > 0
    assert report["black"].data()["technique_bytes"] == 0


def test_the_data_is_plain_json_without_nan(report):
    text = json.dumps(report.data, allow_nan=False)
    data = json.loads(text)
    assert data["scene"] == BOX.name
    assert data["size"] == list(SIZE)
    assert data["camera"] == BOX.cameras[0].name
    assert data["reference"]["technique"] == "uniform-lpv"
    assert data["techniques"][0]["settings"]["n"] == 16
    assert data["exposure_ev100"] == BOX.exposure


def test_one_exposure_for_all(device):
    """Without one, that which the first technique is metered with."""
    scene = replace(BOX, exposure=None)
    studio = Studio(scene, device, SIZE, frame_settings=small_settings())
    studio.settle_exposure(choice("constant"))
    assert studio.exposure == studio.renderer(choice("constant")).exposure
    settings = {"size": SIZE, "device": device, "frame_settings": small_settings()}
    assert studio.exposure == octolux.Renderer(scene, "constant", **settings).meter()
    given = Studio(BOX, device, SIZE, exposure=3.0)
    given.settle_exposure(choice("constant"))
    assert given.exposure == 3.0


def test_a_sealed_room_leaks_what_a_constant_brings(device):
    """Nothing but a leak can light the dark room, whose reference is black: then no ratio can be told either."""
    scene = octolux.load("two-rooms")
    found = small(scene, ["uniform-lpv,n=16"], "none", camera="dark", device=device)
    assert found.facts["lit_level_nits"] > 1.0  # from the lit room's cameras: this one sees no light at all
    black, lpv = found["black"], found.entries[0]
    # The coarse shadow maps of tests let light through at a few pixels of an edge.
    assert black.leak.score == 0.0 and black.leak.dark_share > 0.95
    assert black.energy is None
    assert 0.0 < lpv.leak.score <= 1.0
    assert lpv.leak.mean > 0.0


def test_an_unlit_scene_has_no_leak_score(device):
    found = small(replace(BOX, lights=[]), ["none"], device=device, default_light=False)
    assert found.facts["lit_level_nits"] is None
    assert found.entries[0].leak.score is None
    assert json.dumps(found.data, allow_nan=False)


def test_limits_that_hold_and_that_do_not(report):
    ratio = report[LPV].energy
    assert exceeded(report, [limit(f"{metric}=1e9") for metric in METRICS if metric not in ("leak", "flip")]) == []
    below = limit(f"energy_error={abs(ratio - 1) / 2}")
    assert len(exceeded(report, [below])) == 1  # not the baselines, which are not asked for
    assert LPV in exceeded(report, [below])[0]
    assert exceeded(report, [limit("black:energy_error=0.9")]) == ["black: energy_error is 1 (black:energy_error=0.9)"]
    assert exceeded(report, [limit(f"uniform-lpv:frame_ms={report[LPV].statistics['frame_ms']['median']}")]) == []


def test_what_cannot_be_told_does_not_hold(report):
    """The Cornell box as a reference has dark pixels or not; a leak score of None is no pass."""
    unknown = replace(report.entries[0], leak=report.entries[0].leak._replace(score=None))
    phrases = exceeded(replace(report, entries=[unknown]), [limit("leak=1")])
    assert len(phrases) == 1 and "cannot be told" in phrases[0]


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ({"techniques": ["nothing"]}, "'nothing'"), ({"reference": "path-tracr"}, "'path-tracr'"),
        ({"size": (10, 40)}, "11x11"), ({"frames": 0}, "not 0"), ({"camera": "nowhere"}, "'nowhere'"),
    ],
)  # fmt: skip
def test_wrong_words(device, words, says):
    with pytest.raises(OctoluxError, match=says):
        small(BOX, **{"device": device, "techniques": ["none"]} | words)


def test_pictures_that_are_not_finite_are_an_error(device, monkeypatch):
    from octolux.compare import rendering

    real = rendering._rendering

    def broken(picture, statistics):
        found = real(picture, statistics)
        found.pictures["indirect"][3, 4, 1] = np.nan
        return found

    monkeypatch.setattr(rendering, "_rendering", broken)
    with pytest.raises(OctoluxError, match=r"black: 1 pixels of 'indirect' are not finite"):
        small(BOX, ["none"], device=device)
