"""Scenes made by code: always at hand, no files needed."""

from __future__ import annotations

from collections.abc import Callable

from ..scene import Scene
from .atrium import atrium
from .cornell_box import cornell_box
from .furnace import furnace

BUILTIN: dict[str, Callable[[], Scene]] = {"cornell-box": cornell_box, "furnace": furnace, "atrium": atrium}
"""Built-in scenes by name; each call makes a new Scene."""
