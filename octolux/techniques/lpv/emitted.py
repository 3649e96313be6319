"""Low-frequency direct light in volumes: particles, area lights, glowing surfaces, surroundings (CLPV 3.1)."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ...frame.emitters import glowing_patches
from ...frame.frame import Frame
from ...frame.vpl_sources import SOURCE, VplSource, group_sources
from ...gpu.bindings import Binding, atomic_words, storage_rw, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.passes import ComputePass
from ...gpu.records import record_texture, records, write_records
from ...scene.lights import AreaLight, ParticleLights
from ...simulator.camera import pack_normals
from ...simulator.grid import Grid
from ...simulator.lpv.emitted import Emitted, environment_records, particle_records, patch_records
from .constants import GRID, SH_CONSTANTS, grids_binding

# A record: simulator/lpv/emitted.py says what its light is. axis: octahedral.
EMITTED = Struct("Emitted", position="vec3f", axis="u32", flux="vec3f", beam="f32")

KINDS = ("particles", "surfaces", "surroundings")


def pack_emitted(emitted: Emitted) -> np.ndarray:
    """EMITTED of each record."""
    rows = EMITTED.array(len(emitted.beam))
    rows["position"], rows["flux"], rows["beam"] = emitted.position, emitted.flux, emitted.beam
    rows["axis"] = pack_normals(emitted.axis)
    return rows


class EmittedLights:
    """The records of a scene's low-frequency lights on the device, made anew where what they are made of has changed.

    kinds: which of KINDS.  texture: EMITTED.  sources: the range of each kind that has light, for `EmittedInjection`.
    """

    def __init__(self, device: Device, kinds: Sequence[str] = KINDS):
        self.device, self.kinds = device, tuple(kinds)
        self.texture: Any = record_texture(device, "LPV emitted light", EMITTED, 1)
        self.sources: list[VplSource] = []
        self._room = 1
        self._made: dict[str, tuple[tuple, Emitted]] = {}

    def sync(self, frame: Frame, grids: Sequence[Grid]) -> None:
        """Bring the records up to date. grids: nested, the finest first; surfaces are cut into patches no longer than
        half a cell of the first, the surroundings' light enters at the border of the last."""
        makers = {"particles": self._particles, "surfaces": self._surfaces, "surroundings": self._surroundings}
        changed = [makers[kind](frame, grids) for kind in self.kinds]
        if any(changed):
            self._upload([self._made[kind][1] for kind in self.kinds])

    def _particles(self, frame: Frame, grids: Sequence[Grid]) -> bool:
        groups = tuple(light for light in frame.scene.lights if isinstance(light, ParticleLights))
        return self._renewed("particles", groups, lambda: particle_records(groups))

    def _surfaces(self, frame: Frame, grids: Sequence[Grid]) -> bool:
        scene, longest = frame.scene, 0.5 * grids[0].cell_size
        lamps = tuple(light for light in scene.lights if isinstance(light, AreaLight))

        def make() -> Emitted:
            patches = glowing_patches(scene)
            return patch_records(patches.corners, patches.radiance, longest)

        return self._renewed("surfaces", (frame.gpu_scene.moves, lamps, longest), make)

    def _surroundings(self, frame: Frame, grids: Sequence[Grid]) -> bool:
        environment, grid = frame.surroundings, grids[-1]
        return self._renewed(
            "surroundings", (environment, grid),
            lambda: Emitted.joined([]) if environment.is_black else environment_records(environment, grid),
        )  # fmt: skip

    def _renewed(self, kind: str, key: tuple, make: Callable[[], Emitted]) -> bool:
        """Whether the records of a kind had to be made anew: not where its key is as it was."""
        if kind in self._made and self._made[kind][0] == key:
            return False
        self._made[kind] = key, make()
        return True

    def _upload(self, parts: Sequence[Emitted]) -> None:
        rows = np.concatenate([pack_emitted(part).view(np.uint8) for part in parts]).view(EMITTED.dtype)
        ends = np.cumsum([len(part.beam) for part in parts])
        self.sources = [
            VplSource(int(end) - len(part.beam), len(part.beam), part.bound)
            for part, end in zip(parts, ends, strict=True) if len(part.beam)
        ]  # fmt: skip
        if len(rows) > self._room:
            self._room = len(rows) + len(rows) // 4
            self.texture = record_texture(self.device, "LPV emitted light", EMITTED, self._room)
        write_records(self.device, self.texture, rows)


class EmittedInjection:
    """Adds records to light that is there already: vec4f [grid][z][y][x][rgb], W/sr, and to its peak.

    grids: nested ones, the finest first, each of n^3 cells. A record goes into each that holds it.
    moments: `run` is given those that `Injection` has left, and adds to them.
    """

    def __init__(self, device: Device, n: int, *, grids: int = 1, moments: bool = False):
        self.device = device
        self._layers, self._moments = grids, moments
        self._sums = device.buffer("LPV emitted sums", size=grids * n**3 * (64 if moments else 48))
        self._sources: list[Any] = []
        bindings = [uniform("source", SOURCE), grids_binding(grids), records("emitted", EMITTED)]

        def made(label: str, collect: bool, more: Sequence[Binding]) -> ComputePass:
            return ComputePass(
                device, f"{label} emitted light", "techniques/lpv/emitted.wgsl",
                [*bindings, atomic_words("sums", "i32"), *more],
                structs=[SOURCE, GRID, EMITTED], workgroup=(64, 1, 1), grids=grids, collect=collect,
                moments=moments, **SH_CONSTANTS,
            )  # fmt: skip

        self._scatter = made("inject", False, ())
        self._collect = made("collect", True, (
            storage_rw("injected", "f32"), atomic_words("peak", "u32"),
            *([storage_rw("moments", "f32")] if moments else []),
        ))  # fmt: skip

    def run(
        self, stage: Any, grids: Any, lights: EmittedLights, injected: Any, peak: Any, moments: Any = None
    ) -> None:
        """Add the light. grids: uniform buffer of GRID, one for each.  injected, peak, moments: as `Injection` leaves
        them."""
        shared = {"grids": grids, "emitted": lights.texture, "sums": self._sums}
        placed = {"moments": moments} if self._moments else {}
        used = 0
        for group in group_sources(lights.sources):
            ranges = [(self._source_buffer(used + i, packed), packed) for i, packed in enumerate(group.pack())]
            used += len(ranges)
            for source, packed in ranges:
                self._scatter.run(stage, (int(packed["count"][0]), self._layers), source=source, **shared)
            for source, packed in ranges:
                threads = (int(packed["count"][0]), self._layers)
                self._collect.run(stage, threads, source=source, injected=injected, peak=peak, **placed, **shared)

    def _source_buffer(self, number: int, packed: np.ndarray) -> Any:
        """A uniform buffer for each dispatch of a frame: all are written before the first of them runs."""
        if number == len(self._sources):
            self._sources.append(self.device.uniform("LPV emitted sources", SOURCE.array(1)))
        self.device.write(self._sources[number], packed)
        return self._sources[number]
