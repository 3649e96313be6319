"""What culling by face saves: the six faces of a point light against one face that draws everything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from octolux.frame.frame import Frame, FrameBuffers, FrameSettings, Targets
from octolux.frame.lights import light_set
from octolux.frame.shadows import ShadowMapPass
from octolux.frame.views import camera_view
from octolux.frame.visibility import VisibilityPass, draw_list
from octolux.gpu.profiler import Profiler
from octolux.gpu_scene.gpu_scene import GpuScene
from octolux.scene.lights import DirectionalLight, Light, PointLight
from octolux.scene.scene import Scene

from .lab import device, interleaved
from .registry import at_most, figure
from .scenes_on_disk import load

RESOLUTION, PAIRS = 512, 25
_WHITE = (1.0, 1.0, 1.0)


@dataclass
class ShadowWork:
    """Everything needed to draw the shadow maps of one light, again and again."""

    scene: Scene
    gpu_scene: GpuScene
    light: Light
    cull: bool

    def __post_init__(self) -> None:
        self.settings = FrameSettings(8, 8, RESOLUTION, RESOLUTION)
        self.targets, self.buffers = Targets(device(), 8, 8), FrameBuffers(device())
        self.profiler = Profiler(device(), "off")
        self.maps = ShadowMapPass(device(), VisibilityPass(device(), self.gpu_scene))

    def draw(self) -> None:
        """Decide what each face sees, record, submit and wait; with triangle numbers, as RSMs need them."""
        lights = light_set([self.light], self.gpu_scene.bounds, RESOLUTION)
        views = [camera_view(self.scene.cameras[0], 8, 8, 100.0), *lights.views]
        draws = draw_list(self.gpu_scene, views, self.cull)
        frame = Frame(
            device(), self.profiler, self.scene, self.gpu_scene, self.settings, self.targets, lights, views, draws,
            self.buffers.upload(lights, views, draws),
        )  # fmt: skip
        self.maps.forget()
        with self.profiler.frame():
            self.maps.run(frame, ids=True)


def shadow_works(scene: Scene) -> tuple[Callable[[], None], Callable[[], None]]:
    """Six culled faces of a point light in the middle of `scene`; one face that holds and draws all of it."""
    gpu_scene = GpuScene(device())
    gpu_scene.sync(scene)
    middle = tuple(float(v) for v in np.mean(gpu_scene.bounds, axis=0))
    point = PointLight(position=middle, intensity=_WHITE)
    sun = DirectionalLight(direction=(0.3, -1.0, 0.2), illuminance=_WHITE)
    return ShadowWork(scene, gpu_scene, point, True).draw, ShadowWork(scene, gpu_scene, sun, False).draw


@figure("shadow_faces", group="ratios", unit={"ratio": "x", "six_faces_ms": "ms", "one_face_ms": "ms"},
        bound={"ratio": at_most(2.5)})  # fmt: skip
def shadow_faces() -> dict[str, float]:
    """Six 512^2 faces of a point light in the middle of Crytek Sponza, over one face that draws everything."""
    times = interleaved(*shadow_works(load("crytek_sponza")), PAIRS)
    return {"ratio": times["ratio"], "six_faces_ms": times["first"], "one_face_ms": times["second"]}
