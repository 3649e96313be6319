"""Reading injectors and occluders from files.

NPZ: an array `light` (or `blocking`), or the only one there is: coefficients [z][y][x][4] in the order 1, y, z, x.
CSV: a header and one line for each cell: x, y, z and either c00, c1-1, c10, c11, or multiplier and, for a direction,
dx, dy, dz. Lines for the same cell add up.
"""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from octolux.scene.errors import SceneError
from octolux.scene.files import read_file

from .injectors import ROLES, Scales, coefficients

COEFFICIENTS = ("c00", "c1-1", "c10", "c11")
"""Names of the four coefficients, in their order."""

CELL, DIRECTION = ("x", "y", "z"), ("dx", "dy", "dz")
_FORMS = (
    {*CELL, *COEFFICIENTS},
    {*CELL, "multiplier"},
    {*CELL, "multiplier", *DIRECTION},
)


def read_coefficients(path: Path, n: int, role: str = "light") -> np.ndarray:
    """Coefficients [z][y][x][4] of n^3 places that the file holds, in the form `role` asks for ("light", "blocking").

    Raises SceneError: cannot be read, other kind, other shape, not finite.
    """
    if path.suffix.lower() not in (".npz", ".csv"):
        raise SceneError(path, "", f"files of the kind '{path.suffix}' are not read", "give an .npz or a .csv")
    try:
        data = read_file(path)
    except (OSError, ValueError) as error:
        problem = getattr(error, "strerror", None) or error
        raise SceneError(path, "", f"cannot be read: {problem}", "check the name and the permissions") from error
    values = _npz(path, data, role) if path.suffix.lower() == ".npz" else _csv(path, data, n, ROLES[role])
    if values.shape != (n, n, n, 4):
        remedy = f"give coefficients [z][y][x][4] of {n} x {n} x {n} cells"
        raise SceneError(path, f"array of {role}", f"has the shape {values.shape}", remedy)
    if not np.isfinite(values).all():
        where = np.argwhere(~np.isfinite(values))[0].tolist()
        raise SceneError(path, f"array of {role} {where}", "is not a finite number", "replace NaN and infinity")
    return values


def _npz(path: Path, data: bytes, role: str) -> np.ndarray:
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            name = role if role in arrays.files else arrays.files[0] if len(arrays.files) == 1 else ""
            if not name:
                names = ", ".join(arrays.files[:10]) or "none"
                raise SceneError(path, "", f"has no array '{role}', but: {names}", "name the array so")
            values = arrays[name]
    except (ValueError, EOFError, OSError, KeyError, zipfile.BadZipFile) as error:
        raise SceneError(path, "", "is not an NPZ of plain numbers", "write it with numpy.savez") from error
    if values.dtype.kind not in "iuf":
        raise SceneError(path, name, f"holds {values.dtype}, not numbers", "write it as float64")
    return values.astype(np.float64)


def _csv(path: Path, data: bytes, n: int, scales: Scales) -> np.ndarray:
    volume = np.zeros((n, n, n, 4))
    for line, numbers in _rows(path, data):
        cell = np.array([numbers[name] for name in CELL])
        if (cell != np.floor(cell)).any() or (cell < 0).any() or (cell >= n).any():
            remedy = f"give whole numbers from 0 to {n - 1}"
            raise SceneError(path, f"line {line}", f"cell {cell.tolist()} is not in the volume", remedy)
        x, y, z = cell.astype(int)
        if COEFFICIENTS[0] in numbers:
            volume[z, y, x] += [numbers[name] for name in COEFFICIENTS]
            continue
        dx, dy, dz = (numbers.get(name, 0.0) for name in DIRECTION)
        if DIRECTION[0] in numbers and not (dx or dy or dz):
            raise SceneError(path, f"line {line}", "its direction is 0", "give a vector of any length above 0")
        direction = (dx, dy, dz) if DIRECTION[0] in numbers else None
        volume[z, y, x] += coefficients(direction, numbers["multiplier"], scales)
    return volume


def _rows(path: Path, data: bytes) -> Iterator[tuple[int, dict[str, float]]]:
    """The number of each line, and its numbers by column."""
    try:
        reader = csv.reader(io.StringIO(data.decode("utf-8-sig")))
        header = [name.strip() for name in next(reader, [])]
        if set(header) not in _FORMS or len(header) != len(set(header)):
            shown = ", ".join(header[:10]) or "nothing"
            remedy = "begin with x,y,z,multiplier or x,y,z,multiplier,dx,dy,dz or x,y,z,c00,c1-1,c10,c11"
            raise SceneError(path, "line 1", f"the columns are {shown}", remedy)
        for row in reader:
            if row:
                yield reader.line_num, _numbers(path, reader.line_num, header, row)
    except UnicodeDecodeError as error:
        raise SceneError(path, "", "is not UTF-8 text", "save it as UTF-8") from error
    except csv.Error as error:
        raise SceneError(path, "", f"is not CSV: {error}", "separate numbers by commas") from error


def _numbers(path: Path, line: int, header: list[str], row: list[str]) -> dict[str, float]:
    if len(row) != len(header):
        raise SceneError(path, f"line {line}", f"has {len(row)} numbers, not {len(header)}", "complete the line")
    numbers = {}
    for name, text in zip(header, row, strict=True):
        try:
            numbers[name] = float(text)
        except ValueError:
            raise SceneError(path, f"line {line}: {name}", f"is '{text.strip()}'", "give a number") from None
        if not np.isfinite(numbers[name]):
            raise SceneError(path, f"line {line}: {name}", f"is {text.strip()}", "give a finite number")
    return numbers
