"""`voxel-cones`: cones through a sparse octree of voxels (Drinovsky 2013)."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...frame.frame import Frame
from ...gpu.device import Device
from ...simulator.grid import Grid
from ...simulator.voxels.surfaces import around
from ..debug_views import DebugViews
from ..technique import Technique
from .bounces import Bounces
from .gathering import DiffuseCones, SpecularCones, Voxels
from .injection import Injection
from .reading import Reading
from .settings import VoxelConesSettings, read_box
from .structure import VoxelOctree
from .views import VoxelViews


class VoxelCones(Technique):
    """The octree is built when what is drawn has changed; light is injected each frame, and filtered where it is other
    than before."""

    name, summary = "voxel-cones", "light gathered by cones through an octree of voxels, with occlusion and reflections"
    settings_class = VoxelConesSettings
    label = "voxel"
    needs = frozenset({"rsm"})
    supports = frozenset({"dynamic geometry", "dynamic lights", "diffuse", "glossy", "occlusion"})
    settings: VoxelConesSettings

    def __init__(self, device: Device, settings: VoxelConesSettings):
        super().__init__(device, settings)
        s = settings
        self.octree = VoxelOctree(device, s.depth, s.texture_level)
        self.injection = Injection(device, self.octree)
        self.reading = Reading(device, self.octree.bricks)
        reading = self.reading
        self.voxels = Voxels(s.depth, reading.file, reading.bindings, reading.structs, reading.values, skips=True)
        start: dict[str, Any] = {"offset": s.offset, "cover": s.cover, "sky": s.sky}
        self.gathers_sky = s.sky
        self.diffuse = DiffuseCones(
            device, self.voxels, count=s.cones, per_level=s.samples, width=s.width, resolution=s.resolution, **start
        )
        self.specular = SpecularCones(device, self.voxels, step=s.step, **start) if s.glossy else None
        self.bounces = None
        if s.bounces > 1:
            self.bounces = Bounces(device, self.octree, self.reading, s.bounces - 1, s.bounce_level)
        self._built_of: tuple[int, int] | None = None
        self.frame: Frame | None = None
        """The last one, for debug views."""

    def prepare(self, frame: Frame) -> None:
        self.diffuse.prepare(frame.pixels)
        frame.irradiance = self.diffuse.irradiance
        if self.specular:
            self.specular.prepare(frame.pixels)
            frame.specular = self.specular.specular

    def update(self, frame: Frame) -> None:
        self.frame = frame
        key = (id(frame.gpu_scene), frame.gpu_scene.moves)
        new = self._built_of != key
        if new:
            self.octree.build(frame.profiler, frame.gpu_scene, scene_grid(frame, self.settings))
            self._built_of = key
        with frame.profiler.stage("injection") as stage:
            everything = self.injection.run(stage, frame) or new
        unit = self.injection.unit
        with frame.profiler.stage("filtering") as stage:
            if everything or self.bounces:
                self.octree.filtering.everything(stage, unit)
                stage.encoder.clear_buffer(self.octree.bricks.touched.resource)
            else:
                self.octree.filtering.touched(stage, unit)
        if self.bounces:
            self.bounces.run(frame.profiler, self.injection.fresh.resource, unit)

    def shade(self, frame: Frame) -> None:
        grid, voxels = self.octree.grid, self.reading.resources
        with frame.profiler.stage("diffuse cones") as stage:
            self.diffuse.gather(stage, frame, grid, **voxels)
        with frame.profiler.stage("cone filter") as stage:
            self.diffuse.filter(stage, frame)
        if self.specular:
            with frame.profiler.stage("specular cones") as stage:
                self.specular.run(stage, frame, grid, **voxels)

    def debug_views(self) -> DebugViews:
        """See views.py."""
        return VoxelViews(self).all()


def scene_grid(frame: Frame, settings: VoxelConesSettings) -> Grid:
    """The cube of voxels around what is drawn, or another box."""
    low, high = read_box(settings.box) or frame.world_box
    if not np.any(high > low):  # an empty scene: any box will do
        high = low + 1.0
    return around(low, high, settings.depth)
