"""Checked access to a glTF's JSON: each look-up either gives the type asked for or raises SceneError with the place.

Plain `json` and these checks, not pygltflib: that fills dataclasses without looking at types or ranges, so that
mistakes surface later, as tracebacks without a place.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ..errors import SceneError

_REMEDY = "correct the file, or export the model again"
_LARGEST = 2**53  # integers above it are not exact in JSON


class Fields:
    """One JSON object of a glTF file. `place` says which ("accessor 3"); "" is the root."""

    def __init__(self, file: Path, place: str, values: dict[str, Any]):
        self.file, self.place, self.values = file, place, values

    def error(self, problem: str, remedy: str = _REMEDY) -> SceneError:
        return SceneError(self.file, self.place, problem, remedy)

    def __contains__(self, key: str) -> bool:
        return key in self.values

    def integer(self, key: str, default: int | None = None, *, low: int = 0, high: int = _LARGEST) -> int:
        """An integer in [low, high]; `default` when absent, an error when that is None."""
        value = self._value(key, default)
        if isinstance(value, float) and value.is_integer():
            value = int(value)
        if isinstance(value, bool) or not isinstance(value, int):
            raise self.error(f"'{key}' must be an integer, is {_show(value)}")
        if not low <= value <= high:
            raise self.error(f"'{key}' is {value}, must be in [{low}, {high}]")
        return value

    def index(self, key: str, count: int, what: str) -> int | None:
        """An index into a list of `count`, or None when absent."""
        if key not in self.values:
            return None
        value = self.integer(key)
        if value >= count:
            raise self.error(f"'{key}' asks for {what} {value}, the file has {count}")
        return value

    def indices(self, key: str, count: int, what: str) -> list[int]:
        """A list of indices into a list of `count`; empty when absent."""
        listed = Fields(self.file, f"{self.place}: {key}" if self.place else key, {})
        for position, value in enumerate(self._list(key)):
            listed.values[str(position)] = value
        return [i for i in (listed.index(position, count, what) for position in listed.values) if i is not None]

    def number(self, key: str, default: float | None = None, *, low: float = -1e30, high: float = 1e30) -> float:
        """A finite number in [low, high], as `integer`."""
        value = self._number(key, self._value(key, default))
        if not low <= value <= high:
            raise self.error(f"'{key}' is {value:g}, must be in [{low:g}, {high:g}]")
        return value

    def numbers(self, key: str, count: int, default: tuple[float, ...], *, low: float = -1e30) -> tuple[float, ...]:
        """`count` finite numbers, none below `low`; `default` when absent."""
        if key not in self.values:
            return default
        values = tuple(self._number(key, value) for value in self._list(key))
        if len(values) != count:
            raise self.error(f"'{key}' must hold {count} numbers, holds {len(values)}")
        if min(values) < low:
            raise self.error(f"'{key}' holds {min(values):g}, must be {low:g} or more")
        return values

    def boolean(self, key: str, default: bool) -> bool:
        value = self._value(key, default)
        if not isinstance(value, bool):
            raise self.error(f"'{key}' must be true or false, is {_show(value)}")
        return value

    def string(self, key: str, default: str | None = None) -> str:
        value = self._value(key, default)
        if not isinstance(value, str):
            raise self.error(f"'{key}' must be text, is {_show(value)}")
        return _unicode(value)

    def strings(self, key: str) -> list[str]:
        values = self._list(key)
        for value in values:
            if not isinstance(value, str):
                raise self.error(f"'{key}' must be a list of texts, holds {_show(value)}")
        return [_unicode(value) for value in values]

    def child(self, key: str) -> Fields | None:
        """The object under `key`, or None when absent."""
        if key not in self.values:
            return None
        value = self.values[key]
        if not isinstance(value, dict):
            raise self.error(f"'{key}' must be an object, is {_show(value)}")
        return Fields(self.file, f"{self.place}: {key}" if self.place else key, value)

    def extension(self, name: str) -> Fields | None:
        extensions = self.child("extensions")
        return extensions.child(name) if extensions else None

    def children(self, key: str, what: str) -> list[Fields]:
        """The list of objects under `key`, placed as "what 0", "what 1", ...; empty when absent."""
        prefix = f"{self.place} " if self.place else ""
        items = []
        for number, value in enumerate(self._list(key)):
            if not isinstance(value, dict):
                raise self.error(f"'{key}' must be a list of objects, holds {_show(value)}")
            items.append(Fields(self.file, f"{prefix}{what} {number}", value))
        return items

    def _value(self, key: str, default: Any) -> Any:
        value = self.values.get(key, default)
        if value is None:
            raise self.error(f"'{key}' is missing")
        return value

    def _list(self, key: str) -> list[Any]:
        value = self.values.get(key, [])
        if not isinstance(value, list):
            raise self.error(f"'{key}' must be a list, is {_show(value)}")
        return value

    def _number(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise self.error(f"'{key}' must be made of numbers, holds {_show(value)}")
        if not abs(value) <= 1e30:  # also false for nan, and safe for integers too large for a float
            raise self.error(f"'{key}' is not a finite number of usable size")
        return float(value)


def _show(value: Any) -> str:
    text = json.dumps(value)
    return text if len(text) <= 40 else text[:37] + "..."


def _unicode(text: str) -> str:
    """The text with "?" for halves of surrogate pairs, which JSON can hold and no file or terminal."""
    return text.encode("utf-8", "replace").decode()


def parse(file: Path, text: bytes) -> Fields:
    """The root object of a glTF's JSON. Raises SceneError when it is no valid UTF-8 JSON object."""
    root = Fields(file, "JSON", {})
    try:
        values = json.loads(text.decode("utf-8-sig"))
    except RecursionError as error:
        raise root.error("lists or objects are nested too deeply") from error
    except json.JSONDecodeError as error:
        raise root.error(f"{error.msg} in line {error.lineno}, column {error.colno}") from error
    except ValueError as error:  # not UTF-8, or an integer of thousands of digits
        raise root.error(f"not valid JSON text ({error})") from error
    if not isinstance(values, dict):
        raise root.error(f"the file must hold one object, holds {_show(values)}")
    return Fields(file, "", values)
