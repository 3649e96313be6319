"""Small frames of voxel-cones for figures: scenes of squares, and what the technique keeps of the frame."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from octolux.compare.choices import choice
from octolux.frame.frame import Frame, FrameSettings
from octolux.gpu.device import Device
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene
from octolux.techniques.voxel_cones.cones.diffuse import DiffuseCones
from octolux.techniques.voxel_cones.cones.sharing import USUAL_SIZE, sharing
from octolux.techniques.voxel_cones.settings import VoxelConesSettings
from octolux.techniques.voxel_cones.technique import VoxelCones

from . import from_tests  # noqa: F401
from .lab import submitted

import voxel_tools  # isort: skip

PRESETS = ("default", *VoxelConesSettings.PRESETS)
SIZE = (32, 24)
DEPTH = 6
MAPS = FrameSettings(shadow_resolution=64, rsm_resolution=32, sky_lights=0, emitter_lights=0)
"""No light but the scene's."""


@dataclass(eq=False)
class Watched:
    """A picture, and the technique that made it, which keeps the frame that its passes read."""

    picture: Picture
    technique: VoxelCones

    def shine(self, light: Callable[[np.ndarray], np.ndarray]) -> None:
        """Let voxels of level 0 send this, in the place of what lamps bring: of [z][y][x][6], what faces each way, the
        radiance times that, nits at most 1."""
        octree = self.technique.octree
        sent = light(voxel_tools.read(octree).facing)
        voxel_tools.shine(octree, sent[..., None] * np.ones(3), unit=1.0)

    def irradiance(self, sky: bool = False) -> np.ndarray:
        """What the technique's diffuse cones gather in voxels now, (height, width, 3); `sky`: what is left sees it."""
        technique, s = self.technique, self.technique.settings
        cones = DiffuseCones(
            technique.device, technique.voxels, replace(technique.wide, screen=0.0),
            resolution=technique.diffuse.resolution, offset=s.offset, cover=s.cover, sky=sky,
        )  # fmt: skip
        frame = self._frame()
        cones.prepare(frame.pixels)
        with submitted() as stage:
            cones.gather(stage, frame, technique.octree.grid, **technique.reading.resources)
            cones.filter(stage, frame)
        return technique.device.read_texture(cones.irradiance, np.float32, 4)[..., :3]

    def specular(self) -> np.ndarray:
        """What its specular cones reflect now, (height, width, 3)."""
        technique = self.technique
        assert technique.specular
        with submitted() as stage:
            technique.specular.run(stage, self._frame(), technique.octree.grid, **technique.reading.resources)
        return technique.device.read_texture(technique.specular.specular, np.float32, 4)[..., :3]

    def _frame(self) -> Frame:
        assert self.technique.frame
        return self.technique.frame


def watched(
    device: Device, scene: Scene, camera: Camera | str, words: str = "default", size: tuple[int, int] = SIZE
) -> Watched:
    """One frame. words: preset and changed settings, PRESET[,KEY=VALUE...]; DEPTH and one bounce unless they say it.
    Pixels share cones as they do at 1280x720."""
    preset, _, changes = words.partition(",")
    one = choice(f"voxel-cones:{preset},depth={DEPTH},bounces=1{',' + changes if changes else ''}")
    assert isinstance(one.settings, VoxelConesSettings)
    shared = sharing(one.settings.resolution, one.settings.tile, USUAL_SIZE)
    settings = replace(one.settings, resolution=shared.resolution, tile=shared.tile)
    renderer = Renderer(
        scene, one.technique, settings=settings, size=size, device=device,
        exposure=0.0, default_light=False, frame_settings=MAPS,
    )  # fmt: skip
    picture = renderer.render(camera)
    assert isinstance(renderer.technique, VoxelCones)
    return Watched(picture, renderer.technique)


def scene_of(meshes: Sequence[Mesh], materials: Sequence[Material], **rest: Any) -> Scene:
    """Each mesh once, where it was made."""
    instances = [Instance(i) for i in range(len(meshes))]
    return Scene(meshes=list(meshes), instances=instances, materials=list(materials), exposure=0.0, **rest)


def level(y: float, half: float, up: bool, material: int = 0) -> Mesh:
    """A square at height y around the axis, of 2 `half` metres, that looks up or down."""
    corners = [(-half, y, half), (half, y, half), (half, y, -half), (-half, y, -half)]
    return quad(corners if up else corners[::-1], material=material)


def from_above(height: float, across: float) -> Camera:
    """Looks down at the origin, `across` metres of it."""
    place = np.eye(4)
    place[:3, :3] = np.array([(1, 0, 0), (0, 0, -1), (0, 1, 0)], dtype=float).T
    place[:3, 3] = (0.0, height, 0.0)
    return Camera(transform=place, orthographic_height=across)
