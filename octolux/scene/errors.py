"""The one error that bad input raises."""

from __future__ import annotations

from pathlib import Path

_PLACE, _PROBLEM, _REMEDY = 120, 240, 300  # characters; what files hold may be of any length


def one_line(text: str, longest: int) -> str:
    """The text in at most `longest` characters, cut in its middle; what cannot be printed is escaped as in Python."""
    plain = "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)
    return plain if len(plain) <= longest else f"{plain[: longest * 2 // 3]} ... {plain[-(longest // 4):]}"


class OctoluxError(Exception):
    """A problem that the user can mend. The CLI prints its text and exits with 2; it never shows a traceback."""


class SceneError(OctoluxError):
    """Bad scene input: which file, where in it, what is wrong, what to do about it.

    Parameters
    ----------
    file: the file that holds the mistake.
    place: where in the file ("accessor 3", "line 12", "[[light]] 2: intensity"); "" when the whole file is meant.
    problem: what is wrong, as a sentence without a full stop.
    remedy: what the user can do, as a sentence without a full stop.

    What they quote from the file may be anything: they are made one line each, and shortened.
    """

    def __init__(self, file: str | Path, place: str, problem: str, remedy: str):
        self.file, self.place = str(file), one_line(place, _PLACE)
        self.problem, self.remedy = one_line(problem, _PROBLEM), one_line(remedy, _REMEDY)
        where = f"{file}: {self.place}" if place else f"{file}"
        super().__init__(f"{where}: {self.problem}. {self.remedy}.")
