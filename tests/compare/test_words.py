"""What techniques, references and limits are called."""

from __future__ import annotations

from pathlib import Path

import pytest

from octolux.compare.choices import choice, choices, reference_file
from octolux.compare.limits import METRICS, check_labels, limit
from octolux.compare.rendering import black
from octolux.scene.errors import OctoluxError


def test_a_technique_with_preset_and_settings():
    plain, paper, both = map(choice, ("uniform-lpv", "uniform-lpv:paper", "uniform-lpv:paper,n=64,iterations=8"))
    assert (plain.technique, plain.preset, plain.label) == ("uniform-lpv", "default", "uniform-lpv")
    assert paper.settings == type(paper.settings).from_strings("paper")
    assert both.settings == type(paper.settings).from_strings("paper", {"n": "64", "iterations": "8"})
    assert choice("uniform-lpv,n=64").settings.as_dict()["n"] == 64


def test_a_path_tracer_as_the_reference_sees_what_the_others_see():
    """Through the middle of the pixel, unless something else is asked for."""
    assert choice("path-tracer", as_reference=True).preset == "reference"
    assert choice("path-tracer,samples=4", as_reference=True).settings.as_dict()["pixel"] == "centre"
    assert choice("path-tracer:default", as_reference=True).settings == choice("path-tracer").settings
    assert choice("uniform-lpv", as_reference=True).preset == "default"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("unifrom-lpv", "'uniform-lpv'"), ("constant,gren=3", "'green'"),
        ("uniform-lpv:thsis", "'thesis'"),
        ("uniform-lpv,itrations=3", "'iterations'"),
        ("uniform-lpv,n", "KEY=VALUE"), ("uniform-lpv:paper:n=3", "KEY=VALUE"), ("", "no technique"),
    ],
)  # fmt: skip
def test_wrong_techniques(text, says):
    with pytest.raises(OctoluxError, match=says):
        choice(text)


def test_without_names_all_but_the_baselines_are_compared():
    names = [c.technique for c in choices([])]
    assert "uniform-lpv" in names
    assert not {"none", "constant", "path-tracer"} & set(names)
    assert "uniform-lpv" not in [c.technique for c in choices([], "uniform-lpv")]


def test_a_technique_is_given_once():
    with pytest.raises(OctoluxError, match="twice"):
        choices(["none", "none"])
    with pytest.raises(OctoluxError, match="fitted"):
        choices(["constant"])


@pytest.mark.parametrize(
    ("text", "path", "paths"),
    [
        ("a/b.npz", "a/b.npz", ""), ("a.npz:first_bounce", "a.npz", "first_bounce"), ("A.EXR", "A.EXR", ""),
        (r"C:\a b\c.npz:all_indirect", r"C:\a b\c.npz", "all_indirect"),
    ],
)  # fmt: skip
def test_references_that_are_files(text, path, paths):
    assert reference_file(text) == (Path(path), paths)


def test_references_that_are_techniques():
    assert reference_file("path-tracer") is None
    assert reference_file("uniform-lpv:paper,n=64") is None


def test_limits():
    plain, layer, named = map(limit, ("flip=0.2", "indirect.relative_rmse=0.5", "uniform-lpv:paper,n=64:leak=1e-2"))
    assert (plain.label, plain.layer, plain.metric, plain.most) == ("", "final", "flip", 0.2)
    assert (layer.layer, layer.metric) == ("indirect", "relative_rmse")
    assert (named.label, named.metric, named.most) == ("uniform-lpv:paper,n=64", "leak", 0.01)
    assert len(METRICS) == len(set(METRICS))


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("flip", "METRIC=NUMBER"), ("flip=many", "METRIC=NUMBER"), ("flip=nan", "METRIC=NUMBER"), ("flap=1", "'flip'"),
        ("direct.flip=1", "'direct'"), ("final.leak=1", "'final'"), ("ssim=0.9", "'ssim_error'"),
    ],
)  # fmt: skip
def test_wrong_limits(text, says):
    with pytest.raises(OctoluxError, match=says):
        limit(text)


def test_limits_name_what_is_compared():
    check_labels([limit("black:leak=0.1"), limit("leak=0.1")], ["uniform-lpv", "black"])
    with pytest.raises(OctoluxError, match="'uniform-lpv'"):
        check_labels([limit("uniform-lpw:leak=0.1")], ["uniform-lpv", "black"])


def test_black_draws_no_samples():
    assert not black().seeded
