"""Propagation through an octree of which only the leaves carry light (Olovsson 2012, 7.1, "on the fly").

The leaves tile the volume: each region of space is propagated once, on its own level, and light crosses from level to
level on its way. Levels, sums and reading are octree.py's: a cell of level i has the size h 2^i.

Tree. A cell of level 1 is split where one of its children is lit or at most `margin` cells from a lit one, also along
diagonals; a cell of level i + 1 where one of its children is split or as near to a split one; the root always. So cells
grow away from lit ones alike on all sides (7.1, "radially expanded"), and leaves that touch differ by one level at
most: where a cell of level i is split, the cells around it are children of split cells, so they are there.

A step. Light that leaves a cell along d falls into the cell N of the same size beyond, as flux through the five faces
of N that it meets (transfer.py). There are three cases and no other:

- N is a leaf: the flux through each face becomes a lobe, as in a uniform volume.
- N is part of a leaf of the next level, which takes all of it: four such sides make up the leaf's own.
- N is split, and the four of its children that lie at the side are leaves. From the middle of the cell that sends, the
  side face s is seen through that part of the side where s is the largest coordinate across d: half of it through
  either of the two children next to s, by symmetry, and the far face a quarter through each. So the children get these
  shares (`ENTRY_SHARES`), as lobes in the same directions.

The shares of each face add to 1, so every step hands on exactly what `face_flux` sends: of the signed and the
dominant-lobe evaluation the flux of all cells, times `gain`, but for what leaves the volume.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from octolux.simulator import sh as harmonics
from octolux.simulator.lpv import transfer
from octolux.simulator.lpv.octree import build_levels, downsample, level_sizes, reading_factor, upsample
from octolux.simulator.lpv.propagation import face_flux, reprojection_lobes, shifted


def _entry_shares() -> np.ndarray:
    shares = np.zeros((6, 2, 2, 2, 5))
    for travel, direction in enumerate(transfer.DIRECTIONS):
        for corner in np.ndindex(2, 2, 2):
            at = 2 * np.array(corner[::-1]) - 1  # x, y, z, from the middle of the parent
            if at @ direction < 0:
                shares[travel][corner] = [0.25, *(0.5 * (at @ transfer.NORMALS[travel, 1:].T > 0))]
    return shares


ENTRY_SHARES = _entry_shares()
"""What each child of a split cell gets of the flux through its parent's faces: (6, 2, 2, 2, 5), [travel direction][z]
[y][x][face]. Nothing but for the four children at the side where light comes in."""


@dataclass(frozen=True, eq=False)
class Tree:
    """split: bool [z][y][x] of each level of `level_sizes(n)`: where cells have children that are in the tree."""

    split: tuple[np.ndarray, ...]

    @property
    def leaves(self) -> list[np.ndarray]:
        """Where each level's cells are leaves: bool [z][y][x]."""
        return [here & ~split for here, split in zip(self.present, self.split, strict=True)]

    @property
    def present(self) -> list[np.ndarray]:
        """Where each level's cells are in the tree, as leaves or split: bool [z][y][x]."""
        parents = [upsample(split, 2 * split.shape[0]) for split in self.split[1:]]
        return [*parents, np.ones((1, 1, 1), dtype=bool)]


def build_tree(lit, margin: int = 1) -> Tree:
    """The tree around the lit cells of level 0, bool [z][y][x]; `margin`: cells of each level, at least, around what
    is finer. Raises ValueError unless it is a cube of a power of two, at least 2, along each side, and margin >= 1."""
    lit = np.asarray(lit, dtype=bool)
    n = lit.shape[0]
    if n < 2 or lit.shape != (n, n, n):
        raise ValueError(f"a tree is built over a cube of at least 2 cells along each side, got {lit.shape}")
    if margin < 1:
        raise ValueError(f"the margin is at least one cell, got {margin}")
    split = [np.zeros_like(lit)]
    below = lit
    for _ in level_sizes(n)[1:]:
        below = downsample(_widened(below, margin)) > 0.0
        split.append(below)
    split[-1] = np.ones_like(split[-1])
    return Tree(tuple(split))


def _widened(cells: np.ndarray, margin: int) -> np.ndarray:
    """Cells that are set or at most `margin` from one that is, also across edges and corners."""
    for axis, n in enumerate(cells.shape):
        padded = np.pad(cells, [(margin * int(a == axis),) * 2 for a in range(3)])
        cells = np.logical_or.reduce([padded.take(range(k, k + n), axis=axis) for k in range(2 * margin + 1)])
    return cells


