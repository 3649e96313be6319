"""The comparison set: its references fit its scenes and views, and its table says of known techniques what is known."""

from __future__ import annotations

import json
import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks import comparison, comparison_command, comparison_references, comparison_set
from benchmarks.__main__ import main
from benchmarks.comparison_references import GRID, KEPT_BITS, compact, make, noise_of_mean, traced
from benchmarks.comparison_set import LIGHTS, SET, SIZE, VIEWS, reference, scene_of
from benchmarks.registry import NeedsData, select
from benchmarks.stages import interleaved_stages
from octolux.compare.choices import choice
from octolux.compare.metrics import relative_noise
from octolux.compare.rendering import Studio, black
from octolux.scene.errors import OctoluxError

OURS = [view for view in SET if view.samples]
ids = [view.name for view in OURS]


def there(view):
    """The view, or a test that is skipped where its model or reference is not there."""
    try:
        scene_of(view)
        reference(view)
    except NeedsData as missing:
        pytest.skip(f"needs OCTOLUX_DATA ({missing})")
    return view


def test_the_set():
    wanted = {"cornell_point", "cornell_area", "sponza_sunpoint", "atrium", "corridor", "two_rooms", "crytek_sun",
              "crytek_lamps"}  # fmt: skip
    assert wanted <= set(VIEWS)
    assert {view.name for view in SET if view.built_in} == {"atrium", "corridor", "two_rooms", "two_rooms_dark"}
    assert [f.name for f in select(["comparison"])] == [f"indirect_{view.name}" for view in SET]


def test_our_references_are_a_few_megabytes():
    assert sum(path.stat().st_size for path in comparison_set.REFERENCES.iterdir()) < 6e6
    assert {path.stem for path in comparison_set.REFERENCES.glob("*.npz")} == {view.name for view in OURS}


@pytest.mark.parametrize("view", SET, ids=lambda view: view.name)
def test_references_are_whole(view):
    there(view)
    for light in LIGHTS:
        found = reference(view, light)
        assert found.noise_free
        assert found.mask.mean() > 0.5
        assert all(np.isfinite(half).all() and (half >= 0).all() for half in found.halves["indirect"])
        assert (found.pictures["indirect"].max() > 0) == (not view.lit_by)
    if view.samples:
        assert reference(view).size == SIZE


@pytest.mark.parametrize("view", OURS, ids=ids)
def test_the_noise_is_what_the_facts_state(view):
    """Rounding each half by 2^-(KEPT_BITS + 1) at most moves the difference of the halves, and so the stated noise, by
    no more than that of the picture's root mean square."""
    facts = json.loads((comparison_set.REFERENCES / f"{view.name}.json").read_text(encoding="utf-8"))
    assert facts["camera"] == view.camera and facts["scene"] == view.scene and tuple(facts["size"]) == SIZE
    for light, count in zip(LIGHTS, view.samples, strict=True):
        halves = [half.astype(np.float64) for half in reference(view, light).halves["indirect"]]
        found, stated = relative_noise(*halves, reference(view).mask), facts["relative_noise"][light]
        assert [s["samples"] for s in facts["settings"][light]] == [count] * 2
        assert len({s["seed"] for s in facts["settings"][light]}) == 2
        assert all(s["materials"] == "diffuse" and s["pixel"] == "centre" for s in facts["settings"][light])
        if stated is None:
            assert found is None
            continue
        values = np.stack(halves)[:, reference(view).mask]
        spread = float(np.sqrt(np.mean(values**2)) / values.mean())
        assert found == pytest.approx(stated, abs=2.0 ** -(KEPT_BITS + 1) * spread + 2.0 ** -(KEPT_BITS + 1) * stated)
        assert facts["relative_noise_of_mean"][light] < 0.02


@pytest.mark.parametrize("view", OURS, ids=ids)
def test_references_show_the_view(device, view):
    """Positions are kept to the nearest 1 / GRID m; on another adapter pixels on edges may show another surface."""
    found = Studio(scene_of(there(view)), device, SIZE, view.camera, frames=0).render(black())
    known = reference(view)
    assert known.position is not None
    off = np.abs(found.position - known.position).max(axis=-1)
    assert (known.mask == found.mask).mean() > 0.99
    assert (off[known.mask & found.mask] <= 0.51 / GRID).mean() > 0.99


