"""Scripts: a simulation and its actions as TOML or JSON; docs/simulate.md lists the keys.

Everything is read and checked before anything runs; every mistake is a SceneError that names file and place.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

from octolux.scene.errors import SceneError
from octolux.scene.files import read_file
from octolux.scene.toml.fields import Table
from octolux.scene.toml.loader import parsed

from . import results
from .actions import Action, read_action
from .injectors import AXES, ROLES, Area, Element, Injector, Wall, from_file
from .simulation import Simulation
from .tables import cell, factor, placed, whole

TOP_KEYS = (
    "n", "coarsest", "combine", "threshold", "propagator", "factor", "compare", "uniform_iterations", "injector",
    "occluder", "action",
)  # fmt: skip
SHAPES = {
    "wall": ("axis", "index"), "element": ("cell",), "area": ("low", "high"), "file": ("file",),
}  # fmt: skip
"""The kinds of injectors and occluders, with the keys that only they have."""


class Script:
    """A script that was read: `simulation` as it begins, and the `actions` that are to come."""

    def __init__(self, path: str | Path):
        """Read a .toml or .json file. Raises SceneError."""
        self.path = Path(path)
        top = Table(self.path, "", _values(self.path))
        top.allow(TOP_KEYS)
        settings = _settings(top)
        with placed(top, ""):
            n = Simulation(**settings).state.n
        for name, role in (("injector", "light"), ("occluder", "blocking")):
            settings[f"{name}s"] = [_shape(table, n, role) for table in top.tables(name)]
        self.simulation = Simulation(**settings)
        tables = top.tables("action")
        if not tables:
            raise top.error("action", "there is nothing to do", 'write [[action]] and do = "run", iterations = 4')
        self.actions: list[tuple[Table, Action]] = [
            (table, read_action(table, len(self.simulation.state.injectors))) for table in tables
        ]
        self._check_files()

    def run(self, progress: Callable[[str], None] = lambda text: None) -> dict[str, bytes]:
        """Do all actions; the pictures and states they made, by file name. Raises SceneError."""
        files: dict[str, bytes] = {}
        for number, (table, action) in enumerate(self.actions, 1):
            progress(f"{number} of {len(self.actions)}: {table.values['do']}")
            with placed(table, ""):
                made = action.perform(self.simulation)
            if made is not None:
                files[str(action.file)] = made
        return files

    def _check_files(self) -> None:
        taken = set(results.FILES)
        for table, action in self.actions:
            if action.file in taken:
                raise table.error("file", f"'{action.file}' is written already", "give each file its own name")
            taken |= {action.file} if action.file else set()


def _values(path: Path) -> dict[str, Any]:
    if path.suffix.lower() == ".toml":
        return parsed(path)
    if path.suffix.lower() != ".json":
        raise SceneError(path, "", f"scripts of the kind '{path.suffix}' are not read", "give a .toml or a .json")
    try:
        values = json.loads(read_file(path).decode("utf-8-sig"))
    except json.JSONDecodeError as error:
        remedy = "correct the line; json.org shows how it is written"
        raise SceneError(path, f"line {error.lineno}", f"is not JSON: {error.msg}", remedy) from error
    except (OSError, ValueError, RecursionError) as error:
        problem = getattr(error, "strerror", None) or "it is not plain UTF-8 text"
        raise SceneError(path, "", f"cannot be read: {problem}", "check the name and the permissions") from error
    if not isinstance(values, dict):
        raise SceneError(path, "", "holds no table", 'begin with { "n": 32, "action": [...] }')
    return values


def _settings(top: Table) -> dict[str, Any]:
    """The arguments of `Simulation` that the script gives; it checks names and ranges itself."""
    given: dict[str, Any] = {}
    for key in ("n", "coarsest", "uniform_iterations"):
        given[key] = whole(top, key, None)
    for key in ("combine", "propagator"):
        given[key] = top.text(key, None)
    given["threshold"] = top.number("threshold", None)
    given["factor"] = factor(top)
    given["compare"] = top.texts("compare")
    return {key: value for key, value in given.items() if value is not None}


def _shape(table: Table, n: int, role: str) -> Injector:
    """The injector or occluder that a table describes, tried on its own so that what does not fit is placed there."""
    kind = table.choice("kind", list(SHAPES))
    table.allow(("name", "kind", *SHAPES[kind], "multiplier", *(() if kind == "file" else ("direction",))))
    multiplier = table.number("multiplier", 1.0, low=0.0)
    if kind == "file":
        return from_file(table.file.parent / table.text("file"), n, role, multiplier)
    with placed(table, ""):
        shape = _drawn(table, kind, multiplier)
        shape.fill(n if role == "light" else n + 1, ROLES[role])
    return shape


def _drawn(table: Table, kind: str, multiplier: float) -> Injector:
    direction = table.values.get("direction")
    if direction is not None and not isinstance(direction, str):
        direction = table.direction("direction")
    if kind == "wall":
        return Wall(table.choice("axis", AXES), whole(table, "index", 0), direction, multiplier)
    if kind == "element":
        return Element(cell(table, "cell"), direction, multiplier)
    return Area(cell(table, "low"), cell(table, "high"), direction, multiplier)
