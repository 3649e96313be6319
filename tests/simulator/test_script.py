"""Scripts and `octolux simulate`: what they write, and one clear error for each mistake."""

from __future__ import annotations

import csv
import io
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from octolux.cli import main
from octolux.scene.errors import SceneError
from octolux.simulator.laboratory import Element, Simulation, Wall, from_file
from octolux.simulator.laboratory.files import COEFFICIENTS
from octolux.simulator.laboratory.results import FILES
from octolux.simulator.laboratory.script import Script

EXAMPLES = sorted((Path(__file__).resolve().parents[2] / "examples" / "simulate").glob("*.toml"))

TOML = """
n = 8
propagator = "clpv"
factor = [1.0, 0.9, 0.8, 0.7]
compare = ["uniform"]
[[injector]]
kind = "wall"
axis = "x"
[[injector]]
kind = "element"
cell = [5, 4, 4]
direction = [0, 1, 0]
multiplier = 2.0
[[occluder]]
kind = "area"
low = [3, 0, 0]
high = [3, 4, 8]
direction = "all"
"""
RUN = '[[action]]\ndo = "run"\niterations = 2\n'


@pytest.fixture
def write(tmp_path):
    def call(text: str, name: str = "script.toml") -> Path:
        (tmp_path / name).write_text(text, encoding="utf-8")
        return tmp_path / name

    return call


@pytest.fixture
def simulate(monkeypatch, capsys, tmp_path):
    """`simulate("script.toml")`: exit code, what was printed, and what on stderr; in the temporary folder."""
    monkeypatch.chdir(tmp_path)

    def call(*words: str) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["octolux", "simulate", *words])
        code = 0
        try:
            main()
        except SystemExit as stop:
            code = stop.code if isinstance(stop.code, int) else int(bool(stop.code))
        return code, *capsys.readouterr()

    return call


def test_the_command_writes_everything(write, simulate, tmp_path):
    picture = '[[action]]\ndo = "picture"\nfile = "level1.png"\nlevel = 1\naxis = "x"\nslice = 2\nscale = "log"\n'
    write(TOML + RUN + picture)
    code, out, err = simulate("script.toml", "--out", "made")
    assert code == 0 and "e_abs" in out and err.splitlines() == ["1 of 2: run", "2 of 2: picture"]
    made = tmp_path / "made"
    assert sorted(path.name for path in made.iterdir()) == sorted([*FILES, "level1.png"])
    for name in ("errors.png", "slices.png", "level1.png"):
        low, high = Image.open(made / name).convert("L").getextrema()
        assert low < 100 and high == 255
    rows = list(csv.DictReader(io.StringIO((made / "errors.csv").read_text())))
    assert [float(row["iteration"]) for row in rows] == [0.0, 1.0, 2.0]
    assert float(rows[0]["e_abs"]) == 0.0 < float(rows[2]["corrected_e_abs"])


def test_the_state_that_is_written_is_that_of_the_actions(write, simulate, tmp_path):
    write(TOML + RUN)
    assert simulate("script.toml", "--out", "made")[0] == 0
    expected = Script(tmp_path / "script.toml")
    expected.run()
    state = expected.simulation.state
    with np.load(tmp_path / "made" / "state.npz") as found:
        for i in range(4):
            np.testing.assert_array_equal(found[f"sum_{i}"], state.sum[i])
            np.testing.assert_array_equal(found[f"index_{i}"], state.index[i])
            np.testing.assert_array_equal(found[f"geometry_{i}"], state.geometry[i])
        np.testing.assert_array_equal(found["merged"], state.merged)
        settings = json.loads(str(found["settings"]))
    assert settings["propagator"] == "clpv" and settings["factors"] == [1.0, 0.9, 0.8, 0.7]


def test_toml_json_and_python_are_the_same(write):
    actions = [*({"do": name} for name in ("inject", "downsample", "accumulate")), {"do": "step", "times": 2}]
    actions.append({"do": "merge"})
    values = {"n": 8, "injector": [{"kind": "wall", "axis": "y", "index": -1}], "action": actions}
    toml = 'n = 8\n[[injector]]\nkind = "wall"\naxis = "y"\nindex = -1\n' + "".join(
        "[[action]]\n" + "".join(f"{k} = {json.dumps(v)}\n" for k, v in a.items()) for a in actions
    )
    states = []
    for path in (write(toml), write(json.dumps(values), "script.json")):
        script = Script(path)
        script.run()
        states.append(script.simulation.state)
    ours = Simulation(8)
    ours.set_injectors([Wall("y", -1)])
    ours.run(2)
    for state in states:
        assert all((a == b).all() for a, b in zip(state.arrays(), ours.state.arrays(), strict=True))


