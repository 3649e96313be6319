"""What tests of fog share: a medium before a black wall, its lights, and the float64 march along a picture's rays."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from gpu_tools import front_camera, scene_of, small_settings

from octolux.frame.volume_light import VolumeLight
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.scene.builtin.shapes import quad
from octolux.scene.cameras import Camera
from octolux.scene.lights import DirectionalLight, PointLight, SpotLight
from octolux.scene.materials import Material
from octolux.scene.medium import Medium
from octolux.scene.meshes import Instance
from octolux.scene.scene import Scene
from octolux.simulator import fog
from octolux.simulator.camera import pixel_rays
from octolux.techniques.baselines import NoTechnique
from octolux.techniques.settings import Settings

LOW, HIGH = (-4.0, -3.0, -8.0), (4.0, 3.0, 0.0)
BOX = (np.array(LOW), np.array(HIGH))
HAZE = Medium(scattering=(0.05, 0.1, 0.15), absorption=(0.05, 0.0, 0.03), low=LOW, high=HIGH)
SUN = DirectionalLight(direction=(0.0, -1.0, 0.0), illuminance=(9.0, 8.0, 7.0))
LAMP = PointLight(position=(1.0, 0.5, -3.0), intensity=(3.0, 2.0, 1.0))
SPOT = SpotLight(position=(0.0, 2.5, -1.0), direction=(0.0, -1.0, -0.6), intensity=(9.0, 8.0, 7.0), inner_angle=0.3,
                 outer_angle=0.8)  # fmt: skip
SIZE = (48, 32)
EYE = front_camera(2.0)
FLOAT = 1e-5  # rounding of some hundred float32 operations


def wall(z: float = -6.0, half: float = 20.0) -> Scene:
    """A black wall across the view, within the medium."""
    corners = [(-half, -half, z), (half, -half, z), (half, half, z), (-half, half, z)]
    return scene_of([quad(corners)], [Material(base_color=(0, 0, 0), specular=0.0)], cameras=[EYE])


def render(
    device, scene: Scene, medium: Medium | None = HAZE, lights=(), volume=None, size=SIZE, **settings
) -> Picture:
    """A picture of the scene in a medium under lights, of direct light and that of a light volume."""
    scene = replace(scene, medium=medium, lights=list(lights))
    settings = {"shadow_resolution": 256, **settings}
    renderer = Renderer(scene, "none", size=size, exposure=0.0, default_light=False, device=device,
                        frame_settings=small_settings(**settings))  # fmt: skip
    if volume:
        renderer.technique = WithVolume(device, volume)
    return renderer.render()


class WithVolume(NoTechnique):
    """No indirect light on surfaces, but a light volume."""

    def __init__(self, device, volume: VolumeLight):
        super().__init__(device, Settings())
        self.volume = volume

    def update(self, frame) -> None:
        frame.volume_light = self.volume


def even_volume(fluence: float, cell: float = 0.5) -> VolumeLight:
    file = str(Path(__file__).parent / "kernels" / "fog_volume.wgsl")
    return VolumeLight(file, values={"even_fluence": fluence, "even_cell": cell})


def rays(picture, camera: Camera = EYE):
    """Origins, unit directions and lengths of the lines of sight to what the picture sees; infinite where nothing."""
    height, width = picture.radiance.shape[:2]
    origins, directions = pixel_rays(camera, width, height)
    depth = picture.layers["depth"].astype(np.float64)
    along = depth / (directions @ camera.forward)
    return origins, directions, np.where(depth > 0, along, np.inf)


# Where the marched light is compared: not at the picture's rim, where the filter lacks a side.
PLACES = (slice(11, -11, 13), slice(9, -9, 13))


def expected(picture, medium: Medium, fluence, camera: Camera = EYE, steps: int = 1024):
    """Of the pixels at PLACES by the float64 march: radiance and transmittance (rows, columns, 3)."""
    lines = [x[PLACES] for x in rays(picture, camera)]
    shape = (*lines[2].shape, 3)
    found = [
        fog.single_scattering(medium, BOX, o, d, float(r), fluence, steps)
        for o, d, r in zip(lines[0].reshape(-1, 3), lines[1].reshape(-1, 3), lines[2].ravel(), strict=True)
    ]
    return np.array([f for f, _ in found]).reshape(shape), np.array([t for _, t in found]).reshape(shape)


def relative(found, wanted) -> float:
    return float((np.abs(found - wanted) / np.maximum(wanted.max(axis=-1, keepdims=True), 1e-30)).max())


def shaded() -> Scene:
    """The wall, and a black plate above the medium that keeps the sun from everything at x < 0."""
    roof = quad([(-4.5, 3.5, -9), (0, 3.5, -9), (0, 3.5, 1), (-4.5, 3.5, 1)])
    scene = wall()
    return replace(scene, meshes=[*scene.meshes, roof], instances=[*scene.instances, Instance(1)])
