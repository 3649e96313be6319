"""Lights as injection sees them: where their VPLs lie, and which of them share a scale of fixed point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, pi

import numpy as np

from ..gpu.layout import Struct
from ..simulator.lpv.injection import INT32_MAX, fixed_point_scale
from .frame import Frame

# The count VPLs from number `first` on, in rows of `width`. scale: from flux to fixed point; to_intensity: back.
# moment_scale: of the intensity of all channels together, times a place in the cell.
SOURCE = Struct(
    "Source", scale="vec3f", first="u32", to_intensity="vec3f", count="u32", width="u32", moment_scale="f32"
)
MIN_STEPS = 2**12
"""Lights share a scale while a VPL of each one's mean flux has this many steps of fixed point: rounding then moves it
by at most 2^-13 of it, half of what the half floats that cells may be stored as do."""
MOST_BESIDE = 1.25
"""Cells from the middle of its light's cell, along each axis, that a surface lies at most: half a cell, and half a cell
times a beam (simulator/lpv/emitted.py, MOST_BEAM) that the light has been moved by."""


@dataclass(frozen=True, eq=False)
class VplSource:
    """The VPLs of one light. total_flux: (3,), at least the sum of their flux, lm or W. intensity_per_flux: 1/pi keeps
    the flux (simulator/lpv/injection.py). width: VPLs in a row of the light's map; the result does not depend on it,
    but VPLs below one another mostly lie in one cell, and are then added up before they are scattered."""

    first: int
    count: int
    total_flux: np.ndarray
    intensity_per_flux: float = 1.0 / pi
    width: int = 1


@dataclass(eq=False)
class SourceGroup:
    """Lights that share a scale, that of their fluxes' sum.

    total: per channel, W/sr but for the lobe's factor, at least the sum of all; and of all channels together times
    MOST_BESIDE, for moments.  least: the smallest mean of a light.
    """

    sources: list[VplSource]
    total: tuple[float, ...]
    least: tuple[float, ...]

    @staticmethod
    def bounds(source: VplSource) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """`total` and `least` of one light alone."""
        channels = tuple(float(f) * source.intensity_per_flux for f in source.total_flux)
        total = (*channels, MOST_BESIDE * sum(channels))
        return total, tuple(f / source.count if f > 0.0 else inf for f in total)

    def joined_by(self, source: VplSource) -> SourceGroup | None:
        """The group with one light more, or None where one of them would have too few steps."""
        more, mean = self.bounds(source)
        total = tuple(a + b for a, b in zip(self.total, more, strict=True))
        least = tuple(map(min, self.least, mean))
        # The scale makes at least half of the largest int32 of `total`: it is rounded down to a power of two.
        if any(0.5 * INT32_MAX * a < MIN_STEPS * b for a, b in zip(least, total, strict=True)):
            return None
        return SourceGroup([*self.sources, source], total, least)

    def pack(self) -> list[np.ndarray]:
        """SOURCE of each range of VPLs that lie in one piece."""
        ranges: list[VplSource] = []
        for source in sorted(self.sources, key=lambda s: s.first):
            if ranges and _continues(ranges[-1], source):
                ranges[-1] = replace(ranges[-1], count=ranges[-1].count + source.count)
            else:
                ranges.append(source)
        count = sum(s.count for s in self.sources)
        scales = fixed_point_scale(self.total, count, intensity_per_flux=1.0)
        scale, moment_scale = scales[:3], scales[3]
        return [
            SOURCE.pack(
                scale=scale * r.intensity_per_flux,
                to_intensity=1.0 / scale, first=r.first, count=r.count, width=r.width, moment_scale=moment_scale,
            )
            for r in ranges
        ]  # fmt: skip


NO_SOURCES = SourceGroup([], (0.0,) * 4, (0.0,) * 4)
"""What a frame without lights injects: what there was before goes."""


def _continues(before: VplSource, source: VplSource) -> bool:
    same = before.width == source.width and before.intensity_per_flux == source.intensity_per_flux
    return same and before.first + before.count == source.first


def group_sources(sources: Sequence[VplSource]) -> list[SourceGroup]:
    """Lights, from the one with the faintest VPLs on, in the first group that takes them."""
    groups: list[SourceGroup] = []
    for source in sorted((s for s in sources if s.count), key=lambda s: float(np.sum(s.total_flux)) / s.count):
        for number, group in enumerate(groups):
            if (joined := group.joined_by(source)) is not None:
                groups[number] = joined
                break
        else:
            groups.append(SourceGroup([source], *SourceGroup.bounds(source)))
    return groups


def vpl_sources(frame: Frame) -> list[VplSource]:
    """The VPLs of each of the frame's lights."""
    lights = zip(frame.vpl_ranges, frame.vpl_widths, frame.lights.total_flux, strict=True)
    return [VplSource(first, count, flux, width=width) for (first, count), width, flux in lights]
