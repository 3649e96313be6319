"""The text of MTL files, the material libraries of OBJ (Wavefront, "MTL material format", 1995; paulbourke.net).

Read here and not by assimp, which hides which lines a material has and loses the options of map lines.
"""

from __future__ import annotations

import shlex
from dataclasses import dataclass, field
from pathlib import Path

from ..errors import SceneError
from ..files import read_file

# Options of map lines and how many values follow; -o, -s and -t take one to three.
_OPTIONS = {"-blendu": 1, "-blendv": 1, "-boost": 1, "-bm": 1, "-cc": 1, "-clamp": 1, "-imfchan": 1, "-mm": 2}
_OPTIONS |= {"-o": 3, "-s": 3, "-t": 3, "-texres": 1, "-type": 1}
_MAPS = {"map_kd": "map_kd", "map_ke": "map_ke", "map_d": "map_d", "norm": "norm", "bump": "bump", "map_bump": "bump"}
_COLORS = ("kd", "ks", "ke")
_NUMBERS = ("ns", "d", "tr", "illum")


@dataclass(frozen=True)
class MapLine:
    """A texture that an MTL file names: `file` as written there, and the options that octolux reads."""

    file: str
    clamp: bool = False
    bump_multiplier: float = 1.0


@dataclass
class MtlEntry:
    """One `newmtl` block. Keys are in lower case and absent when the file has no such line.

    colors: kd, ks, ke; numbers: ns, d, tr, illum; maps: map_kd, map_ke, map_d, bump, norm.
    """

    name: str
    colors: dict[str, tuple[float, float, float]] = field(default_factory=dict)
    numbers: dict[str, float] = field(default_factory=dict)
    maps: dict[str, MapLine] = field(default_factory=dict)


def read_mtl(path: Path) -> dict[str, MtlEntry]:
    """The materials of an MTL file by name, in its order. Raises SceneError with the line; OSError when unreadable."""
    entries: dict[str, MtlEntry] = {}
    current: MtlEntry | None = None
    for number, line in enumerate(read_file(path).decode("utf-8", errors="replace").splitlines(), start=1):
        keyword, _, rest = line.partition("#")[0].strip().partition(" ")
        keyword, tab, more = keyword.partition("\t")
        keyword, rest = keyword.lower(), (more + " " + rest if tab else rest).strip()
        if keyword == "newmtl":
            current = entries.setdefault(rest, MtlEntry(rest))
        elif current is not None and rest:
            try:
                _read_line(current, keyword, rest)
            except ValueError as error:
                remedy = f"write finite numbers after '{keyword}'"
                raise SceneError(path, f"line {number}", f"'{line.strip()}': {error}", remedy) from error
    return entries


def _read_line(entry: MtlEntry, keyword: str, rest: str) -> None:
    if keyword in _COLORS:
        entry.colors[keyword] = _color(rest.split())
    elif keyword in _NUMBERS:
        entry.numbers[keyword] = _number(rest.split()[-1])  # `d -halo 0.5` has its number last
    elif keyword in _MAPS:
        entry.maps[_MAPS[keyword]] = _map_line(rest)


def _number(word: str) -> float:
    value = float(word)
    if not abs(value) < 1e30:
        raise ValueError(f"{word} is not a finite number")
    return value


def _color(words: list[str]) -> tuple[float, float, float]:
    """Three numbers, or one for all three. Spectral curves and CIE XYZ (`Kd spectral f.rfl`, `Kd xyz ...`) are not."""
    values = [_number(word) for word in words[:3]]
    if len(values) == 1:
        values *= 3
    if len(values) != 3 or min(values) < 0:
        raise ValueError("a colour has three values, none negative")
    return values[0], values[1], values[2]


def _map_line(rest: str) -> MapLine:
    """Options first, then a file name that may hold spaces and backslashes."""
    clamp, multiplier, words = False, 1.0, _words(rest)
    while len(words) > 1 and words[0].lower() in _OPTIONS:
        option = words.pop(0).lower()
        values = _option_values(words, _OPTIONS[option], variable=option in ("-o", "-s", "-t"))
        if option == "-clamp" and values:
            clamp = values[0].lower() == "on"
        elif option == "-bm" and values:
            multiplier = _number(values[0])
    return MapLine(" ".join(words), clamp, multiplier)


def _option_values(words: list[str], count: int, variable: bool) -> list[str]:
    """Take an option's values off the front of `words`, of which the last always belongs to the file name."""
    values: list[str] = []
    while len(values) < count and len(words) > 1 and not (variable and values and not _is_number(words[0])):
        values.append(words.pop(0))
    return values


def _is_number(word: str) -> bool:
    try:
        float(word)
    except ValueError:
        return False
    return True


def _words(rest: str) -> list[str]:
    lexer = shlex.shlex(rest, posix=True)
    lexer.whitespace_split, lexer.escape, lexer.commenters = True, "", ""
    lexer.quotes = '"'
    try:
        return list(lexer)
    except ValueError:  # a lone quotation mark
        return rest.split()
