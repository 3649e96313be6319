"""Fit the table of linearly transformed cosines, octolux/simulator/ltc.npz, to the house's BRDF, and print its error.

    python scripts/ltc_table.py [--size 32]

For each roughness and n.v the specular lobe D V n.l (simulator/brdf.py), divided by its integral, is matched by
`simulator.ltc.density`. The error is half the integral of the absolute difference: the most by which the share of the
lobe that any light takes may be wrong. It is printed at the table's nodes and halfway between them, where rows and
columns are interpolated. Takes half a minute.
"""

from __future__ import annotations

import argparse
from math import pi

import numpy as np
from scipy.optimize import minimize

from octolux.simulator import brdf, ltc

# Directions of the quadrature: so many rings of half vectors drawn by D, as many by a wider D, which has the tails, and
# so many even rings, which have the rest; each is weighed by the density of all (the balance heuristic).
RINGS, WIDER, EVEN_RINGS = 32, 3.0, 24


def _rings(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Midpoints of `count` x 2 count parts of the unit square, flat: in [0, 1), and angles."""
    steps = np.arange(2 * count) + 0.5
    share, turn = np.meshgrid(steps[:count] / count, steps / (2 * count), indexing="ij")
    return share.ravel(), 2.0 * pi * turn.ravel()


def _directions(cosine: np.ndarray, turn: np.ndarray) -> np.ndarray:
    sine = np.sqrt(np.maximum(1.0 - cosine * cosine, 0.0))
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1)


def _half_density(n_h: np.ndarray, v_h: np.ndarray, alpha: float) -> np.ndarray:
    """Density, 1/sr, of light directions mirrored at half vectors that are drawn by D n.h."""
    drawn = brdf.ggx_distribution(n_h, alpha) * n_h / (4.0 * np.maximum(np.abs(v_h), 1e-9))
    return np.where(n_h > 0.0, drawn, 0.0)


def quadrature(alpha: float, view: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit directions (n, 3) above the horizon, and the solid angle that each stands for (n,)."""
    share, turn = _rings(RINGS)
    parts, alphas = [], (alpha, min(1.0, WIDER * alpha))
    for each in alphas:
        half = _directions(np.sqrt((1.0 - share) / (1.0 + (each * each - 1.0) * share)), turn)
        parts.append(2.0 * (half @ view)[:, None] * half - view)
    even, around = _rings(EVEN_RINGS)
    parts.append(_directions(2.0 * even - 1.0, around))
    light = np.concatenate(parts)
    half = light + view
    half /= np.maximum(np.linalg.norm(half, axis=1, keepdims=True), 1e-12)
    found = sum(len(share) * _half_density(half[:, 2], half @ view, each) for each in alphas)
    above = light[:, 2] > 0.0
    return light[above], 1.0 / (found + len(even) / (4.0 * pi))[above]


class Target:
    """The lobe of one roughness and n.v, and how far a moved cosine is from it."""

    def __init__(self, roughness: float, n_dot_v: float):
        self.alpha, self.n_dot_v = float(brdf.alpha_of(roughness)), n_dot_v
        view = np.array([np.sqrt(1.0 - n_dot_v**2), 0.0, n_dot_v])
        self.light, self.weight = quadrature(self.alpha, view)
        half = self.light + view
        n_h = half[:, 2] / np.linalg.norm(half, axis=1)
        n_l = self.light[:, 2]
        lobe = brdf.ggx_distribution(n_h, self.alpha) * brdf.smith_visibility(n_l, n_dot_v, self.alpha) * n_l
        self.lobe = lobe / (lobe @ self.weight)

    def error(self, four: np.ndarray) -> float:
        """Half the integral of the absolute difference, in [0, 1]; 2 for what is no lobe."""
        if min(four[0], four[1]) <= 1e-3 or abs(four[3]) >= 1.0:
            return 2.0
        moved = ltc.density(ltc.matrix(four, self.alpha, self.n_dot_v), self.light)
        return float(0.5 * np.abs(moved - self.lobe) @ self.weight)

    def fitted(self, start: np.ndarray) -> np.ndarray:
        """The four numbers, by the simplex method of Nelder and Mead, twice: a shrunk simplex is opened again."""
        for _ in range(2):
            tilt = 0.05 if start[3] < 0.85 else -0.05
            edges = np.diag([0.2, 0.2 * max(start[1], 0.1), -0.2 * self.n_dot_v, tilt])
            simplex = np.concatenate([start[None], start + edges])
            options = {"maxiter": 500, "xatol": 1e-4, "fatol": 1e-6, "initial_simplex": simplex}
            start = minimize(self.error, start, method="Nelder-Mead", options=options).x
        return start


def fit(size: int) -> tuple[np.ndarray, np.ndarray]:
    """The table, float32 (size, size, 4), and the error at its nodes (size, size). From n.v of 1 on each node starts
    from the one before it: neighbours then lie in the same valley, and what is between them does too."""
    found, errors = np.zeros((size, size, 4), np.float32), np.zeros((size, size))
    rows, columns = ltc.nodes(size)
    for i, roughness in enumerate(rows):
        width = 2.0 - float(brdf.alpha_of(roughness))
        start = np.array([width, width, 0.0, 0.0])
        for j, n_dot_v in enumerate(columns):
            target = Target(roughness, n_dot_v)
            start = target.fitted(start)
            found[i, j], errors[i, j] = start, target.error(start)
    return found, errors


def errors_between(found: np.ndarray) -> np.ndarray:
    """The error in the middle of each four nodes (size - 1, size - 1)."""
    size = len(found)
    middle = (np.arange(size - 1) + 0.5) / (size - 1)
    mean = 0.25 * (found[1:, 1:] + found[1:, :-1] + found[:-1, 1:] + found[:-1, :-1])
    result = np.zeros((size - 1, size - 1))
    for i, j in np.ndindex(result.shape):
        result[i, j] = Target(max(middle[i], brdf.MIN_ROUGHNESS), 1.0 - middle[j] ** 2).error(mean[i, j])
    return result


def report(name: str, errors: np.ndarray) -> None:
    """Mean and largest error by the angle of view."""
    cosine = 1.0 - (np.linspace(0.0, 1.0, errors.shape[1])) ** 2
    for low, high in ((0.5, 1.0), (0.2, 0.5), (0.0, 0.2)):
        part = errors[:, (cosine >= low) & (cosine <= high)]
        print(f"{name}, n.v {low} to {high}: mean {part.mean():.4f}, largest {part.max():.4f}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--size", type=int, default=32, help="rows and columns (32)")
    found, errors = fit(parser.parse_args().size)
    np.savez_compressed(ltc.TABLE, parameters=found)
    report("at the nodes", errors)
    report("between them", errors_between(found))
    print(f"{ltc.TABLE.name}: {ltc.TABLE.stat().st_size} bytes")


if __name__ == "__main__":
    main()