@pytest.mark.parametrize("view", [v for v in OURS if v.built_in], ids=lambda view: view.name)
def test_references_are_what_the_path_tracer_shows(device, view):
    """Two means with known standard errors differ by less than five of them, and by rounding, 2^-(KEPT_BITS + 1)."""
    studio = Studio(scene_of(view), device, SIZE, view.camera)
    words = "path-tracer:reference,materials=diffuse,paths=first-bounce,seed=1000"
    fresh, kept = studio.reference(choice(words), 8), reference(view)
    means = [float(one.pictures["indirect"][one.mask].mean()) for one in (fresh, kept)]
    if view.lit_by:
        assert means == [0.0, 0.0]
        return
    errors = [noise_of_mean(one) * mean for one, mean in zip((fresh, kept), means, strict=True)]
    assert means[0] == pytest.approx(means[1], abs=5 * math.hypot(*errors) + 2.0 ** -(KEPT_BITS + 1) * means[1])


def test_rounding():
    values = np.random.default_rng(1).uniform(1e-3, 6e4, 10_000)
    assert np.abs(compact(values) / values - 1).max() <= 2.0 ** -(KEPT_BITS + 1) + 2.0**-11
    assert len(np.unique(compact(np.linspace(1.0, 2.0, 10_000)))) == 2**KEPT_BITS + 1
    assert not compact(np.zeros(3)).any()
    with pytest.raises(OctoluxError, match="65504"):
        compact(np.array([7e4]))


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """The atrium with a reference of 48 x 27 pixels and few paths, in a folder of its own."""
    folder = tmp_path_factory.mktemp("references")
    view = replace(VIEWS["atrium"], samples=(16, 16))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(comparison_set, "REFERENCES", folder)
        make(view, folder, (48, 27))
        yield view


def by_name(found):
    return {one.technique: one for one in found}


def test_scores_of_what_is_known(small):
    """`constant` has the reference's mean in each channel; `black` errs by the reference; the path tracer, with another
    seed, by its noise alone."""
    truth = "path-tracer:reference,materials=diffuse,paths=first-bounce,samples=16,seed=7"
    found = by_name(comparison.scores(small, [truth]))
    assert list(found) == [truth, "constant", "black"]
    known = reference(small)
    a, b = (half[known.mask].astype(np.float64) for half in known.halves["indirect"])
    assert found["black"].ratio == 0.0 and found["black"].leak is None
    assert found["black"].rmse == pytest.approx(np.sqrt(np.mean(a * b)) / np.mean(0.5 * (a + b)))
    assert found["constant"].ratio == pytest.approx(1.0, abs=2e-3)  # its albedo is read from 16-bit numbers
    assert 0.2 < found["constant"].energy < 1.0
    noise = noise_of_mean(known)
    # One picture of 16 paths beside the mean of two such: noise of sqrt(2) and 1 times the reference's.
    assert found[truth].ratio == pytest.approx(1.0, abs=5 * math.sqrt(3) * noise)
    assert found[truth].rmse < found["constant"].rmse


def test_specular_light_is_not_compared(small):
    rendering = comparison.studio(small).render(choice("constant"))
    gloss = np.full_like(rendering.specular, 3.0)
    shiny = replace(
        rendering, specular=gloss, pictures=rendering.pictures | {"indirect": rendering.pictures["indirect"] + gloss}
    )
    np.testing.assert_allclose(
        comparison.diffuse_indirect(shiny), comparison.diffuse_indirect(rendering), rtol=1e-6, atol=1e-6
    )


def test_the_constant_of_a_dark_view_is_the_lit_one_s():
    dark = VIEWS["two_rooms_dark"]
    settings = comparison.constant(dark).settings
    assert settings == comparison.constant(VIEWS["two_rooms"]).settings
    assert min(settings.red, settings.green, settings.blue) > 0.0


