"""What surrounds the scene: light from infinitely far away."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .materials import Color


@dataclass(frozen=True, eq=False)
class Environment:
    """Radiance from every direction, nits: the constant `radiance` plus what `image` shows there.

    image: float32 (height, width, 3), equirectangular, linear Rec. 709, nits; None for none. Its middle column is seen
        towards -z and columns run to the right as one looks: +x lies a quarter of the width to the right. Its top row
        is +y.
    rotation: radians by which the image is turned about +y, counter-clockwise seen from above.
    """

    radiance: Color = (0.0, 0.0, 0.0)
    image: np.ndarray | None = None
    rotation: float = 0.0

    def __post_init__(self) -> None:
        i = self.image
        if i is not None and (i.dtype != np.float32 or i.ndim != 3 or i.shape[2] != 3 or 0 in i.shape):
            raise ValueError(f"environment image: expected float32 (height, width, 3), got {i.dtype} {i.shape}")

    @cached_property  # asked for in every frame
    def is_black(self) -> bool:
        return max(self.radiance) <= 0 and (self.image is None or not self.image.any())
