"""`voxel-cones`: cones through a sparse octree of voxels (Drinovsky 2013)."""

from __future__ import annotations

from typing import Any

from ...frame.frame import Frame
from ...gpu.device import Device
from ..debug_views import DebugViews
from ..technique import Technique
from .bricks.reading import Reading
from .cones.diffuse import DiffuseCones
from .cones.gathering import Voxels
from .cones.sharing import Sharing, sharing
from .cones.specular import SpecularCones
from .cones.wide import WideCones
from .light.bounces import Bounces
from .light.injection import Injection
from .light.series import Series
from .settings import VoxelConesSettings, read_box
from .views.views import VoxelViews
from .voxels.parts import Parts
from .voxels.structure import VoxelOctree


class VoxelCones(Technique):
    """The octree of what is static is built once, that of what moves whenever it does (parts.py); light is injected
    when lights or what is drawn have changed, and filtered where it is other than before."""

    name, summary = "voxel-cones", "light gathered by cones through an octree of voxels, with occlusion and reflections"
    settings_class = VoxelConesSettings
    label = "voxel"
    needs = frozenset({"rsm"})
    supports = frozenset({"dynamic geometry", "dynamic lights", "diffuse", "glossy", "occlusion"})
    settings: VoxelConesSettings
    wide: WideCones
    diffuse: DiffuseCones

    def __init__(self, device: Device, settings: VoxelConesSettings):
        super().__init__(device, settings)
        s = settings
        self.parts = Parts(device, s.depth, s.texture_level, s.representation, s.interior, read_box(s.box))
        self._light_of: tuple[object, ...] | None = None
        self.frame: Frame | None = None
        """The last one, for debug views."""
        self.reading = reading = Reading(device, self.octree.bricks)
        self.voxels = Voxels(s.depth, reading.file, reading.bindings, reading.structs, reading.values, skips=True)
        self._start: dict[str, Any] = {
            "offset": s.offset, "cover": s.cover, "sky": s.sky, "attenuation": s.attenuation,
        }  # fmt: skip
        self.gathers_sky = s.sky
        self._shared: Sharing | None = None
        self.specular: SpecularCones | None = None
        if s.glossy:
            self.specular = SpecularCones(
                device, self.voxels, step=s.step, resolution=s.glossy_resolution, **self._start
            )  # fmt: skip
        self._follow()

    def _share(self, shared: Sharing) -> None:
        """Make diffuse cones that so many pixels share, unless these are they."""
        if shared == self._shared:
            return
        s = self.settings
        self._shared = shared
        self.wide = WideCones(s.cones, s.samples, s.width, shared.tile, shared.among, s.screen, s.bounces)
        self.diffuse = DiffuseCones(
            self.device, self.voxels, self.wide, resolution=shared.resolution, reach=s.ambient_distance, **self._start
        )  # fmt: skip

    def _follow(self) -> None:
        """Passes that write into the octrees that there are."""
        self.forget()
        s, device, octrees = self.settings, self.device, self.parts.octrees
        others = [*octrees[1:], *octrees[:1]] if len(octrees) > 1 else [None]
        self.injections = [Injection(device, one, other) for one, other in zip(octrees, others, strict=True)]
        self.reading.moving = self.parts.moving.bricks if self.parts.moving else None
        self.series, self.bounces = Series(device, octrees), []
        if s.bounces > 1:
            self.bounces = [Bounces(device, octree, self.reading, s.bounce_level, s.attenuation) for octree in octrees]

    @property
    def octree(self) -> VoxelOctree:
        """Of what is static."""
        return self.parts.static

    @property
    def injection(self) -> Injection:
        """Into what is static."""
        return self.injections[0]

    def prepare(self, frame: Frame) -> None:
        if self.parts.prepare(frame.gpu_scene):
            self._follow()
        self._share(sharing(self.settings.resolution, self.settings.tile, frame.pixels, frame.samples))
        self.diffuse.prepare(frame.pixels)
        frame.irradiance = self.diffuse.irradiance
        if self.wide.screen:
            frame.targets.need_direct_diffuse(self.device)
        if self.specular:
            self.specular.prepare(frame.pixels)
            frame.specular = self.specular.specular

    def update(self, frame: Frame) -> None:
        self.frame = frame
        new = self.parts.build(frame.profiler, frame.gpu_scene)
        scene, lights = frame.gpu_scene, frame.lights
        medium = frame.scene.medium  # which dims light on its way to what reflects it
        bring = (lights.packed.tobytes(), lights.total_flux.tobytes(), frame.settings.inverse_square)
        light_of = (id(scene), scene.moves, medium, *bring)
        if not new and light_of == self._light_of:
            for octree in self.parts.octrees:
                octree.filtering.nothing()
            return
        self.forget()  # light that fails half-way is made anew
        with frame.profiler.stage("injection") as stage:
            changed = [injection.run(stage, frame) for injection in self.injections]
        self._filter(frame, everything=new or changed[0] or bool(self.bounces))
        for number in range(self.settings.bounces - 1):
            self._bounce(frame, number)
        self._light_of = light_of

    def forget(self) -> None:
        """Let the next frame make light anew, though neither lights nor the scene be other than before."""
        self._light_of = None

    def _filter(self, frame: Frame, everything: bool) -> None:
        """What is static first: the other borrows its light, and is small."""
        static, *moving = self.parts.octrees
        unit = self.injection.unit
        with frame.profiler.stage("filtering") as stage:
            if everything:
                static.filtering.everything(stage, unit)
            else:
                static.filtering.touched(stage, unit)
            for octree in moving:
                octree.filtering.everything(stage, unit)

    def _bounce(self, frame: Frame, number: int) -> None:
        unit, last = self.injection.unit, number == self.settings.bounces - 2
        with frame.profiler.stage("bounces") as stage:
            received = [bounces.receive(stage, unit, number) for bounces in self.bounces]
            self.series.follow(stage, number, received)
            for bounces, injection in zip(self.bounces, self.injections, strict=True):
                fresh = injection.fresh.resource
                bounces.reflect(stage, fresh, unit, number, self.series, last and self.settings.endless)

    def shade(self, frame: Frame) -> None:
        grid, voxels = self.octree.grid, self.reading.resources
        with frame.profiler.stage("diffuse cones") as stage:
            self.diffuse.gather(stage, frame, grid, **voxels)
        with frame.profiler.stage("cone filter") as stage:
            self.diffuse.filter(stage, frame)
        if self.specular:
            with frame.profiler.stage("specular cones") as stage:
                self.specular.run(stage, frame, grid, **voxels)

    def pools(self) -> dict[str, dict[str, int]]:
        octrees = zip(("static", "moving"), self.parts.octrees, strict=False)
        return {f"{part} {name}": full for part, octree in octrees for name, full in octree.pools().items()}

    def debug_views(self) -> DebugViews:
        """See views.py."""
        return VoxelViews(self).all()