def test_the_table(monkeypatch, capsys, tmp_path):
    """Text, Markdown and JSON of the dark room: a constant lights it nearly all, black nothing; there is no ratio."""
    files = [tmp_path / "a.json", tmp_path / "a.md"]
    options = ["--technique", "none", "--json", str(files[0]), "--markdown", str(files[1])]
    assert main(["comparison", "two_rooms_dark", *options]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[2].split() == ["view", "technique", "ratio", "rel.", "RMSE", "trimmed", "of", "all", "bounces", "leak"]
    assert lines[3].split() == ["two_rooms_dark", "none", "–", "–", "–", "–", "0.000"]
    assert lines[4].split()[:5] == ["constant", "–", "–", "–", "–"]
    data = json.loads(files[0].read_text(encoding="utf-8"))
    by_technique = {s["technique"]: s for s in data["scores"]}
    assert list(by_technique) == ["none", "constant", "black"]
    assert all(s["ratio"] is None for s in by_technique.values())
    assert by_technique["none"]["leak"] == by_technique["black"]["leak"] == 0.0
    assert 0.95 < by_technique["constant"]["leak"] <= 1.0  # not where the albedo is black
    table = files[1].read_text(encoding="utf-8").splitlines()
    assert table[1] == "|---|---|---|---|---|---|---|" and len(table) == 5
    assert table[3].startswith("|  | constant | – | – | – | – | ")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["atrum"], "Did you mean 'atrium'"), (["--technique", "uniform-lvp"], "Did you mean 'uniform-lpv'"),
        (["--technique", "uniform-lpv", "--technique", "uniform-lpv"], "given twice"),
        (["--json", "nowhere/a.json"], "there is no folder"),
    ],
)  # fmt: skip
def test_wrong_words(monkeypatch, capsys, words, says):
    monkeypatch.setattr(comparison_command, "measure", lambda *given: pytest.fail("measured"))
    assert main(["comparison", *words]) == 2
    assert says in capsys.readouterr().err


def test_missing_data_leaves_views_out(monkeypatch, capsys, tmp_path):
    """Whatever other tests have loaded and kept: the scores are asked for without what is cached."""
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path))
    monkeypatch.setattr(comparison_command, "scores", lambda view, techniques, light: reference.__wrapped__(view))
    assert comparison_command.main(["cornell_point", "--technique", "none"]) == 0
    told = capsys.readouterr()
    assert "cornell_point: left out, needs OCTOLUX_DATA (ground-truth/cornell_point.npz)" in told.err
    assert told.out.splitlines()[-1].startswith("view")


def test_scores_against_all_bounces(small):
    """`constant` has the mean of what it is asked to stand for; `black` errs by all of it."""
    found = by_name(comparison.scores(small, ["none"], "all_indirect"))
    assert found["constant"].ratio == pytest.approx(1.0, abs=0.02)
    assert found["constant"].energy == pytest.approx(found["constant"].ratio)
    assert found["black"].ratio == 0.0


def test_foreign_references_are_not_made(capsys):
    assert comparison_references.main(["cornell_point"]) == 2
    assert "another program's" in capsys.readouterr().err


def test_lights_are_traced_as_named(device):
    """All bounces are more than the first, in a room without noise to speak of."""
    view = VIEWS["two_rooms"]
    studio = Studio(scene_of(view), device, (32, 18), view.camera)
    first, every = (traced(view, studio, light, 32).pictures["indirect"].mean() for light in LIGHTS)
    assert every > 1.3 * first


def test_stages_of_techniques_in_turn():
    """Each technique's own stages and those all share, once a frame."""
    found = interleaved_stages(scene_of(VIEWS["corridor"]), "far", ("none", "uniform-lpv,n=16"), (32, 18), 2)
    assert list(found) == ["none", "uniform-lpv,n=16"]
    assert set(found["uniform-lpv,n=16"]) - set(found["none"]) >= {"injection", "propagation", "lookup"}
    for stages in found.values():
        assert all(time > 0.0 for time in stages.values())
