"""The interface of every technique: one way of computing indirect light."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from ..frame.frame import Frame
from ..gpu.device import Device
from .debug_views import DebugViews
from .settings import Settings


class Technique(ABC):
    """Refreshes its light cache (`update`), then shades: sets `frame.irradiance` and `frame.specular`.

    name: for `--technique`.  summary: one line for people.
    needs: shared things it reads: "rsm", and with it "surfaces", the traits of the VPLs' surfaces.
    supports: what it handles ("dynamic geometry", "dynamic lights", "glossy", ...).
    replaces_direct: it makes the whole picture, with direct light and what is seen of the surroundings.
    soft_light: whether emitters and the sky shine directly, past their shadow maps; False where the technique's light
    cache brings their light.
    lamp_layers, camera_layers: of what lamps and the camera see, one behind the other, how many it takes surfels from.
    gathers_sky: whether it brings the sky's direct light too; lights that stand for it are then there for RSMs only.
    label: what the labels of its resources begin with; "" where it has none.
    """

    name: ClassVar[str]
    summary: ClassVar[str]
    settings_class: ClassVar[type[Settings]]
    needs: ClassVar[frozenset[str]] = frozenset()
    supports: ClassVar[frozenset[str]] = frozenset()
    replaces_direct: ClassVar[bool] = False
    label: ClassVar[str] = ""

    soft_light: bool = True
    gathers_sky: bool = False
    lamp_layers: int = 1
    camera_layers: int = 1

    def __init__(self, device: Device, settings: Settings):
        self.device, self.settings = device, settings

    @abstractmethod
    def prepare(self, frame: Frame) -> None:
        """Allocate for this scene and size; does nothing when all is there."""

    @abstractmethod
    def update(self, frame: Frame) -> None:
        """Refresh the light cache from this frame's lights and scene."""

    @abstractmethod
    def shade(self, frame: Frame) -> None:
        """Write irradiance before albedo (rgba32float, ambient visibility in alpha) for what the camera sees."""

    def debug_views(self) -> DebugViews:
        """What the cache holds after a frame, by name; the names are known before one."""
        return DebugViews({})

    def pools(self) -> dict[str, dict[str, int]]:
        """How full is what grows with the scene, by name: how many elements are `used`, for how many there is `room`
        now, and the `most` that there can be. Nothing where the scene has no part in it."""
        return {}

    def memory(self) -> dict[str, int]:
        """Bytes by resource that techniques of this kind hold on the device: those labelled with `label`."""
        return {k: v for k, v in self.device.memory.by_label().items() if self.label and k.startswith(self.label)}
