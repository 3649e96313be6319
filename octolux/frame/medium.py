"""The scene's medium on the device."""

from __future__ import annotations

from typing import Any

import numpy as np
import wgpu

from ..gpu.bindings import Binding, sampler, texture, uniform
from ..gpu.device import Device
from ..gpu.layout import Struct
from ..scene.medium import Medium
from .frame import TEXTURE

# extinction, scattering: 1/m where the stored density is 1, the peak of the medium's. albedo: scattering / extinction.
# cell: the longest edge of a cell of the density, metres.
MEDIUM = Struct(
    "Medium", low="vec3f", cell="f32", high="vec3f", extinction="vec3f", albedo="vec3f",
)  # fmt: skip
# Towards a light a density is summed up in so many steps.
_LIGHT_STEPS = 8


class MediumBuffers:
    """What `shaders/medium.wgsl` reads, brought up to date when the medium or its box has changed."""

    def __init__(self, device: Device):
        self.device = device
        self._of: Medium | None = None
        self._settings = device.uniform("medium", MEDIUM.array(1))
        self._density: Any = None
        self._peak = 1.0
        clamp = {f"address_mode_{axis}": "clamp-to-edge" for axis in "uvw"}
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear", **clamp)

    @property
    def has_density(self) -> bool:
        return self._density is not None

    @property
    def values(self) -> dict[str, Any]:
        """For the shaders' templates."""
        return {"medium": True, "density": self.has_density, "light_steps": _LIGHT_STEPS}

    @property
    def bindings(self) -> list[Binding]:
        more = [texture("density_map", "float", "3d"), sampler("density_sampler")] if self.has_density else []
        return [uniform("medium", MEDIUM), *more]

    @property
    def resources(self) -> dict[str, Any]:
        more = {"density_map": self._density, "density_sampler": self._sampler} if self.has_density else {}
        return {"medium": self._settings, **more}

    def sync(self, medium: Medium, bounds: tuple[np.ndarray, np.ndarray]) -> None:
        """bounds: of the scene, metres: what a medium fills that has no box."""
        if self._of is not medium:
            self._upload(medium.density)
            self._of = medium
        low, high = bounds if medium.low is None or medium.high is None else (medium.low, medium.high)
        cells = (1, 1, 1) if medium.density is None else medium.density.shape[::-1]
        extinction = medium.extinction
        albedo = np.divide(medium.scattering, extinction, out=np.zeros(3), where=extinction > 0.0)
        self.device.write(self._settings, MEDIUM.pack(
            low=low, high=high, extinction=np.minimum(extinction * self._peak, 1e30), albedo=albedo,
            cell=float(((np.asarray(high) - np.asarray(low)) / cells).max()),
        ))  # fmt: skip

    def _upload(self, density: np.ndarray | None) -> None:
        """As shares of the peak, so that half floats hold any density with 11 bits."""
        self._density, self._peak = None, 1.0
        if density is None:
            return
        self._peak = float(density.max()) or 1.0
        depth, height, width = density.shape
        usage = TEXTURE | wgpu.TextureUsage.COPY_DST
        size = (width, height, depth)
        self._density = self.device.texture("fog density", size, "r16float", usage=usage, dimension="3d")
        shares = np.ascontiguousarray(density / np.float32(self._peak), dtype=np.float16)
        layout = {"bytes_per_row": 2 * width, "rows_per_image": height}
        self.device.queue.write_texture({"texture": self._density}, shares, layout, self._density.size)
