"""The measurements of OLPV: which part a pass belongs to, the table, what counts as a jump, and wrong options."""

from __future__ import annotations

import json

import numpy as np
import pytest

from benchmarks import olpv_artefacts, olpv_sweep, olpv_table1, scenes_on_disk
from benchmarks.olpv_jumps import DEFAULT, STEPS, THESIS, element, excess_steps, wall
from benchmarks.olpv_parts import OTHER, PARTS, part_of
from benchmarks.olpv_table1 import UNIFORM, measured, rows, tables
from benchmarks.part_profiler import Times
from octolux.gpu.device import DeviceError

SMALL = (32, 18)


def test_parts_by_name():
    assert part_of("RSM rendering", "visibility") == part_of("RSM surfaces", "RSM") == "RSMCreate"
    assert part_of("visibility", "visibility") == part_of("lookup", "lookup") == OTHER
    assert part_of("geometry volume", "downsample") == "GVDownsample"
    assert part_of("downsampling", "downsample") == "LPVDownsample"
    assert part_of("injection", "LPV injected light", clears=True) == "LPVClear"
    assert part_of("geometry volume", "LPV geometry volume", clears=True) == "GVClear"
    assert part_of("propagation", "LPV index volume", clears=True) == "IXClear"


@pytest.fixture(scope="module")
def found():
    return measured("atrium", (*olpv_table1.OCTREES, UNIFORM), 2, SMALL)


def test_every_part_of_the_thesis_is_timed(found):
    """The octree's in all three; the uniform volume has nothing to downsample. The index volume needs no clearing: the
    first pass of the propagation writes all of it."""
    for text in olpv_table1.OCTREES:
        missing = {"IXClear"} if text != DEFAULT else {"IXClear", "LPVMerge"}
        assert set(PARTS) - set(found[text]) == missing, text
    assert set(PARTS) - set(found[UNIFORM]) == {"IXClear", "GVDownsample", "LPVDownsample"}
    for times in found.values():
        assert times["Frame"].count == 2
        assert times["RSMCreate"].count >= 2 * 18  # six faces of three lights
        inside = sum(t.total for part, t in times.items() if part not in ("Frame", "Clear to merge"))
        assert inside <= times["Frame"].total
        together = sum(times[part].total for part in PARTS[2:] if part in times)
        assert times["Clear to merge"].total == pytest.approx(together)


def test_steps_are_counted(found):
    """k steps of each of two frames, the first of which reads injected light: no pass before them."""
    assert found[THESIS]["LPVPropagate"].count == 2 * 4
    assert found[UNIFORM]["LPVPropagate"].count == 2 * 16


def test_rows():
    octree = {"Frame": Times(2, 3.0, 3.0, 6.0), "LPVMerge": Times(2, 1.0, 1.0, 2.0)}
    uniform = {"Frame": Times(2, 4.0, 4.0, 8.0)}
    plain = rows(octree, uniform, thesis=False)
    assert [line[0] for line in plain] == ["part", "Frame", "LPVMerge"]
    assert plain[1][1:] == ("2", "3.00", "3.00", "6", "-2", "2", "4.00", "4.00", "8", "0.75")
    assert plain[2][1:] == ("2", "1.00", "1.00", "2", "+2", "–", "–", "–", "–", "–")
    printed = rows(octree, uniform, thesis=True)
    assert [line[0] for line in printed[1:]] == [*PARTS, "Clear to merge"]
    assert printed[1][-6:] == ("500", "106", "53193", "-4801", "115", "57994")
    assert printed[-1][-6:] == ("500", "95", "47601", "-5230", "106", "52831")
    assert len({len(line) for line in printed}) == 1


