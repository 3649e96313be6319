"""FrameSettings: what of a frame all techniques share."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from ..scene.errors import OctoluxError

COARSE_BLOCK = 8  # soft lights are many and even: a VPL for 8 x 8 texels of their maps
FOG_RESOLUTIONS = (1, 2, 4)
"""Pixels along the edge of the block that one path of fog stands for."""
SHADOW_FILTERS = (1, 2)
"""Texels along the edge of the block of a shadow map that a point is compared with."""
_OF_PATHS = ("normal_maps", "inverse_square")


@dataclass(frozen=True)
class FrameSettings:
    """What all techniques share. Raises OctoluxError for values that cannot be.

    width, height: pixels.  shadow_resolution: texels along a shadow map's edge.  rsm_resolution: VPLs along an RSM's
    edge, one taken of each block of shadow texels; it divides shadow_resolution.  sky_lights: distant lights that stand
    for the surroundings; 0 leaves these to be seen without lighting anything.  emitter_lights: lights that stand for
    all glowing surfaces, and for area lights in their shadows and indirect light; 0 leaves both to glow alone.
    coarse_resolution: texels along the edge of the shadow maps of both, COARSE_BLOCK of them to a VPL.  fog_resolution:
    1, 2 or 4: one path of fog is marched for each block of pixels with that edge.  fog_step: length of a step of fog,
    in cells of the technique's light volume and of the medium's density.

    normal_maps: whether surfaces that are seen, and that paths meet, have those of their materials (VCT C.2, -nm).
    shadow_filter: 1 or 2 texels along the edge of the block of a shadow map that a surface is compared with: 2 x 2 are
    blended (-pcf), one alone leaves steps.  inverse_square: whether point and spot lights fall off with the square of
    the distance (-qatt). Without it they bring everywhere what they do at 1 m, I cd as I lx: light grows with the
    distance, which no lamp's does. Surfaces that shine, the sky and particle lights are as they are.
    """

    width: int = 1280
    height: int = 720
    shadow_resolution: int = 1024
    rsm_resolution: int = 256
    sky_lights: int = 32
    emitter_lights: int = 4
    coarse_resolution: int = 512
    fog_resolution: int = 2
    fog_step: float = 1.0
    normal_maps: bool = True
    shadow_filter: int = 2
    inverse_square: bool = True

    def __post_init__(self) -> None:
        for name, value in (("width", self.width), ("height", self.height)):
            if not 1 <= value <= 8192:
                raise OctoluxError(f"The picture's {name} must be 1 to 8192 pixels, not {value}.")
        if self.coarse_resolution % COARSE_BLOCK:
            raise OctoluxError(f"coarse_resolution {self.coarse_resolution} is not a multiple of {COARSE_BLOCK}.")
        if self.fog_resolution not in FOG_RESOLUTIONS:
            raise OctoluxError(f"fog_resolution is 1, 2 or 4 pixels, not {self.fog_resolution}.")
        if not 0.0 < self.fog_step < math.inf:
            raise OctoluxError(f"fog_step is a number of cells above 0, not {self.fog_step}.")
        if self.shadow_resolution % self.rsm_resolution:
            raise OctoluxError(
                f"rsm_resolution {self.rsm_resolution} does not divide shadow_resolution {self.shadow_resolution}."
            )
        if self.shadow_filter not in SHADOW_FILTERS:
            raise OctoluxError(f"shadow_filter is 1 or 2 texels, not {self.shadow_filter}.")
        for name, switch in self.of_paths.items():
            if not isinstance(switch, bool):
                raise OctoluxError(f"{name} is True or False, not {switch!r}.")

    @property
    def of_paths(self) -> dict[str, Any]:
        """Those that change what the path tracer makes of a scene, by name."""
        return {name: getattr(self, name) for name in _OF_PATHS}
