"""Anti-aliasing: several samples a pixel, or a filter on the finished picture."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from ..gpu.bindings import sampler, storage_texture, texture
from ..gpu.device import Device
from ..gpu.passes import ComputePass
from ..scene.errors import OctoluxError
from .frame import Frame
from .views import View

STILL_SAMPLES = 8
MAX_SAMPLES = 1024

# The golden ratio, of which multiples are spread most evenly (a Fibonacci lattice where the number of samples is one).
_GOLDEN = 0.6180339887498949


def samples_of(anti_aliasing: str | int, sequence: bool) -> tuple[int, bool]:
    """Samples a pixel, and whether FXAA follows, of "off", "fxaa", "auto" or a number.

    "auto" takes samples for stills and FXAA for sequences. Raises OctoluxError for anything else.
    """
    text = str(anti_aliasing)
    if text == "auto":
        text = "fxaa" if sequence else str(STILL_SAMPLES)
    if text in ("off", "fxaa"):
        return 1, text == "fxaa"
    if not text.isdecimal() or not 1 <= int(text) <= MAX_SAMPLES:
        choices = f"off, fxaa, auto or a number of samples a pixel, 1 to {MAX_SAMPLES}"
        raise OctoluxError(f"Anti-aliasing is {choices}, not '{anti_aliasing}'.")
    return int(text), False


def sample_shift(sample: int, samples: int) -> tuple[float, float]:
    """Where in the pixel sample number `sample` lies, from its centre, pixels; the last one lies in the centre."""
    number = samples - 1 - sample
    x, y = ((0.5 + number * step) % 1.0 - 0.5 for step in (1.0 / samples, _GOLDEN))
    return x, y


def sample_view(view: View, sample: int, samples: int) -> View:
    """The view through the sample's place in each pixel."""
    return replace(view, shift=sample_shift(sample, samples))


class FxaaPass:
    """Filters `display`. Constants are the whitepaper's: default threshold and subpixel amount, preset 12's steps."""

    def __init__(self, device: Device):
        self.device = device
        self._filtered: Any = None
        self._pass = ComputePass(
            device, "FXAA", "frame/fxaa.wgsl",
            [texture("picture", "float"), sampler("picture_sampler"), storage_texture("picture_out", "rgba8unorm")],
            threshold=0.166, threshold_min=0.0833, subpixel=0.75, steps=(1.0, 1.5, 2.0, 4.0, 12.0),
        )  # fmt: skip
        self._sampler = device.wgpu.create_sampler(mag_filter="linear", min_filter="linear")

    def run(self, frame: Frame) -> None:
        self._filtered = self._filtered or frame.targets.display_like(self.device)
        with frame.profiler.stage("FXAA") as stage:
            self._pass.run(
                stage, frame.pixels, picture=frame.targets.display, picture_sampler=self._sampler,
                picture_out=self._filtered,
            )  # fmt: skip
        frame.targets.display, self._filtered = self._filtered, frame.targets.display