def test_tables_are_written(found, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(olpv_table1, "measured", lambda *given: found)
    files = [tmp_path / "a.json", tmp_path / "a.md"]
    assert olpv_table1.main(["--frames", "2", "--json", str(files[0]), "--markdown", str(files[1])]) == 0
    data = json.loads(files[0].read_text(encoding="utf-8"))
    assert data["scene"] == "atrium" and data["techniques"][THESIS]["LPVInject"]["count"] > 0
    assert data["thesis"]["LPVPropagate"]["uniform_total"] == 9403
    assert files[1].read_text(encoding="utf-8").count("| part |") == len(tables(found)) == 3
    assert f"{STEPS} beside {UNIFORM}" in capsys.readouterr().out


def test_the_sweep():
    """More cells are more memory; times are over those of a technique's first row."""
    costs = olpv_sweep.swept("atrium", ("octree-lpv:thesis,n=16", "octree-lpv:thesis,n=32", "octree-lpv,n=16"), 1)
    assert [c.cells for c in costs] == [16**3 + 8**3 + 4**3 + 2**3, 32**3 + 16**3 + 8**3 + 4**3 + 2**3,
                                        sum(8**i for i in range(5))]  # fmt: skip
    irradiance = 320 * 180 * 16 / 1e6  # of the picture, by pixels
    growth = (costs[1].megabytes - irradiance) / (costs[0].megabytes - irradiance)
    assert (34 / 18) ** 3 < growth < 8.0  # all else is by cells, some of it with a border
    assert [c.k for c in costs] == [4, 4, None]
    lines = olpv_sweep.rows(costs)
    assert [(line[0], line[1], line[2]) for line in lines[1:]] == [
        ("octree-lpv", "16", "–"), ("octree-lpv:thesis", "16", "4"), ("octree-lpv:thesis", "32", "4")
    ]  # fmt: skip
    assert lines[1][5] == lines[2][5] == "1.00"
    assert float(lines[3][5]) == pytest.approx(costs[1].milliseconds / costs[0].milliseconds, abs=0.005)


def test_what_a_device_does_not_hold_is_left_open(monkeypatch):
    def refused(*given, **more):
        raise DeviceError("'LPV cells' needs 130 MiB; one binding holds 128 MiB.")

    monkeypatch.setattr(olpv_sweep, "kept", refused)
    lines = olpv_sweep.rows(olpv_sweep.swept("atrium", ("octree-lpv:thesis,n=128",), 1))
    assert lines[1] == ("octree-lpv:thesis", "128", "4", "2,396,744", "–", "–", "–")


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--frames", "0"], "at least 1"), (["--size", "wide"], "WIDTHxHEIGHT"),
        (["--json", "nowhere/a.json"], "there is no folder"),
    ],
)  # fmt: skip
def test_wrong_options(monkeypatch, capsys, words, says):
    monkeypatch.setattr(olpv_table1, "measured", lambda *given: pytest.fail("measured"))
    assert olpv_table1.main(words) == 2
    assert says in capsys.readouterr().err


def test_a_missing_scene_is_said(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("OCTOLUX_DATA", str(tmp_path))
    monkeypatch.setattr("benchmarks.scenes_on_disk.load", scenes_on_disk.load.__wrapped__)  # nothing from tests before
    monkeypatch.setattr(olpv_table1, "base_scene", olpv_table1.base_scene.__wrapped__)
    monkeypatch.setattr("benchmarks.olpv_scene.base_scene", olpv_table1.base_scene)
    assert olpv_table1.main(["--scene", "crytek", "--frames", "1"]) == 2
    assert "needs OCTOLUX_DATA" in capsys.readouterr().err


def test_artefacts_into_a_missing_folder(monkeypatch, capsys):
    monkeypatch.setattr(olpv_artefacts, "rows", lambda: pytest.fail("measured"))
    assert olpv_artefacts.main(["--json", "nowhere/a.json"]) == 2
    assert "there is no folder" in capsys.readouterr().err


def test_steps_out_of_line():
    """Light that halves in each cell has none; a factor of 4 on top of it between cells 3 and 4 is two stops there and
    one in the steps beside it; without light there is nothing to tell."""
    light = np.broadcast_to(2.0 ** -np.arange(8.0), (8, 8, 8)).copy()
    assert np.abs(excess_steps(light, 2)).max() < 1e-12
    light[..., 4:] *= 4.0
    np.testing.assert_allclose(excess_steps(light, 2)[0, 0], [0, 1, 2, 1, 0], atol=1e-12)
    light[..., 0] = 0.0
    assert np.isnan(excess_steps(light, 2)[..., 0]).all()


def test_the_inverse_square_is_in_line():
    """As stated there: 0.034 stops from 3 cells away on."""
    light = np.broadcast_to(np.arange(3.0, 11.0) ** -2, (8, 8, 8))
    assert excess_steps(light, 2).max() == pytest.approx(0.034, abs=5e-4)


def test_given_light():
    assert np.count_nonzero(wall()[..., 0, 0]) == 30 * 30
    assert np.argwhere(element((5, 13, 18))[..., 0, 0]).tolist() == [[18, 13, 5]]
