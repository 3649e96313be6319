"""Particle lights in TOML: from a file of numbers, or strewn evenly in a box."""

from __future__ import annotations

import zipfile
from io import BytesIO
from pathlib import Path

import numpy as np

from ..errors import SceneError
from ..files import read_file
from ..particles import MOST_PARTICLES, ParticleLights
from .fields import Table, nearest
from .models import file_path

STREWN = ("count", "box", "seed")
"""Keys that stand in the place of `file`."""

_MOST_BYTES = 1 << 26
"""Of a file, and of what a compressed one unfolds to: MOST_PARTICLES lines of six float64 numbers are 48 MiB."""

Rows = tuple[np.ndarray, np.ndarray | None]


def load_particles(table: Table, name: str) -> ParticleLights:
    """The group that a [[light]] of type "particles" describes. Raises SceneError."""
    table.allow(("type", "name", "file", "intensity", *STREWN))
    positions, intensities = _from_file(table) if "file" in table else _strewn(table)
    if intensities is None:
        intensities = np.array(table.color("intensity"))
    elif "intensity" in table:
        raise table.error("intensity", "stands beside a file that holds intensities", "leave it out")
    try:
        return ParticleLights(positions=positions, intensities=intensities, name=name)
    except SceneError as error:
        raise table.error("file", f"its {error.place} {error.problem}", error.remedy) from error


def _strewn(table: Table) -> Rows:
    if not any(key in table for key in STREWN):
        raise table.error("file", "is missing", "name a file of positions, or give count, box and seed")
    count = table.number("count", low=1, high=MOST_PARTICLES)
    seed = table.number("seed", 0.0, low=0, high=2**53)
    for key, value in (("count", count), ("seed", seed)):
        if value != int(value):
            raise table.error(key, f"is {value:g}", "give a whole number")
    low, high = (np.array(corner) for corner in table.rows("box", (3,), lines=2))
    if (low > high).any():
        raise table.error("box", "its first corner is not the lowest", "write [[x, y, z], [x, y, z]], the lower first")
    return np.random.default_rng(int(seed)).uniform(low, high, (int(count), 3)), None


def _from_file(table: Table) -> Rows:
    for key in STREWN:
        if key in table:
            raise table.error(key, "stands beside 'file'", "give either a file or count, box and seed")
    path = file_path(table, "file", table.text("file"))
    readers = {".npy": _npy, ".npz": _npz, ".csv": _csv}
    if path.suffix.lower() not in readers:
        raise table.error("file", f"'{path.name}' is no file of particles", nearest(path.suffix, readers))
    try:
        data = read_file(path)
        if len(data) > _MOST_BYTES:
            raise ValueError(f"it has {len(data):,} bytes, of at most {_MOST_BYTES:,}")
        return readers[path.suffix.lower()](data)
    except FileNotFoundError as error:
        options = [file.name for file in _beside(path) if file.suffix.lower() in readers]
        raise table.error("file", f"there is no file '{path}'", nearest(path.name, options)) from error
    except (OSError, ValueError, EOFError, MemoryError, zipfile.BadZipFile) as error:
        reason = getattr(error, "strerror", None) or error
        remedy = "give rows of x, y, z (metres), or of x, y, z, r, g, b (candela)"
        raise table.error("file", f"'{path}' cannot be read: {reason}", remedy) from error


def _beside(path: Path) -> list[Path]:
    return list(path.parent.iterdir()) if path.parent.is_dir() else []


def _npy(data: bytes) -> Rows:
    return _split(np.load(BytesIO(data), allow_pickle=False))


def _npz(data: bytes) -> Rows:
    """Arrays `positions` and, if they are there, `intensities`."""
    with zipfile.ZipFile(BytesIO(data)) as archive:
        if sum(entry.file_size for entry in archive.infolist()) > _MOST_BYTES:
            raise ValueError(f"it unfolds to more than {_MOST_BYTES:,} bytes")
    with np.load(BytesIO(data), allow_pickle=False) as arrays:
        if "positions" not in arrays:
            raise ValueError("it holds no array 'positions'")
        return arrays["positions"], arrays.get("intensities")


def _csv(data: bytes) -> Rows:
    """A row to a line; what follows a # is left out."""
    return _split(np.loadtxt(data.decode("utf-8-sig").splitlines(), delimiter=",", ndmin=2))


def _split(rows: np.ndarray) -> Rows:
    if rows.ndim != 2 or rows.shape[1] not in (3, 6):
        raise ValueError(f"it holds an array of the shape {rows.shape}")
    return rows[:, :3], rows[:, 3:] if rows.shape[1] == 6 else None
