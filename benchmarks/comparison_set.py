"""The comparison set: the views that every technique is judged on, and the references they are judged against.

Three views have references by another program, in the data folder (ground-truth); the others have ours, made by
`python -m benchmarks.comparison_references` and kept in benchmarks/references. All materials are diffuse there, and all
paths go through the pixels' middles: what a technique of diffuse light would show if it were right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import octolux
from octolux.compare.reference import Reference
from octolux.compare.reference_files import read_reference
from octolux.scene.errors import OctoluxError
from octolux.scene.scene import Scene
from octolux.techniques.settings import suggest

from . import scenes_on_disk
from .lab import data
from .registry import NeedsData

TECHNIQUES = (
    "cascaded-lpv", "cascaded-lpv,bounces=1", "cascaded-lpv:paper", "octree-lpv", "octree-lpv:steps",
    "octree-lpv:thesis", "voxel-cones", "voxel-cones,bounces=1", "voxel-cones:full,bounces=1",
    "voxel-cones:finest,bounces=1", "voxel-cones:fast,bounces=1", "uniform-lpv", "uniform-lpv:paper",
    "uniform-lpv:thesis",
)  # fmt: skip
"""What is measured unless other techniques are asked for, in the words of `octolux compare --technique`. A new one is
one word more; `constant` and `black` are always measured beside."""

REFERENCES = Path(__file__).parent / "references"
SIZE = (256, 144)
"""Pixels, of our own references."""

LIGHTS = ("first_bounce", "all_indirect")
"""What a reference holds: light reflected once before it lit the seen surface, and all that was reflected before."""


@dataclass(frozen=True)
class View:
    """One view of the set.

    scene: a built-in scene's name, or that of a file in benchmarks/scenes.  camera: one of its cameras.
    samples: paths through each pixel in each of the two halves of our reference, by LIGHTS; none for another program's.
    leaks: whether no direct light falls into the view, so that a leak score says something.
    lit_by: the view whose light `constant` has, where this one's reference is black.
    """

    name: str
    scene: str
    camera: str
    samples: tuple[int, int] | None = None
    leaks: bool = False
    lit_by: str = ""

    @property
    def built_in(self) -> bool:
        """Whether it needs no data folder."""
        return not (scenes_on_disk.SCENES / f"{self.scene}.toml").exists()


# A few minutes for each view on two processor cores. Errors are free of the noise's bias (metrics.relative_errors), and
# a mean over 36,864 pixels is some 190 times less noisy than one of them.
_OURS = (256, 64)
SET = (
    View("cornell_point", "cornell_point", "front"),
    View("cornell_area", "cornell_area", "front"),
    View("sponza_sunpoint", "sponza_sunpoint", "nave"),
    View("atrium", "atrium", "hall", _OURS),
    # Light comes round a corner there: with few paths a lit pixel is black now and then, and would count as dark.
    View("corridor", "corridor", "far", (256, 512), leaks=True),
    View("two_rooms", "two-rooms", "lit", _OURS),
    # Black in every sample: the room is sealed.
    View("two_rooms_dark", "two-rooms", "dark", (4, 4), leaks=True, lit_by="two_rooms"),
    View("crytek_sun", "crytek_sponza", "nave", _OURS),
    View("crytek_lamps", "crytek_lamps", "nave", _OURS),
)
VIEWS = {view.name: view for view in SET}


def views(names: Sequence[str] = ()) -> list[View]:
    """The views of those names, all without any. Raises OctoluxError that names the nearest."""
    for name in names:
        if name not in VIEWS:
            raise OctoluxError(f"There is no view '{name}' in the comparison set. {suggest(name, VIEWS)}")
    return [VIEWS[name] for name in names] or list(SET)


@cache
def scene_of(view: View) -> Scene:
    """The scene as it is at 0 s. Raises NeedsData when its model is not there."""
    scene = octolux.load(view.scene) if view.built_in else scenes_on_disk.load(view.scene)
    return scene.at(0.0) if scene.tracks else scene


def reference_file(view: View) -> Path:
    """Where the reference is. Raises NeedsData when it is not there."""
    if view.samples is None:
        return data("ground-truth", f"{view.name}.npz")
    path = REFERENCES / f"{view.name}.npz"
    if not path.is_file():
        raise NeedsData(f"{path.name}; make it: python -m benchmarks.comparison_references {view.name}")
    return path


@cache
def reference(view: View, light: str = "first_bounce") -> Reference:
    """The reference whose indirect light is `light`, of LIGHTS. Raises NeedsData, or SceneError for a broken file."""
    return read_reference(reference_file(view), light)
