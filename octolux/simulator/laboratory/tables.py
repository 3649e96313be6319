"""What reading a script's tables needs besides `octolux.scene.toml.fields`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from octolux.scene.toml.fields import MISSING, Table

from .errors import SimulationError


@contextmanager
def placed(table: Table, key: str) -> Iterator[None]:
    """Errors of the simulation become errors of the file, at `key` of `table`."""
    try:
        yield
    except SimulationError as error:
        raise table.error(key, error.problem, error.remedy) from error


def whole(table: Table, key: str, default: Any = MISSING, *, low: int = -(10**9), high: int = 10**9) -> Any:
    """A whole number in [low, high], or `default`. Raises SceneError."""
    value = table.number(key, default, low=low, high=high)
    if key in table and value != int(value):
        raise table.error(key, f"is {value:g}", "give a whole number")
    return int(value) if key in table else value


def factor(table: Table) -> float | list[float] | None:
    """The propagation factor: a number, a list of them, or None where there is none. Raises SceneError."""
    values = table.values.get("factor")
    if isinstance(values, list):
        return list(table.numbers("factor", len(values)))
    return table.number("factor", None, low=0.0)


def cell(table: Table, key: str) -> tuple[int, int, int]:
    """Three whole numbers, none negative. Raises SceneError."""
    x, y, z = table.numbers(key, 3)
    if not all(number.is_integer() and number >= 0.0 for number in (x, y, z)):
        raise table.error(key, f"is [{x:g}, {y:g}, {z:g}]", "give three whole numbers, none negative")
    return int(x), int(y), int(z)