def test_undo_redo_set_clear_and_single_injectors(write):
    text = TOML + "".join(f"[[action]]\n{keys}\n" for keys in (
        'do = "inject"\ninjector = 2', 'do = "inject"\ninjector = 1', 'do = "undo"', 'do = "save"\nfile = "a.npz"',
        'do = "redo"', 'do = "set"\npropagator = "dom6"\nfactor = 0.5', 'do = "clear"', 'do = "propagate"',
    ))  # fmt: skip
    script = Script(write(text))
    with np.load(io.BytesIO(script.run()["a.npz"])) as saved:
        alone = Simulation(8)
        alone.inject(Element((5, 4, 4), (0.0, 1.0, 0.0), 2.0))
        np.testing.assert_array_equal(saved["source_0"], alone.state.source[0])
    state = script.simulation.state
    assert state.propagator.name == "dom6" and state.factors == (0.5,) * 4 and not state.target[0].any()


def test_injectors_from_files(write, tmp_path):
    """A state that was saved can be injected; CSV has lobes or coefficients."""
    simulation = Simulation(4)
    simulation.inject(Element((1, 2, 3), (0.0, 0.0, -2.0), 5.0))
    light = simulation.state.source[0]
    np.savez(tmp_path / "one.npz", light)
    np.savez(tmp_path / "two.npz", light=light, other=np.zeros(3))
    write("x, y, z, multiplier, dx, dy, dz\n1, 2, 3, 2, 0, 0, -1\n1, 2, 3, 3, 0, 0, -1\n", "lobes.csv")
    numbers = ",".join(repr(float(c)) for c in light[3, 2, 1])
    write(f"x,y,z,{','.join(COEFFICIENTS)}\n1,2,3,{numbers}\n", "coefficients.csv")
    for name in ("one.npz", "two.npz", "lobes.csv", "coefficients.csv"):
        found = from_file(tmp_path / name, 4).coefficients
        np.testing.assert_allclose(found, light, rtol=1e-15)
    write("x,y,z,multiplier\n4,0,0,0.5\n", "corner.csv")  # corners go to n
    blocking = from_file(tmp_path / "corner.csv", 4, "blocking").coefficients
    assert blocking.shape == (5, 5, 5, 4) and blocking[0, 0, 4, 0] == pytest.approx(np.sqrt(np.pi))


BAD = {
    'n = 12\n': "n must be a power of two, got 12",
    'n = 8.5\n': "n: is 8.5. give a whole number",
    'propagator = "cplv"\n': "perhaps 'clpv' is meant",
    'factr = 1.0\n': "factr: there is no such key here. perhaps 'factor' is meant",
    'factor = nan\n': "not finite",
    'n = 8\nfactor = [1.0, 2.0]\n': "2 factors for 4 levels",
    'compare = ["unifrom"]\n': "perhaps 'uniform' is meant",
    '[[injector]]\nkind = "wal"\n': "[[injector]] 1: kind: is 'wal'. perhaps 'wall' is meant",
    '[[injector]]\nkind = "wall"\naxis = "w"\n': "[[injector]] 1: axis",
    'n = 8\n[[injector]]\nkind = "wall"\naxis = "x"\nindex = 8\n': "[[injector]] 1: the wall at x = 8 is outside",
    '[[injector]]\nkind = "element"\ncell = [1, 2]\n': "must be 3 numbers",
    '[[injector]]\nkind = "element"\ncell = [1, 2, -3]\n': "three whole numbers",
    '[[injector]]\nkind = "area"\nlow = [3, 0, 0]\nhigh = [2, 1, 1]\n': "lies beyond",
    '[[injector]]\nkind = "element"\ncell = [1, 2, 3]\nindex = 2\n': "[[injector]] 1: index: there is no such key",
    '[[injector]]\nkind = "element"\ncell = [1, 2, 3]\nmultiplier = -1\n': "multiplier: is -1",
    '[[occluder]]\nkind = "element"\ncell = [1, 2, 3]\ndirection = [0, 0, 0]\n': "has no direction",
    '[[injector]]\nkind = "file"\nfile = "none.npz"\n': "none.npz: cannot be read: No such file",
    '[[injector]]\nkind = "file"\nfile = "light.txt"\n': "files of the kind '.txt' are not read",
}  # fmt: skip
BAD_ACTIONS = {
    'do = "rum"\n': "[[action]] 1: do: is 'rum'. perhaps 'run' is meant",
    'iterations = 3\n': "[[action]] 1: do: is missing",
    'do = "run"\n': "iterations: is missing",
    'do = "run"\niterations = -1\n': "iterations: is -1. give at least 0",
    'do = "run"\niterations = 1.5\n': "whole number",
    'do = "step"\niterations = 3\n': "iterations: there is no such key here",
    'do = "undo"\n': "nothing to undo",
    'do = "set"\n': "sets nothing",
    'do = "set"\npropagator = "dom7"\n': "perhaps 'dom6' is meant",
    'do = "inject"\ninjector = 1\n': "injector",
    'do = "picture"\nfile = "../a.png"\n': "not a plain file name",
    'do = "picture"\nfile = "a.gif"\n': "end the name with .png",
    'do = "picture"\nfile = "slices.png"\n': "is written already",
    'do = "picture"\nfile = "a.png"\nlevel = 9\n': "there is no level 9. give 0 to 5",
    'do = "picture"\nfile = "a.png"\nslice = 99\n': "there is no slice 99. give 0 to 31",
    'do = "picture"\nfile = "a.png"\nscale = "lin"\n': "perhaps 'linear' is meant",
    'do = "picture"\nfile = "a.png"\nshow = ["som"]\n': "perhaps 'sum' is meant",
    'do = "save"\nfile = "a.png"\n': "end the name with .npz",
}  # fmt: skip


