"""voxel-cones against the path tracer on the comparison set: of the first bounce, and of all."""

from __future__ import annotations

import numpy as np

from octolux.compare.choices import choice
from octolux.compare.metrics import relative_errors
from octolux.compare.rendering import Studio

from .comparison import diffuse_indirect
from .comparison_set import SET, View, reference, scene_of
from .lab import device
from .registry import NeedsData, aim, at_least, at_most, figure


def errors_of(view: View, text: str, finer: int = 1, light: str = "first_bounce") -> dict[str, float]:
    """metrics.relative_errors of a technique's picture, with so many times the reference's pixels along each edge,
    against a light of LIGHTS. Raises NeedsData."""
    known = reference(view, light)
    width, height = known.size
    studio = Studio(scene_of(view), device(), (finer * width, finer * height), view.camera, frames=0)
    rendering, every = studio.render(choice(text)), np.s_[finer // 2 :: finer, finer // 2 :: finer]
    mask, halves = known.mask & rendering.mask[every], known.halves["indirect"]
    found = relative_errors(diffuse_indirect(rendering)[every], *halves, mask, known.pictures["indirect"])
    return {name: value for name, value in found.items() if value is not None}


def _of_set(name: str, text: str, light: str) -> dict[str, float]:
    """Of the views' ratios of means the least and the most, and of their trimmed errors, which follow, the largest."""
    found, ratios = {}, []
    for view in SET:
        try:
            if not view.lit_by:
                errors = errors_of(view, text, light=light)
                ratios.append(errors["ratio"])
                found[view.name] = errors["trimmed"]
        except NeedsData:
            continue
    whole = {"least_ratio": min(ratios), "most_ratio": max(ratios), "trimmed": max(found.values())}
    return {f"{name}.{key}": value for key, value in (whole | found).items()}


@figure("vct_first_bounce", group="vct", unit="relative", bound={
    **{f"{name}.least_ratio": at_least(0.85) for name in ("finest", "default")},
    **{f"{name}.most_ratio": at_most(1.15) for name in ("finest", "default")},
    "finest.trimmed": at_most(0.25), "default.trimmed": aim("<= 0.25"),
})  # fmt: skip
def vct_first_bounce() -> dict[str, float]:
    """The preset for stills and the default, 8 levels, against the path tracer's first bounce on the comparison set:
    least and most ratio of means, and trimmed errors, the largest first."""
    texts = {"finest": "voxel-cones:finest,bounces=1", "default": "voxel-cones,bounces=1"}
    return {key: v for name, text in texts.items() for key, v in _of_set(name, text, "first_bounce").items()}


@figure("vct_all_bounces", group="vct", unit="relative")
def vct_all_bounces() -> dict[str, float]:
    """The same against all indirect light: four bounces with what further ones bring, and without."""
    texts = {"endless": "voxel-cones", "four": "voxel-cones,endless=false"}
    return {key: v for name, text in texts.items() for key, v in _of_set(name, text, "all_indirect").items()}
