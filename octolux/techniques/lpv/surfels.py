"""Where a frame's surfels lie: the RSM of each lamp and the G-buffer, or the scene's own surfaces."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ...frame.frame import CameraSees, Frame
from ...frame.peeling import LampLayer
from ...frame.scene_surfels import SceneSurfels

SAMPLES = 4
"""Of a wall, along each edge of a cell of the finest grid, where the scene's own surfaces are sampled: where a wall
ends in a cell is known to an eighth of it, if the scene does not need more samples than there may be."""

GBUFFER_SAMPLES = 256  # surfels along the longer side of the picture: as many as an RSM has


@dataclass(frozen=True, eq=False)
class SurfelBuffer:
    """Surfels that are merged by themselves (CLPV 3.2). Those of a view's layers are summed: a surface is in one of
    them, so that no blocking is accumulated twice, and a cell that has a wall in parts of several has it whole.

    layers: textures of VPL and of traits, or what the camera sees.  first, count, width, block: of SURFELS, the same of
    each layer.
    """

    layers: Sequence[LampLayer | CameraSees]
    first: int
    count: int
    width: int
    block: int = 1

    @property
    def total(self) -> int:
        """Surfels of all layers."""
        return self.count * len(self.layers)

    @property
    def where(self) -> dict[str, int]:
        return {"first": self.first, "count": self.count, "width": self.width, "block": self.block}


def surfel_buffers(frame: Frame, camera: bool, scene: SceneSurfels | None = None) -> Iterator[SurfelBuffer]:
    """Those of `scene` alone if there is one: all surfaces are in it. Else of each lamp, and the camera's. The many
    coarse maps of the sky and of glowing surfaces are left out: they would cost more than they add. Of lamps and the
    camera all layers that the frame has."""
    if scene is not None:
        if scene.count:
            yield SurfelBuffer([LampLayer(scene.surfels, scene.surfaces)], 0, scene.count, 1)
        return
    lamps = [LampLayer(frame.vpls, frame.vpl_surfaces), *frame.lamp_layers]
    for (first, count), width in list(zip(frame.vpl_ranges, frame.vpl_widths, strict=True))[: frame.lights.lamps]:
        yield SurfelBuffer(lamps, first, count, width)
    if camera:
        block = max(1, -(-max(frame.pixels) // GBUFFER_SAMPLES))
        width, height = (-(-side // block) for side in frame.pixels)
        yield SurfelBuffer([frame.targets, *frame.camera_layers], 0, width * height, width, block)
