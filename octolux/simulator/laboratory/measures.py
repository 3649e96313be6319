"""What is measured: errors against downsampling, a uniform volume and the analytic solution; flux and its centre.

An error of a cell is the infinity norm of the difference of two coefficient vectors (Olovsson 2012, 6.2).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from octolux.simulator.lpv import octree, propagation

from .state import State, as_averages

DARK = 2.0**-40
"""Below this share of its level's largest a cell holds what rounding may have made, and counts as dark.

A sum in float64 is off by 2^-53 of its largest term for each rounding. A cell's coefficient is rounded fewer than 2^6
times a step (30 faces or 26 links, each a product of four terms), and light crosses the largest volume, 128 cells, in
fewer than 2^7 steps: 2^(-53 + 6 + 7).
"""


def cell_errors(measured: np.ndarray, expected: np.ndarray) -> np.ndarray:
    """||measured - expected|| of each cell, [z][y][x], of coefficients [z][y][x][4]."""
    return np.abs(measured - expected).max(axis=-1)


def octree_errors(levels: Sequence[np.ndarray], expected: Sequence[np.ndarray]) -> dict[str, float]:
    """e_abs, e_rel and the largest of both over all cells of levels 1 and up (6.2); 0 where there is no such level.

    The mean is 7 / (8^l - 8) times the sum, as 6.2 prints it, when the coarsest level has 2^3 cells as the thesis's;
    with a single cell there it is 7 / (8^(l-1) - 1). The relative error is 0 where |O_i| is below `DARK` of its level's
    largest, or 0: there is nothing to relate it to. 6.2 divides by any |O_i| but 0, and what rounding leaves
    in cells that light does not reach made its mean 10^19. Light above that is faint but real, and where it has only
    just arrived the mean may still be large.
    """
    if len(levels) < 2:
        return {"e_abs": 0.0, "e_rel": 0.0, "max_abs": 0.0, "max_rel": 0.0}
    errors = np.concatenate([cell_errors(o, e).ravel() for o, e in zip(levels[1:], expected[1:], strict=True)])
    sizes = [np.abs(o).max(axis=-1).ravel() for o in levels[1:]]
    lit = np.concatenate([size > DARK * size.max() for size in sizes])
    relative = np.divide(errors, np.concatenate(sizes), out=np.zeros_like(errors), where=lit)
    return {
        "e_abs": float(errors.mean()), "e_rel": float(relative.mean()),
        "max_abs": float(errors.max()), "max_rel": float(relative.max()),
    }  # fmt: skip


def against_downsampling(levels: Sequence[np.ndarray], combine: str) -> dict[str, float]:
    """The paper's metric (6.2): each level against the downsampled next finer one of the same octree.

    Sums are taken as the averages they stand for, so that a number means the same on every level.
    """
    averages = as_averages(levels, combine)
    return octree_errors(averages, [averages[0], *(octree.downsample(a, "average") for a in averages[:-1])])


def against_uniform(levels: Sequence[np.ndarray], uniform: np.ndarray, combine: str) -> dict[str, float]:
    """The corrected metric (7, Error calculations): each level against the uniform volume [z][y][x][4], which was
    propagated first, downsampled. A level whose children are still dark no longer counts as wrong."""
    expected = octree.build_levels(uniform, "average", np.shape(levels[-1])[0])
    return octree_errors(as_averages(levels, combine), expected)


def volume_errors(measured: np.ndarray, expected: np.ndarray) -> dict[str, float]:
    """A volume against another one cell by cell, as 6.2 suggests for S(x, y, z): the mean error, and the sum of errors
    over the sum of what is expected (NaN in the dark)."""
    errors, size = cell_errors(measured, expected), np.abs(expected).max(axis=-1)
    total = float(size.sum())
    return {"abs": float(errors.mean()), "rel": float(errors.sum()) / total if total > 0.0 else float("nan")}


def flux_and_centre(cells: np.ndarray) -> dict[str, float]:
    """Total flux, W (lm), and its centre of mass x, y, z in cell indices (NaN in the dark), of `cells` [z][y][x][4]."""
    one_channel = cells[..., None, :]
    x, y, z = propagation.centre_of_mass(one_channel)[0]
    return {
        "flux": float(propagation.total_flux(one_channel)[0]),
        "centre_x": float(x), "centre_y": float(y), "centre_z": float(z),
    }  # fmt: skip


def row(state: State, uniform: np.ndarray | None, analytic: np.ndarray | None) -> dict[str, float]:
    """All that is measured of a state, by column; references that are None have no columns."""
    merged = octree.merge(state.sum, state.index, state.combine)
    result = {"iteration": float(state.iterations), **against_downsampling(state.sum, state.combine)}
    if uniform is not None:
        corrected = against_uniform(state.sum, uniform, state.combine)
        result |= {f"corrected_{name}": value for name, value in corrected.items()}
        result |= {f"merged_{name}": value for name, value in volume_errors(merged, uniform).items()}
    if analytic is not None:
        result |= {f"analytic_{name}": value for name, value in volume_errors(merged, analytic).items()}
        result["analytic_uniform_rel"] = volume_errors(state.sum[0], analytic)["rel"]
    result |= {f"step_{name}": value for name, value in flux_and_centre(state.current[0]).items()}
    result |= {f"sum_{name}": value for name, value in flux_and_centre(merged).items()}
    return result
