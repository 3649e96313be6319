"""Sets of wide cones (VCT 5.6; simulator/voxels/cones.py)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ....frame.frame import Frame
from ....gpu.bindings import Binding, texture, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct
from ....scene.errors import OctoluxError
from ....simulator.grid import Grid
from ....simulator.gtao import GOLDEN
from ....simulator.voxels import cones, directions, screen

# ceiling: metres above what is shown up to which cones are followed on the screen.
SCREEN = Struct("Screen", ceiling="f32")
TILES = (1, 2, 4)
MOST_SCREEN = 64.0


@dataclass(frozen=True)
class WideCones:
    """Of what are they made. Raises OctoluxError for values out of range.

    count: of cones in a set, 4 to 16.  per_level: samples of a cone for each level, 1 to 8.  width: of the voxels
    that are read, over those that blur as much as a cone does, 0.25 to 2: smaller ones see finer, and need more
    samples a level.  tile: pixels along the edge of a tile whose pixels have all sets between them.  among: samples
    of a pixel that have its sets between them.  screen: voxels of level 0 for which cones are followed among what
    the picture shows, 0 to 64 (simulator/voxels/screen.py); the frame then has `direct_diffuse`.  bounces:
    reflections of what is met there.
    """

    count: int = 8
    per_level: int = 2
    width: float = 1.0
    tile: int = 4
    among: int = 1
    screen: float = 0.0
    bounces: int = 1

    def __post_init__(self) -> None:
        if not 4 <= self.count <= 16 or not 1 <= self.per_level <= 8 or not 0.25 <= self.width <= 2.0:
            raise OctoluxError(
                "There are 4 to 16 cones of 1 to 8 samples a level and a width of 0.25 to 2, "
                f"not {self.count} of {self.per_level} and {self.width}."
            )
        if self.tile not in TILES or not 0.0 <= self.screen <= MOST_SCREEN:
            raise OctoluxError(
                f"Tiles are {TILES} pixels wide, and cones go 0 to {MOST_SCREEN:g} voxels on the screen, "
                f"not {self.tile} and {self.screen}."
            )
        if self.among < 1 or directions.PHASES // self.tile**2 % self.among:
            raise OctoluxError(
                f"A pixel's {directions.PHASES // self.tile**2} sets cannot be shared alike by {self.among} samples."
            )

    @property
    def sets(self) -> int:
        """Of cones, that each pixel has in a sample."""
        return directions.PHASES // self.tile**2 // self.among

    def values(self) -> dict[str, Any]:
        """What wide_cone.wgsl wants to know, and what screen.wgsl."""
        return {
            "cones": self.count, "near": cones.near_samples(self.count, self.width),
            "first_level": cones.first_level_samples(self.count, self.per_level, self.width),
            "phases": directions.PHASES, "cone_turn": directions.CONE_TURN, "phase_turn": directions.PHASE_TURN,
            "tile": self.tile, "sets": self.sets, "among": self.among,
            "screen": float(self.screen), "screen_steps": screen.steps_of(self.screen),
            "clearance": screen.CLEARANCE, "golden": GOLDEN, "bounces": self.bounces,
        }  # fmt: skip

    @property
    def bindings(self) -> Sequence[Binding]:
        """Of what pixel_cone.wgsl reads besides."""
        return [texture("reflected_map"), uniform("screen", SCREEN)] if self.screen else []

    @property
    def structs(self) -> Sequence[Struct]:
        """Of the bindings."""
        return [SCREEN] if self.screen else []

    def resources(self, device: Device, frame: Frame, grid: Grid) -> dict[str, Any]:
        """For the bindings. grid: of the voxels."""
        if not self.screen:
            return {}
        ceiling = screen.ceiling(frame.gpu_scene.culls) * grid.cell_size
        return {
            "reflected_map": frame.targets.direct_diffuse,
            "screen": device.uniform("voxel cones", SCREEN.pack(ceiling=ceiling)),
        }


USUAL = WideCones()
