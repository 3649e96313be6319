"""What fewer pixels' cones save and what they cost in accuracy, and the corridor's polished floor."""

from __future__ import annotations

import statistics

import numpy as np

import octolux
from octolux.compare.choices import choice
from octolux.compare.perception import flip, flip_missing
from octolux.picture import Picture
from octolux.renderer import Renderer
from octolux.simulator.tonemap import signal

from .clpv_glossy import SMALL, reference
from .comparison_set import SET, scene_of
from .lab import device
from .registry import NeedsData, aim, at_least, at_most, figure
from .stages import interleaved_stages
from .vct_accuracy import errors_of

HALF, FULL = (f"voxel-cones,bounces=1,resolution={resolution},tile=4" for resolution in (2, 1))
TIMED, SIZE, FRAMES = ("atrium", "corridor"), (640, 360), 5
GATHERING = ("diffuse cones", "cone filter")


FINER = 5
"""Times as many pixels along each edge as references have: 1280x720. It is odd, so that the middle of each of a
reference's pixels, which its paths go through, is that of a finer pixel."""


@figure("vct_half_resolution", group="vct", unit="x", bound={
    "faster": at_least(3.0), "mean_error": at_most(1.1), "mean_error_small": aim("<= 1.1"),
})  # fmt: skip
def vct_half_resolution() -> dict[str, float]:
    """Cones at a quarter of the pixels: how often the time of gathering at all pixels of 640x360 is theirs, the least
    of two scenes; and trimmed error of the first bounce over that of all pixels' on the comparison set at 1280x720:
    its mean, and by view. Small: at the references' own 256x144."""
    faster = []
    for name in TIMED:
        view = next(view for view in SET if view.name == name)
        found = interleaved_stages(scene_of(view), view.camera, (HALF, FULL), SIZE, FRAMES)
        half, full = (sum(found[text][stage] for stage in GATHERING) for text in (HALF, FULL))
        faster.append(full / half)
    fine, small = _error_ratios(FINER), _error_ratios(1)
    mean = {"mean_error": statistics.fmean(fine.values()), "mean_error_small": statistics.fmean(small.values())}
    return {"faster": min(faster), **mean, **fine}


def _error_ratios(finer: int) -> dict[str, float]:
    """Of half resolution over full, by view."""
    found = {}
    for view in SET:
        try:
            if not view.lit_by:
                half, full = (errors_of(view, text, finer)["trimmed"] for text in (HALF, FULL))
                found[view.name] = half / full
        except NeedsData:
            continue
    return found


REFLECTING = ("voxel-cones", "voxel-cones,bounces=1", "cascaded-lpv", "cascaded-lpv,bounces=1", "none")
"""The first one's light is in the pictures that are compared, but for reflections."""


@figure("vct_floor", group="vct", unit="FLIP", bound={
    "over_none": at_most(1.0), "over_cascaded": at_most(1.0),
})  # fmt: skip
def vct_floor() -> dict[str, float]:
    """The corridor's polished floor with reflections by technique beside path-traced ones, by FLIP: of pictures that
    are alike otherwise; noise is what the two halves of the paths differ by, which is in all of these; over_cascaded
    with as many bounces."""
    if flip_missing():
        raise NeedsData(flip_missing())
    made = {text: _corridor(text) for text in REFLECTING}
    first, second = reference()
    seen = next(iter(made.values()))
    rest, floor, exposure = seen.radiance - seen.layers["specular"], floor_of(seen), seen.exposure

    def difference(one: np.ndarray, other: np.ndarray) -> float:
        found = flip(*(signal(np.maximum(rest + light, 0.0), exposure, "neutral") for light in (one, other)))
        assert found
        return float(found[1][floor].mean())

    traced = 0.5 * (first + second)
    found = {text: difference(picture.layers["specular"], traced) for text, picture in made.items()}
    found["noise"] = difference(first, second)
    found["over_none"] = found["voxel-cones"] / found["none"]
    return {**found, "over_cascaded": found["voxel-cones"] / found["cascaded-lpv"]}


def _corridor(text: str) -> Picture:
    one = choice(text)
    scene = octolux.load("corridor")
    return Renderer(scene, one.technique, settings=one.settings, size=SMALL, device=device()).render("lit")


def floor_of(picture: Picture) -> np.ndarray:
    """bool (height, width): pixels that show the floor."""
    names = [number for number, name in picture.object_names.items() if name == "floor"]
    return np.isin(picture.layers["object_id"], names)
