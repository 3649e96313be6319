"""What blocks and reflects light in all cascades, kept from frame to frame while it stays as it is (CLPV 3.2)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ....frame.frame import Frame
from ....frame.scene_surfels import SceneSurfels
from ....gpu.device import Device
from ....simulator.grid import Grid
from ..geometry import GeometryVolume
from ..keeping import KeptCells
from ..reflectors import Reflectors
from ..surfels import SAMPLES


class Surfaces:
    """`geometry` and `reflectors`, where there are any.

    surfels: setting of that name. Of "scene" what they hold is made anew when something moves, or a grid does: it does
    not depend on lights or on what is seen. What lamps and the camera see is new in each frame, besides what is kept.
    keep: static surfaces that were seen in earlier frames.  aside: cells by which the cells lie off the cascades'.
    """

    def __init__(
        self, device: Device, surfels: str, geometry: GeometryVolume | None, reflectors: Reflectors | None, *,
        keep: bool = False, aside: float = 0.0,
    ):  # fmt: skip
        self.geometry, self.reflectors, self._aside = geometry, reflectors, aside
        self._kept = geometry.keeping() if keep and geometry else None
        self._kept_reflectors = reflectors.keeping() if keep and reflectors else None
        self._scene = SceneSurfels(device) if surfels == "scene" and self else None
        self._grids: tuple[Grid, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.geometry or self.reflectors)

    def forget(self) -> None:
        """They are made anew in the next frame, whatever it brings."""
        self._grids = ()
        for kept in (self._kept, self._kept_reflectors):
            if kept:
                kept.forget()

    def update(self, frame: Frame, grids: Sequence[Grid], buffer: Any) -> None:
        """Bring them to what the frame shows. grids: of all cascades.  buffer: uniform buffer of GRID, where the
        surfels are to lie."""
        if not self._changed(frame, grids):
            return
        if self.geometry:
            with frame.profiler.stage("geometry volume") as stage:
                self._follow(stage, self._kept, frame, grids)
                self.geometry.run(stage, frame, buffer, self._scene, self._kept)
                if self.geometry.planes:
                    self.geometry.pack(stage)
        if self.reflectors:
            with frame.profiler.stage("reflectors") as stage:
                self._follow(stage, self._kept_reflectors, frame, grids)
                self.reflectors.run(stage, frame, buffer, self._scene, self._kept_reflectors)

    def _follow(self, stage: Any, kept: KeptCells | None, frame: Frame, grids: Sequence[Grid]) -> None:
        if kept:
            kept.follow(stage, [grid.moved(self._aside) for grid in grids], frame.gpu_scene)

    def _changed(self, frame: Frame, grids: Sequence[Grid]) -> bool:
        if not self._scene:
            return True
        before, self._grids = self._grids, tuple(grids)
        spacing = grids[0].cell_size / SAMPLES
        return self._scene.run(frame, np.array(grids[-1].origin), spacing) or self._grids != before
