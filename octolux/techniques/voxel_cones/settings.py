"""Settings of `voxel-cones`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from ...simulator.voxels.cones import COVERS
from ..settings import Form, Settings, setting
from .bricks.representation import REPRESENTATIONS
from .cones.sharing import AUTO


def read_box(text: str) -> tuple[np.ndarray, np.ndarray] | None:
    """The lowest and highest corner that six numbers say, (3,) each, metres; None for "scene". Raises ValueError."""
    if text == "scene":
        return None
    low, high = np.array([float(part) for part in text.split()]).reshape(2, 3)
    if not ((low >= -_FARTHEST) & (low < high) & (high <= _FARTHEST)).all():
        raise ValueError("a box has its lowest corner first, and is not farther away than float32 tells places apart")
    return low, high


_FARTHEST = 1e6  # m; float32 has 0.06 m there
BOX = Form("`scene`, or six numbers with spaces between: the lowest corner's x y z, then the highest's", read_box)


@dataclass(frozen=True)
class VoxelConesSettings(Settings):
    """The default traces many narrow cones, at half resolution where a picture has as many pixels as 1280 x 720;
    `full` four times as many; `finest` all directions at every pixel, for stills; `fast` fewer, wide ones, at half
    resolution."""

    depth: int = setting(
        8, meaning="levels of the octree: 2^depth voxels along each side of the cube around the scene", unit="levels",
        allowed=[6, 9], cost="each one more takes four times the memory and the time of filtering",
        source="VCT 5.2, tables 6.6 and 6.9",
    )  # fmt: skip
    box: str = setting(
        "scene", meaning="what the cube of voxels is around: the scene's box, or another. Outside, nothing is lit by "
        "voxels, and light that falls there is lost", unit="m", allowed=BOX,
        cost="none; a smaller one has smaller voxels", source="VCT 5.2",
    )  # fmt: skip
    representation: str = setting(
        "axial", meaning="what voxels keep of light: six axial intensities; or one, and as Gaussian lobes normals and "
        "where light comes from", unit="", allowed=tuple(REPRESENTATIONS),
        cost="lobes take less memory where surfaces are seen from both sides, and filter faster there; less exact",
        source="VCT 5.3, tables 6.5 and 6.6",
    )  # fmt: skip
    interior: bool = setting(
        True, meaning="single-sided surfaces are closed from behind too, as for paths of light: what is solid is dark "
        "inside", unit="", allowed=(False, True), cost="more bricks; without it light comes through thin walls",
        source="VCT 7.2; simulator/voxels/surfaces.py",
    )  # fmt: skip
    texture_level: float = setting(
        0.0, meaning="mip level of textures that voxels take their colour from, over that whose texels are as large as "
        "a voxel", unit="levels", allowed=[-4.0, 4.0],
        cost="none; less picks out texels, more blurs over the borders of what a texture shows", source="VCT 5.2.1",
    )  # fmt: skip
    bounces: int = setting(
        4, meaning="times that light is reflected, and followed, before it reaches what is seen", unit="bounces",
        allowed=[1, 8], cost="each more than one: a gathering at the scene's coarse voxels, and filtering everything, "
        "when lights or the scene change", source="VCT 7.2",
    )  # fmt: skip
    endless: bool = setting(
        True, meaning="with 4 or more `bounces`, what further ones would bring is added, as a geometric series",
        unit="", allowed=(False, True), cost="little; without it their light is missing",
        source="ours; simulator/voxels/series.py",
    )  # fmt: skip
    bounce_level: int = setting(
        3, meaning="level of the voxels that gather light for further bounces", unit="levels", allowed=[0, 4],
        cost="each finer one takes four times as long; coarser ones spread what they receive farther", source="ours",
    )  # fmt: skip
    cones: int = setting(
        16, meaning="diffuse cones of a pixel; of 16 pixels each has others", unit="cones", allowed=[4, 16],
        cost="time is proportional; fewer are wider, and take small openings for closed", source="VCT 5.6, table 6.10",
    )  # fmt: skip
    width: float = setting(
        0.5, meaning="of the voxels that diffuse cones read, over those that blur as much as the cone does", unit="",
        allowed=[0.25, 2.0], cost="less sees finer, and wants as many more samples", source="VCT 5.6",
    )  # fmt: skip
    samples: int = setting(
        6, meaning="samples of a diffuse cone for each level; for 8 cones 2 over `width` leave no gaps, for 16 cones 3",
        unit="samples", allowed=[1, 8], cost="time is proportional; gaps let light through walls", source="VCT 5.6",
    )  # fmt: skip
    resolution: int = setting(
        AUTO, meaning="pixels along the edge of a block of which one gathers diffuse light; 0: 2, but 1 where the "
        "picture then has no more cones than one of 1280 x 720 with 2", unit="pixels",
        allowed=(AUTO, 1, 2, 4), cost="1: four times as long as 2; more blurs what is small",
        source="VCT 7.2, table 6.7; cones/sharing.py",
    )  # fmt: skip
    tile: int = setting(
        AUTO, meaning="pixels along the edge of a tile whose pixels gather through other cones each, and share their "
        "mean; 0: 4, but 2 or 1 where the picture then has no more cones than one of 1280 x 720 with 4", unit="pixels",
        allowed=(AUTO, 1, 2, 4), cost="2: four times as long as 4, 1: sixteen; 4 blurs what is small",
        source="ours; simulator/voxels/directions.py",
    )  # fmt: skip
    screen: float = setting(
        12.0, meaning="how far diffuse cones are first followed among what the picture shows, exactly, before they go "
        "through voxels; 0: nowhere", unit="voxels", allowed=[0.0, 64.0],
        cost="a step for each, a fifth of gathering for 12; more is seen exactly, and depends on what the camera sees",
        source="ours; simulator/voxels/screen.py",
    )  # fmt: skip
    glossy: bool = setting(
        True, meaning="glossy surfaces reflect the voxels", unit="", allowed=(False, True),
        cost="a tight cone a pixel, some 60 ms of a CPU at 1280 x 720", source="VCT 5.6",
    )  # fmt: skip
    glossy_resolution: int = setting(
        1, meaning="pixels along the edge of a block of which one gathers what is reflected", unit="pixels",
        allowed=(1, 2, 4), cost="1: four times as long as 2; more blurs mirrors", source="VCT 7.2",
    )  # fmt: skip
    sky: bool = setting(
        False, meaning="what is left of cones sees the sky, whose direct light then comes through them, and with "
        "`glossy` its reflection; else past shadow maps. What surfaces reflect of it is in the voxels either "
        "way", unit="", allowed=(False, True),
        cost="direct light takes less time; wide cones take small openings for closed", source="VCT 3.6; ours",
    )  # fmt: skip
    attenuation: float = setting(
        0.0, meaning="share that the air takes of gathered light each metre: exp(-attenuation distance) of it arrives. "
        "Lamps fall off with the square of the distance besides; in fog it is what that scatters and absorbs",
        unit="1/m", allowed=[0.0, 10.0], cost="an exponential a sample", source="VCT, table C.2; cones.py",
    )  # fmt: skip
    ambient_distance: float = setting(
        0.0, meaning="how far away surfaces may be to count for ambient visibility; 0: however far", unit="m",
        allowed=[0.0, 1000.0], cost="little; light is gathered from as far as before", source="VCT 5.6; ours",
    )  # fmt: skip
    step: float = setting(
        1.0, meaning="between samples of a specular cone, in voxels as large as it is wide", unit="voxels",
        allowed=[0.125, 2.0], cost="time is inversely proportional; more leaves gaps", source="VCT 5.6",
    )  # fmt: skip
    offset: float = setting(
        1.0, meaning="from a surface to where its cones start", unit="voxels", allowed=[0.0, 4.0],
        cost="none; more loses light of what is near", source="VCT 5.6",
    )  # fmt: skip
    cover: str = setting(
        "surfaces", meaning="what opacity means: shares of the cone that surfaces cover, side by side; or of a medium, "
        "of which each layer hides a share of all behind it", unit="", allowed=COVERS,
        cost="none; medium lets some light through walls", source="VCT 5.6; simulator/voxels/cones.py",
    )  # fmt: skip

    PRESETS: ClassVar[dict[str, dict[str, Any]]] = {
        "full": {"resolution": 1},
        "finest": {"resolution": 1, "tile": 1, "width": 0.35, "samples": 8, "screen": 24.0},
        "fast": {"resolution": 2, "tile": 4, "cones": 8, "width": 0.7, "samples": 3},
    }
