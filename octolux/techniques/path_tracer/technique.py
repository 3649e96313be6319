"""`path-tracer`: the reference. Unbiased light transport for everything the scene model has."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import wgpu

from ...frame.environment import SurroundingsMap
from ...frame.frame import COPY, STORAGE, TEXTURE, Frame, TracedPaths
from ...frame.shader_values import CONSTANTS, surface_values
from ...frame.structs import ENVIRONMENT, LIGHT, VIEW, lights_binding, views_binding
from ...gpu.bindings import storage_texture, storage_words, texture, uniform
from ...gpu.device import Device
from ...gpu.layout import Struct
from ...gpu.passes import ComputePass
from ...raytracing.bvh import Bvh
from ...simulator.environment import LUMINANCE
from ..technique import Technique
from .emitters import EMITTER, EmitterList, emitter_list, sky_table
from .particles import PARTICLE, ParticleTable
from .settings import PathTracerSettings

PATHS = Struct(
    "PathSettings", tile_origin="vec2u", tile_size="vec2u", first_sample="u32", samples="u32", seed="u32",
    emitters="u32", near="f32", inverse_emission="f32", inverse_sky="f32", exposure="f32", fresh="u32",
    particles="u32", inverse_particles="f32",
)  # fmt: skip
RESOLVE = Struct("ResolveSettings", count="f32")

_SUMS = ("radiance_sum", "direct_sum", "indirect_sum")
# A dispatch aims at this long, s: far below the second or two after which systems take a graphics card for hung.
_DISPATCH_SECONDS = 0.25
_METERING_SAMPLES = 4
_LUMINANCE = f"vec3f({', '.join(map(str, LUMINANCE))})"


class PathTracer(Technique):
    """Sums up paths in tiles; `frame.progress` is asked after each round whether to go on."""

    name, summary = "path-tracer", "the reference: unbiased paths for all light and materials"
    settings_class = PathTracerSettings
    label = "path tracer"
    needs = frozenset({"bvh", "surroundings"})
    supports = frozenset(
        {"dynamic geometry", "dynamic lights", "diffuse", "glossy", "area lights", "emission", "sky", "particles",
         "many bounces"}
    )  # fmt: skip
    replaces_direct = True
    settings: PathTracerSettings

    def __init__(self, device: Device, settings: PathTracerSettings):
        super().__init__(device, settings)
        self.bvh = Bvh(device)
        self._uniform = device.uniform("path tracer settings", PATHS.array(1))
        self._resolve_uniform = device.uniform("path tracer settings", RESOLVE.array(1))
        self._sums: dict[str, list[Any]] = {}
        self._out: Any = None
        self._passes: dict[tuple, ComputePass] = {}
        self._sky_of: Any = None
        self._sky, self._sky_power = None, 0.0
        self._emitters_key: tuple = ()
        self._emitters: EmitterList
        self._emitter_buffer: Any = None
        self._particles = ParticleTable(device)
        self._paths_per_dispatch = 1 << 14
        self.samples_taken = 0
        self._resolve = ComputePass(
            device, "path tracer means", "techniques/path_tracer/resolve.wgsl",
            [
                uniform("settings", RESOLVE), *(texture(name) for name in _SUMS),
                *(storage_texture(name, "rgba32float") for name in ("radiance_out", "direct_out", "indirect_out")),
            ],
            structs=[RESOLVE], luminance=_LUMINANCE,
        )  # fmt: skip

    def prepare(self, frame: Frame) -> None:
        if self._out is None or self._out[0].size[:2] != frame.pixels:
            self._sums = {name: [self._picture(frame), self._picture(frame)] for name in _SUMS}
            self._out = [self._picture(frame), self._picture(frame)]
        frame.radiance, frame.indirect = self._out

    def _picture(self, frame: Frame) -> Any:
        return self.device.texture(
            "path tracer", frame.pixels, "rgba32float", usage=STORAGE | TEXTURE | COPY | wgpu.TextureUsage.COPY_DST
        )

    def update(self, frame: Frame) -> None:
        """Bring the BVH and the lists of what shines up to date."""
        with frame.profiler.stage("BVH") as stage:
            self.bvh.sync(frame.gpu_scene, stage)
        self._sync_emitters(frame)
        self._particles.sync(frame.scene)
        environment = frame.scene.environment
        if self._sky_of is not environment:
            dark = np.zeros((1, 1, 4), np.float32), 0.0
            table, self._sky_power = dark if environment.is_black else sky_table(environment)
            usage, size = TEXTURE | wgpu.TextureUsage.COPY_DST, (table.shape[1], table.shape[0])
            self._sky = self.device.texture("path tracer sky", size, "rgba32float", usage=usage)
            self.device.write_layer(self._sky, table)
            self._sky_of = environment

    def _sync_emitters(self, frame: Frame) -> None:
        key = (frame.gpu_scene.moves, tuple(frame.scene.lights))
        if self._emitters_key == key:
            return
        self._emitters_key, self._emitters = key, emitter_list(frame.scene, frame.gpu_scene.drawn)
        rows = self._emitters.rows
        if self._emitter_buffer is None or self._emitter_buffer.size != rows.nbytes:
            self._emitter_buffer = self.device.buffer("path tracer emitters", rows)
        else:
            self.device.write(self._emitter_buffer, rows)

    def shade(self, frame: Frame) -> None:
        """Take the samples and write the means."""
        target = min(self.settings.samples, _METERING_SAMPLES) if frame.metering else self.settings.samples
        trace, self.samples_taken, check = self._trace_pass(frame), 0, 16
        if frame.start and not frame.metering:
            self._go_on_from(frame.start)
        check = max(check, 2 * self.samples_taken)
        while self.samples_taken < target:
            self._round(frame, trace)
            self.samples_taken += 1
            if frame.progress and not frame.metering and not frame.progress(self.samples_taken, target):
                break
            if self.settings.noise > 0 and self.samples_taken == check:
                self._write_means(frame)
                if self._relative_error(frame) <= self.settings.noise:
                    return
                check *= 2
        self._write_means(frame)

    def _go_on_from(self, start: TracedPaths) -> None:
        """Sums are counts times means. The squares' is led back from the standard error, whose square is (mean square -
        square of mean) / (n - 1)."""
        n, mean = start.count, start.radiance.astype(np.float64) @ LUMINANCE
        squares = n * ((n - 1) * start.noise[..., 0].astype(np.float64) ** 2 + mean * mean)
        sums = {
            "radiance_sum": np.dstack([start.radiance, start.alpha]) * n,
            "direct_sum": np.dstack([start.direct * n, squares]),
            "indirect_sum": np.dstack([start.indirect, start.alpha]) * n,
        }
        for name, values in sums.items():
            self.device.write_layer(self._sums[name][0], np.ascontiguousarray(values, dtype=np.float32))
        self.samples_taken = n

    def _round(self, frame: Frame, trace: ComputePass) -> None:
        """One more path for every pixel, in tiles of whole rows."""
        width, height = frame.pixels
        top = 0
        while top < height:
            rows = max(1, min(self._paths_per_dispatch // width, height - top))
            self._write_settings(frame, (0, top), (width, rows))
            ins = {f"{name}_in": pair[0] for name, pair in self._sums.items()}
            outs = {f"{name}_out": pair[1] for name, pair in self._sums.items()}
            start = time.perf_counter()
            with frame.profiler.stage("paths") as stage:
                trace.run(
                    stage, (width, rows), frame.gpu_scene.resources, settings=self._uniform,
                    views=frame.buffers["views"], lights=frame.buffers["lights"], bvh=self.bvh.texture,
                    emitters=self._emitter_buffer, particles=self._particles.buffer, sky_table=self._sky,
                    **frame.surroundings_map.resources, **ins, **outs,
                )  # fmt: skip
            frame.profiler.submit()
            self.device.wait()
            self._adapt(time.perf_counter() - start, full=top + rows < height)
            top += rows
        for pair in self._sums.values():
            pair.reverse()

    def _adapt(self, seconds: float, full: bool) -> None:
        """Make the next dispatch longer or shorter; the last tile of a picture says little."""
        if seconds > 2.0 * _DISPATCH_SECONDS:
            self._paths_per_dispatch = max(self._paths_per_dispatch // 2, 1 << 10)
        elif seconds < 0.5 * _DISPATCH_SECONDS and full:
            self._paths_per_dispatch = min(self._paths_per_dispatch * 2, 1 << 22)

    def _write_settings(self, frame: Frame, origin: tuple[int, int], size: tuple[int, int]) -> None:
        emission, sky = self._emitters.power, self._sky_power
        self.device.write(self._uniform, PATHS.pack(
            tile_origin=origin, tile_size=size, first_sample=self.samples_taken, samples=1, seed=self.settings.seed,
            emitters=len(self._emitters.rows) if emission else 0, near=frame.views[0].near,
            inverse_emission=1.0 / emission if emission else 0.0, inverse_sky=1.0 / sky if sky else 0.0,
            exposure=frame.exposure_factor, fresh=self.samples_taken == 0, **self._particles.settings,
        ))  # fmt: skip

    def _write_means(self, frame: Frame) -> None:
        frame.paths = self.samples_taken
        self.device.write(self._resolve_uniform, RESOLVE.pack(count=self.samples_taken))
        with frame.profiler.stage("means") as stage:
            self._resolve.run(
                stage, frame.pixels, settings=self._resolve_uniform, radiance_out=frame.radiance,
                direct_out=frame.targets.direct, indirect_out=frame.indirect,
                **{name: pair[0] for name, pair in self._sums.items()},
            )  # fmt: skip
        frame.profiler.submit()

    def _relative_error(self, frame: Frame) -> float:
        """Root mean square of the pixels' standard errors over the picture's mean luminance."""
        errors = self.device.read_texture(frame.targets.direct, np.float32, 4)[..., 3].astype(np.float64)
        mean = float((self.device.read_texture(frame.radiance, np.float32, 4)[..., :3] @ LUMINANCE).mean())
        return float(np.sqrt((errors**2).mean())) / max(mean, 1e-30)

    def _trace_pass(self, frame: Frame) -> ComputePass:
        directional, spots, points = frame.lights.counts[:3]
        values = {
            "directional": directional, "spots": spots, "lamps": directional + spots + points,
            "emitters": bool(self._emitters.power), "area_lights": self._emitters.area_lights,
            "sky": int(self._sky_power > 0), "particles": bool(self._particles.power),
            "paths": self.settings.paths, "bounces": self._bounces(),
            "diffuse_only": self.settings.materials == "diffuse", "centre": self.settings.pixel == "centre",
            "transparent": frame.transparent, "inverse_square": frame.settings.inverse_square,
        }  # fmt: skip
        made_for = (frame.gpu_scene.version, self.bvh.version)
        key = (*made_for, *values.values())
        if key not in self._passes:
            self._passes = {k: p for k, p in self._passes.items() if k[:2] == made_for}
            self._passes[key] = self._made(frame, values)
        return self._passes[key]

    def _bounces(self) -> int:
        most = {"direct": 0, "first-bounce": 1}.get(self.settings.paths, self.settings.bounces)
        return min(most, self.settings.bounces)

    def _made(self, frame: Frame, values: dict[str, Any]) -> ComputePass:
        names = (*(f"{name}_in" for name in _SUMS), "sky_table")
        return ComputePass(
            self.device, "path tracer", "techniques/path_tracer/trace.wgsl",
            [
                uniform("settings", PATHS), views_binding(), lights_binding(), self.bvh.binding,
                storage_words("emitters", EMITTER), storage_words("particles", PARTICLE),
                *(texture(name) for name in names),
                *(storage_texture(f"{name}_out", "rgba32float") for name in _SUMS), *SurroundingsMap.bindings(),
            ],
            # Neighbouring threads are 4 x 2 pixels: their rays stay together longer than those of a row.
            structs=[PATHS, VIEW, LIGHT, EMITTER, PARTICLE, ENVIRONMENT], workgroup=(4, 16, 1),
            shared=frame.gpu_scene.bindings, shadows=False, luminance=_LUMINANCE, **values, **self.bvh.values,
            **CONSTANTS, **surface_values(frame.gpu_scene),
        )  # fmt: skip

    def memory(self) -> dict[str, int]:
        """With the BVH's."""
        held = self.device.memory.by_label()
        return {k: v for k, v in held.items() if k.startswith(("path tracer", "BVH"))}
