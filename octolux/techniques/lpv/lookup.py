"""Lookup: accumulated light in filterable volumes, read as irradiance at what the camera sees, and by fog."""

from __future__ import annotations

from typing import Any

from ...frame.frame import COPY, STORAGE, TEXTURE, Frame
from ...frame.structs import VIEW, views_binding
from ...frame.volume_light import VolumeLight
from ...gpu.bindings import Binding, sampler, storage, storage_texture, texture
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.passes import ComputePass
from ...simulator.lpv.cascades import transition
from .constants import GRID, SH_CONSTANTS, grids_binding
from .windows import WINDOW, windows_binding

CHANNELS = ("red", "green", "blue")


class Lookup:
    """Three rgba16float volumes and the pass that reads them.

    reading, scale: simulator/lpv/lookup.py.  damping: CLPV 3.4's derivative damping.  lookup_offset: cells that the
    point of lookup is moved along the normal.  windows: nested ones (CLPV 4), which lie behind one another in y; at
    each place the finest is read that holds it, giving way to the next at its ends.  visibility: `read` is given a
    texture of ambient visibility.
    """

    def __init__(
        self, device: Device, n: int, *, reading: str, damping: bool, lookup_offset: float, scale: float = 1.0,
        windows: int = 1, visibility: bool = False,
    ):  # fmt: skip
        self.n, self.windows, self.device, self._visibility = n, windows, device, visibility
        usage = TEXTURE | STORAGE | COPY
        self.volumes = {
            c: device.texture("LPV volumes", (n, n * windows, n), "rgba16float", usage=usage, dimension="3d")
            for c in CHANNELS
        }
        self._write = ComputePass(
            device, "volumes", "techniques/lpv/volumes.wgsl",
            [storage("light", "vec4f"), *(storage_texture(f"{c}_out", "rgba16float", "3d") for c in CHANNELS)],
            workgroup=(4, 4, 4), n=n,
        )  # fmt: skip
        clamp = {f"address_mode_{axis}": "clamp-to-edge" for axis in "uvw"}
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear", **clamp)
        self._read = ComputePass(
            device, "lookup", "techniques/lpv/lookup.wgsl",
            [
                views_binding(), texture("surface_map", "uint"), texture("depth_map"), *self._bindings(),
                storage_texture("irradiance_out", "rgba32float"),
                *([texture("visibility_map")] if visibility else []),
            ],
            structs=[VIEW, *self._structs()], reading=reading, damping=damping, lookup_offset=float(lookup_offset),
            scale=scale, visibility=visibility, **self._values(),
        )  # fmt: skip
        self.irradiance: Any = None

    def prepare(self, pixels: tuple[int, int]) -> None:
        if self.irradiance is None or self.irradiance.size[:2] != pixels:
            usage = STORAGE | TEXTURE | COPY
            self.irradiance = self.device.texture("LPV irradiance", pixels, "rgba32float", usage=usage)

    def write_volumes(self, stage: Any, light: Any) -> None:
        """light: vec4f [window][z][y][x][rgb], scaled for storage."""
        outputs = {f"{c}_out": self.volumes[c] for c in CHANNELS}
        self._write.run(stage, (self.n, self.n * self.windows, self.n), light=light, **outputs)

    def read(
        self, stage: Any, frame: Frame, grids: Any, peak: Any, windows: Any = None, visibility: Any = None
    ) -> None:
        """Write irradiance of every pixel into `self.irradiance`, and ambient visibility into its alpha: `visibility`
        (r32float), or 1. grids: uniform buffer of GRID, one for each window.  windows: of WINDOW, where there are
        several."""
        visible = {"visibility_map": visibility} if self._visibility else {}
        self._read.run(
            stage, frame.pixels, views=frame.buffers["views"], surface_map=frame.targets.surface,
            depth_map=frame.targets.depth, irradiance_out=self.irradiance, **visible,
            **self._resources(grids, peak, windows),
        )  # fmt: skip

    def volume_light(self, grids: Any, peak: Any, windows: Any = None) -> VolumeLight:
        """The volumes as fog reads them. grids, windows: as for `read`.  peak: of the injection."""
        return VolumeLight(
            "techniques/lpv/volume_light.wgsl", tuple(self._bindings()), tuple(self._structs()),
            self._resources(grids, peak, windows), self._values(),
        )  # fmt: skip

    def _bindings(self) -> list[Binding]:
        volumes = [texture(c, "float", "3d") for c in CHANNELS]
        places = [grids_binding(self.windows), *([windows_binding(self.windows)] if self.windows > 1 else [])]
        return [*places, storage("peak", "u32"), *volumes, sampler("volume_sampler")]

    def _structs(self) -> list[Struct]:
        return [GRID, WINDOW] if self.windows > 1 else [GRID]

    def _values(self) -> dict[str, Any]:
        return {"n": self.n, "windows": self.windows, "transition": transition(self.n), **SH_CONSTANTS}

    def _resources(self, grids: Any, peak: Any, windows: Any) -> dict[str, Any]:
        nested = {"windows": windows} if self.windows > 1 else {}
        return {"grids": grids, "peak": peak, "volume_sampler": self._sampler, **nested, **self.volumes}
