"""The surroundings on the device: the map that is seen and reflected, and its irradiance."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from typing import Any

import numpy as np
import wgpu

from ..gpu.bindings import Binding, texture, uniform
from ..gpu.device import Device
from ..scene.environment import Environment
from ..simulator import environment as reference
from .frame import COPY, TEXTURE
from .lights import SkyLight
from .structs import ENVIRONMENT

# The sky is seen in the mirror and behind the scene: at 2048 a texel is 0.18 degrees, a pixel of a wide camera.
_WIDEST = 2048
# Irradiance changes slowly, and of some hundred lights each stands for hundreds of texels of a map so wide.
_IRRADIANCE_SIZE = (32, 64)
_LIGHTS_WIDTH = 256


class SurroundingsMap:
    """What `shaders/environment.wgsl` reads, brought up to date when the scene has another environment."""

    def __init__(self, device: Device):
        self.device = device
        self._of: Environment | None = None
        self._small = Environment()  # no wider than the device's map, from which the rest is halved further
        self._lights: dict[int, list[SkyLight]] = {}
        self._settings = device.uniform("environment settings", ENVIRONMENT.array(1))
        table = reference.brdf_table()
        self._table = self._texture("BRDF table", [np.dstack([table, np.zeros(table.shape[:2], np.float32)])])
        self._map: Any = None
        self._irradiance: Any = None

    @staticmethod
    def bindings() -> list[Binding]:
        names = ("environment_map", "environment_irradiance", "brdf_table")
        return [uniform("environment", ENVIRONMENT), *(texture(name) for name in names)]

    @property
    def resources(self) -> dict[str, Any]:
        return {
            "environment": self._settings, "environment_map": self._map,
            "environment_irradiance": self._irradiance, "brdf_table": self._table,
        }  # fmt: skip

    def sync(self, environment: Environment) -> None:
        if self._of is environment:
            return
        self._lights = {}
        image = None if environment.image is None else reference.reduced(environment.image, _WIDEST)
        self._small = replace(environment, image=image)
        levels = _mip_levels(np.zeros((1, 2, 3), np.float32) if image is None else image)
        self._map = self._texture("environment map", [_with_alpha(level) for level in levels])
        whole = reference.total_map(self._small, 2 * _IRRADIANCE_SIZE[1])
        irradiance = reference.irradiance_map(whole, *_IRRADIANCE_SIZE)
        self._irradiance = self._texture("environment irradiance", [_with_alpha(irradiance)])
        height, width = levels[0].shape[:2]
        self.device.write(self._settings, ENVIRONMENT.pack(
            radiance=environment.radiance, turn=environment.rotation / (2.0 * pi), levels=len(levels),
            texels=2.0 / pi * height * width,
        ))  # fmt: skip
        self._of = environment

    def lights(self, count: int) -> list[SkyLight]:
        """The environment as at most `count` distant lights, for its shadows and for what it lights indirectly."""
        if count not in self._lights:
            image = reference.total_map(self._small, _LIGHTS_WIDTH)
            pairs = zip(*reference.distant_lights(image, count, self._small.rotation), strict=True)
            self._lights[count] = [SkyLight(direction=_vector(-d), illuminance=_vector(e)) for d, e in pairs]
        return self._lights[count]

    def _texture(self, label: str, levels: list[np.ndarray]) -> Any:
        height, width = levels[0].shape[:2]
        usage = TEXTURE | COPY | wgpu.TextureUsage.COPY_DST
        made = self.device.texture(label, (width, height), "rgba32float", usage=usage, mip_levels=len(levels))
        for number, level in enumerate(levels):
            self.device.write_layer(made, level, level=number)
        return made


def _vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = (float(v) for v in values)
    return x, y, z


def _with_alpha(image: np.ndarray) -> np.ndarray:
    return np.ascontiguousarray(np.dstack([image, np.ones(image.shape[:2], np.float32)]), dtype=np.float32)


def _mip_levels(image: np.ndarray) -> list[np.ndarray]:
    """The map and its halves down to one texel, each as large as a device makes its mip levels."""
    levels = [image]
    while max(levels[-1].shape[:2]) > 1:
        above = levels[-1]
        rows, columns = max(1, above.shape[0] // 2), max(1, above.shape[1] // 2)
        tall, wide = above.shape[0] // rows, above.shape[1] // columns
        cut = above[: rows * tall, : columns * wide].reshape(rows, tall, columns, wide, 3)
        levels.append(cut.mean(axis=(1, 3), dtype=np.float32))
    return levels
