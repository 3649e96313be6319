"""Frame: one picture being made. Passes and techniques read from it what others have written."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import wgpu

from ..gpu.device import Device
from ..gpu.profiler import Profiler
from ..gpu_scene.gpu_scene import GpuScene
from ..scene.environment import Environment
from ..scene.scene import Scene
from .lights import LightSet
from .settings import FrameSettings
from .structs import LIGHT, MAX_LIGHTS, MAX_VIEWS, RASTER_VIEW, RASTER_VIEW_STRIDE, VIEW
from .views import View
from .visibility import DrawList
from .volume_light import VolumeLight

if TYPE_CHECKING:
    from .peeling import LampLayer

TEXTURE, STORAGE = wgpu.TextureUsage.TEXTURE_BINDING, wgpu.TextureUsage.STORAGE_BINDING
RENDER, COPY = wgpu.TextureUsage.RENDER_ATTACHMENT, wgpu.TextureUsage.COPY_SRC


class CameraSees:
    """A layer of what the camera sees: triangle numbers, their raster depth, G-buffer and depth along the axis."""

    def __init__(self, device: Device, width: int, height: int, prefix: str = ""):
        self.size = (width, height)

        def make(label: str, format: str, usage: int) -> Any:
            return device.texture(prefix + label, self.size, format, usage=usage | TEXTURE | COPY)

        self.ids = make("visibility", "r32uint", RENDER)
        self.raster_depth = make("raster depth", "depth32float", RENDER)
        self.surface = make("G-buffer", "rgba32uint", STORAGE)
        self.depth = make("depth", "r32float", STORAGE)


class Targets(CameraSees):
    """The pictures that the shared passes write, of one size."""

    def __init__(self, device: Device, width: int, height: int):
        super().__init__(device, width, height)
        self.direct = self._more(device, "direct light")
        self.radiance = self._more(device, "radiance")
        self.display = self._more(device, "display", "rgba8unorm")
        self.emissive: Any = None
        self.direct_diffuse: Any = None
        self._other_radiance: Any = None

    def need_emissive(self, device: Device) -> None:
        self.emissive = self.emissive or self._more(device, "emissive")

    def need_direct_diffuse(self, device: Device) -> None:
        """Have the pass of direct light write what of it the diffuse lobe reflects."""
        self.direct_diffuse = self.direct_diffuse or self._more(device, "direct light")

    def _more(self, device: Device, label: str, format: str = "rgba32float") -> Any:
        return device.texture(label, self.size, format, usage=STORAGE | TEXTURE | COPY)

    def display_like(self, device: Device) -> Any:
        """Another texture as `display` is."""
        return self._more(device, "display", "rgba8unorm")

    def swap_radiance(self, device: Device) -> Any:
        """Put another texture in the place of `radiance`, and return what was there: no pass can read and write one."""
        other = self._other_radiance or self._more(device, "radiance")
        self.radiance, self._other_radiance = other, self.radiance
        return self._other_radiance


@dataclass(frozen=True, eq=False)
class TracedPaths:
    """Means over `count` paths a pixel, to go on from: float32 (height, width, 3) radiance, direct and indirect, nits;
    (height, width, 1) alpha, and the standard error of the pixel's luminance."""

    count: int
    radiance: np.ndarray
    alpha: np.ndarray
    direct: np.ndarray
    indirect: np.ndarray
    noise: np.ndarray


