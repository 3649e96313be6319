"""The [medium] table of a TOML scene."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..files import check_ordinary
from ..medium import Medium
from .fields import Table
from .models import file_path

KEYS = ("scattering", "absorption", "density", "low", "high")
_REMEDY = "give a .npy file with an array (z, y, x) of numbers"


def load_medium(table: Table) -> Medium | None:
    """The medium that the table describes; None where there is no such table. Raises SceneError."""
    if not table.values:
        return None
    table.allow(KEYS)
    scattering, absorption = (table.color(key, (0.0, 0.0, 0.0)) for key in KEYS[:2])
    low, high = table.numbers("low", 3, None), table.numbers("high", 3, None)
    name = table.text("density", None)
    density = None if name is None else _density(table, file_path(table, "density", name))
    try:
        return Medium(scattering=scattering, absorption=absorption, density=density, low=low, high=high)
    except SceneError as error:
        raise table.error(error.place, error.problem, error.remedy) from error


def _density(table: Table, path: Path) -> np.ndarray:
    """The array of a .npy file as float32."""
    try:
        check_ordinary(path)
        with path.open("rb") as file:
            held = np.lib.format.read_array(file, allow_pickle=False)
    except FileNotFoundError as error:
        raise table.error("density", f"there is no file '{path}'", _REMEDY) from error
    except OSError as error:
        raise table.error("density", f"'{path}' cannot be read: {error.strerror}", _REMEDY) from error
    except (ValueError, EOFError) as error:
        raise table.error("density", f"'{path}' is no array: {error}", _REMEDY) from error
    if not np.issubdtype(held.dtype, np.integer) and not np.issubdtype(held.dtype, np.floating):
        raise table.error("density", f"'{path}' holds {held.dtype}", _REMEDY)
    with np.errstate(over="ignore"):  # what leaves float32's range is infinite then, and refused as such
        return held.astype(np.float32)