@pytest.mark.parametrize("text,message", [
    *((head + RUN, message) for head, message in BAD.items()),
    *(("[[action]]\n" + action, message) for action, message in BAD_ACTIONS.items()),
    ("n = 8\n", "action: there is nothing to do"), ("n = \n", "is not TOML"),
])  # fmt: skip
def test_mistakes(write, simulate, tmp_path, text, message):
    write(text)
    code, _, err = simulate("script.toml", "--out", "made")
    errors = [line for line in err.splitlines() if line.startswith("error")]
    assert code == 2 and len(errors) == 1
    assert message in errors[0], errors[0]
    assert errors[0].startswith("error: script.toml: ") or "none.npz" in errors[0] or "light.txt" in errors[0]
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize("name,text,message", [
    ("s.json", "[1, 2]", "holds no table"), ("s.json", '{"n": 8,', "line 1: is not JSON"),
    ("s.json", '{"n": NaN, "action": [{"do": "merge"}]}', "not finite"), ("s.yaml", "n: 8", "'.yaml' are not read"),
])  # fmt: skip
def test_other_scripts(write, simulate, name, text, message):
    write(text, name)
    code, _, err = simulate(name)
    assert code == 2 and message in err


def test_missing_script_and_folder(simulate, write):
    assert "cannot be read: No such file" in simulate("none.toml")[2]
    write(TOML + RUN)
    assert "there is no folder" in simulate("script.toml", "--out", "no/where")[2]


@pytest.mark.parametrize("name,make,message", [
    ("a.npz", lambda p: np.savez(p, np.zeros((8, 8, 8, 3))), "has the shape (8, 8, 8, 3)"),
    ("a.npz", lambda p: np.savez(p, np.zeros((4, 4, 4, 4))), "8 x 8 x 8 cells"),
    ("a.npz", lambda p: np.savez(p, np.full((8, 8, 8, 4), np.nan)), "[0, 0, 0, 0]: is not a finite number"),
    ("a.npz", lambda p: np.savez(p, a=1, b=2), "has no array 'light', but: a, b"),
    ("a.npz", lambda p: np.savez(p, np.array(["x"])), "not numbers"),
    ("a.npz", lambda p: np.savez(p, np.array([{}])), "is not an NPZ of plain numbers"),
    ("a.npz", lambda p: p.write_bytes(b"PK\x03\x04"), "is not an NPZ"),
    ("a.npz", lambda p: p.write_bytes(b""), "is not an NPZ"),
    ("a.csv", lambda p: p.write_text(""), "the columns are nothing"),
    ("a.csv", lambda p: p.write_text("x,y,flux\n"), "begin with x,y,z,multiplier"),
    ("a.csv", lambda p: p.write_text("x,y,z,multiplier\n1,2,3\n"), "line 2: has 3 numbers, not 4"),
    ("a.csv", lambda p: p.write_text("x,y,z,multiplier\n1,2,8,1\n"), "line 2: cell [1.0, 2.0, 8.0] is not in"),
    ("a.csv", lambda p: p.write_text("x,y,z,multiplier\n1,2,3,nan\n"), "line 2: multiplier: is nan"),
    ("a.csv", lambda p: p.write_text("x,y,z,multiplier\n\n1,2,3,one\n"), "line 3: multiplier: is 'one'"),
    ("a.csv", lambda p: p.write_text("x,y,z,multiplier,dx,dy,dz\n1,2,3,1,0,0,0\n"), "its direction is 0"),
    ("a.csv", lambda p: p.write_bytes(b"\xff\xfe\x00"), "not UTF-8"),
])  # fmt: skip
def test_bad_files_of_light(tmp_path, name, make, message):
    make(tmp_path / name)
    with pytest.raises(SceneError) as raised:
        from_file(tmp_path / name, 8)
    assert message in str(raised.value) and str(tmp_path / name) in str(raised.value)


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples(example, tmp_path, simulate):
    """Each example runs; a smaller volume and fewer iterations show the same."""
    text = example.read_text(encoding="utf-8").replace("n = 32", "n = 16").replace("iterations = 30", "iterations = 4")
    (tmp_path / "example.toml").write_text(text, encoding="utf-8")
    code, _, err = simulate("example.toml", "--out", "made")
    assert code == 0, err
    for path in (tmp_path / "made").glob("*.png"):
        assert Image.open(path).convert("L").getextrema()[0] < 100
