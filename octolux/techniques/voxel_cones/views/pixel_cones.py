"""The cones of one pixel: the samples of each, and these drawn over the picture."""

from __future__ import annotations

import colorsys
from typing import Any

import numpy as np

from ....frame.frame import Frame
from ....frame.views import View
from ....gpu.bindings import storage_rw, texture, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....gpu.passes import ComputePass
from ....gpu.profiler import Profiler
from ....scene.errors import OctoluxError
from ....simulator.grid import Grid
from ....simulator.reflection import CONE
from ..cones.gathering import Gathering, Voxels
from ..cones.wide import WideCones

# position: voxels of level 0 from the cube's corner; level: of the voxels that are read; towards: of the cone; step:
# its way, in voxels of its level; light: radiance times opacity, nits; share: of the cone that it covers.
CONE_SAMPLE = Struct(
    "ConeSample", position="vec3f", level="f32", towards="vec3f", step="f32", light="vec3f", opacity="f32",
    share="f32", cone="u32",
)  # fmt: skip
CHOSEN = Struct("Chosen", column="u32", row="u32")
ROOM = 1 << 12
"""Samples of a cone that are kept, the first ones: a glossy cone of 1/8 voxels' steps may take more, where nothing
covers it."""


class PixelCones(Gathering):
    """Traces cones as DiffuseCones and, if `glossy`, SpecularCones do. step: of the latter."""

    def __init__(
        self, device: Device, voxels: Voxels, wide: WideCones, *, resolution: int, offset: float, cover: str,
        step: float, glossy: bool, attenuation: float = 0.0,
    ):  # fmt: skip
        super().__init__(device, voxels, resolution, offset, cover, attenuation)
        self._wide, self._cones = wide, wide.sets * wide.count + glossy
        values = {**self._values, **wide.values(), "noted": True}
        self._trace = ComputePass(
            device, "cones of a pixel", "techniques/voxel_cones/views/pixel_cones.wgsl",
            [*self._read, *wide.bindings, texture("brdf_table"), uniform("chosen", CHOSEN),
             storage_rw("samples", CONE_SAMPLE, "write"), storage_rw("counts", "u32", "write")],
            structs=[*self._structs, *wide.structs, CHOSEN, CONE_SAMPLE], workgroup=(32, 1, 1), room=ROOM,
            glossy=int(glossy), diffuse=wide.sets * wide.count, sky=False, step=float(step), lobe=CONE,
            skip=voxels.skips, **values,
        )  # fmt: skip

    def samples(self, frame: Frame, grid: Grid, pixel: tuple[int, int], **voxels: Any) -> np.ndarray:
        """CONE_SAMPLE (m,), cone by cone, outwards, of the pixel that stands for the block of `pixel` (column, row).
        Raises OctoluxError where it lies outside the picture, or sees nothing that is in the voxels."""
        if not all(0 <= at < most for at, most in zip(pixel, frame.pixels, strict=True)):
            width, height = frame.pixels
            raise OctoluxError(f"Pixels are 0:0 to {width - 1}:{height - 1}, not {pixel[0]}:{pixel[1]}.")
        column, row = (at // self.resolution for at in pixel)
        profiler, label = Profiler(self.device, "off"), "voxel views"
        out = self.device.buffer(label, size=CONE_SAMPLE.size * ROOM * self._cones)
        counts = self.device.buffer(label, size=4 * self._cones)
        with profiler.frame(), profiler.stage("cones of a pixel") as stage:
            self._trace.run(
                stage, (self._cones,), chosen=self.device.uniform(label, CHOSEN.pack(column=column, row=row)),
                samples=out, counts=counts, brdf_table=frame.surroundings_map.resources["brdf_table"],
                **self._resources(frame, grid), **self._wide.resources(self.device, frame, grid), **voxels,
            )  # fmt: skip
        found = np.frombuffer(self.device.queue.read_buffer(out), CONE_SAMPLE.dtype).reshape(self._cones, ROOM)
        kept = np.frombuffer(self.device.queue.read_buffer(counts), np.uint32)[: self._cones]
        if not kept.any():
            raise OctoluxError(f"The pixel {pixel[0]}:{pixel[1]} sees no surface in the voxels: it has no cones.")
        return np.concatenate([of_cone[:count] for of_cone, count in zip(found, kept, strict=True)])


def drawn_over(picture: np.ndarray, samples: np.ndarray, view: View, grid: Grid, exposure: float) -> np.ndarray:
    """Samples as discs as wide as their voxels, the nearest in front: of the radiance that they have found, as
    opaque as what they cover of their cone; the rims of each cone of one colour.

    picture: float32 (height, width, 3), exposed.  exposure: from nits to it.
    """
    shown = picture.copy()
    world = np.asarray(grid.origin) + grid.cell_size * samples["position"].astype(np.float64)
    clip = np.column_stack([world, np.ones(len(world))]) @ view.view_projection.T
    height, width = picture.shape[:2]
    size = grid.cell_size * 2.0 ** samples["level"].astype(np.float64)
    seen = clip[:, 3] > 1e-6
    depth = np.where(seen, clip[:, 3], 1.0)
    centre = (clip[:, :2] / depth[:, None] * (0.5, -0.5) + 0.5) * (width, height)
    radius = 0.25 * size * height / (np.linalg.norm(view.up) * depth)
    for i in sorted(np.flatnonzero(seen), key=lambda i: -depth[i]):
        _disc(shown, centre[i], radius[i], samples[i], exposure)
    return shown


def _disc(shown: np.ndarray, centre: np.ndarray, radius: float, sample: np.void, exposure: float) -> None:
    height, width = shown.shape[:2]
    low = np.clip(np.floor(centre - radius - 1.0), 0, (width, height)).astype(int)
    high = np.clip(np.ceil(centre + radius + 1.0), 0, (width, height)).astype(int)
    window = shown[low[1] : high[1], low[0] : high[0]]
    y, x = np.mgrid[low[1] : high[1], low[0] : high[0]] + 0.5
    off = np.hypot(x - centre[0], y - centre[1]) - radius
    light = np.clip(exposure * sample["light"] / max(float(sample["opacity"]), 1e-20), 0.0, 1.0)
    inside = (np.clip(0.5 - off, 0.0, 1.0) * min(float(sample["share"]), 1.0))[..., None]
    rim = 0.6 * np.clip(1.0 - np.abs(off), 0.0, 1.0)[..., None]
    window += inside * (light - window)
    window += rim * (cone_colour(int(sample["cone"])) - window)


def cone_colour(number: int) -> np.ndarray:
    """Of any number neighbours differ: hues a golden ratio of the circle apart."""
    return np.array(colorsys.hsv_to_rgb(number * 0.6180339887 % 1.0, 0.8, 1.0), np.float32)