def _where(mask: np.ndarray, values: np.ndarray) -> np.ndarray:
    return np.where(mask[..., None, None], values, 0.0)


def inject(tree: Tree, light) -> list[np.ndarray]:
    """Each leaf's share of `light` [z][y][x][rgb][4] of level 0: the sum of what it holds; all levels, zero but in
    leaves."""
    levels = build_levels(light)
    return [_where(leaf, level) for leaf, level in zip(tree.leaves, levels, strict=True)]


def step(
    tree: Tree, cells: Sequence[np.ndarray], gain: float = 1.0, evaluation: str = "clamped", reprojection: str = "face"
) -> list[np.ndarray]:
    """One step of all leaves: float64 [z][y][x][rgb][4] on each level, zero but in leaves. Raises ValueError on an
    unknown name."""
    lobes, leaves, present = reprojection_lobes(reprojection), tree.leaves, tree.present
    result = [np.zeros_like(level, dtype=np.float64) for level in cells]
    for i, level in enumerate(cells):
        flux = gain * face_flux(level, evaluation)
        for travel, direction in enumerate(transfer.DIRECTIONS):
            arrived = shifted(flux[..., travel, :], direction)
            result[i] += _where(leaves[i], arrived) @ lobes[travel]
            if i + 1 < len(cells):
                result[i + 1] += downsample(_where(~present[i], arrived)) @ lobes[travel]
            if i > 0:
                finer = upsample(_where(tree.split[i], arrived), 2 * level.shape[0])
                shares = np.tile(ENTRY_SHARES[travel], (*level.shape[:3], 1))
                result[i - 1] += (finer * shares[..., None, :]) @ lobes[travel]
    return result


def propagate(
    tree: Tree, light, iterations: int, gain: float = 1.0, evaluation: str = "clamped", reprojection: str = "face"
) -> list[np.ndarray]:
    """Accumulated light after k = `iterations` steps from `light` [z][y][x][rgb][4] of level 0: on each level, zero
    but in leaves. Raises ValueError on an unknown name or a negative number of iterations."""
    if iterations < 0:
        raise ValueError(f"the number of iterations cannot be negative, got {iterations}")
    current = inject(tree, light)
    accumulated = [level.copy() for level in current]
    for _ in range(iterations):
        current = step(tree, current, gain, evaluation, reprojection)
        accumulated = [a + b for a, b in zip(accumulated, current, strict=True)]
    return accumulated


def total_flux(cells: Sequence[np.ndarray]) -> np.ndarray:
    """Flux of the leaves of all levels per colour channel, (3,)."""
    return np.sum([harmonics.flux(level).sum(axis=(0, 1, 2)) for level in cells], axis=0)


def merge(tree: Tree, cells: Sequence[np.ndarray]) -> np.ndarray:
    """One volume of level 0 to be read with its cell size: [z][y][x][rgb][4].

    A cell of level 0 in a leaf of its own level takes its light. In a coarser leaf it takes light filtered between the
    leaf's middle and the middles of the leaves beyond it on its own side, as a texture unit does; of finer ones there
    the child that is nearest counts, and at the volume's border the leaf itself.
    """
    n = cells[0].shape[0]
    plain = np.zeros_like(cells[0])
    for i, level in enumerate(cells):
        plain += upsample(level * reading_factor(i), n)
    merged = _where(tree.leaves[0], plain)
    for i in range(1, len(cells)):
        leaf = upsample(tree.leaves[i], n)
        if leaf.any():
            merged += _where(leaf, _filtered(plain, i))
    return merged


def _filtered(plain: np.ndarray, level: int) -> np.ndarray:
    """`plain` between the middles of cells of `level`, read at its children's places."""
    n, half = plain.shape[0], 2 ** (level - 1)
    at = np.arange(n)
    child = at // half
    beyond = np.clip(child + 2 * (child % 2) - 1, 0, n // half - 1)
    weight = np.abs((at + 0.5) / (2 * half) - (at // (2 * half) + 0.5))
    result = plain
    for axis in range(3):
        # Any cell within a child stands for it: a leaf's light is the same in all it covers.
        near, far = (result.take(index * half, axis=axis) for index in (child, beyond))
        along = weight.reshape([-1 if a == axis else 1 for a in range(5)])
        result = (1.0 - along) * near + along * far
    return result
