"""What is typed into fields, as values. All raise SimulationError, which says what to type instead."""

from __future__ import annotations

import base64
import binascii
from collections.abc import Sequence
from pathlib import Path
from tempfile import TemporaryDirectory

from octolux.scene.errors import SceneError
from octolux.simulator.laboratory import SimulationError, from_file
from octolux.simulator.laboratory.injectors import Cell, Direction, FromArray


def numbers(name: str, text: str) -> list[float]:
    """Numbers between commas or spaces."""
    try:
        return [float(part) for part in text.replace(",", " ").split()]
    except ValueError as error:
        raise SimulationError(f"{name} is '{text}'", "give numbers with commas between them") from error


def cell(name: str, text: str) -> Cell:
    """Three whole numbers."""
    values = numbers(name, text)
    if len(values) != 3 or not all(value.is_integer() for value in values):
        raise SimulationError(f"{name} is '{text}'", "give three whole numbers x, y, z")
    x, y, z = (int(value) for value in values)
    return x, y, z


def direction(text: str) -> Direction:
    """Nothing, "all", or three numbers."""
    if text.strip() in ("", "all"):
        return text.strip() or None
    values = numbers("the direction", text)
    if len(values) != 3:
        raise SimulationError(f"the direction is '{text}'", "give three numbers, 'all', or nothing for the default")
    x, y, z = values
    return x, y, z


def factor(text: str) -> float | Sequence[float]:
    """One number, or one for each level."""
    values = numbers("the factor", text)
    if not values:
        raise SimulationError("the factor is empty", "give a number, or one for each level")
    return values[0] if len(values) == 1 else values


def uploaded(name: str, contents: str, n: int, role: str, multiplier: float) -> FromArray:
    """The injector or occluder of an NPZ or CSV file that the browser sent: its name, and its contents in base64.

    Raises SceneError, with the file's own name, too.
    """
    if not name:
        raise SimulationError("no file is chosen", "choose an .npz or .csv file first")
    try:
        data = base64.b64decode(contents, validate=True)
    except binascii.Error as error:
        raise SimulationError(f"{name} did not arrive whole", "choose it again") from error
    with TemporaryDirectory() as folder:
        path = Path(folder) / Path(name).name
        path.write_bytes(data)
        try:
            made = from_file(path, n, role, multiplier)
        except SceneError as error:
            raise SceneError(path.name, error.place, error.problem, error.remedy) from error
    return FromArray(made.coefficients, multiplier, path.name)
