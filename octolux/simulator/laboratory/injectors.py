"""Injectors: which cells of level 0 are given which light (Olovsson 2012, 5.1).

The same shapes are occluders when they are added as such: then they fill the corners of cells with blocking instead
(`occlusion`). Cells and corners are counted from 0 along x, y, z.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import pi, sqrt
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np

from octolux.simulator import sh as harmonics

from .errors import SimulationError

AXES = ("x", "y", "z")

Direction = tuple[float, float, float] | str | None
"""Of a cosine lobe, any length; "all" or None is the same in all directions."""

Cell = tuple[int, int, int]

ISOTROPIC = np.array([2.0 * sqrt(pi), 0.0, 0.0, 0.0])
"""Coefficients of the function that is 1 in every direction."""


class Scales(NamedTuple):
    """Factors of the cosine lobe, and of the function that is 1 in every direction."""

    lobe: float
    isotropic: float


class Injector(Protocol):
    """What `Simulation` takes as injector or occluder."""

    def fill(self, n: int, scales: Scales) -> np.ndarray:
        """Coefficients [z][y][x][4] on n^3 places. Raises SimulationError when it does not lie within."""


ROLES = {"light": Scales(1.0 / pi, 1.0 / (4.0 * pi)), "blocking": Scales(1.0, 1.0)}
"""What a multiplier of 1 is: of light a flux of 1 W (lm) for each cell; of blocking A/s^2 = 1, the share of a cell's
cross-section that blocks light along the direction, or along all (Kaplanyan & Dachsbacher 2010, 3.2)."""


def light(injector: Injector, n: int) -> np.ndarray:
    """Intensity [z][y][x][4] that `injector` gives to n^3 cells."""
    return injector.fill(n, ROLES["light"])


def blocking(occluder: Injector, n: int) -> np.ndarray:
    """Blocking B(w) [z][y][x][4] that `occluder` gives to the (n + 1)^3 corners of n^3 cells."""
    return occluder.fill(n + 1, ROLES["blocking"])


def coefficients(direction: Direction, multiplier: float, scales: Scales) -> np.ndarray:
    """The four coefficients of a cosine lobe along `direction`, or of the same in all directions."""
    if direction is None or isinstance(direction, str):
        return multiplier * scales.isotropic * ISOTROPIC
    vector = np.asarray(direction, dtype=np.float64)
    vector = vector / np.abs(vector).max()  # so that neither tiny nor huge ones lose their length
    return multiplier * scales.lobe * harmonics.cosine_lobe(vector / np.linalg.norm(vector))


@dataclass(frozen=True)
class Area:
    """A box of cells, both ends included.

    direction: see `Direction`.  multiplier: 0 or more; `ROLES` says what of.
    """

    low: Cell
    high: Cell
    direction: Direction = None
    multiplier: float = 1.0

    def __post_init__(self) -> None:
        for name in ("low", "high"):
            object.__setattr__(self, name, _cell(name, getattr(self, name)))
        if any(a > b for a, b in zip(self.low, self.high, strict=True)):
            raise SimulationError(f"low = {self.low} lies beyond high = {self.high}", "exchange them")
        _check(self.direction, self.multiplier)

    def fill(self, n: int, scales: Scales) -> np.ndarray:
        if max(self.high) >= n:
            raise SimulationError(f"cell {self.high} is outside the volume", f"give 0 to {n - 1} along each axis")
        (x0, y0, z0), (x1, y1, z1) = self.low, self.high
        filled = np.zeros((n, n, n, 4))
        filled[z0 : z1 + 1, y0 : y1 + 1, x0 : x1 + 1] = coefficients(self.direction, self.multiplier, scales)
        return filled


@dataclass(frozen=True)
class Element:
    """A single element; fields as in `Area`."""

    cell: Cell
    direction: Direction = None
    multiplier: float = 1.0

    def __post_init__(self) -> None:
        object.__setattr__(self, "cell", _cell("cell", self.cell))
        _check(self.direction, self.multiplier)

    def fill(self, n: int, scales: Scales) -> np.ndarray:
        return Area(self.cell, self.cell, self.direction, self.multiplier).fill(n, scales)


@dataclass(frozen=True)
class Wall:
    """All cells whose coordinate along `axis` ("x", "y" or "z") is `index`; negative ones count from the far end.

    direction: by default (None) along the axis, away from the nearer end of the volume.
    """

    axis: str
    index: int = 0
    direction: Direction = None
    multiplier: float = 1.0

    def __post_init__(self) -> None:
        if self.axis not in AXES:
            raise SimulationError(f"a wall's axis is '{self.axis}'", f"give one of {', '.join(AXES)}")
        if isinstance(self.index, bool) or not isinstance(self.index, int):
            raise SimulationError(f"a wall's index is {self.index!r}", "give a whole number")
        _check(self.direction, self.multiplier)

    def fill(self, n: int, scales: Scales) -> np.ndarray:
        if not -n <= self.index < n:
            raise SimulationError(f"the wall at {self.axis} = {self.index} is outside", f"give {-n} to {n - 1}")
        at, axis = self.index % n, AXES.index(self.axis)
        low, high = [0] * 3, [n - 1] * 3
        low[axis] = high[axis] = at
        direction = self.direction
        if direction is None:
            inwards = [0.0] * 3
            inwards[axis] = 1.0 if 2 * at < n else -1.0
            direction = (inwards[0], inwards[1], inwards[2])
        return Area((low[0], low[1], low[2]), (high[0], high[1], high[2]), direction, self.multiplier).fill(
            n, scales
        )


@dataclass(frozen=True, eq=False)
class FromArray:
    """Coefficients [z][y][x][4] given whole: intensity, or blocking. `name` says where they came from."""

    coefficients: np.ndarray = field(repr=False)
    multiplier: float = 1.0
    name: str = "array"

    def __post_init__(self) -> None:
        values = np.array(self.coefficients, dtype=np.float64)
        if values.ndim != 4 or values.shape[3] != 4 or len(set(values.shape[:3])) != 1:
            raise SimulationError(f"{self.name}: has the shape {values.shape}", "give [z][y][x][4], a cube of cells")
        if not np.isfinite(values).all():
            raise SimulationError(f"{self.name}: holds numbers that are not finite", "replace NaN and infinity")
        values.setflags(write=False)
        object.__setattr__(self, "coefficients", values)
        _check(None, self.multiplier)

    def fill(self, n: int, scales: Scales) -> np.ndarray:
        if self.coefficients.shape[0] != n:
            raise SimulationError(f"{self.name}: is {self.coefficients.shape[0]} wide", f"give {n} along each axis")
        return self.multiplier * self.coefficients


def from_file(path: str | Path, n: int, role: str = "light", multiplier: float = 1.0) -> FromArray:
    """The injector (role "light"), or the occluder ("blocking"), for n^3 cells that an NPZ or CSV file holds; `files`
    tells their forms. Raises SceneError, which names file and place."""
    from .files import read_coefficients

    return FromArray(read_coefficients(Path(path), n if role == "light" else n + 1, role), multiplier, str(path))


def _cell(name: str, cell: object) -> Cell:
    numbers = np.asarray(cell)
    if numbers.shape != (3,) or numbers.dtype.kind not in "iu" or (numbers < 0).any():
        raise SimulationError(f"{name} is {cell!r}", "give three whole numbers x, y, z, none negative")
    x, y, z = (int(number) for number in numbers)
    return x, y, z


def _check(direction: object, multiplier: float) -> None:
    if isinstance(direction, str):
        if direction != "all":
            raise SimulationError(f"a direction is '{direction}'", "give three numbers, or 'all'")
    elif direction is not None:
        vector = np.asarray(direction)
        if vector.shape != (3,) or vector.dtype.kind not in "iuf" or not np.isfinite(vector).all() or not vector.any():
            raise SimulationError(f"a direction is {direction!r}", "give three finite numbers, not all 0")
    if isinstance(multiplier, bool) or not isinstance(multiplier, int | float) or not 0.0 <= multiplier < np.inf:
        raise SimulationError(f"a multiplier is {multiplier!r}", "give a finite number of at least 0")
