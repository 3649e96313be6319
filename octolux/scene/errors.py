"""The one error that bad input raises."""

from __future__ import annotations

from pathlib import Path


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
    """

    def __init__(self, file: str | Path, place: str, problem: str, remedy: str):
        self.file, self.place, self.problem, self.remedy = str(file), place, problem, remedy
        where = f"{file}: {place}" if place else f"{file}"
        super().__init__(f"{where}: {problem}. {remedy}.")
