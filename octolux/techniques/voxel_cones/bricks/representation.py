"""The two ways in which bricks keep light (VCT 5.3): six intensities, or one with the lobe of where it comes from."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import accumulate
from math import sqrt
from typing import Any

from ....frame.frame import Frame
from ....frame.structs import VIEW, views_binding
from ....gpu.bindings import Binding, uniform
from ....gpu.device import Device
from ....gpu.layout import Struct

# View of the first VPL of a range.
SHONE = Struct("Shone", first_view="u32")


@dataclass(frozen=True)
class Representation:
    """folder: of the shaders that know it.  row: bricks along x and y of their texture; of lobes whole nodes.  sides:
    to how many sides a brick's voxels gather light that bounces.  most: of the flux that a voxel reflects what it may
    send, all sides together.  together: bricks of a node that are written at once, with one scale.  directed: light is
    kept with its direction.

    In `axial` a node has a brick for each of six ways that anything in it faces, `ways` and `owners` say for which. In
    `lobes` it has three, side by side: light and x of its moment; y and z, and what faces +x and +y; and what faces +z,
    -x, -y and -z, which only a build writes. Their `light` is the light, the moment, and nothing (simulator/voxels/
    lobes.py).
    """

    folder: str
    row: int
    sides: int = 1
    most: float = 1.0
    together: int = 1
    directed: bool = False

    def file(self, name: str) -> str:
        return f"{self.folder}/{name}.wgsl"

    @property
    def bindings(self) -> list[Binding]:
        """What injection wants to know besides, whose structs are `structs`."""
        return [views_binding(), uniform("shone", SHONE)] if self.directed else []

    @property
    def structs(self) -> list[Struct]:
        return [VIEW, SHONE] if self.directed else []

    def resources(self, device: Device, frame: Frame, first_vpl: int) -> dict[str, Any]:
        """For `bindings`, of a range of VPLs whose maps are of one size."""
        if not self.directed:
            return {}
        counts = [frame.vpl_widths[owner] ** 2 for owner in frame.lights.light_of_view]
        first_view = 1 + [0, *accumulate(counts)].index(first_vpl)  # view 0 is the camera's
        packed = SHONE.pack(first_view=first_view)
        return {"views": frame.buffers["views"], "shone": device.uniform("voxel light", packed)}


REPRESENTATIONS = {
    "axial": Representation("techniques/voxel_cones/axial", row=128),
    "lobes": Representation(
        "techniques/voxel_cones/lobes", row=126, sides=2, most=sqrt(3.0), together=3, directed=True
    ),
}
