"""A technique for figures: the uniform volume, but its light is given and not injected from lights."""

from __future__ import annotations

import numpy as np

from octolux.frame.frame import Frame
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.cameras import Camera
from octolux.scene.materials import Material
from octolux.scene.meshes import Instance, Mesh
from octolux.scene.scene import Scene
from octolux.simulator.grid import Grid
from octolux.techniques.lpv.constants import pack_grid
from octolux.techniques.lpv.uniform.settings import UniformLpvSettings
from octolux.techniques.lpv.uniform.technique import UniformLpv

from .lab import device


class GivenLight(UniformLpv):
    """light: [z][y][x][rgb][4], W/sr, in the cells of `volume`, propagated and read as the settings say."""

    needs = frozenset()

    def __init__(self, settings: UniformLpvSettings, light: np.ndarray, volume: Grid):
        super().__init__(device(), settings)
        self._given, self._volume = light.astype(np.float32), volume

    def prepare(self, frame: Frame) -> None:
        super().prepare(frame)
        self.grid = self._volume
        self.device.write(self._grid_buffer, pack_grid(self._volume))

    def update(self, frame: Frame) -> None:
        self.device.write(self.injection.injected, self._given)
        self.device.write(self.injection.peak, self._given[..., 0].max(keepdims=True))
        with frame.profiler.stage("propagation") as stage:
            self.propagation.run(stage, self.injection.injected, self.injection.peak, self.settings.iterations)
            self.lookup.write_volumes(stage, self.propagation.light)


def seen_in(
    mesh: Mesh, camera: Camera, size: tuple[int, int], settings: UniformLpvSettings, light: np.ndarray, volume: Grid
) -> Picture:
    """A picture of `mesh` in the given light."""
    scene = Scene(meshes=[mesh], instances=[Instance(0)], materials=[Material(specular=0.0, double_sided=True)],
                  cameras=[camera], exposure=0.0)  # fmt: skip
    renderer = Renderer(scene, "none", size=size, device=device())
    renderer.technique = GivenLight(settings, light, volume)
    return renderer.render()
