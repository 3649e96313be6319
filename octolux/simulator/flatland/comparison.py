"""The schemes against the analytic solution: Kaplanyan & Dachsbacher 2010, figure 5, in numbers."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from .bases import Basis, Harmonics, Sectors
from .lights import Setting, l_shape, one_light
from .schemes import DOM4, DOM8, SCHEMES, Scheme, propagate

ANGLES = (np.arange(720) + 0.5) * (2.0 * pi / 720)
"""Where intensities are compared: every half degree, rad."""


@dataclass(frozen=True)
class Solution:
    """What one scheme makes of a setting. `intensity`: (height, width, len(ANGLES)), W/rad; the rest of `errors`."""

    setting: Setting
    scheme: Scheme
    basis: Basis
    intensity: np.ndarray
    left: float

    def errors(self) -> dict[str, Any]:
        """As JSON, over the cells without a light, all against the analytic solution.

        relative_rmse: of the intensity over all cells and directions. flux_ratio: of the flux through all cells.
        direction_error: angle between the net fluxes of a cell, weighted with the cell's analytic flux, degrees; 90
        where a scheme brings a cell no net flux.
        left: share of the lights' flux that is still under way after the last step.
        """
        cells = ~self.setting.lit()
        truth, found = self.setting.intensity(ANGLES)[cells], self.intensity[cells]
        net = [(i * np.exp(1j * ANGLES)).sum(axis=-1) for i in (truth, found)]
        nothing = np.abs(net[1]) <= 1e-9 * np.abs(net[0]).max()
        turned = np.where(nothing, 90.0, np.degrees(np.abs(np.angle(net[1] * np.conj(net[0])))))
        return {
            "setting": self.setting.name, "scheme": self.scheme.name, "basis": self.basis.label,
            "relative_rmse": float(np.sqrt(((found - truth) ** 2).sum() / (truth**2).sum())),
            "flux_ratio": float(found.sum() / truth.sum()),
            "direction_error": float(np.average(turned, weights=truth.sum(axis=-1))),
            "left": self.left,
        }  # fmt: skip


def solve(setting: Setting, scheme: Scheme, basis: Basis, iterations: int | None = None) -> Solution:
    """Propagate the lights of `setting`. `iterations`: twice the longer side unless given, the paper's rule of thumb
    (section 3.3). Raises ValueError where it is negative."""
    steps = 2 * max(setting.width, setting.height) if iterations is None else iterations
    start = setting.inject(basis)
    total, rest = propagate(start, steps, scheme, basis)
    whole = basis.integral(0.0, 2.0 * pi)
    left = float((rest @ whole).sum() / (start @ whole).sum())
    return Solution(setting, scheme, basis, total @ basis.evaluate(ANGLES).T, left)


def settings(size: tuple[int, int]) -> tuple[Setting, Setting]:
    """The two of figure 5, on a grid of `size` (width, height)."""
    return one_light(*size), l_shape(*size)


def compare(
    bands: Iterable[int] = (2, 4, 16), size: tuple[int, int] = (12, 9), iterations: int | None = None
) -> list[Solution]:
    """All schemes with each number of bands, and plain DOM4 and DOM8, on both settings, in this order.

    Raises ValueError for fewer than 1 band or a negative number of iterations.
    """
    bases = [Harmonics(b) for b in bands]
    pairs: list[tuple[Scheme, Basis]] = [(scheme, basis) for basis in bases for scheme in SCHEMES.values()]
    pairs += [(DOM4, Sectors(4)), (DOM8, Sectors(8))]
    return [solve(setting, scheme, basis, iterations) for setting in settings(size) for scheme, basis in pairs]
