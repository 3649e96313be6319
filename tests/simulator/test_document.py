"""docs/simulate.md says what the laboratory takes and gives."""

from __future__ import annotations

import re
from pathlib import Path

from octolux.simulator.laboratory import PROPAGATORS, Simulation
from octolux.simulator.laboratory.actions import ACTIONS
from octolux.simulator.laboratory.results import FILES
from octolux.simulator.laboratory.script import SHAPES, TOP_KEYS, Script

PAGE = (Path(__file__).resolve().parents[2] / "docs" / "simulate.md").read_text(encoding="utf-8")


def test_every_propagator_is_listed():
    for propagator in PROPAGATORS.values():
        row = f"| `{propagator.name}` | {propagator.gain:g} | {propagator.meaning} | {propagator.source} |"
        assert row in PAGE


def test_every_key_and_action_is_listed():
    for key in TOP_KEYS:
        assert re.search(rf"^(\[\[)?{key}\b", PAGE, re.MULTILINE), key
    for name, (keys, _) in ACTIONS.items():
        assert f"`{name}`" in PAGE and all(f"`{key}`" in PAGE for key in keys), name
    for kind, keys in SHAPES.items():
        assert f'kind = "{kind}"' in PAGE and all(f"{key} = " in PAGE for key in keys)
    assert all(f"`{name}`" in PAGE for name in FILES)


def test_every_column_is_listed():
    """Except those that the page gives by their beginning."""
    simulation = Simulation(4, compare=["uniform", "analytic"])
    simulation.run(0)
    beginnings = tuple(re.findall(r"`(\w+?)(?:\.\.\.|_x)`", PAGE))
    for column in simulation.state.measures[0]:
        assert f"`{column}`" in PAGE or column.startswith(beginnings) or column == "iteration", column


def test_the_script_of_the_page_runs(tmp_path):
    block = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    path = tmp_path / "script.toml"
    path.write_text(block[1], encoding="utf-8")
    script = Script(path)
    script.run()
    assert script.simulation.state.merged.any()


def test_the_program_of_the_page_runs(capsys):
    block = re.search(r"```python\n(.*?)```", PAGE, re.DOTALL)
    exec(block[1], {})
    assert "(8, 8, 8, 4)" in capsys.readouterr().out
