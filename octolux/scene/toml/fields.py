"""Checked access to the tables of a TOML scene: each look-up gives the type asked for, or raises SceneError with the
place and what to write instead."""

from __future__ import annotations

import difflib
from collections.abc import Iterable, Sequence
from math import inf, isfinite
from pathlib import Path
from typing import Any

from ..errors import SceneError
from ..materials import Color

MISSING: Any = object()
"""The default of a field that must be given."""

LARGEST = 1e30
"""Of numbers in TOML. float32 holds 3.4e38; this leaves room for factors."""

Vector3 = tuple[float, float, float]


class Table:
    """One table of a TOML file. `place` says which: "[[light]] 2 'lamp'", or "" for the top of the file."""

    def __init__(self, file: Path, place: str, values: dict[str, Any]):
        self.file, self.place, self.values = file, place, values

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def error(self, key: str, problem: str, remedy: str) -> SceneError:
        """The error for one key of this table, or for the whole table when `key` is ""."""
        return SceneError(self.file, ": ".join(part for part in (self.place, key) if part), problem, remedy)

    def allow(self, keys: Iterable[str]) -> None:
        """Raises SceneError, naming the nearest valid key, when the table has a key that is not in `keys`."""
        keys = list(keys)
        for key in self.values:
            if key not in keys:
                raise self.error(key, "there is no such key here", nearest(key, keys))

    def text(self, key: str, default: Any = MISSING) -> Any:
        """A string that is not empty, or `default`."""
        value = self._get(key, default, 'give it as text, in quotes')
        if key in self.values and (not isinstance(value, str) or not value):
            raise self._wrong(key, value, "text", "write it in quotes, not empty")
        return value

    def choice(self, key: str, options: Sequence[str], default: Any = MISSING) -> str:
        """One of `options`, or `default`."""
        value = self.text(key, default)
        if value not in options:
            raise self.error(key, f"is '{value}'", nearest(value, options))
        return value

    def texts(self, key: str) -> list[str]:
        """A list of strings; empty when absent."""
        values = self.values.get(key, [])
        if not isinstance(values, list) or not all(isinstance(v, str) for v in values):
            raise self._wrong(key, values, "a list of texts", 'write it as ["one", "two"]')
        return values

    def boolean(self, key: str, default: Any = MISSING) -> Any:
        """True or false, or `default`."""
        value = self._get(key, default, "give true or false")
        if key in self.values and not isinstance(value, bool):
            raise self._wrong(key, value, "true or false", "write true or false, without quotes")
        return value

    def number(self, key: str, default: Any = MISSING, *, low: float = -inf, high: float = inf, above: float = -inf,
               below: float = inf) -> Any:
        """A finite number in [low, high] and in (above, below), or `default`."""
        value = self._get(key, default, "give a number")
        if key not in self.values:
            return value
        self._usable(key, value)
        if not _is_number(value):
            raise self._wrong(key, value, "a number", "write it without quotes or brackets")
        if not (low <= value <= high and above < value < below):
            raise self.error(key, f"is {value:g}", _range_text(low, high, above, below))
        return float(value)

    def numbers(self, key: str, count: int, default: Any = MISSING) -> Any:
        """`count` finite numbers as a tuple, or `default`."""
        shape = f"write {count} numbers in brackets"
        value = self._get(key, default, shape)
        if key not in self.values:
            return value
        return self._row(key, value, count, shape)

    def rows(self, key: str, counts: Iterable[int], lines: int | None = None) -> list[tuple[float, ...]]:
        """A list of lists of numbers, each as long as one of `counts`; `lines` of them when that is given."""
        counts = list(counts)
        wanted = f"write {lines or 'one or more'} lists of {' or '.join(map(str, counts))} numbers, [[...], ...]"
        value = self._get(key, MISSING, wanted)
        if not isinstance(value, list) or not value or (lines is not None and len(value) != lines):
            raise self._wrong(key, value, "a list of lists", wanted)
        lengths = [len(row) if isinstance(row, list) else 0 for row in value]
        return [self._row(key, row, n if n in counts else counts[0], wanted)
                for row, n in zip(value, lengths, strict=True)]

    def direction(self, key: str, default: Any = MISSING) -> Vector3:
        """Three numbers that are not all zero."""
        value = self.numbers(key, 3, default)
        if not any(value):
            raise self.error(key, "has no direction, all its numbers are 0", "give a vector of any length above 0")
        return value

    def color(self, key: str, default: Any = MISSING, *, high: float = inf) -> Color:
        """Three numbers in [0, high] (red, green, blue), or one for all three; or `default`."""
        self._usable(key, self.values.get(key))
        if key in self.values and _is_number(self.values[key]):
            color = (float(self.values[key]),) * 3
        else:
            color = self.numbers(key, 3, default)
        if key in self.values and not all(0.0 <= c <= high for c in color):
            wrong = next(c for c in color if not 0.0 <= c <= high)
            raise self.error(key, f"holds {wrong:g}", _range_text(0.0, high))
        return color

    def table(self, key: str) -> Table:
        """The sub-table [key]; an empty one when absent."""
        value = self.values.get(key, {})
        if not isinstance(value, dict):
            raise self._wrong(key, value, "a table", f"write it below a line [{key}]")
        return Table(self.file, f"[{key}]", value)

    def tables(self, key: str) -> list[Table]:
        """The array of tables [[key]], placed as "[[key]] 1", or with their name when they have one."""
        values = self.values.get(key, [])
        if not isinstance(values, list) or not all(isinstance(v, dict) for v in values):
            raise self._wrong(key, values, "a list of tables", f"begin each one with a line [[{key}]]")
        return [Table(self.file, _numbered(key, number, value), value) for number, value in enumerate(values, 1)]

    def _get(self, key: str, default: Any, remedy: str) -> Any:
        value = self.values.get(key, default)
        if value is MISSING:
            raise self.error(key, "is missing", remedy)
        return value

    def _usable(self, key: str, *values: Any) -> None:
        """Raises SceneError when one of the values is a number, but none to compute with."""
        for value in values:
            if isinstance(value, int | float) and not isinstance(value, bool) and not _is_number(value):
                problem = "not finite" if isinstance(value, float) and not isfinite(value) else "too large"
                raise self.error(key, f"holds a number that is {problem}", f"give one from -{LARGEST:g} to {LARGEST:g}")

    def _row(self, key: str, value: Any, count: int, remedy: str) -> tuple[float, ...]:
        self._usable(key, *(value if isinstance(value, list) else ()))
        if not isinstance(value, list) or len(value) != count or not all(_is_number(v) for v in value):
            raise self._wrong(key, value, f"{count} numbers", remedy)
        return tuple(float(v) for v in value)

    def _wrong(self, key: str, value: Any, expected: str, remedy: str) -> SceneError:
        shown = repr(value)
        shown = shown if len(shown) <= 60 else shown[:57] + "..."
        return self.error(key, f"must be {expected}, is {shown}", remedy)


def nearest(word: str, options: Iterable[str]) -> str:
    """A remedy: the option most like `word`, or all options when there are few, or the first ones."""
    options = list(dict.fromkeys(options))
    folded = {option.lower(): option for option in options}
    close = difflib.get_close_matches(word.lower(), folded, n=1)
    if close:
        return f"perhaps '{folded[close[0]]}' is meant"
    if not options:
        return "leave it out: there is nothing it could name"
    return "give one of: " + ", ".join(options[:20]) + (", ..." if len(options) > 20 else "")


def _is_number(value: Any) -> bool:
    """Whether it is a number that a float holds; integers in TOML may be larger, and floats may be nan or inf."""
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def _numbered(key: str, number: int, value: dict[str, Any]) -> str:
    name = value.get("name")
    return f"[[{key}]] {number} '{name}'" if isinstance(name, str) and name else f"[[{key}]] {number}"


def _range_text(low: float, high: float, above: float = -inf, below: float = inf) -> str:
    bounds = [(low, "at least"), (above, "more than"), (high, "at most"), (below, "less than")]
    return "give " + " and ".join(f"{words} {bound:g}" for bound, words in bounds if isfinite(bound))
