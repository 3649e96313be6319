"""Further bounces on the device (simulator/lpv/bouncing.py): light is gathered at surfaces, and injected again."""

from __future__ import annotations

from math import pi
from typing import Any

from ....frame.frame import COPY, STORAGE, TEXTURE
from ....gpu.bindings import atomic_words, sampler, storage, storage_rw, storage_texture, texture
from ....gpu.device import Device
from ....gpu.passes import ComputePass
from ....simulator.lpv.octree import level_sizes
from ..constants import SH_CONSTANTS
from ..gathering.gathering import Gathering
from ..levels import Levels
from ..reflectors import Reflectors
from ..windows import WINDOW, windows_binding

_ALL = 1 << 26  # all that has been sent, in fixed point: surfaces may receive up to 64 times as much


class Bounces:
    """Adds light of `count` further bounces to what has been injected. No bounce lands with more than was sent.

    Light arrives at the surfaces in the cells of the last window, which is whole: cubes of irradiance, gathered as the
    picture's are. What the surfaces of finer windows reflect is made of these cubes, filtered.
    """

    def __init__(self, device: Device, levels: Levels, count: int, *, occlusion: bool):
        n, windows = levels.sizes[0], levels.windows
        self.device, self.n, self._count, self._windows = device, n, count, windows
        whole = Levels(level_sizes(n))
        self._gathering = Gathering(
            device, whole, occlusion=occlusion, lookup_offset=0.0, strips_first=(windows - 1) * n**3,
            unit=2 ** (windows - 1),
        )  # fmt: skip
        self._light = device.buffer("LPV bounced light", size=whole.cells * 48)
        self._received = device.buffer("LPV received light", size=16)
        usage = TEXTURE | STORAGE | COPY
        self._sums = [
            device.texture("LPV bounced irradiance", (n, n, 6 * n), "rgba16float", usage=usage, dimension="3d")
            for _ in range(2)
        ]
        self._sampler = device.wgpu.create_sampler(
            mag_filter="linear", min_filter="linear", **{f"address_mode_{a}": "clamp-to-edge" for a in "uvw"}
        )
        self._make_passes(windows)

    def _make_passes(self, windows: int) -> None:
        device, n = self.device, self.n
        values: dict[str, Any] = {"n": n, "windows": windows, "pi": pi, **SH_CONSTANTS}
        reflectors, cube = storage("reflectors", "vec4f"), texture("cube", "float", "3d")
        self._mark = ComputePass(
            device, "mark reflectors", "techniques/lpv/bouncing/mark_reflectors.wgsl",
            [reflectors, storage_rw("marks", "u32", "write")], workgroup=(64, 1, 1), **values,
        )  # fmt: skip
        peak = storage("peak", "u32")
        values["one"] = _ALL
        self._measure = ComputePass(
            device, "measure bounce", "techniques/lpv/bouncing/measure.wgsl",
            [reflectors, cube, peak, storage("light", "vec4f"), atomic_words("received", "u32")], workgroup=(4, 4, 4),
            last_cell=self._gathering.levels.cells - 1, **values,
        )  # fmt: skip
        self._reflect = [
            ComputePass(
                device, "reflect", "techniques/lpv/bouncing/reflect.wgsl",
                [reflectors, cube, *([] if first else [texture("sum_so_far", "float", "3d")]),
                 storage_texture("sum_out", "rgba16float", "3d"), storage_rw("light", "vec4f", "write"), peak,
                 storage("received", "u32"), storage("places", "vec4f"), storage_rw("moments", "vec4f", "write")],
                workgroup=(4, 4, 4), first=first, **values,
            ) for first in (True, False)
        ]  # fmt: skip
        self._inject = ComputePass(
            device, "inject bounces", "techniques/lpv/bouncing/inject_bounces.wgsl",
            [reflectors, cube, sampler("volume_sampler"), storage("peak", "u32"), windows_binding(windows),
             storage_rw("injected", "vec4f"), storage_rw("moments", "vec4f"), storage("places", "vec4f")],
            structs=[WINDOW], workgroup=(4, 4, 4), **values,
        )  # fmt: skip

    def run(
        self, stage: Any, injected: Any, moments: Any, peak: Any, reflectors: Reflectors, packed_strips: Any,
        windows: Any,
    ) -> None:  # fmt: skip
        """Add bounced light to the cells of all windows of `injected`, which are complete, and to their `moments`
        (gathering.py). reflectors: with places; packed_strips: geometry.py's."""
        n, surfaces = self.n, {"reflectors": reflectors.reflectors, "places": reflectors.places}
        self._gathering.forget(stage)
        self._mark.run(stage, (n**3,), reflectors=reflectors.reflectors, marks=self._gathering.marks)
        last = (self._windows - 1) * n**3
        stage.encoder.copy_buffer_to_buffer(injected, last * 48, self._light, 0, n**3 * 48)
        stage.encoder.copy_buffer_to_buffer(moments, last * 16, self._gathering.moments, 0, n**3 * 16)
        so_far, target = self._sums
        for bounce in range(self._count):
            self._gathering.finish(stage, self._light)
            self._gathering.gather(stage, peak, packed_strips)
            stage.encoder.clear_buffer(self._received)
            given = {"cube": self._gathering.cube, "peak": peak, "light": self._light, "received": self._received}
            self._measure.run(stage, (n, n, n), reflectors=reflectors.reflectors, **given)
            before = {} if bounce == 0 else {"sum_so_far": so_far}
            self._reflect[bounce > 0].run(
                stage, (n, n, n), **surfaces, **given, **before, sum_out=target, moments=self._gathering.moments
            )
            so_far, target = target, so_far
        self._inject.run(
            stage, (n, n, n * self._windows), **surfaces, cube=so_far, volume_sampler=self._sampler, peak=peak,
            windows=windows, injected=injected, moments=moments,
        )  # fmt: skip
