"""Where an OBJ file is wrong, line by line: slow, and therefore only asked after loading has failed."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from math import isfinite
from pathlib import Path

_SIZES = {"v": 3, "vt": 1, "vn": 3}
# Lines, points, and faces of one or two corners.
_NOT_FACES = re.compile(rb"^[ \t]*(?:[lp][ \t].*|f(?:[ \t]+[^ \t\r\n]+){1,2}[ \t\r]*)$", re.MULTILINE)


def find_fault(path: Path) -> tuple[str, str] | None:
    """The first line that cannot be right, as ("line 12", problem), or None when every line looks right."""
    lines = [line.partition("#")[0].split() for line in path.read_text("utf-8", errors="replace").splitlines()]
    totals = {keyword: sum(words[:1] == [keyword] for words in lines) for keyword in _SIZES}
    before = dict.fromkeys(_SIZES, 0)
    for number, words in enumerate(lines, start=1):
        problem = None
        if words and words[0] in _SIZES:
            before[words[0]] += 1
            problem = _vector_problem(words[0], words[1:])
        elif words and words[0] == "f":
            problem = _face_problem(words[1:], before, totals)
        if problem:
            return f"line {number}", problem
    return None if totals["v"] else ("", "the file holds no vertices ('v' lines)")


def _vector_problem(keyword: str, words: list[str]) -> str | None:
    try:
        values = [float(word) for word in words]
    except ValueError:
        return f"'{keyword} {' '.join(words)}' holds something that is not a number"
    if len(values) < _SIZES[keyword]:
        return f"'{keyword}' needs {_SIZES[keyword]} numbers, found {len(values)}"
    return None if all(map(isfinite, values)) else f"'{keyword} {' '.join(words)}' is not finite"


def _face_problem(corners: list[str], before: dict[str, int], totals: dict[str, int]) -> str | None:
    """Positive indices count from the first line of the file, negative ones back from the face."""
    for corner in corners:
        for word, keyword in zip(corner.split("/"), _SIZES, strict=False):
            try:
                index = int(word or "1")
            except ValueError:
                return f"face corner '{corner}' is not made of whole numbers"
            count = totals[keyword] if index >= 0 else before[keyword]
            if word and not 0 < abs(index) <= count:
                return f"face corner '{corner}' asks for number {index} of {count} '{keyword}' lines"
    return None


@contextmanager
def cleaned(path: Path) -> Iterator[Path]:
    """A temporary copy of an OBJ file without its lines, points and faces of fewer than three corners, its names in
    UTF-8, where bytes that are none are replaced as `read_mtl` does."""
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / path.name
        copy.write_text(_NOT_FACES.sub(b"", path.read_bytes()).decode("utf-8", "replace"), "utf-8", newline="")
        yield copy
