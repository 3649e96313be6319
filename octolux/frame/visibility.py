"""Rasterisation: which triangle is nearest, for the camera and for every face of every light. It writes triangle
numbers; what the surface is like there is worked out later, only where it is needed."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..gpu.bindings import storage, texture, uniform_window
from ..gpu.device import Device
from ..gpu.passes import RasterPass
from ..gpu_scene.clusters import CLUSTER_TRIANGLES
from ..gpu_scene.gpu_scene import GpuScene
from ..gpu_scene.materials import BUCKETS, MASKED, SINGLE_SIDED
from .shader_values import surface_values
from .structs import RASTER_VIEW, RASTER_VIEW_STRIDE, VIEW
from .views import View

if TYPE_CHECKING:
    from .frame import Frame


@dataclass(frozen=True, eq=False)
class DrawList:
    """For each view and bucket a run (first, count) of the common list of visible items."""

    runs: list[list[tuple[int, int]]]
    entries: np.ndarray

    @property
    def clusters(self) -> int:
        return len(self.entries)


def draw_list(
    scene: GpuScene, views: list[View], cull: bool = True, glow_free: Container[int] = ()
) -> DrawList:  # fmt: skip
    """What each view draws: items whose boxes it may see, in a fixed order, so that every run gives the same bits.

    glow_free: views that leave out what glows: those of emitters, which stand in its middle.
    """
    runs, parts, first = [], [], 0
    for number, view in enumerate(views):
        of_view = []
        for items in scene.visible_items(view.view_projection, cull, glowing=number not in glow_free):
            parts.append(items)
            of_view.append((first, len(items)))
            first += len(items)
        runs.append(of_view)
    entries = np.concatenate(parts) if parts else np.zeros(0, np.uint32)
    return DrawList(runs, entries)


class VisibilityPass:
    """Draws the scene into depth maps and, where asked, triangle numbers (r32uint, 0 = nothing).

    Variants by alpha mask, culling of back faces (cameras and further layers only: a light is stopped by both sides),
    ids, and depth peeling are built when first used.
    """

    def __init__(self, device: Device, scene: GpuScene):
        self.device, self.scene = device, scene
        self._variants: dict[tuple[bool, ...], RasterPass] = {}

    def _variant(self, masked: bool, cull: bool, ids: bool, peels: bool, mirrored: bool) -> RasterPass:
        key = (masked, cull, ids, peels, mirrored)
        if key not in self._variants:
            self._variants[key] = RasterPass(
                self.device, "visibility", "frame/visibility.wgsl",
                [storage("drawn", "u32"), uniform_window("view", RASTER_VIEW),
                 *([texture("nearer", "depth")] if peels else [])],
                structs=[RASTER_VIEW, VIEW], shared=self.scene.bindings, color_format="r32uint" if ids else None,
                fragment=masked or ids, cull=cull, mirrored=mirrored, masked=masked, writes_id=ids, peels=peels,
                **surface_values(self.scene),
            )  # fmt: skip
        return self._variants[key]

    def draw(
        self, stage: Any, frame: Frame, view: int, depth: Any, ids: Any | None, nearer: Any | None = None
    ) -> None:
        """Draw view number `view` of the frame (0 is the camera) into `depth` and `ids` (texture views).

        nearer: depths of a layer, behind which the next one is drawn (with `ids`): of single-sided surfaces the fronts
        alone, since a closed object's backs add nothing to what it blocks.
        """
        buffers = {"drawn": frame.buffers["drawn"], "view": frame.buffers["raster_views"]}
        peels = nearer is not None
        if peels:
            buffers["nearer"] = nearer
        colors = [{"view": ids, "load_op": "clear", "store_op": "store", "clear_value": (0, 0, 0, 0)}] if ids else []
        encoder = stage.begin_render_pass(
            "visibility",
            color_attachments=colors,
            depth_stencil_attachment={
                "view": depth, "depth_clear_value": 0.0, "depth_load_op": "clear", "depth_store_op": "store",
            },
        )  # fmt: skip
        for bucket in range(BUCKETS):
            first, count = frame.draws.runs[view][bucket]
            if count:
                masked, cull = bool(bucket & MASKED), (view == 0 or peels) and bool(bucket & SINGLE_SIDED)
                mirrored = cull and frame.views[view].mirrored
                variant = self._variant(masked, cull, ids is not None, peels, mirrored)
                variant.bind(encoder, self.scene.resources, [view * RASTER_VIEW_STRIDE], **buffers)
                encoder.draw(3 * CLUSTER_TRIANGLES, count, 0, first)
        encoder.end()
