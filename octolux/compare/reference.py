"""What techniques are compared with: pictures by layer, and two halves whose noise is independent."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .metrics import relative_noise

COMPARED = ("final", "indirect")
"""Layers that are measured; `direct` is shown as well."""


@dataclass(frozen=True)
class Reference:
    """A reference of (height, width) pixels.

    pictures: `final`, `indirect`, `direct`, float32 (height, width, 3), nits.  halves: two estimates of each, the same
    picture twice where there is only one.  mask: bool, where a surface is seen.  noise_free: whether the halves are
    independent, so that errors can be told without the reference's noise.  facts: where it is from, for the report.
    position: world space (height, width, 3), metres, where it is known.
    """

    name: str
    pictures: dict[str, np.ndarray]
    halves: dict[str, tuple[np.ndarray, np.ndarray]]
    mask: np.ndarray
    noise_free: bool
    facts: dict[str, Any] = field(default_factory=dict)
    position: np.ndarray | None = None

    @property
    def size(self) -> tuple[int, int]:
        """(width, height), pixels."""
        return self.mask.shape[1], self.mask.shape[0]

    def noise(self, layer: str) -> float | None:
        """Relative RMSE of the reference's own picture; None where it cannot be told."""
        return relative_noise(*self.halves[layer], self.mask) if self.noise_free else None


def of_halves(name: str, halves: list[dict[str, np.ndarray]], mask: np.ndarray, facts: dict[str, Any]) -> Reference:
    """A reference from one rendering or from two with independent noise, whose mean it is."""
    a, b = halves[0], halves[-1]
    pictures = {layer: (0.5 * (a[layer] + b[layer])).astype(np.float32) for layer in a}
    return Reference(name, pictures, {k: (a[k], b[k]) for k in a}, mask, len(halves) == 2, facts)
