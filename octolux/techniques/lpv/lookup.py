"""Lookup: accumulated light in filterable volumes, read as irradiance at what the camera sees."""

from __future__ import annotations

from typing import Any

from ...frame.frame import COPY, STORAGE, TEXTURE, Frame
from ...frame.structs import VIEW, views_binding
from ...frame.volume_light import VolumeLight
from ...gpu.bindings import Binding, sampler, storage, storage_texture, texture, uniform
from ...gpu.device import Device
from ...gpu.passes import ComputePass
from .constants import GRID, SH_CONSTANTS

CHANNELS = ("red", "green", "blue")


class Lookup:
    """Three rgba16float volumes and the pass that reads them.

    reading, scale: simulator/lpv/lookup.py.  damping: CLPV 3.4's derivative damping.  lookup_offset: cells that the
    point of lookup is moved along the normal.
    """

    def __init__(
        self, device: Device, n: int, *, reading: str, damping: bool, lookup_offset: float, scale: float = 1.0
    ):
        self.n, self.device = n, device
        usage = TEXTURE | STORAGE | COPY
        self.volumes = {
            c: device.texture("LPV volumes", (n, n, n), "rgba16float", usage=usage, dimension="3d") for c in CHANNELS
        }
        self._write = ComputePass(
            device, "volumes", "techniques/lpv/volumes.wgsl",
            [storage("light", "vec4f"), *(storage_texture(f"{c}_out", "rgba16float", "3d") for c in CHANNELS)],
            workgroup=(4, 4, 4),
        )  # fmt: skip
        clamp = {f"address_mode_{axis}": "clamp-to-edge" for axis in "uvw"}
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear", **clamp)
        self._read = ComputePass(
            device, "lookup", "techniques/lpv/lookup.wgsl",
            [
                views_binding(), texture("surface_map", "uint"), texture("depth_map"), *_volume_bindings(),
                storage_texture("irradiance_out", "rgba32float"),
            ],
            structs=[VIEW, GRID], reading=reading, damping=damping, lookup_offset=float(lookup_offset), scale=scale,
            **SH_CONSTANTS,
        )  # fmt: skip
        self.irradiance: Any = None

    def prepare(self, pixels: tuple[int, int]) -> None:
        if self.irradiance is None or self.irradiance.size[:2] != pixels:
            usage = STORAGE | TEXTURE | COPY
            self.irradiance = self.device.texture("LPV irradiance", pixels, "rgba32float", usage=usage)

    def write_volumes(self, stage: Any, light: Any) -> None:
        outputs = {f"{c}_out": self.volumes[c] for c in CHANNELS}
        self._write.run(stage, (self.n,) * 3, light=light, **outputs)

    def read(self, stage: Any, frame: Frame, grid: Any, peak: Any) -> None:
        """Write irradiance of every pixel into `self.irradiance`."""
        self._read.run(
            stage, frame.pixels, views=frame.buffers["views"], surface_map=frame.targets.surface,
            depth_map=frame.targets.depth, grid=grid, peak=peak, volume_sampler=self._sampler,
            irradiance_out=self.irradiance, **self.volumes,
        )  # fmt: skip

    def volume_light(self, grid: Any, peak: Any) -> VolumeLight:
        """The volumes as fog reads them. grid: uniform buffer of GRID.  peak: of the injection."""
        resources = {"grid": grid, "peak": peak, "volume_sampler": self._sampler, **self.volumes}
        file = "techniques/lpv/volume_light.wgsl"
        return VolumeLight(file, tuple(_volume_bindings()), (GRID,), resources, SH_CONSTANTS)


def _volume_bindings() -> list[Binding]:
    volumes = [texture(c, "float", "3d") for c in CHANNELS]
    return [uniform("grid", GRID), storage("peak", "u32"), *volumes, sampler("volume_sampler")]
