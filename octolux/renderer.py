"""The renderer: the order of the passes of a frame."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from .frame.anti_aliasing import FxaaPass, sample_view, samples_of
from .frame.composite import CompositePass
from .frame.direct import DirectLightPass
from .frame.emitters import EmitterLight, emitter_lights
from .frame.environment import SurroundingsMap
from .frame.fog import FogPass
from .frame.frame import Frame, FrameBuffers, Targets, TracedPaths
from .frame.gbuffer import GBufferPass
from .frame.lights import light_set
from .frame.medium import MediumBuffers
from .frame.peeling import PeelingPass
from .frame.rsm import RSMPass
from .frame.settings import FrameSettings
from .frame.shadows import ShadowMapPass
from .frame.views import View, camera_view
from .frame.visibility import VisibilityPass, draw_list
from .gpu.device import Device
from .gpu.profiler import Profiler
from .gpu_scene.gpu_scene import GpuScene
from .picture import Picture
from .scene.cameras import Camera
from .scene.daylight import sky, sun
from .scene.default_camera import chosen_camera
from .scene.errors import OctoluxError
from .scene.exposure import display_exposure
from .scene.lights import AreaLight, Light, ParticleLights
from .scene.scene import Scene
from .simulator.tonemap import TONE_MAPS, exposure_factor
from .techniques import technique_class
from .techniques.settings import Settings

_DARKEST = 1e-6  # nits: what a black picture is metered as
_LISTS = ("meshes", "instances", "materials", "lights", "cameras")


class Renderer:
    """Renders a scene again and again; what changed in the scene is uploaded before each frame.

    scene: octolux.Scene; replace elements of its lists to change it.
    technique: a name of `octolux techniques`; preset: one of its presets; settings: values of its settings by name,
        such as {"n": 64}, or a whole settings object.
    size: (width, height), pixels.  exposure: EV100, or None for the scene's, or else metered from the first frame.
    anti_aliasing: "off", a number of samples a pixel, "fxaa" (a filter on `display`), or "auto": samples for stills,
        the filter where `sequence` says that frames follow one another.
    tone_map: "neutral", "agx", "aces" or "none".
    transparent: leave the surroundings out of the picture: they light and are reflected, but behind the surfaces is
        black of alpha 0 (radiance is then premultiplied by alpha, as compositors want it).
    default_light: let sun and sky shine where nothing in the scene does.
    device: share one between renderers; profile: time each stage (adds a wait per stage where timestamps are wrong).

    `start`, where set, is what the next picture of a technique that traces paths goes on from.
    `progress`, where set, is told how much of a long frame is done, of how much, and returns whether to go on: what is
    there then is the picture.
    `previous` is the scene of the frame before, from which the layer `motion` is made; it is kept up by `render`.
    Raises OctoluxError for an unknown technique, a bad size or a device that is missing or full.
    """

    def __init__(
        self, scene: Scene, technique: str = "octree-lpv", *, preset: str = "default",
        settings: Settings | dict[str, Any] | None = None, size: tuple[int, int] = (1280, 720),
        exposure: float | None = None, anti_aliasing: str | int = "off", sequence: bool = False,
        tone_map: str = "neutral", transparent: bool = False,
        default_light: bool = True, device: Device | None = None, profile: bool = False,
        frame_settings: FrameSettings | None = None,
    ):  # fmt: skip
        chosen = technique_class(technique)
        self.scene, self.exposure = scene, exposure if exposure is not None else scene.exposure
        _check_exposure(self.exposure)
        _check_tone_map(tone_map)
        self.samples, self._filtered = samples_of(anti_aliasing, sequence)
        if chosen.replaces_direct:  # it takes its own samples of a pixel
            self.samples, self._filtered = 1, False
        self.progress: Callable[[int, int], bool] | None = None
        self.start: TracedPaths | None = None
        self.default_light = default_light
        self.previous: Scene | None = None
        self._by_hand: Camera | None = None  # the camera of the frame before, where it was none of the scene's
        base = frame_settings or FrameSettings()
        self.frame_settings = replace(base, width=size[0], height=size[1])
        self.device = device or Device()
        with self.device.guard():
            self.profiler = Profiler(self.device, None if profile else "off")
            self.gpu_scene = GpuScene(self.device)
            self.targets = Targets(self.device, *size)
            self._buffers = FrameBuffers(self.device)
            self._surroundings = SurroundingsMap(self.device)
            self._direct = DirectLightPass(self.device)
            self._composite = CompositePass(self.device, tone_map, transparent)
            self._fxaa = FxaaPass(self.device) if self._filtered else None
            if not isinstance(settings, Settings):
                settings = chosen.settings_class.make(preset, **(settings or {}))
            self.technique = chosen(self.device, settings)
        self._failed = False  # the last frame: what is kept of it may never have been made
        self._passes_of = -1
        self._rsm: RSMPass | None = None  # made when a technique needs it
        self._peeling: PeelingPass | None = None  # made when a technique asks for further layers
        self._fog: FogPass | None = None  # made when a scene has a medium
        self._emitters_of: tuple = ()
        self._emitting: list[EmitterLight] = []

    @property
    def warnings(self) -> list[str]:
        """What the scene lacks for a picture, and what stands in for it."""
        notes = []
        if self.default_light and not shines(self.scene):
            notes.append("nothing in the scene shines: the sun and the sky of a clear day light it")
        if not self.scene.triangle_count:
            notes.append("the scene holds no triangles: only its surroundings are seen")
        particles = sum(len(light.positions) for light in self.scene.lights if isinstance(light, ParticleLights))
        if particles and "particles" not in self.technique.supports:
            notes.append(f"{particles:,} particle lights are left out: {self.technique.name} takes none")
        return notes + self._medium_notes()

    def _medium_notes(self) -> list[str]:
        medium = self.scene.medium
        if medium is None:
            return []
        if self.technique.replaces_direct:
            return [f"the technique {self.technique.name} knows no media: it renders clear air"]
        low, high = self.scene.bounds()
        if medium.low is None and not (low < high).all():
            return ["the medium fills the scene's box, which holds nothing: give it 'low' and 'high'"]
        return []

    def render(self, camera: str | int | Camera | None = None) -> Picture:
        """One frame, seen by `camera` (a name, a number, a Camera, or None for the first), as a Picture.

        Everything is lit from scratch. Raises OctoluxError for an unknown camera or a device that failed.
        """
        if self.exposure is None:
            self.meter(camera)
        with self.device.guard():
            frame = self._drawn(self._begin(camera, self.samples, self.profiler))
            picture = Picture(self.device, frame, self.exposure, self._composite.tone_map, self._before(camera))
        self.start = None
        lists: dict[str, Any] = {name: list(getattr(self.scene, name)) for name in _LISTS}
        self.previous = replace(self.scene, **lists)
        self._by_hand = camera if isinstance(camera, Camera) else None
        return picture

    def meter(self, camera: str | int | Camera | None = None) -> float:
        """Set the exposure from the mean luminance of what `camera` sees, for all frames that follow; returns EV100."""
        off = Profiler(self.device, "off")  # a frame that is not shown is none of those timed
        with self.device.guard():
            frame = self._drawn(self._begin(camera, 1, off, metering=True))
            luminance = Picture(self.device, frame, 0.0).mean_luminance()
        self.exposure = display_exposure(max(luminance, _DARKEST))
        return self.exposure

    def forget(self) -> None:
        """Let the next frame draw shadow maps and RSMs anew, though all that they show be as before: to time a frame as
        if its lights had moved."""
        if self._passes_of >= 0:
            self._shadow_maps.forget()

    def _drawn(self, frame: Frame) -> Frame:
        if self._failed:
            self.technique = type(self.technique)(self.device, self.technique.settings)
            self.forget()
        self._failed = True
        with frame.profiler.frame():
            self._draw(frame)
        self._failed = False
        return frame

    def _draw(self, frame: Frame) -> None:
        view = frame.views[0]
        for sample in range(frame.samples):
            frame.sample = sample
            frame.views[0] = sample_view(view, sample, frame.samples)
            frame.profiler.submit()
            self._buffers.aim(frame.views[0], sample, frame.samples)
            self._gbuffer.run(frame)
            if sample == 0:
                self._light(frame)
            if not self.technique.replaces_direct:
                self._direct.run(frame, self._shadow_maps.sampler, self._surroundings)
            self.technique.shade(frame)
            if self._fog and frame.medium:
                self._fog.run(frame)
            self._composite.run(frame, self._exposure_factor(), self._surroundings)
        if self._fxaa:
            self._fxaa.run(frame)

    def _light(self, frame: Frame) -> None:
        """What all samples of a frame share: shadow maps and the technique's light cache."""
        technique = self.technique
        technique.prepare(frame)
        if not technique.replaces_direct:
            self._shadow_maps.run(frame, ids="rsm" in technique.needs)
        if "rsm" in technique.needs:
            if self._rsm is None:
                with_surfaces = "surfaces" in technique.needs
                self._rsm = RSMPass(self.device, self.gpu_scene, self.frame_settings, with_surfaces)
            self._rsm.run(frame, self._shadow_maps)
        self._peel(frame)
        technique.update(frame)

    def _peel(self, frame: Frame) -> None:
        layers = self.technique.lamp_layers, self.technique.camera_layers
        if self._rsm is None or max(layers) == 1:
            self._peeling = None  # with its textures
            return
        self._peeling = self._peeling or PeelingPass(self.device, self.gpu_scene, self._gbuffer.visibility)
        self._peeling.run(frame, self._shadow_maps, self._rsm, *layers)

    def _begin(
        self, wanted: str | int | Camera | None, samples: int, profiler: Profiler, metering: bool = False
    ) -> Frame:
        settings, gpu_scene = self.frame_settings, self.gpu_scene
        scene = self._lit(self.scene)
        gpu_scene.sync(scene, settings.normal_maps)
        self._surroundings.sync(scene.environment)
        if self._passes_of != gpu_scene.version:
            visibility = VisibilityPass(self.device, gpu_scene)
            self._gbuffer = GBufferPass(self.device, gpu_scene, visibility)
            self._shadow_maps = ShadowMapPass(self.device, visibility)
            self._rsm = self._peeling = None
            self._passes_of = gpu_scene.version
        soft: list[Light] = []
        if self.technique.soft_light and not self.technique.replaces_direct:
            soft = [*self._emitters(scene), *self._surroundings.lights(settings.sky_lights)]
        resolutions = (settings.shadow_resolution, settings.coarse_resolution)
        lights = light_set([*scene.lights, *soft], gpu_scene.bounds, *resolutions, settings.inverse_square)
        views = [self._view(self._camera(wanted, scene)), *lights.views]
        drawn = [] if self.technique.replaces_direct else lights.views  # rays need no shadow maps
        draws = draw_list(gpu_scene, [views[0].widened(), *drawn], glow_free=lights.emitter_views)
        buffers = self._buffers.upload(lights, views, draws)
        return Frame(
            self.device, profiler, scene, gpu_scene, settings, self.targets, lights, views, draws, buffers,
            samples=samples, exposure_factor=self._exposure_factor(), metering=metering, progress=self.progress,
            transparent=self._composite.transparent, sky_shines=not self.technique.gathers_sky,
            start=self.start, surroundings_map=self._surroundings, medium=self._medium(scene),
        )  # fmt: skip

    def _medium(self, scene: Scene) -> MediumBuffers | None:
        if scene.medium is None or self.technique.replaces_direct:
            return None
        if self._fog is None:
            self._fog = FogPass(self.device)
        self._fog.medium.sync(scene.medium, self.gpu_scene.bounds)
        return self._fog.medium

    def _view(self, camera: Camera) -> View:
        low, high = self.gpu_scene.bounds
        reach = float(np.linalg.norm(np.maximum(np.abs(low - camera.position), np.abs(high - camera.position))))
        return camera_view(camera, *self.targets.size, reach)

    def _before(self, wanted: str | int | Camera | None) -> tuple[View, Scene] | None:
        if self.previous is None:
            return None
        seen_by = self._by_hand if self._by_hand and isinstance(wanted, Camera) else wanted
        return self._view(self._camera(seen_by, self.previous)), self.previous

    def _emitters(self, scene: Scene) -> list[EmitterLight]:
        """Worked out again when something that may glow has changed."""
        area_lights = [light for light in scene.lights if isinstance(light, AreaLight)]
        key = (self.gpu_scene.moves, tuple(area_lights))
        if self._emitters_of != key:
            self._emitters_of, self._emitting = key, emitter_lights(scene, self.frame_settings.emitter_lights)
        return self._emitting

    def _lit(self, scene: Scene) -> Scene:
        if not self.default_light or shines(scene):
            return scene
        return replace(scene, lights=[*scene.lights, sun()], environment=sky())

    def _camera(self, wanted: str | int | Camera | None, scene: Scene) -> Camera:
        return chosen_camera(scene, wanted, self.targets.size[0] / self.targets.size[1])

    def _exposure_factor(self) -> float:
        return float(exposure_factor(self.exposure if self.exposure is not None else 0.0))

    def statistics(self) -> dict[str, Any]:
        """What `--stats` writes: adapter, technique, settings, size, times, pools and memory."""
        return {
            "adapter": self.device.adapter_name,
            "technique": self.technique.name,
            "settings": self.technique.settings.as_dict(),
            "frame_settings": dict(vars(self.frame_settings)),
            "size": list(self.targets.size),
            "samples": self.samples,
            "frames": self.profiler.frames,
            "frame_ms": self.profiler.frame_ms(),
            "stages": self.profiler.stages(),
            "timing": self.profiler.mode,
            "timing_note": self.profiler.note,
            "pools": self.technique.pools(),
            "memory_bytes": {"total": self.device.memory.total, **self.device.memory.by_label()},
        }


def shines(scene: Scene) -> bool:
    """Whether anything in the scene gives light."""
    used = {scene.meshes[i.mesh].material for i in scene.instances}
    glowing = any(max(scene.materials[n].emissive) > 0 or scene.materials[n].unlit for n in used)
    return bool(scene.lights) or glowing or not scene.environment.is_black


def _check_tone_map(tone_map: str) -> None:
    if tone_map not in TONE_MAPS:
        raise OctoluxError(f"There is no tone map '{tone_map}'. There are: {', '.join(TONE_MAPS)}.")


def _check_exposure(exposure: float | None) -> None:
    """An exposure beyond 2^64 either way is a slip, and would leave float32's range."""
    if exposure is not None and not abs(exposure) <= 64:
        raise OctoluxError(f"The exposure is EV100, from about -6 (starlight) to 16 (snow in the sun), not {exposure}.")
