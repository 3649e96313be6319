"""Pictures of one view by many techniques, all with the same light, size and exposure."""

from __future__ import annotations

import dataclasses
import gc
import time
from collections.abc import Callable
from dataclasses import dataclass
from math import pi
from typing import Any

import numpy as np

from ..frame.settings import FrameSettings
from ..gpu.device import Device
from ..picture import Picture
from ..renderer import Renderer
from ..scene.errors import OctoluxError
from ..scene.scene import Scene
from ..simulator.tonemap import signal
from ..techniques.baselines import ConstantSettings
from ..techniques.settings import Settings
from .choices import Choice
from .metrics import lit_level
from .reference import Reference, of_halves

LAYERS = {"final": "radiance", "indirect": "indirect", "direct": "direct"}
"""What the report calls a layer, and what a Picture does."""


_SAY_EVERY = 10.0  # seconds


@dataclass(frozen=True)
class Rendering:
    """A technique's pictures (height, width, 3), nits, by the names of LAYERS; mask bool (height, width); albedo and
    position (height, width, 3); specular, the part of `indirect` that is not diffuse, likewise; statistics as
    Renderer.statistics, with `technique_bytes`."""

    pictures: dict[str, np.ndarray]
    mask: np.ndarray
    albedo: np.ndarray
    position: np.ndarray
    specular: np.ndarray
    statistics: dict[str, Any]


@dataclass
class Studio:
    """Renders `scene` from `camera` at `size` (width, height). exposure: EV100, metered where it is None.

    frames: how many are timed, after one that builds the shaders.  progress: is told how far a long frame is.
    """

    scene: Scene
    device: Device
    size: tuple[int, int]
    camera: str | int | None = None
    exposure: float | None = None
    tone_map: str = "neutral"
    default_light: bool = True
    frame_settings: FrameSettings | None = None
    frames: int = 5
    progress: Callable[[str], None] = lambda text: None

    def renderer(self, choice: Choice) -> Renderer:
        gc.collect()  # what the technique before held on the device is not this one's
        return Renderer(
            self.scene, choice.technique, settings=choice.settings, size=self.size, exposure=self.exposure,
            tone_map=self.tone_map, default_light=self.default_light, device=self.device, profile=True,
            frame_settings=self.frame_settings,
        )  # fmt: skip

    def settle_exposure(self, choice: Choice) -> None:
        """Without an exposure asked for, take the scene's, or else meter as `octolux render` does with a technique."""
        if self.exposure is None:
            self.exposure = self.scene.exposure
        if self.exposure is None:
            self.exposure = self.renderer(choice).meter(self.camera)

    def direct_light(self) -> tuple[Rendering, float | None]:
        """The picture without indirect light, and metrics.lit_level of this view and of all the scene's cameras."""
        one = black()
        renderer = self.renderer(one)
        rendering = self._render(one, renderer)
        others = [renderer.render(number) for number in range(len(self.scene.cameras))]
        views = [(rendering.pictures["direct"], rendering.mask), *((v.layers["direct"], v.mask) for v in others)]
        return rendering, lit_level(views)

    def render(self, choice: Choice) -> Rendering:
        """The technique's picture and times. What draws samples is rendered once, and its time is that of one frame
        with its shaders built; all else again and again, with shadow maps and RSMs drawn anew as if lights had moved.
        Raises OctoluxError where a picture is not finite."""
        return self._render(choice, self.renderer(choice))

    def _render(self, choice: Choice, renderer: Renderer) -> Rendering:
        renderer.progress = _Pace(choice.label, self.progress)
        picture = renderer.render(self.camera)
        if not choice.seeded:
            renderer.profiler.clear()
            for _ in range(self.frames):
                renderer.forget()
                picture = renderer.render(self.camera)
        statistics = renderer.statistics() | {"technique_bytes": sum(renderer.technique.memory().values())}
        rendering = _rendering(picture, statistics)
        for layer, pixels in rendering.pictures.items():
            bad = int(np.count_nonzero(~np.isfinite(pixels).all(axis=-1)))
            if bad:
                raise OctoluxError(f"{choice.label}: {bad} pixels of '{layer}' are not finite. Please report it.")
        return rendering

    def reference(self, choice: Choice, samples: int | None = None) -> Reference:
        """A technique as the reference. One with seeds is rendered with two of them at half of the samples each.

        samples: a pixel, of both together; None for those of its settings. Raises OctoluxError.
        """
        parts = _halves(choice, samples)
        renderings = [self.render(part) for part in parts]
        first = renderings[0]
        facts = {"technique": choice.technique, "settings": [part.settings.as_dict() for part in parts],
                 **_times([r.statistics for r in renderings])}  # fmt: skip
        found = of_halves(choice.label, [r.pictures for r in renderings], first.mask, facts)
        return dataclasses.replace(found, position=first.position)

    def displayed(self, radiance: np.ndarray) -> np.ndarray:
        """The sRGB signal float64 (height, width, 3) in [0, 1] of radiance in nits."""
        return signal(radiance, self.exposure or 0.0, self.tone_map)


class _Pace:
    """Says at most every ten seconds how much of a long frame is done."""

    def __init__(self, label: str, say: Callable[[str], None]):
        self._label, self._say = label, say
        self._start = self._said = time.monotonic()

    def __call__(self, done: int, total: int) -> bool:
        """Whether to go on: always."""
        now = time.monotonic()
        if now - self._said >= _SAY_EVERY:
            self._said = now
            left = (now - self._start) / done * (total - done)
            self._say(f"{self._label}: {done} of {total} samples, {left:.0f} s left")
        return True


def black() -> Choice:
    """No indirect light."""
    return Choice("none", Settings(), "black")


def fitted_constant(reference: Reference, albedo: np.ndarray, mask: np.ndarray) -> Choice:
    """One irradiance (RGB) everywhere, with the mean indirect light of the reference where `mask` is set.

    It is reflected as albedo / pi * E, so E = pi * mean(indirect) / mean(albedo), for each channel; 0 where no surface
    reflects the channel.
    """
    wanted = reference.pictures["indirect"][mask].mean(axis=0, dtype=np.float64)
    reflected = albedo[mask].mean(axis=0, dtype=np.float64)
    irradiance = np.divide(pi * wanted, reflected, out=np.zeros(3), where=reflected > 0.0)
    red, green, blue = np.maximum(irradiance, 0.0).tolist()
    return Choice("constant", ConstantSettings(red, green, blue), "constant")


def _rendering(picture: Picture, statistics: dict[str, Any]) -> Rendering:
    layers = picture.layers
    pictures = {name: np.array(layers[layer]) for name, layer in LAYERS.items()}
    return Rendering(pictures, picture.mask, layers["albedo"], layers["position"], layers["specular"], statistics)


def _halves(choice: Choice, samples: int | None) -> list[Choice]:
    if not choice.seeded:
        if samples is not None:
            raise OctoluxError(f"--reference-samples: {choice.label} draws no samples. Leave the option out.")
        return [choice]
    settings: Any = choice.settings
    half = -(-(samples or settings.samples) // 2)
    changes = ({"seed": settings.seed + k, "samples": half} for k in (0, 1))
    return [dataclasses.replace(choice, settings=dataclasses.replace(settings, **change)) for change in changes]


def _times(statistics: list[dict[str, Any]]) -> dict[str, Any]:
    return {"frame_ms": sum(s["frame_ms"]["median"] for s in statistics)}
