"""The cheap figures hold their bounds, and the registry says so: names, table, JSON, exit codes."""

from __future__ import annotations

import json
import math

import pytest

from benchmarks import registry
from benchmarks.__main__ import main, table
from benchmarks.registry import Bound, NeedsData, UnknownFigure, aim, at_least, at_most, figure, select, within

registry.load_all()
CHEAP = [f.name for f in select(["closed_form", "kernels", "determinism"])]
UNBOUND = {"plates"}


@pytest.mark.parametrize("name", CHEAP)
def test_every_bound_holds(name):
    rows = registry.FIGURES[name].rows()
    assert rows and all(row.value is not None and math.isfinite(row.value) for row in rows), rows
    failed = [f"{row.name} = {row.value:.6g}, bound {row.bound}" for row in rows if row.holds is False]
    assert not failed
    assert any(row.holds for row in rows) != (name in UNBOUND)


def test_what_the_issue_names_is_there():
    """The figures that the first version promises."""
    wanted = {
        "sh_projection", "sh_cosine_lobe", "sh_rotation", "step_gain", "flux_kept", "injected_flux", "reading",
        "plates", "kernel_injection", "kernel_propagation", "kernel_lookup", "kernel_direct_light",
        "direct_cornell_point", "direct_sponza_sunpoint", "indirect_cornell_point", "indirect_sponza_sunpoint",
        "same_bytes", "propagation_speedup", "shadow_faces", "crytek_frame", "crytek_load", "crytek_memory",
        "broken_files",
    }  # fmt: skip
    assert wanted <= set(registry.FIGURES)
    assert not [f.name for f in registry.FIGURES.values() if not f.summary]


@pytest.fixture
def figures(monkeypatch):
    """An empty registry for figures made by a test."""
    monkeypatch.setattr(registry, "FIGURES", {})


def test_one_value_and_many(figures):
    @figure("speed", group="ratios", unit="x", bound=at_least(1.5))
    def speed():
        """How fast."""
        return 2

    @figure("parts", group="ratios", unit={"a": "ms"}, bound={"b": at_most(1.0)})
    def parts():
        return {"a": 3.0, "b": 4.0}

    rows = [row for f in select([]) for row in f.rows()]
    assert [(r.name, r.value, r.unit, r.bound, r.holds) for r in rows] == [
        ("speed", 2.0, "x", ">= 1.5", True),
        ("parts.a", 3.0, "ms", "", None),
        ("parts.b", 4.0, "", "<= 1", False),
    ]
    assert table(rows).splitlines() == [
        "figure   value  unit  bound   holds",
        "speed    2      x     >= 1.5  holds",
        "parts.a  3      ms    -       -",
        "parts.b  4            <= 1    FAILS",
    ]


def test_bounds():
    assert [within(1.0, 0.25).holds(v) for v in (0.74, 0.75, 1.25, 1.26)] == [False, True, True, False]
    assert [at_most(2.0).holds(v) for v in (2.0, 2.1, math.nan)] == [True, False, False]
    assert at_least(2.0).holds(math.nan) is False
    assert Bound().holds(5.0) is None
    assert aim("6").holds(math.inf) is None and aim("6").text == "aim: 6"


def test_names_select_figures_and_groups_once(figures):
    for name, group in (("a", "g"), ("b", "g"), ("c", "h")):
        figure(name, group=group)(lambda: 1.0)
    assert [f.name for f in select(["b", "g"])] == ["a", "b"]
    assert [f.name for f in select([])] == ["a", "b", "c"]
    for name, group in (("a", "x"), ("h", "x"), ("x", "a"), ("x", "x")):
        with pytest.raises(ValueError, match="already"):
            figure(name, group=group)


def test_an_unknown_name_suggests_the_nearest(capsys):
    with pytest.raises(UnknownFigure, match="'propagation_speedup'"):
        select(["propagaton_speedup"])
    assert main(["propagaton_speedup"]) == 2
    told = capsys.readouterr()
    assert told.err.splitlines() == [
        "error: There is no figure or group 'propagaton_speedup'. Did you mean 'propagation_speedup'?"
    ]
    assert not told.out


def test_exit_code_table_and_json(figures, capsys, tmp_path):
    figure("good", group="g", unit="x", bound=at_most(1.0))(lambda: 0.5)
    figure("far", group="g", bound=aim("1"))(lambda: 9.0)
    file, page = tmp_path / "figures.json", tmp_path / "figures.md"
    assert main(["--json", str(file), "--markdown", str(page)]) == 0
    assert "| good | 0.5 | x | <= 1 | holds |" in page.read_text(encoding="utf-8")
    data = json.loads(file.read_text(encoding="utf-8"))
    assert data["figures"][0] == {
        "name": "good", "group": "g", "value": 0.5, "unit": "x", "bound": "<= 1", "holds": True, "problem": ""
    }  # fmt: skip
    assert data["figures"][1]["holds"] is None
    out = capsys.readouterr().out
    assert out.startswith(f"adapter: {data['adapter']}\n") and out.endswith("all bounds hold\n")
    assert "far     9            aim: 1  -" in out

    figure("bad", group="g", bound=at_most(1.0))(lambda: 1.5)
    assert main([]) == 1
    assert capsys.readouterr().out.endswith("1 bounds do not hold: bad\n")
    assert main(["good"]) == 0


def test_json_into_a_missing_folder_is_refused_before_measuring(figures, capsys, tmp_path):
    @figure("slow", group="g")
    def slow():
        raise AssertionError("measured")

    assert main(["--json", str(tmp_path / "none" / "f.json")]) == 2
    assert "there is no folder" in capsys.readouterr().err


def test_a_figure_that_breaks_fails_alone(figures, capsys):
    @figure("broken", group="g")
    def broken():
        raise ZeroDivisionError("no time")

    figure("good", group="g", bound=at_most(1.0))(lambda: 0.5)
    assert main([]) == 1
    told = capsys.readouterr()
    assert "ZeroDivisionError: no time" in told.out and "FAILS" in told.out and "good    0.5" in told.out
    assert "Traceback" in told.err


def test_missing_data_is_said_and_not_counted(figures, capsys):
    @figure("far_away", group="g", bound=at_most(1.0))
    def far_away():
        raise NeedsData("ground-truth/x.npz")

    assert main([]) == 0
    assert "needs OCTOLUX_DATA (ground-truth/x.npz)" in capsys.readouterr().out


def test_list_measures_nothing(figures, capsys):
    @figure("speed", group="ratios", bound={"ratio": at_least(1.5)})
    def speed():
        """How fast it is.

        More.
        """
        raise AssertionError("measured")

    assert main(["--list"]) == 0
    assert capsys.readouterr().out.splitlines()[1] == "speed   ratios  >= 1.5  How fast it is."
