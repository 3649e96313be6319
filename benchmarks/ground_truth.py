"""Direct light against path-traced pictures of the same scenes; indirect light is in comparison.py."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from octolux.picture import Picture
from octolux.renderer import Renderer

from .edges import away_from_edges, unshadowed
from .lab import data, device
from .metrics import pixel_errors
from .registry import at_most, figure, within
from .scenes_on_disk import load


@cache
def truth(name: str) -> dict[str, np.ndarray]:
    """The arrays of a ground-truth file. Raises NeedsData when it is not there."""
    with np.load(data("ground-truth", f"{name}.npz")) as arrays:
        return dict(arrays)


@cache
def rendered(name: str) -> Picture:
    """Our picture of the scene without indirect light, of the size of the reference."""
    height, width = truth(name)["mask"].shape
    return Renderer(load(name), "none", size=(width, height), device=device()).render()


def direct_light(name: str) -> dict[str, float]:
    """Ratio of the means of direct light, and the error of pixels, away from shadow edges and of all that are seen.

    Away from edges is what `edges.away_from_edges` says; a pixel's error is `metrics.pixel_errors`.
    """
    known, lights = truth(name), load(name).lights
    found, mask = rendered(name).layers["direct"], truth(name)["mask"]
    errors = pixel_errors(found, known["direct"], unshadowed(lights, known).sum(axis=0))
    clear = away_from_edges(lights, known)
    return {
        "ratio": float(found[mask].mean(dtype=np.float64) / known["direct"][mask].mean(dtype=np.float64)),
        "clear_p99": 100.0 * float(np.quantile(errors[clear], 0.99)),
        "clear_within_2": 100.0 * float((errors[clear] <= 0.02).mean()),
        "clear_pixels": 100.0 * float(clear[mask].mean()),
        "all_within_2": 100.0 * float((errors[mask] <= 0.02).mean()),
    }


_DIRECT: dict[str, Any] = {
    "group": "ground_truth",
    "unit": {"ratio": "x", **dict.fromkeys(("clear_p99", "clear_within_2", "clear_pixels", "all_within_2"), "%")},
    "bound": {"ratio": within(1.0, 0.01), "clear_p99": at_most(2.0)},
}


@figure("direct_cornell_point", **_DIRECT)
def direct_cornell_point() -> dict[str, float]:
    """Direct light of the Cornell box with a point light: mean, and error of pixels away from shadow edges."""
    return direct_light("cornell_point")


@figure("direct_sponza_sunpoint", **_DIRECT)
def direct_sponza_sunpoint() -> dict[str, float]:
    """Direct light of the older Sponza with sun and point light: mean, and error of pixels away from shadow edges."""
    return direct_light("sponza_sunpoint")
