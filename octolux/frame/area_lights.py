"""Area lights on the device: their quadrilaterals, for linearly transformed cosines, and the emitters that shadow them.

A surface gets the analytic light of the whole quadrilateral times the share of its emitters' light that arrives: the
ratio estimator of Heitz, Hill and McGuire 2018 ("Combining analytic direct illumination and stochastic shadows"), with
the emitters in the place of random samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any

import numpy as np
import wgpu

from ..gpu.bindings import Binding, texture, uniform
from ..gpu.device import Device
from ..simulator import ltc
from .emitters import EmitterLight
from .frame import COPY, TEXTURE
from .structs import AREA_LIGHT, MAX_LIGHTS
from .views import CUBE_FACES

MAX_AREA_LIGHTS = MAX_LIGHTS // CUBE_FACES
"""Each has an emitter, whose shadow maps have six layers."""


@dataclass(frozen=True, eq=False)
class AreaLights:
    """packed: AREA_LIGHT rows.  emitters: how many stand for each.  points: how many emitters stand for none."""

    packed: np.ndarray
    emitters: tuple[int, ...]
    points: int


def area_lights(emitters: Sequence[EmitterLight]) -> AreaLights:
    """The area lights that `emitters` stand for, which lie as `emitter_lights` gives them: those of none first, then
    those of each lamp together."""
    points = sum(emitter.lamp is None for emitter in emitters)
    lamps = [emitter.lamp for emitter in emitters if emitter.lamp is not None]
    groups = [list(group) for _, group in groupby(lamps, id)]
    packed, first = AREA_LIGHT.array(len(groups)), points
    for row, group in zip(packed, groups, strict=True):
        corners = np.asarray(group[0].corners, dtype=np.float64)[::-1]
        row["corner"], row["radiance"] = corners[0], group[0].radiance
        row["edge0"], row["edge1"], row["edge2"] = np.diff(corners, axis=0)
        row["first"], row["emitters"] = first, len(group)
        first += len(group)
    return AreaLights(packed, tuple(len(group) for group in groups), points)


class AreaLightBuffers:
    """What `shaders/ltc.wgsl` reads, but for the table of the BRDF."""

    def __init__(self, device: Device):
        self.device = device
        self._lights = device.uniform("area lights", AREA_LIGHT.array(MAX_AREA_LIGHTS))
        table = ltc.table()
        usage = TEXTURE | COPY | wgpu.TextureUsage.COPY_DST
        self._table = device.texture("LTC table", table.shape[:2], "rgba32float", usage=usage)
        device.write_layer(self._table, table)

    @staticmethod
    def bindings() -> list[Binding]:
        return [uniform("area_lights", f"array<AreaLight, {MAX_AREA_LIGHTS}>"), texture("ltc_table")]

    @staticmethod
    def values() -> dict[str, Any]:
        """For the template."""
        return {"ltc_table_size": len(ltc.table()), "least_cosine": ltc.LEAST_COSINE}

    def write(self, lights: AreaLights) -> dict[str, Any]:
        """Upload this frame's lights; the resources by binding name."""
        self.device.write(self._lights, lights.packed)
        return {"area_lights": self._lights, "ltc_table": self._table}
