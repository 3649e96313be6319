"""Scenes made by code: always at hand, no files needed."""

from __future__ import annotations

from collections.abc import Callable
from inspect import getdoc

from ..scene import Scene
from .atrium import atrium
from .conference import conference
from .cornell_box import cornell_box
from .corridor import corridor
from .foliage import foliage
from .furnace import furnace
from .spheres import spheres
from .two_rooms import two_rooms

BUILTIN: dict[str, Callable[[], Scene]] = {
    "cornell-box": cornell_box,
    "furnace": furnace,
    "atrium": atrium,
    "corridor": corridor,
    "two-rooms": two_rooms,
    "foliage": foliage,
    "conference": conference,
    "spheres": spheres,
}
"""Built-in scenes by name; each call makes a new Scene."""


def description(name: str) -> str:
    """What the built-in scene `name` is, in one line: the first of its function's docstring. Raises KeyError."""
    return (getdoc(BUILTIN[name]) or "").splitlines()[0]
