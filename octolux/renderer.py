"""The renderer: the order of the passes of a frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from .frame.composite import CompositePass
from .frame.direct import DirectLightPass
from .frame.frame import Frame, FrameBuffers, FrameSettings, Targets
from .frame.gbuffer import GBufferPass
from .frame.lights import light_set, unsupported
from .frame.rsm import RSMPass
from .frame.shadows import ShadowMapPass
from .frame.views import camera_view
from .frame.visibility import VisibilityPass, draw_list
from .gpu.device import Device
from .gpu.profiler import Profiler
from .gpu_scene.gpu_scene import GpuScene
from .picture import Picture
from .scene.cameras import Camera
from .scene.default_camera import default_camera
from .scene.errors import OctoluxError
from .scene.exposure import metered_exposure
from .scene.scene import Scene
from .simulator.tonemap import exposure_factor
from .techniques import technique_class
from .techniques.settings import Settings

_DARKEST = 1e-6  # nits: what a black picture is metered as


class Renderer:
    """Renders a scene again and again; what changed in the scene is uploaded before each frame.

    scene: octolux.Scene; replace elements of its lists to change it.
    technique: a name of `octolux techniques`; preset: one of its presets; settings: values of its settings by name,
        such as {"n": 64}, or a whole settings object.
    size: (width, height), pixels.  exposure: EV100, or None for the scene's, or else metered from the first frame.
    device: share one between renderers; profile: time each stage (adds a wait per stage where timestamps are wrong).

    Raises OctoluxError for an unknown technique, a bad size or a device that is missing or full.
    """

    def __init__(
        self, scene: Scene, technique: str = "uniform-lpv", *, preset: str = "default",
        settings: Settings | dict[str, Any] | None = None, size: tuple[int, int] = (1280, 720),
        exposure: float | None = None, device: Device | None = None, profile: bool = False,
        frame_settings: FrameSettings | None = None,
    ):  # fmt: skip
        chosen = technique_class(technique)
        self.scene, self.exposure = scene, exposure if exposure is not None else scene.exposure
        _check_exposure(self.exposure)
        base = frame_settings or FrameSettings()
        self.frame_settings = FrameSettings(*size, base.shadow_resolution, base.rsm_resolution)
        _check_size(self.frame_settings)
        self.device = device or Device()
        with self.device.guard():
            self.profiler = Profiler(self.device, None if profile else "off")
            self.gpu_scene = GpuScene(self.device)
            self.targets = Targets(self.device, *size)
            self._buffers = FrameBuffers(self.device)
            self._direct = DirectLightPass(self.device)
            self._composite = CompositePass(self.device)
            if not isinstance(settings, Settings):
                settings = chosen.settings_class.make(preset, **(settings or {}))
            self.technique = chosen(self.device, settings)
        self._passes_of = -1

    @property
    def warnings(self) -> list[str]:
        """What the scene holds that this technique leaves out, and what it lacks for a picture."""
        left_out = unsupported(self.scene.lights)
        notes = [
            f"{type(light).__name__} '{light.name}' is left out: technique {self.technique.name} has no area lights"
            for light in left_out
        ]
        if len(left_out) == len(self.scene.lights):
            notes.append("the scene has no light that shines here: only what glows is seen; add lights in a TOML scene")
        if not self.scene.triangle_count:
            notes.append("the scene holds no triangles: only its surroundings are seen")
        return notes

    def render(self, camera: str | int | Camera | None = None) -> Picture:
        """One frame, seen by `camera` (a name, a number, a Camera, or None for the first), as a Picture.

        Everything is lit from scratch. Raises OctoluxError for an unknown camera or a device that failed.
        """
        with self.device.guard():
            frame = self._begin(self._camera(camera))
            with self.profiler.frame():
                self._draw(frame)
            if self.exposure is None:
                self._meter(frame)
            return Picture(self.device, frame, self.exposure)

    def _draw(self, frame: Frame) -> None:
        technique = self.technique
        technique.prepare(frame)
        self._gbuffer.run(frame)
        self._shadow_maps.run(frame, ids="rsm" in technique.needs)
        if "rsm" in technique.needs:
            self._rsm.run(frame, self._shadow_maps)
        technique.update(frame)
        self._direct.run(frame, self._shadow_maps.sampler)
        technique.shade(frame)
        self._composite.run(frame, self._exposure_factor())

    def _begin(self, camera: Camera) -> Frame:
        settings, gpu_scene = self.frame_settings, self.gpu_scene
        gpu_scene.sync(self.scene)
        if self._passes_of != gpu_scene.version:
            visibility = VisibilityPass(self.device, gpu_scene)
            self._gbuffer = GBufferPass(self.device, gpu_scene, visibility)
            self._shadow_maps = ShadowMapPass(self.device, visibility)
            self._rsm = RSMPass(self.device, gpu_scene, settings)
            self._passes_of = gpu_scene.version
        lights = light_set(self.scene.lights, gpu_scene.bounds, settings.shadow_resolution)
        low, high = gpu_scene.bounds
        reach = float(np.linalg.norm(np.maximum(np.abs(low - camera.position), np.abs(high - camera.position))))
        views = [camera_view(camera, *self.targets.size, reach), *lights.views]
        draws = draw_list(gpu_scene, views)
        buffers = self._buffers.upload(lights, views, draws)
        return Frame(
            self.device, self.profiler, self.scene, gpu_scene, settings, self.targets, lights, views, draws, buffers
        )

    def _camera(self, wanted: str | int | Camera | None) -> Camera:
        if isinstance(wanted, Camera):
            return wanted
        cameras = self.scene.cameras or [default_camera(self.scene)]
        names = [c.name for c in cameras]
        if isinstance(wanted, str) and wanted in names:
            return cameras[names.index(wanted)]
        number = 0 if wanted is None else int(wanted) if str(wanted).isdecimal() else -1
        if not 0 <= number < len(cameras):
            known = ", ".join(f"{i} '{name}'" for i, name in enumerate(names))
            raise OctoluxError(f"The scene has no camera '{wanted}'. There are: {known}.")
        return cameras[number]

    def _exposure_factor(self) -> float:
        return float(exposure_factor(self.exposure if self.exposure is not None else 0.0))

    def _meter(self, frame: Frame) -> None:
        """Set the exposure from the mean luminance of this frame, and keep it for those that follow."""
        luminance = Picture(self.device, frame, 0.0).mean_luminance()
        self.exposure = metered_exposure(max(luminance, _DARKEST))
        frame.profiler = Profiler(self.device, "off")  # composing again is no frame of its own
        with frame.profiler.frame():
            self._composite.run(frame, self._exposure_factor())

    def statistics(self) -> dict[str, Any]:
        """What `--stats` writes: adapter, technique, settings, size, times and memory."""
        return {
            "adapter": self.device.adapter_name,
            "technique": self.technique.name,
            "settings": self.technique.settings.as_dict(),
            "size": list(self.targets.size),
            "frames": self.profiler.frames,
            "frame_ms": self.profiler.frame_ms(),
            "stages": self.profiler.stages(),
            "timing": self.profiler.mode,
            "timing_note": self.profiler.note,
            "memory_bytes": {"total": self.device.memory.total, **self.device.memory.by_label()},
        }


def _check_exposure(exposure: float | None) -> None:
    """An exposure beyond 2^64 either way is a slip, and would leave float32's range."""
    if exposure is not None and not abs(exposure) <= 64:
        raise OctoluxError(f"The exposure is EV100, from about -6 (starlight) to 16 (snow in the sun), not {exposure}.")


def _check_size(settings: FrameSettings) -> None:
    """Raise OctoluxError for sizes that cannot be."""
    for name, value, most in (("width", settings.width, 8192), ("height", settings.height, 8192)):
        if not 1 <= value <= most:
            raise OctoluxError(f"The picture's {name} must be 1 to {most} pixels, not {value}.")
    if settings.shadow_resolution % settings.rsm_resolution:
        raise OctoluxError(
            f"rsm_resolution {settings.rsm_resolution} does not divide shadow_resolution {settings.shadow_resolution}."
        )
