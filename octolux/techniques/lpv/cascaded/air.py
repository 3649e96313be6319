"""Light in the air for fog: what cells of the level above the last cascade gather, surfaces or not (CLPV 7)."""

from __future__ import annotations

from typing import Any

from ....frame.frame import Frame
from ....frame.volume_light import VolumeLight
from ....gpu.bindings import sampler as sampler_binding
from ....gpu.bindings import storage, texture
from ....gpu.device import Device
from ....simulator.lpv.octree import level_sizes
from ..constants import GRID, grids_binding
from ..gathering.gathering import Gathering
from ..levels import Levels
from .cascades import Cascades


class AirLight:
    """Cells of (n / 2)^3 over the whole volume: light in the air has no edges but those of shafts, which are direct
    light's, and all its cells are read, not only those before surfaces. `light` is what fog reads."""

    def __init__(self, device: Device, cascades: Cascades, levels: Levels, *, occlusion: bool):
        self._cascades, self._level = cascades, levels.windows
        self._first = levels.first(self._level)
        self._whole = Levels(level_sizes(cascades.n // 2))
        self._light = device.buffer("LPV light in the air", size=self._whole.cells * 48)
        self._gathering = Gathering(
            device, self._whole, occlusion=occlusion, lookup_offset=0.0, everywhere=True, strips_first=self._first,
            unit=2**self._level,
        )  # fmt: skip
        self.light: VolumeLight | None = None
        clamp = {f"address_mode_{axis}": "clamp-to-edge" for axis in "uvw"}
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear", **clamp)

    def run(self, stage: Any, frame: Frame, injected: Any, moments: Any, peak: Any, packed_strips: Any) -> None:
        """Gather from `injected` and its `moments`, all levels of which are made, and let the frame's fog read it."""
        for source, target, size in ((injected, self._light, 48), (moments, self._gathering.moments, 16)):
            cells = (self._cascades.n // 2) ** 3
            stage.encoder.copy_buffer_to_buffer(source, self._first * size, target, 0, cells * size)
        self._gathering.forget(stage)
        self._gathering.finish(stage, self._light)
        self._gathering.gather(stage, peak, packed_strips)
        count = self._cascades.count
        self.light = frame.volume_light = VolumeLight(
            "techniques/lpv/cascaded/air.wgsl",
            (grids_binding(count), storage("peak", "u32"), texture("air_cube", "float", "3d"),
             sampler_binding("air_sampler")),
            (GRID,),
            {"grids": self._cascades.grids_buffer, "peak": peak, "air_cube": self._gathering.cube,
             "air_sampler": self._sampler},
            {"air_n": self._cascades.n // 2, "last": count - 1},
        )  # fmt: skip
