"""The measurements of VCT: what the thesis prints adds up, which part a pass belongs to, the tables."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

from benchmarks import registry, vct_rows, vct_tables
from benchmarks import vct_thesis as thesis
from benchmarks.vct_cost import tessellated
from benchmarks.vct_frames import COPIES, OCTREE, OTHER, Case, built, frames_of, part_of
from octolux.scene.builtin.shapes import box

registry.load_all()
SMALL = {"size": (32, 18), "shadows": 64}


@pytest.mark.parametrize(
    ("table", "columns"),
    [
        (thesis.BY_DEPTH, thesis.STEPS[2:]), (thesis.BY_REPRESENTATION, thesis.STEPS[2:]),
        (thesis.STATIC_PARTS, thesis.STATIC), (thesis.MOVING_PARTS, thesis.MOVING),
        (thesis.INJECTION_PARTS, thesis.INJECTION),
    ],
)  # fmt: skip
def test_what_is_printed_adds_up(table, columns):
    """So no digit was lost: each total is the sum of its row, as numbers of two decimals are."""
    for scene in thesis.SCENES:
        for row in table[scene].values():
            parts = [row[column] for column in columns if column != thesis.TOTAL]
            assert sum(parts) == pytest.approx(row[thesis.TOTAL], abs=0.005 * (len(parts) + 1) + 1e-9)


def test_tables_that_are_printed_agree():
    """Steps of 6.9 are those of 6.11 to 6.13 together."""
    for scene in thesis.SCENES:
        for depth, row in thesis.BY_DEPTH[scene].items():
            static = thesis.STATIC_PARTS[scene][depth]
            assert static[thesis.FRAGMENTS] + static[thesis.BUILD] == pytest.approx(row[thesis.BUILD], abs=0.02)
            assert static[thesis.TOTAL] == pytest.approx(row[thesis.BUILD] + row[thesis.FILL], abs=0.02)
            assert thesis.INJECTION_PARTS[scene][depth][thesis.TOTAL] == row[thesis.INJECT]


def test_parts_by_name():
    assert part_of("injection", "inject") == part_of("RSM surfaces", "RSM") == thesis.TRAVERSE
    assert part_of("injection", "collect") == thesis.INSERT
    assert part_of("filtering", "average_light") == thesis.CHILDREN
    assert part_of("filtering", "voxel octree", clears=True) == thesis.LIST
    assert part_of("voxels", "voxel octree", clears=True) == OCTREE + thesis.RESET
    assert part_of("edge copy", "bricks") == OCTREE + COPIES
    assert part_of("edge copy", "average_light") == OCTREE + thesis.CHILDREN
    assert part_of("direct light", "direct") == OTHER


@pytest.fixture(scope="module")
def frames():
    return frames_of("cornell-box", [Case(f"depth={depth}", **SMALL) for depth in (6, 7)], 2)


def test_every_part_of_a_frame_is_timed(frames):
    """Those of building an octree for the ball that moves, too."""
    build = {OCTREE + part for part in (*vct_rows.BUILDING, *vct_rows.FILLING)}
    for frame in frames:
        assert {*vct_rows.INJECTION, thesis.DIFFUSE, thesis.SPECULAR, *build} <= set(frame)
        assert all(time > 0.0 for time in frame.values())


def test_every_part_of_a_build_is_timed():
    small, large = built("cornell-box", [("axial", 6), ("axial", 7)], 1)
    assert set(small.parts) == {"Frame", *(OCTREE + part for part in (*vct_rows.BUILDING, *vct_rows.FILLING))}
    assert 3.0 < large.nodes / small.nodes < 5.0  # surfaces: four times as many on each level
    assert 2.0 <= large.megabytes / small.megabytes <= 8.0
    assert small.megabytes * 1e6 >= 4 * 27 * small.bricks


def test_lines():
    row = {thesis.RENDER: 2.0, COPIES: 30.0}
    found = {"cornell-box": {"6": row, "7": {thesis.RENDER: 5.0, COPIES: 3000.0}}, "atrium": {"6": row}}
    lines = vct_tables.lines(found, thesis.INJECTION_PARTS, "depth")
    assert lines[0] == ("scene", "depth", "", thesis.RENDER, COPIES)
    assert lines[1:4] == [
        ("cornell-box", "6", "ours", "2.00", "30.0"), ("", "", thesis.ADAPTER, "0.46", "1.76"),
        ("", "7", "ours", "5.00 (×2.5)", "3,000 (×100)"),
    ]  # fmt: skip
    assert lines[5:] == [("atrium", "6", "ours", "2.00", "30.0")], "it is not in the thesis"
    share = vct_tables.lines({"corridor": {"8": {thesis.SPECULAR: 1.0, thesis.TOTAL: 4.0}}}, {}, "depth", shares=True)
    assert share[1][3:] == ("1.00 (25%)", "4.00 (100%)")


def test_tables_are_written(frames, monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(vct_rows, "_by_depth", lambda scene, count: [*frames, frames[-1]])
    files = [tmp_path / "a.json", tmp_path / "a.md", tmp_path / "page.md"]
    written = zip(("--json", "--markdown", "--page"), map(str, files), strict=True)
    assert vct_tables.main(["6.13", "--scene", "corridor", *(word for pair in written for word in pair)]) == 0
    data = json.loads(files[0].read_text(encoding="utf-8"))["tables"]["6.13"]
    assert data["ours"]["corridor"]["6"][thesis.RENDER] == frames[0][thesis.RENDER]
    assert data["thesis"]["corridor"]["8"][thesis.TOTAL] == 48.70
    assert "Table 6.13" in capsys.readouterr().out and "| corridor | 6 |" in files[1].read_text(encoding="utf-8")
    page = files[2].read_text(encoding="utf-8")
    assert page.startswith("# voxel-cones") and "## Table 6.13. Injection of light\n\n| scene |" in page


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["--frames", "0"], "at least 1"), (["6.90"], "6.9"), (["--json", "nowhere/a.json"], "there is no folder"),
        (["--page", "nowhere/a.md"], "there is no folder"),
    ],
)  # fmt: skip
def test_wrong_options(monkeypatch, capsys, words, says):
    monkeypatch.setattr(vct_rows, "frames_of", lambda *given: pytest.fail("measured"))
    monkeypatch.setattr(vct_rows, "built", lambda *given: pytest.fail("measured"))
    assert vct_tables.main(words) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize("name", ["vct_octree", "vct_furnace"])
def test_what_is_known_exactly(name):
    rows = registry.FIGURES[name].rows()
    assert any(row.holds for row in rows)
    assert all(row.holds is not False and math.isfinite(row.value) for row in rows), rows


def test_tessellated_surfaces_are_the_same():
    """As many triangles as the square of the parts, of the same area, on the same surface, turned the same way."""
    mesh = box((-1.0, 0.0, 2.0), (1.0, 1.5, 3.0))
    fine = tessellated(mesh, parts=10)
    assert len(fine.indices) == 100 * len(mesh.indices)
    corners = [m.positions[m.indices].astype(np.float64) for m in (mesh, fine)]
    areas = [np.cross(c[:, 1] - c[:, 0], c[:, 2] - c[:, 0]) for c in corners]
    np.testing.assert_allclose(areas[1].sum(axis=0), areas[0].sum(axis=0), atol=1e-5)
    assert np.linalg.norm(areas[1], axis=1).sum() == pytest.approx(np.linalg.norm(areas[0], axis=1).sum(), rel=1e-5)
    normals = fine.normals[fine.indices].mean(axis=1)
    assert (np.sum(normals * areas[1], axis=1) > 0.0).all()
    largest = [np.linalg.norm(area, axis=1).max() for area in areas]
    assert largest[1] == pytest.approx(largest[0] / 100, rel=1e-4)


def test_memory_of_both_representations(monkeypatch):
    """Three bricks of lobes for each node. All rows are those that the thesis has."""
    wanted = [f"{kind} {depth}" for kind in (thesis.AXIAL, thesis.LOBES) for depth in vct_rows.MEMORY_DEPTHS]
    assert wanted == list(thesis.MEMORY["Cornell box"])
    monkeypatch.setattr(vct_rows, "MEMORY_DEPTHS", (6,))
    found = vct_rows.memory("cornell-box", 1)
    nodes = vct_rows.built("cornell-box", [(thesis.LOBES, 6)], 1)[0].nodes
    assert found["lobes 6"][vct_rows.BRICKS] == 3 * nodes
    assert set(found) == {"axial 6", "lobes 6"}
