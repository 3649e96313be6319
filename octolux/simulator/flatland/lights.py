"""Area lights in the plane, and the light they give in closed form.

A light lies on the line through the centres of a row or column of cells and shines to one side of it, with the same
radiance M/2 in all directions, where M is its flux per cell of length: the integral of max(0, cos t) over the circle
is 2. Seen under the angles from a to b, it gives the fluence M/2 (b - a) and, on a surface whose normal is at angle 0,
the irradiance M/2 (sin b - sin a).
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from .bases import LOBE_FLUX, Basis


@dataclass(frozen=True)
class AreaLight:
    """The cells from `first` to `last` (x, y), in one row or column, that shine along `angle`, one of the four axes.

    `exitance`: flux per cell, W. Raises ValueError where the cells are not across the direction.
    """

    first: tuple[int, int]
    last: tuple[int, int]
    angle: float
    exitance: float = 1.0

    def __post_init__(self) -> None:
        quarter = self.angle / (pi / 2.0)
        along = (self.last[0] - self.first[0]) * cos(self.angle) + (self.last[1] - self.first[1]) * sin(self.angle)
        in_line = self.first[0] == self.last[0] or self.first[1] == self.last[1]
        if abs(quarter - round(quarter)) > 1e-9 or not in_line or abs(along) > 1e-9:
            raise ValueError(f"an area light is a row or column of cells that shines across it, not {self}")

    def cells(self) -> list[tuple[int, int]]:
        """Its cells (x, y)."""
        (x0, x1), (y0, y1) = sorted((self.first[0], self.last[0])), sorted((self.first[1], self.last[1]))
        return [(x, y) for x in range(x0, x1 + 1) for y in range(y0, y1 + 1)]

    def ends(self) -> np.ndarray:
        """Its two end points (2, 2) [end][x, y], in cells; a cell's centre has half-integer coordinates."""
        points = np.sort(np.array([self.first, self.last], dtype=np.float64), axis=0) + 0.5
        half = 0.5 * np.abs([sin(self.angle), cos(self.angle)])
        return points + np.array([-half, half])

    def seen(self, points) -> tuple[np.ndarray, np.ndarray]:
        """The directions a <= b (...) in which its light travels at `points` (..., 2); a = b behind it."""
        offset = np.asarray(points, dtype=np.float64)[..., None, :] - self.ends()
        ahead = offset @ np.array([cos(self.angle), sin(self.angle)])
        aside = offset @ np.array([-sin(self.angle), cos(self.angle)])
        angles = np.sort(np.arctan2(aside, ahead), axis=-1) + self.angle
        before = ahead[..., 0] > 1e-9
        return np.where(before, angles[..., 0], 0.0), np.where(before, angles[..., 1], 0.0)


@dataclass(frozen=True)
class Setting:
    """A grid of `width` x `height` cells with lights. Raises ValueError where a light is outside it."""

    name: str
    width: int
    height: int
    lights: tuple[AreaLight, ...]

    def __post_init__(self) -> None:
        for light in self.lights:
            if not all(0 <= x < self.width and 0 <= y < self.height for x, y in light.cells()):
                raise ValueError(f"{light} is outside the grid of {self.width} x {self.height} cells")

    def centres(self) -> np.ndarray:
        """Centres of the cells, (height, width, 2)."""
        x, y = np.meshgrid(np.arange(self.width) + 0.5, np.arange(self.height) + 0.5)
        return np.stack([x, y], axis=-1)

    def lit(self) -> np.ndarray:
        """Which cells hold a light: bool (height, width)."""
        mask = np.zeros((self.height, self.width), dtype=bool)
        for x, y in (cell for light in self.lights for cell in light.cells()):
            mask[y, x] = True
        return mask

    def inject(self, basis: Basis) -> np.ndarray:
        """Coefficients (height, width, size) of the lights: in each cell a cosine lobe of the flux it emits."""
        cells = np.zeros((self.height, self.width, basis.size))
        for light in self.lights:
            for x, y in light.cells():
                cells[y, x] += light.exitance / LOBE_FLUX * basis.cosine_lobe(light.angle)
        return cells

    def intensity(self, angles) -> np.ndarray:
        """The analytic solution: flux per radian that crosses each cell along `angles` (n,): (height, width, n), W/rad.

        A cell shows |cos t| + |sin t| of its side to light along t, here times the radiance at its centre. In the
        cells of a light it is what the light emits, M/2 max(0, cos t).
        """
        angles = np.asarray(angles, dtype=np.float64)
        across = np.abs(np.cos(angles)) + np.abs(np.sin(angles))
        total = np.zeros((self.height, self.width, angles.size))
        for light in self.lights:
            begin, end = light.seen(self.centres())
            inside = np.mod(angles - begin[..., None], 2.0 * pi) < (end - begin)[..., None]
            total += light.exitance / LOBE_FLUX * across * inside
            for x, y in light.cells():
                total[y, x] += light.exitance / LOBE_FLUX * np.maximum(0.0, np.cos(angles - light.angle))
        return total

    def fluence(self) -> np.ndarray:
        """The analytic fluence at the centres, (height, width), W per cell of length; without the cells' own light."""
        total = np.zeros((self.height, self.width))
        for light in self.lights:
            begin, end = light.seen(self.centres())
            total += light.exitance / LOBE_FLUX * (end - begin)
        return total

    def irradiance(self, point, normal_angle: float) -> float:
        """On a surface at `point` (x, y) with a normal at `normal_angle`, in front of every light: W per cell."""
        total = 0.0
        for light in self.lights:
            begin, end = (float(a) for a in light.seen(np.asarray(point, dtype=np.float64)))
            # Light travels against the direction that it is seen in.
            turn = round((normal_angle + pi - (begin + end) / 2.0) / (2.0 * pi)) * 2.0 * pi
            low, high = (np.clip(a + turn - normal_angle - pi, -pi / 2, pi / 2) for a in (begin, end))
            total += light.exitance / LOBE_FLUX * float(np.sin(high) - np.sin(low))
        return total


def one_light(width: int = 12, height: int = 9) -> Setting:
    """One area light on the left, shining along +x, a third of the height (upper row of the paper's figure 5)."""
    third = height // 3
    return Setting("one area light", width, height, (AreaLight((0, third), (0, height - 1 - third), 0.0),))


def l_shape(width: int = 12, height: int = 9) -> Setting:
    """Two in an L: from the left along +x and from below along +y (lower row of figure 5)."""
    upright = AreaLight((0, 1), (0, max(1, (2 * height) // 3)), 0.0)
    flat = AreaLight((1, 0), (max(1, (2 * width) // 3), 0), pi / 2.0)
    return Setting("two area lights in an L", width, height, (upright, flat))
