"""How the levels of a volume lie in its buffers: one level for a uniform volume, all of them for an octree."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod
from typing import Any

import numpy as np

WORKGROUP = 32  # threads of a pass over all levels; a level's threads fill whole workgroups
ROW = 32768 * WORKGROUP  # threads in a row of a dispatch: a dimension has at most 65,535 workgroups


class Levels:
    """sizes: cells along each side, the finest first. The first `windows` of them are of one size and show parts of
    their levels alone, but the last of them, which is whole (simulator/lpv/cascades.py).

    cells: of all levels.  stored: the same with a dark border of one cell around each level (cells.wgsl).
    """

    def __init__(self, sizes: Sequence[int], windows: int = 1):
        self.sizes, self.windows = tuple(sizes), windows
        self.cells = sum(n**3 for n in self.sizes)
        self.stored = sum((n + 2) ** 3 for n in self.sizes)

    @property
    def rows(self) -> tuple[int, int]:
        """Threads across and rows of a dispatch over all cells."""
        return min(self.cells, ROW), -(-self.cells // ROW)

    def first(self, level: int) -> int:
        """Number of the first cell of `level`."""
        return sum(n**3 for n in self.sizes[:level])

    def threads(self, block: tuple[int, int, int] = (1, 1, 1), beyond: int = 0) -> list[int]:
        """Threads of each level, one for a block of cells or part of one, in whole workgroups. beyond: cells more along
        each side."""
        counts = [prod(-(-(n + beyond) // b) for b in block) for n in self.sizes]
        return [-(-count // WORKGROUP) * WORKGROUP for count in counts]

    def dispatched(self, block: tuple[int, int, int] = (1, 1, 1), beyond: int = 0) -> tuple[int, int]:
        """Threads across and rows of a dispatch over all levels."""
        total = sum(self.threads(block, beyond))
        return min(total, ROW), -(-total // ROW)

    def described(self, block: tuple[int, int, int] = (1, 1, 1), beyond: int = 0) -> list[dict[str, Any]]:
        """For templates: size, first stored cell, first cell, first thread and the thread after the last."""
        threads, stored, result = self.threads(block, beyond), 0, []
        for i, n in enumerate(self.sizes):
            first = sum(threads[:i])
            result.append({"n": n, "stored": stored, "light": self.first(i), "first": first,
                           "end": first + threads[i]})  # fmt: skip
            stored += (n + 2) ** 3
        return result

    def split(self, cells: np.ndarray) -> list[np.ndarray]:
        """`cells` of all levels, (cells, ...), as one array [z][y][x]... for each."""
        firsts = [self.first(i) for i in range(len(self.sizes))]
        return [cells[f : f + n**3].reshape(n, n, n, *cells.shape[1:]) for f, n in zip(firsts, self.sizes, strict=True)]