@dataclass(eq=False)
class Frame:
    """Everything one picture needs. `views` are the camera's and then one for each shadow map.

    shadow_maps, coarse_maps: depth arrays.  vpls: texture of VPL (gpu/records.py), set when the technique needs
    RSMs: each light's [layer][row][column], of which vpl_ranges says first and number, and vpl_widths the length of
    a row.  vpl_surfaces: texture of words (gpu/records.py), the traits of the VPLs' surfaces (traits.py), set when it
    needs "surfaces".
    lamp_layers, camera_layers: what lies behind that, layer by layer (peeling.py), as many as the technique asks for.
    irradiance: rgba32float texture a technique writes: irradiance before albedo, and ambient visibility in alpha;
    specular: radiance already weighted by the BRDF. None is black.
    radiance: rgba32float texture of a technique that makes the whole picture: radiance, and coverage in alpha;
    `indirect` is then its part of it, and the targets' direct light is the technique's; paths: how many of each pixel
    are in it, if it has noise: the direct light's alpha is then the standard error of the pixel's luminance.
    medium: what shaders/medium.wgsl reads, None for clear air.  volume_light: what a technique knows of the light in
    space, or None.  inscattered, transmittance: rgba32float textures of fog, None where there is none.
    sample, samples: which of the samples of each pixel is being made, and of how many.
    exposure_factor: from nits to the picture's unit.  metering: the frame is only made to set the exposure.
    transparent: the surroundings are not to be seen.  sky_shines: they shine directly, past their shadow maps.
    start: paths of an earlier run that the picture goes on from.
    progress: told how much of a long frame is done, of how much; it returns whether to go on.
    """

    device: Device
    profiler: Profiler
    scene: Scene
    gpu_scene: GpuScene
    settings: FrameSettings
    targets: Targets
    lights: LightSet
    views: list[View]
    draws: DrawList
    buffers: dict[str, Any]
    shadow_maps: Any = None
    coarse_maps: Any = None
    vpls: Any = None
    vpl_surfaces: Any = None
    vpl_ranges: list[tuple[int, int]] = field(default_factory=list)
    vpl_widths: list[int] = field(default_factory=list)
    lamp_layers: Sequence[LampLayer] = ()
    camera_layers: Sequence[CameraSees] = ()
    irradiance: Any = None
    specular: Any = None
    radiance: Any = None
    indirect: Any = None
    paths: int = 0
    sample: int = 0
    samples: int = 1
    exposure_factor: float = 1.0
    metering: bool = False
    transparent: bool = False
    sky_shines: bool = True
    start: TracedPaths | None = None
    progress: Callable[[int, int], bool] | None = None
    surroundings_map: Any = None
    medium: Any = None
    volume_light: VolumeLight | None = None
    inscattered: Any = None
    transmittance: Any = None

    @property
    def surroundings(self) -> Environment:
        return self.scene.environment

    @property
    def pixels(self) -> tuple[int, int]:
        return self.targets.size

    @property
    def world_box(self) -> tuple[np.ndarray, np.ndarray]:
        return self.gpu_scene.bounds


class FrameBuffers:
    """The small buffers that change every frame: views, lights, and what is drawn."""

    def __init__(self, device: Device):
        self.device = device
        self._kept = {
            "views": device.uniform("views", VIEW.array(MAX_VIEWS)),
            "lights": device.uniform("lights", LIGHT.array(MAX_LIGHTS)),
            "raster_views": device.uniform("raster views", np.zeros(MAX_VIEWS * RASTER_VIEW_STRIDE, np.uint8)),
            "drawn": device.buffer("drawn clusters", size=1 << 16),
        }

    def upload(self, lights: LightSet, views: list[View], draws: DrawList) -> dict[str, Any]:
        """Write this frame's contents; returns the buffers by binding name. `drawn` grows when it must."""
        packed = VIEW.array(len(views))  # filled in place: np.concatenate would drop the struct's padding
        raster = np.zeros((len(views), RASTER_VIEW_STRIDE // 4), np.float32)
        for i, (view, owner) in enumerate(zip(views, [0, *lights.light_of_view], strict=True)):
            packed[i] = view.pack(owner)[0]
            raster[i, :16] = packed[i]["view_projection"].ravel()
        if self._kept["drawn"].size < draws.entries.nbytes:
            self._kept["drawn"] = self.device.buffer("drawn clusters", size=2 * draws.entries.nbytes)
        contents = {"views": packed, "raster_views": raster, "lights": lights.packed, "drawn": draws.entries}
        for name, data in contents.items():
            self.device.write(self._kept[name], data)
        return dict(self._kept)

    def aim(self, view: View, sample: int, samples: int) -> None:
        """Let the camera look along `view` from now on, for sample number `sample` of each pixel."""
        matrix = view.view_projection.T
        packed = RASTER_VIEW.pack(view_projection=matrix, sample=sample, samples=samples)
        self.device.write(self._kept["views"], view.pack())
        self.device.write(self._kept["raster_views"], packed)
