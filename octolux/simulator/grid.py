"""The uniform grid of cubic cells in which a light propagation volume lives."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Grid:
    """n^3 cubic cells. Cell (x, y, z) spans origin + h * (x, y, z) to origin + h * (x + 1, y + 1, z + 1).

    origin: lowest corner, metres, world space.
    cell_size: edge h of a cell, metres.
    n: cells along each side.

    Raises ValueError when the size is not positive or the origin is not three finite numbers.
    """

    origin: tuple[float, float, float]
    cell_size: float
    n: int

    def __post_init__(self) -> None:
        if np.shape(self.origin) != (3,) or not np.isfinite(self.origin).all():
            raise ValueError(f"grid origin must be three finite numbers, got {self.origin}")
        if not (0.0 < self.cell_size < np.inf):
            raise ValueError(f"grid cell size must be positive and finite, got {self.cell_size}")
        if self.n < 1:
            raise ValueError(f"a grid needs at least one cell on a side, got n = {self.n}")
        object.__setattr__(self, "origin", tuple(float(v) for v in self.origin))

    @classmethod
    def around(cls, low, high, n: int) -> Grid:
        """The default volume of a scene with bounds `low` (3,), `high` (3,): its bounding cube, concentric with the
        box, plus one cell on each side, so that VPLs pushed off the outermost walls stay inside: h = side / (n - 2).

        Raises ValueError for n < 3 or an empty box.
        """
        low, high = np.asarray(low, dtype=np.float64), np.asarray(high, dtype=np.float64)
        if n < 3:
            raise ValueError(f"a grid with one spare cell on each side needs n >= 3, got {n}")
        side = float(np.max(high - low))
        if not side > 0.0:
            raise ValueError(f"the box from {low} to {high} has no extent; a grid needs one")
        cell_size = side / (n - 2)
        origin = 0.5 * (low + high) - 0.5 * n * cell_size
        return cls(tuple(origin), cell_size, n)

    def moved(self, cells: float) -> Grid:
        """The same grid, so many cells further along x, y and z."""
        x, y, z = (o + cells * self.cell_size for o in self.origin)
        return Grid((x, y, z), self.cell_size, self.n)

    def to_cells(self, points) -> np.ndarray:
        """World `points` (..., 3) in units of cells from the origin, float64 (..., 3)."""
        return (np.asarray(points, dtype=np.float64) - self.origin) / self.cell_size

    def cell_of(self, points) -> np.ndarray:
        """Integer cells (x, y, z) of world `points` (..., 3): int64 (..., 3), not clamped to the grid.

        A point on a face belongs to the upper cell.
        """
        return np.floor(self.to_cells(points)).astype(np.int64)

    def inside(self, points) -> np.ndarray:
        """Which world `points` (..., 3) lie in a cell of the grid: bool (...). The upper border is outside."""
        cells = self.cell_of(points)
        return np.all((cells >= 0) & (cells < self.n), axis=-1)

    def cell_centres(self) -> np.ndarray:
        """World positions of the cell centres, float64 (n, n, n, 3), indexed [z][y][x] as the SH arrays are."""
        steps = np.arange(self.n) + 0.5
        z, y, x = np.meshgrid(steps, steps, steps, indexing="ij")
        return np.stack([x, y, z], axis=-1) * self.cell_size + self.origin
