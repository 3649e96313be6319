"""Diffuse indirect light of techniques on the comparison set, against the path-traced first bounce."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

import numpy as np

from octolux.compare.choices import Choice, choices
from octolux.compare.metrics import leak, relative_errors
from octolux.compare.rendering import Rendering, Studio, black, fitted_constant

from .comparison_set import SET, TECHNIQUES, View, reference, scene_of, views
from .lab import device
from .registry import figure


@dataclass(frozen=True)
class Score:
    """One technique in one view; None where a figure cannot be told.

    ratio, rmse, trimmed: metrics.relative_errors against the first bounce, or the light asked for.  energy: mean over
    that of all bounces.
    leak: metrics.leak's score against all light, so that no bounce counts as a leak; only in views that are for leaks.
    """

    view: str
    technique: str
    ratio: float | None
    rmse: float | None
    trimmed: float | None
    energy: float | None
    leak: float | None


@cache
def studio(view: View) -> Studio:
    """Renders the view at the size of its reference, each technique once."""
    return Studio(scene_of(view), device(), reference(view).size, view.camera, frames=0)


@cache
def _direct(view: View) -> tuple[Rendering, float | None]:
    return studio(view).direct_light()


def diffuse_indirect(rendering: Rendering) -> np.ndarray:
    """What is compared: references have diffuse materials alone. (height, width, 3), nits."""
    return rendering.pictures["indirect"] - rendering.specular


def constant(view: View, light: str = "first_bounce") -> Choice:
    """One irradiance everywhere, with the mean of the reference's `light` in this view; or, for a view that is to be
    dark, in the lit one beside it."""
    lit = views([view.lit_by])[0] if view.lit_by else view
    dark, known = _direct(lit)[0], reference(lit, light)
    return fitted_constant(known, dark.albedo, known.mask & dark.mask)


def scores(view: View, techniques: Sequence[str] = TECHNIQUES, light: str = "first_bounce") -> list[Score]:
    """The techniques, then `constant` and `black`, against a light of LIGHTS. Raises NeedsData, and OctoluxError for an
    unknown technique."""
    measured = choices(list(techniques))
    return [score(view, one, picture(view, one), light) for one in (*measured, constant(view, light), black())]


def picture(view: View, one: Choice) -> Rendering:
    """What the technique renders there; `black` is rendered anyway, for the direct light."""
    return _direct(view)[0] if one.label == "black" else studio(view).render(one)


def score(view: View, one: Choice, rendering: Rendering, light: str = "first_bounce") -> Score:
    """The rendering against the view's references."""
    known, every = reference(view, light), reference(view, "all_indirect")
    mask, found = known.mask & rendering.mask, diffuse_indirect(rendering)
    errors = relative_errors(found, *known.halves["indirect"], mask, known.pictures["indirect"])
    energy = relative_errors(found, *every.halves["indirect"], mask, every.pictures["indirect"])["ratio"]
    level = _direct(view)[1]
    leaked = None
    if view.leaks and level:
        leaked = leak(rendering.pictures["direct"] + found, *every.halves["final"], mask, level).score
    return Score(view.name, one.label, errors["ratio"], errors["rmse"], errors["trimmed"], energy, leaked)


def _figure(view: View) -> Callable[[], dict[str, float]]:
    def measure() -> dict[str, float]:
        kept = ("ratio", "rmse", "trimmed", "leak")
        found = {f"{s.technique}.{key}": getattr(s, key) for s in scores(view) for key in kept}
        return {key: value for key, value in found.items() if value is not None}

    measure.__doc__ = f"First bounce, {view.name} of the comparison set: every preset beside a constant and black."
    return measure


for _view in SET:
    figure(f"indirect_{_view.name}", group="comparison", unit="relative")(_figure(_view))
